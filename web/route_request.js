// A planned route: what is asked of the server, and the texts about its answer. Pure functions: no DOM, no requests.

import { courseTo, heading, isKnown, margin, windTo } from './units.js';

const kSameAltitude_m = 1;

// 75 -> "1:15", 3675 -> "1:01:15".
export function clock(time_s) {
  const whole_s = Math.round(time_s);
  const two = (value) => String(value).padStart(2, '0');
  const [hours, minutes] = [Math.floor(whole_s / 3600), Math.floor(whole_s / 60) % 60];
  return hours ? `${hours}:${two(minutes)}:${two(whole_s % 60)}` : `${minutes}:${two(whole_s % 60)}`;
}

const isEmpty = ({ points, plan }) => points.length === 0 && !plan;
const needsAltitude = ({ points, plan }) => !plan && points.some(({ altitude_m }) => !isKnown(altitude_m));

// What is missing, as {field, detail}; null if the server can be asked. draft: {points, plan}; a point without altitude_m
// is at values.altitude_m. plan: {name, json}, or null.
export function faultOf(draft, values) {
  if (isEmpty(draft) || (!draft.plan && draft.points.length < 2)) {
    return { field: null, detail: 'Draw at least two points, or choose a plan.' };
  }
  if (needsAltitude(draft) && !isKnown(values.altitude_m)) return { field: 'altitude_m', detail: 'Enter the altitude of the route.' };
  if (!isKnown(values.airspeed_mps)) return { field: 'airspeed_mps', detail: 'Enter the airspeed.' };
  const [speed_mps, from_deg] = [values.wind_speed_mps, values.wind_from_deg];
  if (isKnown(speed_mps) && speed_mps > 0 && !isKnown(from_deg)) return { field: 'wind_from_deg', detail: 'Enter where the wind comes from.' };
  if (!isKnown(speed_mps) && isKnown(from_deg)) return { field: 'wind_speed_mps', detail: 'Enter the wind speed, or leave both empty.' };
  return null;
}

const rounded = (value) => Number(value.toFixed(3)) + 0;  // never −0

// null if the wind is unknown.
function windOf({ wind_speed_mps, wind_from_deg, wind_sd_mps }) {
  if (!isKnown(wind_speed_mps)) return null;
  const { east_mps, north_mps } = windTo(wind_speed_mps, wind_from_deg ?? 0);
  return { east_mps: rounded(east_mps), north_mps: rounded(north_mps), ...(wind_sd_mps > 0 ? { sd_mps: wind_sd_mps } : {}) };
}

// The body of POST /v1/routes/check. values.aircraft: a profile's name, fields, or null for each site's own.
export function requestOf({ points, plan }, values) {
  const wind = windOf(values);
  const place = ({ latitude_deg, longitude_deg, altitude_m }) => ({ latitude_deg, longitude_deg, altitude_m: altitude_m ?? values.altitude_m });
  return {
    ...(plan ? { plan: plan.json } : { route: points.map(place) }), altitude_datum: 'amsl', airspeed_mps: values.airspeed_mps,
    ...(wind ? { wind } : {}), ...(values.aircraft ? { aircraft: values.aircraft } : {}),
  };
}

// The same request with the plan's file as body: its query, or null if the request cannot be asked in this way.
export function planQueryOf({ plan, wind, aircraft, ...rest }) {
  if (!plan || (aircraft && typeof aircraft !== 'string')) return null;
  const winds = wind ? Object.fromEntries(Object.entries(wind).map(([name, value]) => [`wind_${name}`, value])) : {};
  return { ...rest, ...winds, aircraft };
}

// {json, airspeed_mps} of a plan of QGroundControl; throws if the text is none.
export function planOf(text) {
  let json = null;
  try { json = JSON.parse(text); } catch { /* reported below */ }
  if (json?.fileType !== 'Plan' || !json.mission) throw new Error('This file is not a plan of QGroundControl.');
  return { json, airspeed_mps: isKnown(json.mission.cruiseSpeed) ? json.mission.cruiseSpeed : null };
}

// "3 points", "4 points, 580 m to 630 m AMSL", "Plan survey.plan".
export function draftText({ points, plan }) {
  if (plan) return `Plan ${plan.name}. Its altitudes count.`;
  const altitudes_m = points.map(({ altitude_m }) => altitude_m).filter(isKnown);
  const [least, most] = [Math.min(...altitudes_m), Math.max(...altitudes_m)].map((value) => value.toFixed(0));
  const count = `${points.length} ${points.length === 1 ? 'point' : 'points'}`;
  if (altitudes_m.length === 0) return count;
  return `${count}, ${least === most ? `${least} m` : `${least} m to ${most} m`} AMSL`;
}

