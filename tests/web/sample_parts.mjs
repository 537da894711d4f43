// Sample answers for parts of the API, around a place [lon, lat]: ground in reach, obstacles, sites worth a new look.

const metresPerDegree = 111195;
export const offset = ([lon, lat], east_m, north_m) =>
  [lon + east_m / metresPerDegree / Math.cos(lat * Math.PI / 180), lat + north_m / metresPerDegree];

const ringAround = (place, radius_m, sign = 1, [east_m, north_m] = [0, 0]) => Array.from({ length: 25 }, (_, i) => {
  const turn = sign * 2 * Math.PI * (i % 24) / 24;
  return offset(place, east_m + radius_m * Math.cos(turn), north_m + radius_m * Math.sin(turn));
});

const feature = ({ id, ...properties }, geometry) => ({ type: 'Feature', ...(id ? { id } : {}), properties, geometry });
const collection = (features) => ({ type: 'FeatureCollection', features });

// sites: [{id, place, arrival_margin_m}]; radius_m: of the reach. A hole where a hill stands, and no map in the west.
export const sampleReach = (place, sites, radius_m = 900) => collection([
  feature({ kind: 'reach' }, { type: 'Polygon', coordinates: [
    ringAround(place, radius_m), ringAround(place, 0.2 * radius_m, -1, [0.53 * radius_m, 0.33 * radius_m])] }),
  feature({ kind: 'unknown_terrain' }, { type: 'Polygon', coordinates: [ringAround(place, 0.33 * radius_m, 1, [-0.58 * radius_m, 0])] }),
  ...sites.map(({ id, place: at, arrival_margin_m }) => feature({ kind: 'site', site_id: id, arrival_margin_m }, { type: 'Point', coordinates: at })),
]);

export const sampleObstacles = (place) => [
  feature({ id: 'wire-1', kind: 'wire', name: 'Valley line', height_m: 32, altitude_datum: 'amsl' },
    { type: 'LineString', coordinates: [offset(place, -260, -140), offset(place, -40, -200), offset(place, 240, -190)] }),
  feature({ id: 'mast-1', kind: 'mast', name: 'Radio mast', height_m: 85 }, { type: 'Point', coordinates: offset(place, 170, 120) }),
  feature({ id: 'zone-1', kind: 'no_fly', name: 'Hospital', floor_m: 300, ceiling_m: 900, altitude_datum: 'amsl' },
    { type: 'Polygon', coordinates: [[offset(place, -330, 40), offset(place, -190, 40), offset(place, -190, 190), offset(place, -330, 190), offset(place, -330, 40)]] }),
  feature({ id: 'people-1', kind: 'people', name: 'Fair', expires_at: new Date(Date.now() + 7200000).toISOString() },
    { type: 'Polygon', coordinates: [ringAround(place, 60, 1, [40, 190])] }),
];

// sites: features of the server.
export const sampleNewLook = (sites) => collection(sites.map((site, i) => ({ ...site, properties: { ...site.properties, new_look: {
  value: 0.9 - 0.1 * i, age_s: 86400 * (40 - 9 * i), gain: 0.4 - 0.05 * i,
  sentence: `Along ${60 - 10 * i} % of the loiter circle some ground was not measured; a flight along the south side may make it landable.` } } })));

// Adds a go-around to an answer of /approach, from noReturn_m before the touchdown.
export function withGoAround(approach, noReturn_m) {
  const final = approach.features.find(({ properties }) => properties.kind === 'approach').geometry.coordinates;
  const [start, end] = [final[0], final.at(-1)];
  const share = noReturn_m / approach.features.find(({ properties }) => properties.kind === 'approach').properties.distance_m;
  const at = (s, up_m) => [end[0] + s * (start[0] - end[0]), end[1] + s * (start[1] - end[1]), end[2] + up_m];
  return { ...approach, features: [...approach.features.filter(({ properties }) => properties.kind !== 'go_around'), feature({ kind: 'go_around', no_return_distance_m: noReturn_m, unseen_ratio: 0.12 },
    { type: 'LineString', coordinates: [at(share, 8), at(-0.6, 25), at(-1.8, 60)] })] };
}

