// Which trigger took which picture. What is not sure is not paired. Pure.
//
// 1. By name, if a message of the current flight told it (CAMERA_IMAGE_CAPTURED): one message and one
//    picture of that name at about that time.
// 2. By time: pictures whose time is of the same kind (EXIF, EXIF in whole seconds, file) have one
//    offset to the triggers. If only one offset explains the intervals, a picture belongs to the
//    trigger at its time, unless another trigger, or another picture, is near.

import { clockOffset } from './clock_offset.js';

// By kind of time, the least first: how evenly cameras and programs work is not known before. A whole
// second lies within half a second of its middle.
const tolerancesOf_us = { exif: [50_000, 100_000, 200_000], exif_seconds: [600_000], file: [50_000, 100_000, 200_000] };
// No camera takes pictures as close together as this; a coarser time could be that of a neighbour.
const coarse_us = 400_000;
// Of one exposure several messages may tell; the best kind that is heard in a flight counts.
const kinds = ['CAMERA_IMAGE_CAPTURED', 'CAMERA_FEEDBACK', 'CAMERA_TRIGGER'];
// A message comes later than its exposure.
const settle_us = 3_000_000;
const sureFor_ms = 30_000;
const unsureFor_ms = 5000;

const fileName = (path) => path.split(/[\\/]/).at(-1).toLowerCase();

function countsOf(names) {
  const counts = new Map();
  for (const name of names) counts.set(name, (counts.get(name) ?? 0) + 1);
  return counts;
}

export function triggersThatCount(triggers) {
  const best = new Map();
  for (const { session, kind } of triggers) best.set(session, Math.min(best.get(session) ?? kinds.length, kinds.indexOf(kind)));
  return triggers.filter(({ session, kind }) => kinds.indexOf(kind) === best.get(session)).sort((a, b) => a.time_us - b.time_us);
}

function grouped(values, keyOf) {
  const groups = new Map();
  for (const value of values) {
    const key = keyOf(value);
    if (groups.has(key)) groups.get(key).push(value);
    else groups.set(key, [value]);
  }
  return groups;
}

// pictures: [{ name, time_us, time_kind, order }]; triggers: with a file, of one session: a camera may
// begin its names anew.
function pairsByName(pictures, triggers, limit_us) {
  const picturesOf = grouped(pictures, ({ name }) => name.toLowerCase());
  const pairs = new Map();
  for (const [name, [trigger, ...others]] of grouped(triggers, ({ file }) => fileName(file))) {
    const fitting = (picturesOf.get(name) ?? []).filter(({ time_us, order }) =>
      trigger.order < order && Math.abs(time_us - trigger.time_us) <= limit_us);
    if (others.length === 0 && fitting.length === 1) pairs.set(fitting[0], trigger);
  }
  return pairs;
}

// Index of the first value that is not less.
function lowerBound(values, value) {
  let low = 0;
  let high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

// Beside this trigger there may have been another one that was not heard.
function hasUnheard(triggers, at) {
  const isNext = (a, b) => b.index === a.index + 1;
  const [before, trigger, after] = [triggers[at - 1], triggers[at], triggers[at + 1]];
  const isFirst = !before && trigger.index <= 1;
  return !(isFirst || (before && isNext(before, trigger))) || !after || !isNext(trigger, after);
}

// The only trigger near the picture's time; nothing if there is none or a second one.
function triggerAt(picture, triggers, times_us, { offset_us, tolerance_us: sharp_us }) {
  const tolerance = Math.min(2 * sharp_us, tolerancesOf_us[picture.time_kind].at(-1));
  const time_us = picture.time_us - offset_us;
  const first = lowerBound(times_us, time_us - 2 * tolerance);
  const end = lowerBound(times_us, time_us + 2 * tolerance + 1);
  if (end - first !== 1) return undefined;
  const trigger = triggers[first];
  if (tolerance >= coarse_us && hasUnheard(triggers, first)) return undefined;
  return Math.abs(trigger.time_us - time_us) <= tolerance && trigger.order < picture.order ? trigger : undefined;
}

export class Pairing {
  #limit_us;
  // By kind of time: when the offset was searched last, and the offset if it was found.
  #searches = {};

  // limit_us: how far the clock of pictures is from UTC at most.
  constructor({ limit_us }) { this.#limit_us = limit_us; }

  // By kind of time: seconds, if it is known.
  get offsets_s() {
    return Object.fromEntries(Object.entries(this.#searches).filter(([, { offset }]) => offset)
      .map(([kind, { offset }]) => [kind, offset.offset_us / 1e6]));
  }

  // A search takes long on a slow board, and guidance must not wait for it.
  #offsetOf(kind, group, triggers, now_ms) {
    const last = this.#searches[kind];
    if (last && now_ms - last.at_ms < (last.offset ? sureFor_ms : unsureFor_ms)) return last.offset;
    const offset = clockOffset(group, triggers, { tolerances_us: tolerancesOf_us[kind], limit_us: this.#limit_us });
    this.#searches[kind] = { at_ms: now_ms, offset };
    return offset;
  }

  // { pairs: Map of picture to trigger, unpaired: pictures for which the offset is known and yet no
  // trigger is sure }. The others wait. pictures: all, also those that were paired before. session: the
  // current one. used_us: Set of the times of triggers whose picture was sent. now_ms: a clock that
  // never steps.
  pair(pictures, allTriggers, { session, used_us = new Set(), now_ms = performance.now() } = {}) {
    const triggers = triggersThatCount(allTriggers);
    const times_us = triggers.map(({ time_us }) => time_us);
    const named = triggers.filter((trigger) => trigger.session === session && trigger.file && !used_us.has(trigger.time_us));
    const pairs = pairsByName(pictures, named, this.#limit_us);
    const unpaired = [];
    for (const kind of Object.keys(tolerancesOf_us)) {
      const group = pictures.filter((picture) => picture.time_kind === kind && !pairs.has(picture));
      const offset = group.length ? this.#offsetOf(kind, group, triggers, now_ms) : undefined;
      for (const picture of offset ? group : []) {
        const trigger = triggerAt(picture, triggers, times_us, offset);
        if (trigger) pairs.set(picture, trigger);
        else if (picture.time_us - offset.offset_us + settle_us < (times_us.at(-1) ?? -Infinity)) unpaired.push(picture);
      }
    }
    return { pairs: withoutTaken(pairs, unpaired, used_us), unpaired };
  }
}

// Two pictures of one trigger: neither is sure.
function withoutTaken(pairs, unpaired, used_us) {
  const numPictures = countsOf(pairs.values());
  for (const [picture, trigger] of pairs) {
    if (numPictures.get(trigger) === 1 && !used_us.has(trigger.time_us)) continue;
    pairs.delete(picture);
    unpaired.push(picture);
  }
  return pairs;
}