// Neighbouring samples with the same covered: [{isCovered, places}]. Each ends where the next one begins.
export function spansOf({ samples, end }) {
  const spans = [];
  samples.forEach((sample) => {
    if (spans.at(-1)?.isCovered === sample.covered) return spans.at(-1).places.push(sample);
    spans.at(-1)?.places.push(sample);
    return spans.push({ isCovered: sample.covered, places: [sample] });
  });
  spans.at(-1)?.places.push(end);
  return spans;
}

// Rounded down: a route with a gap is never 100 % covered.
export const coveredText = ({ covered_ratio }) => `${Math.floor(100 * covered_ratio + 1e-9)} %`;

export const uncovered_s = ({ gaps }) => gaps.reduce((sum, { from_s, to_s }) => sum + to_s - from_s, 0);

const reasons = {
  too_low: 'too low', too_high: 'too near and too high', terrain: 'terrain or an obstacle is in the way', no_approach: 'no approach in this wind',
  no_site: 'no site is stored within any glide', not_evaluated: 'not evaluated',
};

// {title, lines} about a sample. nameOf(site id): how the page calls a site.
export function momentText(sample, nameOf) {
  const at = `${clock(sample.time_s)}, ${sample.altitude_m.toFixed(0)} m AMSL, heading ${heading(sample.heading_deg)}`;
  const margin_m = margin(sample.arrival_margin_m);
  const site = sample.best_site ? nameOf(sample.best_site) : null;
  if (sample.covered) {
    const failure = isKnown(sample.failure_probability) ? `, failure probability ${(100 * sample.failure_probability).toFixed(1)} %` : '';
    return { title: `✓ ${site}, arrival margin ${margin_m}`, lines: [at + failure] };
  }
  const share = sample.covered_weight > 0 ? `In reach in ${Math.floor(100 * sample.covered_weight)} % of the winds. ` : '';
  const miss = isKnown(sample.arrival_margin_m) ? `. Arrival margin ${margin_m}${site ? ` at ${site}` : ''}` : '';
  return { title: `✕ No site in reach: ${reasons[sample.reason] ?? 'reason unknown'}`, lines: [`${share}${at}${miss}`] };
}

// How the page calls a site: by its rank in the selected flight, else by its flight; the id if neither is known.
export function siteName(id, rank, flights) {
  if (rank) return `site ${rank}`;
  const flight = flights.find((candidate) => id.startsWith(`${candidate.id}-`));
  return flight ? `site ${id.slice(flight.id.length + 1)} of ${flight.name || flight.id}` : id;
}

// The sentence of the server as a line of text, with the page's names for sites.
export function sentenceOf(text, nameOf) {
  const named = text.replace(/[A-Za-z0-9][\w.-]*\w/g, (word) => nameOf(word));
  return `${named[0].toUpperCase()}${named.slice(1)}.`;
}

// The part of a changed route that differs from the samples of the former one, with one point of it on both sides:
// {points, highest: the middle one of its highest points, or null if no altitude differs}.
export function changedPart(route, samples) {
  const [first, second] = samples;
  const near_m = second ? 10 + courseTo(first, second).distance_m : 10;
  const differences = route.map((point) => {
    const nearest = samples.map((sample) => ({ sample, distance_m: courseTo(sample, point).distance_m }))
      .reduce((best, other) => (other.distance_m < best.distance_m ? other : best));
    const isHigher = point.altitude_m - nearest.sample.altitude_m > kSameAltitude_m;
    return { point, isHigher, isChanged: nearest.distance_m > near_m || isHigher };
  });
  const from = differences.findIndex(({ isChanged }) => isChanged);
  const to = differences.findLastIndex(({ isChanged }) => isChanged);
  const higher = differences.filter(({ isHigher }) => isHigher).map(({ point }) => point);
  const most_m = Math.max(...higher.map(({ altitude_m }) => altitude_m));
  const highest = higher.filter(({ altitude_m }) => altitude_m > most_m - kSameAltitude_m);
  return { points: from < 0 ? route : route.slice(Math.max(0, from - 1), to + 2), highest: highest[Math.floor(highest.length / 2)] ?? null };
}
