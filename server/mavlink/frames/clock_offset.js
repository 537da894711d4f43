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

// { offset_us, numMatched } if only one offset explains what was seen; else nothing. pictures and
// triggers: [{ time_us, order }], the newest last; order: of arrival, common to both. tolerance_us:
// of a single difference. limit_us: largest offset.
export function clockOffset(pictures, triggers, { tolerance_us, limit_us }) {
  const windows = windowsOf(differencesOf(pictures, triggers, limit_us), 2 * tolerance_us);
  let best;
  for (const window of windows) if (!best || window.numPictures > best.numPictures) best = window;
  if (!best || best.numPictures < minNumMatched) return undefined;
  const allowed = faults(best.numPictures, Math.min(pictures.length, maxNumPictures) - best.numPictures);
  const isOther = ({ offset_us, numPictures }) =>
    Math.abs(offset_us - best.offset_us) > tolerance_us && numPictures >= best.numPictures - allowed;
  // Triggers that are closer together than the times are sharp.
  const isCoarse = best.numPairs > best.numPictures + allowed;
  if (isCoarse || windows.some(isOther)) return undefined;
  return { offset_us: best.offset_us, numMatched: best.numPictures };
}
