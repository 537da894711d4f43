// Stored strips on which new photographs show something: the event, the obstacle that covers the strip, and their texts.

import { clockOf, isKnown } from './units.js';

const kPrefix = 'strip-';

// {siteId, seen_at, expires_at, place} of an obstacle that covers a strip; null for any other obstacle.
export function stripOf({ id, properties: p, geometry }) {
  const obstacleId = p.id ?? id ?? '';
  if (p.kind !== 'no_fly' || !obstacleId.startsWith(kPrefix)) return null;
  const ring = geometry.coordinates[0].slice(0, -1);
  const middle = (k) => ring.reduce((sum, point) => sum + point[k], 0) / ring.length;
  return {
    siteId: obstacleId.slice(kPrefix.length), obstacleId, seen_at: /seen (\S+)/.exec(p.name ?? '')?.[1], expires_at: p.expires_at,
    place: { latitude_deg: middle(1), longitude_deg: middle(0) },
  };
}

// Of a site in an emergency answer: what its way crosses is named there, without a time.
export const stripOfAnswer = ({ site_id, airspaces }) => (airspaces?.includes(kPrefix + site_id) ? {} : undefined);

export const isOver = ({ expires_at }, now_ms = Date.now()) => Date.parse(expires_at) <= now_ms;

const metres = (value_m) => (value_m < 1 ? value_m.toFixed(1) : String(Math.round(value_m)));

// ": about 4 m × 2 m", ": 3 things, the largest about 4 m × 2 m"
export function sizeText(things = []) {
  const sized = things.filter(({ length_m, width_m }) => isKnown(length_m) && isKnown(width_m));
  const largest = sized.toSorted((a, b) => b.length_m * b.width_m - a.length_m * a.width_m)[0];
  if (!largest) return '';
  const size = `about ${metres(largest.length_m)} m × ${metres(largest.width_m)} m`;
  return things.length === 1 ? `: ${size}` : `: ${things.length} things, the largest ${size}`;
}

const seenText = ({ seen_at }) => (seen_at ? `, seen ${clockOf(seen_at)}` : '');

// event: of a strip that is occupied. nameOf(site id).
export function noticeText(event, nameOf) {
  const count = event.frames?.length ?? 0;
  const by = count > 0 ? ` by ${count} photograph${count === 1 ? '' : 's'}` : '';
  return `Something new stands on ${nameOf(event.site_id)}${sizeText(event.things)}${seenText(event)}${by}.`;
}

export const alternateText = ({ alternate }, nameOf) =>
  (alternate ? `Best other site in reach: ${nameOf(alternate)}.` : 'No other site is known to be in reach.');

// In the list of sites, and on an emergency card.
export const shortText = (strip) => `Something new on the strip${seenText(strip)}`;

// In the card of the site.
export const stripText = (strip) => `Something new stands on this strip${seenText(strip)}. ` +
  `Until ${clockOf(strip.expires_at)}, or until new photographs show it free, this site ranks last in an emergency.`;