const kSamplesPerLeg = 40;

// An answer of /v1/routes/check: no site is in reach in the last leg, unless the route is 50 m higher there.
export function sampleInsurance({ route, with_fixes = true }, siteId) {
  const between = (a, b, share) => Object.fromEntries(Object.keys(a).map((key) => [key, a[key] + share * (b[key] - a[key])]));
  const isHigh = route.at(-2).altitude_m >= route[0].altitude_m + 50;
  const samples = route.slice(1).flatMap((to, leg) => Array.from({ length: kSamplesPerLeg }, (_, i) => {
    const covered = isHigh || leg < route.length - 2;
    return { time_s: leg * kSamplesPerLeg + i, ...between(route[leg], to, i / kSamplesPerLeg), heading_deg: 90, covered, covered_weight: covered ? 1 : 0.4,
      best_site: siteId, arrival_margin_m: covered ? 42.9 - i : -10.5 - 3 * i, ...(covered ? { failure_probability: 0.0472 } : { reason: 'too_low' }) };
  }));
  const gap = samples.filter(({ covered }) => !covered);
  const higher = [...route.slice(0, -2), ...route.slice(-2).map((point) => ({ ...point, altitude_m: point.altitude_m + 50 }))];
  const fixes = [
    { kind: 'climb', gap: 0, climb_m: 50, gaps_left_s: 0, sentence: 'fly 50 m higher there: closes 60 of 60 s of gaps', route: higher },
    { kind: 'look', gap: 0, gaps_left_s: 12, sentence: 'photograph this ground first: a strip there closes 48 of 60 s of gaps', place: route.at(-1) }];
  return {
    covered_ratio: 1 - gap.length / samples.length, time_s: samples.length, end: route.at(-1), samples,
    gaps: gap.length === 0 ? [] : [{ from_s: gap[0].time_s, to_s: samples.length, from: route.at(-2), to: route.at(-1), reason: 'too_low',
      nearest_miss: { site_id: siteId, missing_m: 11 }, sentence: `no site is in reach; where least is missing, 11 m are missing to ${siteId}` }],
    ...(gap.length === 0 ? {} : { point_of_no_return: samples[samples.length - gap.length - 1] }),
    fixes: with_fixes && gap.length > 0 ? fixes : [], warnings: ['terrain on the way to a site is known only where stored maps cover it'],
  };
}

// An answer of next-look: legs to the north, one beside the other, with a stored site under the first. site: {id, verdict}.
export const sampleLegs = (place, site, numLegs) => {
  const at = ([longitude_deg, latitude_deg], expected_gain, stored = null) => ({ latitude_deg, longitude_deg, altitude_m: 450,
    site_id: stored?.id ?? null, verdict: stored?.verdict ?? null, expected_gain });
  const legs = Array.from({ length: numLegs }, (_, i) => feature({ kind: 'look', rank: i + 1, heading_deg: 0, altitude_m: 560.2, length_m: 300,
    transit_m: 400 - 100 * i, expected_gain: 2.25 - i, places: [
      ...(i === 0 ? [at(place, 0.25, site)] : []), at(offset(place, 200 * i + 60, 80), 1.25 - i), at(offset(place, 200 * i - 30, 40), 0.75)] },
  { type: 'LineString', coordinates: [-150, 150].map((north_m) => [...offset(place, 200 * i, north_m), 560.2]) }));
  return { ...collection(legs), flight_id: 'f', altitude_datum: 'amsl', landing_value: 0.5, expected_gain: legs.reduce((sum, { properties }) => sum + properties.expected_gain, 0),
    height_above_ground_m: 110, photo_spacing_m: 26, photo_along_m: 100, photo_across_m: 160, turn_radius_m: 34 };
};
