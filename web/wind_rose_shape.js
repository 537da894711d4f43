// The wind rose as geometry and as text, without the DOM. Cells lie by direction and speed around the calm.

import { heading } from './units.js';

export const kSpeeds_mps = [0, 2.5, 5, 7.5, 10];
export const kVerdicts = ['landable', 'unverified', 'rejected'];
const kCalmRadius = 20;
const kRingWidth = 26;
export const kRim = kCalmRadius + kRingWidth * (kSpeeds_mps.length - 1);

// Each wind once: a calm has no direction.
export const windsOf = (rose) => rose.entries.filter((e) => e.wind_speed_mps > 0 || e.wind_from_deg === 0);

// Landable winds count first, then unverified ones.
const worthOf = (rose, from_deg) => rose.entries
  .filter((e) => e.wind_from_deg === from_deg && e.wind_speed_mps > 0)
  .reduce((sum, e) => sum + { landable: 1000, unverified: 1, rejected: 0 }[e.verdict], 0);

// {from_deg, to_deg}: the longest run of directions with most landable winds. {isAlike: true} if all
// directions are equal, null if no wind is usable.
export function bestDirections(rose) {
  const worth = rose.directions_deg.map((from_deg) => worthOf(rose, from_deg));
  const most = Math.max(...worth);
  if (!(most > 0)) return null;
  const count = worth.length;
  if (worth.every((each) => each === most)) return { isAlike: true };
  let best = { length: 0 };
  for (let first = 0; first < count; ++first) {
    let length = 0;
    while (worth[(first + length) % count] === most) ++length;
    if (length > best.length) best = { first, length };
  }
  const { first, length } = best;
  return { from_deg: rose.directions_deg[first], to_deg: rose.directions_deg[(first + length - 1) % count] };
}

function bestText(best) {
  if (!best) return '';
  if (best.isAlike) return ' All directions are equal.';
  return ` Best from ${heading(best.from_deg)}${best.from_deg === best.to_deg ? '' : ` to ${heading(best.to_deg)}`}.`;
}

// The rose in words.
export function roseText(rose) {
  const winds = windsOf(rose);
  const [numLandable, numUnverified] = kVerdicts.map((verdict) => winds.filter((e) => e.verdict === verdict).length);
  return `Landable in ${numLandable || 'none'} of ${winds.length} winds` +
    `${numUnverified ? `, unverified in ${numUnverified}` : ''}.${bestText(bestDirections(rose))}`;
}

// Distance of a speed from the centre; the middle of its ring for the speed of a cell.
export function radiusOf(speed_mps) {
  const middles = kSpeeds_mps.map((_, i) => (i === 0 ? 0 : kCalmRadius + (i - 0.5) * kRingWidth));
  const i = kSpeeds_mps.findIndex((each) => each >= speed_mps);
  if (i < 0) return kRim;
  if (i === 0) return 0;
  const share = (speed_mps - kSpeeds_mps[i - 1]) / (kSpeeds_mps[i] - kSpeeds_mps[i - 1]);
  return middles[i - 1] + share * (middles[i] - middles[i - 1]);
}

// "x y" of a point, north up.
export const pointAt = (radius, from_deg) => {
  const from_rad = from_deg * Math.PI / 180;
  return `${(radius * Math.sin(from_rad)).toFixed(2)} ${(-radius * Math.cos(from_rad)).toFixed(2)}`;
};

// SVG path of a cell. ring 0 is the calm.
export function cellPath(ring, from_deg, width_deg) {
  if (ring === 0) return `M0 ${-kCalmRadius}A${kCalmRadius} ${kCalmRadius} 0 1 1 -0.01 ${-kCalmRadius}Z`;
  const [inner, outer] = [kCalmRadius + (ring - 1) * kRingWidth, kCalmRadius + ring * kRingWidth];
  const [left, right] = [from_deg - width_deg / 2, from_deg + width_deg / 2];
  return `M${pointAt(inner, left)}L${pointAt(outer, left)}A${outer} ${outer} 0 0 1 ${pointAt(outer, right)}` +
    `L${pointAt(inner, right)}A${inner} ${inner} 0 0 0 ${pointAt(inner, left)}Z`;
}
