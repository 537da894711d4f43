// By how much the clock of pictures differs from that of the triggers, if the intervals between them
// tell it. Pure.

const minNumMatched = 3;
// Another offset that explains nearly as many pictures could as well be the true one: pictures may be
// missing, and triggers may not have been heard. Pictures without a trigger show how often that is.
const faults = (numMatched, numUnmatched) => 5 + 0.2 * numMatched + numUnmatched;
const maxNumPictures = 120;
const maxNumTriggers = 2000;

// Differences of all pairs that may belong together, sorted: { offset_us, picture (its number) }.
function differencesOf(pictures, triggers, limit_us) {
  const differences = [];
  for (const [number, picture] of pictures.slice(-maxNumPictures).entries()) {
    for (const trigger of triggers.slice(-maxNumTriggers)) {
      const offset_us = picture.time_us - trigger.time_us;
      // A picture that was there before its trigger is of another one.
      if (Math.abs(offset_us) <= limit_us && trigger.order < picture.order) differences.push({ offset_us, picture: number });
    }
  }
  return differences.sort((a, b) => a.offset_us - b.offset_us);
}

// Offsets, with how many pictures have a trigger there, and how many pairs there are.
function windowsOf(differences, width_us) {
  const windows = [];
  const numOf = new Int32Array(maxNumPictures);
  let numPictures = 0;
  for (let first = 0, end = 0; first < differences.length; ++first) {
    for (; end < differences.length && differences[end].offset_us - differences[first].offset_us <= width_us; ++end) {
      if (numOf[differences[end].picture]++ === 0) ++numPictures;
    }
    windows.push({ offset_us: differences[(first + end - 1) >> 1].offset_us, numPictures, numPairs: end - first });
    if (--numOf[differences[first].picture] === 0) --numPictures;
  }
  return windows;
}

// Pictures from the time of the triggers that were heard.
function numWithin(pictures, triggers, offset_us) {
  const times_us = triggers.slice(-maxNumTriggers).map(({ time_us }) => time_us);
  const [first_us, last_us] = [Math.min(...times_us), Math.max(...times_us)];
  return pictures.slice(-maxNumPictures)
    .filter(({ time_us }) => time_us - offset_us >= first_us && time_us - offset_us <= last_us).length;
}

function offsetWithin(pictures, triggers, differences, tolerance_us) {
  const windows = windowsOf(differences, 2 * tolerance_us);
  let best;
  for (const window of windows) if (!best || window.numPictures > best.numPictures) best = window;
  if (!best || best.numPictures < minNumMatched) return undefined;
  const numUnmatched = Math.max(0, numWithin(pictures, triggers, best.offset_us) - best.numPictures);
  const allowed = faults(best.numPictures, numUnmatched);
  const isOther = ({ offset_us, numPictures }) =>
    Math.abs(offset_us - best.offset_us) > tolerance_us && numPictures >= best.numPictures - allowed;
  // Triggers that are closer together than the times are sharp.
  const isCoarse = best.numPairs > best.numPictures + allowed;
  if (isCoarse || windows.some(isOther)) return undefined;
  return { offset_us: best.offset_us, tolerance_us };
}

// { offset_us, tolerance_us } if only one offset explains what was seen, with the least of the
// tolerances that shows it; else nothing. pictures and triggers: [{ time_us, order }], the newest
// last; order: of arrival, common to both. limit_us: largest offset.
export function clockOffset(pictures, triggers, { tolerances_us, limit_us }) {
  const differences = differencesOf(pictures, triggers, limit_us);
  for (const tolerance_us of tolerances_us) {
    const found = offsetWithin(pictures, triggers, differences, tolerance_us);
    if (found) return found;
  }
  return undefined;
}
