// By how much the clock of pictures differs from that of the triggers, if the intervals between them
// tell it. Pure.

const minNumMatched = 3;
// Another offset that explains nearly as many pictures could as well be the true one: pictures may be
// missing, and triggers may not have been heard. Pictures without a trigger show how often that is.
const faults = (numMatched, numUnmatched) => 5 + 0.2 * numMatched + numUnmatched;
const maxNumPictures = 120;
const maxNumTriggers = 1000;
// Differences are sorted as whole numbers of this unit, each with the number of its picture.
const unit_us = 100;

// Differences of all pairs that may belong together, sorted: units times maxNumPictures, plus the
// number of the picture.
function differencesOf(pictures, triggers, limit_us) {
  const differences = [];
  const newest = triggers.slice(-maxNumTriggers);
  for (const [number, picture] of pictures.slice(-maxNumPictures).entries()) {
    for (const trigger of newest) {
      const offset_us = picture.time_us - trigger.time_us;
      // A picture that was there before its trigger is of another one.
      const isPossible = Math.abs(offset_us) <= limit_us && trigger.order < picture.order;
      if (isPossible) differences.push(Math.round(offset_us / unit_us) * maxNumPictures + number);
    }
  }
  return Float64Array.from(differences).sort();
}

const offsetOf = (difference) => Math.floor(difference / maxNumPictures) * unit_us;
const pictureOf = (difference) => difference - Math.floor(difference / maxNumPictures) * maxNumPictures;

// For the window that begins at each difference: how many pictures have a trigger in it, how many
// pairs there are, and its middle.
function windowsOf(differences, width_us) {
  const offsets_us = Float64Array.from(differences, offsetOf);
  const count = differences.length;
  const windows = { numPictures: new Int32Array(count), numPairs: new Int32Array(count), middles_us: new Float64Array(count) };
  const numOf = new Int32Array(maxNumPictures);
  let numPictures = 0;
  for (let first = 0, end = 0; first < count; ++first) {
    for (; end < count && offsets_us[end] <= offsets_us[first] + width_us; ++end) {
      if (numOf[pictureOf(differences[end])]++ === 0) ++numPictures;
    }
    windows.numPictures[first] = numPictures;
    windows.numPairs[first] = end - first;
    windows.middles_us[first] = offsets_us[(first + end - 1) >> 1];
    if (--numOf[pictureOf(differences[first])] === 0) --numPictures;
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
  const { numPictures, numPairs, middles_us } = windowsOf(differences, 2 * tolerance_us);
  const most = numPictures.reduce((best, count) => Math.max(best, count), 0);
  if (most < minNumMatched) return undefined;
  const best = numPictures.indexOf(most);
  const offset_us = middles_us[best];
  const allowed = faults(most, Math.max(0, numWithin(pictures, triggers, offset_us) - most));
  const isOther = (count, i) => count >= most - allowed && Math.abs(middles_us[i] - offset_us) > tolerance_us;
  // Triggers that are closer together than the times are sharp.
  const isCoarse = numPairs[best] > most + allowed;
  return isCoarse || numPictures.some(isOther) ? undefined : { offset_us, tolerance_us };
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
