// Texts about what a place of the map was made of: its photographs, heights, cues and nearest limit.

import { fixed, isKnown, words } from './units.js';

const partNames = { ground: 'the ground', final: 'the final', circle: 'the loiter circle', position: 'the position of the touchdown', wind: 'the wind' };

// Of the log-odds; the server cuts larger ones.
export const kMostLogOdds = 7.875;

// What denies grass, or what speaks for and against it.
const cueNames = {
  views: 'grass in the photographs', look_alike: 'crop that looks like grass', small_object: 'small object',
  fence: 'fence',
};

export const cueName = (cue) => cueNames[cue] ?? words(cue);

const number = (value) => String(Number(value.toFixed(3)));

// "Nearest limit of the risk: the ground, 0.024 of 0.1 allowed, 0.076 left." Empty if an older server does not tell it.
export function nearestLimitText(limit) {
  if (limit === undefined) return '';
  if (limit === null) return 'Nearest limit of the risk: unknown, because no landing could be computed here.';
  const { part, value, limit: most, margin, whole } = limit;
  const rest = margin < 0 ? `${number(-margin)} too much` : `${number(margin)} left`;
  const together = isKnown(whole) && number(whole) !== number(value) ? ` All risks together: ${number(whole)}.` : '';
  return `Nearest limit of the risk: ${partNames[part] ?? words(part)}, ${number(value)} of ${number(most)} allowed, ${rest}.${together}`;
}

export const percent = (share) => `${share > 0 && share < 0.005 ? '< 1' : Math.round(100 * share)}\u00a0%`;

// If no photographs were matched, all weights are 0.
export const hasWeights = (patches) => patches.some(({ weight }) => weight > 0);

// The map shows nothing there: no photograph, height or cue can be stored. An older server tells none of them either.
export const isBlank = ({ frames, height_m }) => !frames && !isKnown(height_m);

// Why there is no picture to show; null if there is one.
export function noPatchesText({ frames, patches }) {
  if (patches?.length) return null;
  if (frames?.length) return `In ${frames.length} photograph${frames.length === 1 ? '' : 's'}. Where in them is not stored.`;
  return frames ? 'No photograph shows this place.' : 'Which photographs show this place is not stored.';
}

export const bestHeight_m = ({ height_m, log_likelihood }) => height_m[log_likelihood.indexOf(Math.max(...log_likelihood))];

// stored: {height_m, height_sd_m} of the map.
export function likelihoodText(likelihood, { height_m, height_sd_m }) {
  const sd = isKnown(height_sd_m) ? ` ± ${fixed(height_sd_m, 2)}` : '';
  const stored = isKnown(height_m) ? ` Stored: ${fixed(height_m, 2)}${sd} m.` : '';
  return `${likelihood.num_views} photographs agree best at ${fixed(bestHeight_m(likelihood), 2, 'm')}, with a correlation of ` +
    `${fixed(likelihood.correlation, 2)}.${stored}`;
}

// "+2.3", "−1.0"; what was cut is at least as large.
export function logOddsText(log_odds) {
  const sign = log_odds < 0 ? '−' : '+';
  const isCut = Math.abs(log_odds) >= kMostLogOdds;
  return `${isCut ? (log_odds < 0 ? '≤ ' : '≥ ') : ''}${sign}${Math.abs(log_odds).toFixed(1)}`;
}

// {telling: cues that deny or weigh, silent: names without objection, unknown: names}
export function cuesByWeight(cues) {
  return {
    telling: cues.filter(({ denies, log_odds }) => denies || (isKnown(log_odds) && log_odds !== 0)),
    silent: cues.filter(({ denies, log_odds }) => !denies && log_odds === 0).map(({ cue }) => cueName(cue)),
    unknown: cues.filter(({ denies, log_odds }) => !denies && !isKnown(log_odds)).map(({ cue }) => cueName(cue)),
  };
}

// A step of 1, 2 or 5 times a power of ten that divides a range into at most `most` parts.
export function niceStep(range, most) {
  const power = 10 ** Math.floor(Math.log10(range / most));
  return [1, 2, 5, 10].map((factor) => factor * power).find((step) => range / step <= most * (1 + 1e-9));
}
