// Ten situations of the emergency view, with the answers that a server gives in them.

import { offset } from './sample_parts.mjs';

const minute_s = 60, hour_s = 3600, year_s = 365.25 * 86400;
const wind = { east_mps: 3, north_mps: 1, sd_mps: 0.6, age_s: 4, source: 'autopilot', counts_as: 'known' };
const kTerrain = 'terrain on the way is known only where stored maps cover it';

const rad = (deg) => deg * Math.PI / 180;

// number: of the site, from which its direction follows. from: [lon, lat] of the aircraft.
function siteAt(from, number, flown, more) {
  const distance_m = 400 + 350 * number;
  const bearing_deg = (50 + 75 * number) % 360;
  const [longitude_deg, latitude_deg] = offset(from, distance_m * Math.sin(rad(bearing_deg)), distance_m * Math.cos(rad(bearing_deg)));
  return {
    site_id: number === 1 ? flown.properties.id : `${flown.flight}-other-${number}`, flight_id: flown.flight, rank: number, reachable: true,
    verdict: 'landable', unseen_ratio: 0, distance_m, bearing_deg, arrival_margin_m: 90 - 20 * number, time_s: 40 + 30 * number, score: 0.8,
    age_s: 3 * 86400, surplus_height_m: 0.4, altitude_datum: 'amsl', warnings: [], ground_speed_mps: 8.2,
    touchdown: { latitude_deg, longitude_deg, altitude_m: 450 }, approach: flown.properties.approach, ...more,
  };
}

// flown: see flownSite. from: [lon, lat] of the aircraft.
export function sampleEmergencies(flown, from) {
  const site = (number, more) => siteAt(from, number, flown, more);
  const unverified = (number, more) => site(number, { verdict: 'unverified', ground_speed_mps: undefined, ...more });
  const taken = (more = {}) => ({ flight_id: flown.flight, altitude_datum: 'amsl', heading_deg: 40, wind, ...more });
  const pose = { longitude_deg: from[0], latitude_deg: from[1], altitude_m: 640, altitude_datum: 'amsl', age_s: 0.4, heading_deg: 40 };
  let number = 0;
  // A position of its own: the page asks for its reach anew.
  const placed = (at) => ({ ...at, longitude_deg: at.longitude_deg + 1e-6 * ++number });
  const made = (name, { alternates = {}, answer, ...more }) => ({
    name, ...more,
    alternates: { flight_id: flown.flight, sites: [], warnings: [], wind, ...alternates, pose: placed(alternates.pose ?? pose) },
    answer: { summary: `${answer.sites?.length ?? 0} sites in reach`, taken_from_flight: taken(), ...answer,
      sites: answer.sites ?? [], warnings: [...(answer.warnings ?? []), kTerrain] },
  });
  const oldWind = { ...wind, age_s: 25 * minute_s, counts_as: 'old' };
  const damage = 'both databases were damaged at 2026-03-01T10:00:00Z: nothing could be restored, and all sites before that time are lost';
  return [
    made('no wind', {
      alternates: { wind: undefined },
      answer: { taken_from_flight: taken({ wind: undefined }), sites: [1, 2, 3].map((number) => unverified(number)),
        warnings: ['the wind is unknown: the worst direction of a wind of 5.5 m/s is assumed, and approaches are planned for an unknown wind'] },
      reads: [/Wind unknown\./, /Unverified: wind not known\./] }),
    made('old wind', {
      alternates: { wind: oldWind },
      answer: { taken_from_flight: taken({ wind: oldWind }), sites: [1, 2].map((number) => unverified(number)),
        warnings: ['the wind was measured 25 minutes ago: it may have changed by 3 m/s and turned by 45 degrees, and nothing is landable without a fresh one'] },
      reads: [/Wind of the same flight, 25 min old: it may have changed\./, /Unverified: wind 25 min old\./] }),
    made('old position', {
      alternates: { pose: { ...pose, age_s: 31 * minute_s, heading_deg: undefined }, wind: { ...wind, age_s: 5 * hour_s, counts_as: 'unknown' } },
      answer: { taken_from_flight: taken({ wind: { ...wind, age_s: 5 * hour_s, counts_as: 'unknown' }, heading_deg: undefined }), sites: [unverified(1), unverified(2)],
        warnings: ['the last wind was measured 5 hours ago: after 3 hours the wind is unknown', 'the wind is unknown: the worst direction of a wind of 5.5 m/s is assumed, and approaches are planned for an unknown wind',
          'no heading is given: the worst turn is assumed'] },
      reads: [/For the position of 31 min ago: in reach, best first/, /Wind unknown: the last one is 5 h old\./] }),
    made('unknown datum', {
      alternates: { pose: { ...pose, altitude_datum: 'unknown' } },
      answer: { taken_from_flight: taken({ altitude_datum: 'unknown' }), sites: [site(1, { arrival_margin_m: 21, datum_penalty_m: 53 })],
        warnings: ['the datum of the altitude, or of stored sites or maps, is unknown: up to 53 m, the height of the geoid, are subtracted'] },
      reads: [/up to 53 m, the height of the geoid, are subtracted/] }),
    made('nothing in reach', {
      answer: { summary: 'no site in reach: 1 stored site nearby has no approach in this wind that clears terrain and obstacles' },
      reads: [/No site in reach: 1 stored site nearby has no approach in this wind/] }),
    made('too low', {
      answer: { summary: 'no site in reach: at the closest miss 18 m of height are missing above terrain or an obstacle on the way',
        nearest_miss: site(1, { rank: undefined, reachable: false, arrival_margin_m: -17.2, missing_m: 17.2, reason: 'terrain', surplus_height_m: undefined,
          sentence: '18 m of height are missing above terrain or an obstacle on the way' }) },
      reads: [/✕ not in reach/, /−18 m/, /18 m of height are missing above terrain/] }),
    made('a margin of 1 m', { answer: { sites: [site(1, { arrival_margin_m: 1.7 })] }, reads: [/\+1 m/, /✓ landable/] }),
    made('a way that cannot lose its height', {
      answer: { summary: 'no site in reach: at the closest miss the aircraft arrives 35 m too high for the final, and no clear way that loses this height was found',
        nearest_miss: site(1, { rank: undefined, reachable: false, arrival_margin_m: 31, surplus_height_m: 35.2, reason: 'too_high',
          sentence: 'the aircraft arrives 35 m too high for the final, and no clear way that loses this height was found' }) },
      reads: [/✕ not in reach/, /Too high by 35 m/] }),
    made('photographs of ten years ago', {
      answer: { sites: [site(1, { age_s: 10.4 * year_s }), site(2, { age_s: 86400 })] }, reads: [/Photographed 10 years ago/, /Photographed 1 d ago/] }),
    made('photographs without a date', {
      answer: { sites: [site(1, { age_s: null, last_seen_at: null })] }, reads: [/Photographed date unknown/] }),
    made('damaged store', {
      notices: [{ id: 'n-1', raised_at: '2026-03-01T10:00:00Z', acknowledged_at: null, text: damage }],
      answer: { summary: 'no site in reach: no usable site is stored nearby', warnings: [damage] },
      reads: [/both databases were damaged/i, /No site in reach: no usable site is stored nearby/] }),
  ];
}
