// The part of the autopilot's mission that is not flown yet, as a route: from where the aircraft is,
// through the places that the items name, to where the landing begins. Pure.

import { distance_m } from '../flat_frame.js';
import { MavCmd, MavFrame } from '../messages.js';

const places = new Set([MavCmd.NAV_WAYPOINT, MavCmd.NAV_LOITER_TURNS, MavCmd.NAV_LOITER_TIME, MavCmd.NAV_LOITER_TO_ALT,
  MavCmd.NAV_SPLINE_WAYPOINT]);
const ends = {
  [MavCmd.DO_LAND_START]: 'the landing', [MavCmd.NAV_LAND]: 'the landing', [MavCmd.NAV_VTOL_LAND]: 'the landing',
  [MavCmd.NAV_RETURN_TO_LAUNCH]: 'the return to launch', [MavCmd.NAV_LOITER_UNLIM]: 'the loiter',
};
// They do not lead elsewhere.
const stays = new Set([MavCmd.NAV_TAKEOFF, MavCmd.NAV_ROI]);
// DO_JUMP_TAG, and navigation that is not flown to a place.
const isUnknownWay = (number) => number === MavCmd.DO_JUMP_TAG ||
  (number < MavCmd.NAV_LAST && !places.has(number) && !(number in ends) && !stays.has(number));
const amsl = new Set([MavFrame.GLOBAL, MavFrame.GLOBAL_INT]);
const aboveHome = new Set([MavFrame.GLOBAL_RELATIVE_ALT, MavFrame.GLOBAL_RELATIVE_ALT_INT]);
const moreOfMission = 'more of the mission';
const maxNumSteps = 5000;
// Fewer than /v1/routes/check takes.
const maxNumPoints = 500;
const least_m = 1;

// Nothing if its height is above the terrain, which the link does not know.
function placeOf({ frame, x, y, z }, before, home_altitude_m) {
  const base_m = amsl.has(frame) ? 0 : aboveHome.has(frame) ? home_altitude_m : undefined;
  if (base_m === undefined) return undefined;
  const { latitude_deg, longitude_deg } = x === 0 && y === 0 ? before : { latitude_deg: x / 1e7, longitude_deg: y / 1e7 };
  return { latitude_deg, longitude_deg, altitude_m: base_m + z };
}

// The items in the order in which they are flown, then { end, isWhole } unless there are too many.
// How often a jump was made already is not known, so it counts in full.
function* flownItems(items, first, lowest) {
  const jumps = new Map();
  let at = Math.max(lowest, first);
  for (let step = 0; at < items.length; ++step) {
    if (step >= maxNumSteps) return;
    const one = items[at];
    if (one.command !== MavCmd.DO_JUMP) {
      yield { ...one, seq: at };
      ++at;
      continue;
    }
    const left = jumps.get(at) ?? (one.param2 < 0 ? Infinity : one.param2);
    const target = one.param1;
    if (left > 0 && !(Number.isInteger(target) && target >= lowest && target < items.length)) {
      yield { end: `item ${at}, a jump to no item`, isWhole: false };
      return;
    }
    jumps.set(at, left - 1);
    at = left > 0 ? target : at + 1;
  }
  yield { end: 'the end of the mission', isWhole: true };
}

// { route: [{ latitude_deg, longitude_deg, altitude_m }], end: what comes after it, isWhole: nothing of the
// mission does }. items: of the autopilot; ArduPilot's first is its home. position: where the aircraft
// is. longest_m: a longer mission is cut there.
export function remainingRoute({ items, current_item, isArdupilot, position, home_altitude_m, longest_m }) {
  const { latitude_deg, longitude_deg, altitude_m } = position;
  const route = [{ latitude_deg, longitude_deg, altitude_m }];
  let length_m = 0;
  for (const one of flownItems(items, current_item, isArdupilot ? 1 : 0)) {
    if (one.end) return { route, ...one };
    if (isUnknownWay(one.command)) return { route, end: `item ${one.seq}, command ${one.command}, whose way is not known`, isWhole: false };
    const last = route.at(-1);
    const isLast = one.command in ends;
    if (places.has(one.command) || one.command === MavCmd.NAV_LOITER_UNLIM) {
      const place = placeOf(one, last, home_altitude_m);
      if (!place) return { route, end: `item ${one.seq}, whose height is above the terrain`, isWhole: false };
      const leg_m = distance_m(last, place);
      if (leg_m >= least_m) route.push(place);
      length_m += leg_m;
    }
    if (isLast) return { route, end: ends[one.command], isWhole: true };
    if (length_m > longest_m || route.length >= maxNumPoints) return { route, end: moreOfMission, isWhole: false };
  }
  return { route, end: moreOfMission, isWhole: false };
}
