// Mission items as MAVLink carries them: how one is written, and when two are the same.

import { wrapped } from '../antimeridian.js';
import { MavFrame } from '../messages.js';

const withoutInt = {
  [MavFrame.GLOBAL_INT]: MavFrame.GLOBAL, [MavFrame.GLOBAL_RELATIVE_ALT_INT]: MavFrame.GLOBAL_RELATIVE_ALT,
  [MavFrame.GLOBAL_TERRAIN_ALT_INT]: MavFrame.GLOBAL_TERRAIN_ALT,
};
const params = ['param1', 'param2', 'param3', 'param4'];
// An autopilot stores whole centimetres and floats of 32 bits.
const altitudeTolerance_m = 0.02;
const paramTolerance = 1e-3;
const degreesE7 = (value_deg) => Math.round(value_deg * 1e7);

export function item(id, place, [param1 = 0, param2 = 0, param3 = 0, param4 = 0] = [], inFrame = MavFrame.GLOBAL) {
  return {
    frame: inFrame, command: id, param1, param2, param3, param4,
    x: place ? degreesE7(place.latitude_deg) : 0, y: place ? degreesE7(wrapped(place.longitude_deg)) : 0, z: place?.altitude_m ?? 0,
  };
}

// Of a received MISSION_ITEM_INT, what is stored.
export const itemOf = ({ frame: inFrame, command: id, param1, param2, param3, param4, x, y, z }) =>
  ({ frame: inFrame, command: id, param1, param2, param3, param4, x, y, z });

// An unset parameter is 0 or NaN.
const isSameParam = (a, b) => Math.abs((a || 0) - (b || 0)) <= paramTolerance * Math.max(1, Math.abs(a || 0));

export function isSameItem(a, b) {
  return (withoutInt[a.frame] ?? a.frame) === (withoutInt[b.frame] ?? b.frame) && a.command === b.command &&
    params.every((name) => isSameParam(a[name], b[name])) && Math.abs(a.x - b.x) <= 1 && Math.abs(a.y - b.y) <= 1 &&
    Math.abs(a.z - b.z) <= altitudeTolerance_m;
}

// hasHome: item 0 is the autopilot's home, which is its own affair.
export function areSame(a, b, { hasHome = false } = {}) {
  if (a.length !== b.length) return false;
  return a.every((one, i) => (hasHome && i === 0) || isSameItem(one, b[i]));
}

// What uploads that were broken off may leave: each item of one of the lists, and no more items than
// the longest has.
export function isMixture(items, lists, { hasHome = false } = {}) {
  if (items.length > Math.max(...lists.map((list) => list.length))) return false;
  return items.every((one, i) => (hasHome && i === 0) || lists.some((list) => list[i] && isSameItem(one, list[i])));
}
