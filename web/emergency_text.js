// Sentences and colours of the emergency view, all made from the answer that is shown. No DOM.

import { age, fixed, isKnown, margin } from './units.js';

// A position this old is not where the aircraft is.
export const kOldPosition_s = 60;
// Recall compares margins in steps of this size.
const kPlenty_m = 15;
const kOldGround_s = 365 * 86400;

export const sentence = (text) => `${text[0].toUpperCase()}${text.slice(1)}${/[.!?]$/.test(text) ? '' : '.'}`;

export const isOldPosition = (pose) => Boolean(pose) && !(isKnown(pose.age_s) && pose.age_s <= kOldPosition_s);
// counts_as is the server's word. A wind that was entered is one of now.
export const isWindKnown = (wind) => Boolean(wind) && wind.counts_as !== 'unknown';
export const isWindOld = (wind) => !isWindKnown(wind) || wind.counts_as === 'old';

export const ageText = (age_s) => (isKnown(age_s) ? `${age(age_s)} old` : 'of unknown age');

function windWords(wind) {
  if (!wind) return 'Wind unknown.';
  if (!isWindKnown(wind)) return `Wind unknown: the last one is ${ageText(wind.age_s)}.`;
  return `Wind of the same flight, ${ageText(wind.age_s)}${isWindOld(wind) ? ': it may have changed' : ''}.`;
}

// pose and wind: of the flight's last data, as its alternates give them.
export const sourceText = ({ pose, wind, isWindEntered }, flightName) =>
  `Position and altitude of flight ${flightName}, ${ageText(pose.age_s)}. ${isWindEntered ? 'Wind as entered.' : windWords(wind)} ` +
  (isKnown(pose.heading_deg) ? 'Heading from its track.' : 'Heading unknown.');

// pose: whose answer this is, null for a position that the user entered.
export function headline({ sites, nearest_miss: miss, summary }, pose) {
  const from = isOldPosition(pose) ? `For the position ${isKnown(pose.age_s) ? `of ${age(pose.age_s)} ago` : 'of an unknown time'}: ` : '';
  const text = sites.length > 0 ? 'In reach, best first' : miss ? 'No site in reach. Closest miss:' : sentence(summary).slice(0, -1);
  return { text: from ? from + text[0].toLowerCase() + text.slice(1) : text, isBad: Boolean(from) || sites.length === 0 };
}

export const isTooHigh = ({ reachable, arrival_margin_m }) => reachable === false && arrival_margin_m >= 0;

// "enough", "scarce", "short" or "high": the colour of a margin.
export function marginKind(site) {
  if (isTooHigh(site)) return 'high';
  if (site.arrival_margin_m < 0) return 'short';
  return Math.floor(site.arrival_margin_m) < kPlenty_m ? 'scarce' : 'enough';
}

export const kinds = {
  enough: `arrives ${kPlenty_m} m or more above the final`,
  scarce: `arrives less than ${kPlenty_m} m above the final`,
  short: 'not in reach: too low',
  high: 'not in reach: too high',
};

export const marginText = (site) => (isTooHigh(site) ? 'too high' : margin(site.arrival_margin_m));

// {name, value, kind} of the height with which the aircraft arrives.
export function arrival(site) {
  const kind = marginKind(site);
  return kind === 'high' ? { name: 'Too high by', value: fixed(site.surplus_height_m, 0, 'm'), kind }
    : { name: 'Arrival margin', value: margin(site.arrival_margin_m), kind };
}

export function groundAge({ age_s }) {
  if (!isKnown(age_s)) return { text: 'date unknown', isOld: true };
  return { text: `${age(age_s)} ago`, isOld: age_s > kOldGround_s };
}

// What makes the site unverified. wind: of the answer, with its age; null if it is unknown.
export function doubts({ verdict, unseen_ratio, ...site }, wind) {
  if (verdict !== 'unverified') return [];
  const mapDoubt = 'doubted_at' in site ? 'another map does not show fit ground' : null;
  const windDoubt = !isWindKnown(wind) ? 'wind not known' : isWindOld(wind) ? `wind ${age(wind.age_s)} old` : null;
  const seenDoubt = unseen_ratio > 0 ? `${fixed(100 * unseen_ratio, 0, '%')} of the circle not measured` : null;
  const known = [mapDoubt, windDoubt, seenDoubt].filter(Boolean);
  return known.length > 0 ? known : ['some ground below the way was not measured'];
}
