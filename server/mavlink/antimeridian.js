// Longitudes on both sides of the antimeridian. Pure.

// The same longitude, at most half a turn from another one; it may leave [-180, 180].
export const nearTo = (longitude_deg, other_deg) => longitude_deg - 360 * Math.round((longitude_deg - other_deg) / 360);
export const wrapped = (longitude_deg) => nearTo(longitude_deg, 0);

// values: one for each position, as times_s.
function whole({ coordinates }, values) {
  const starts = coordinates.map((_, i) => coordinates.slice(0, i).flat().length);
  const isOwn = (_, i) => !starts.slice(1).some((start) => i === start || i === start - 1);
  return { line: { type: 'LineString', coordinates: coordinates.flat().filter(isOwn) }, values: values?.filter(isOwn) };
}

const isCut = (geometry) => geometry?.type === 'MultiLineString';

// An answer of the service, which cuts its lines at the antimeridian (RFC 7946, 3.1.9), with each line in one again,
// without the ends of the cut. Of GeoJSON, and of the paths of an emergency.
export function withWholeLines(answer) {
  for (const feature of answer?.features ?? []) {
    if (isCut(feature.geometry)) feature.geometry = whole(feature.geometry).line;
  }
  for (const site of answer?.sites ?? []) {
    if (!isCut(site.path)) continue;
    const { line, values } = whole(site.path, site.times_s);
    Object.assign(site, { path: line, times_s: values });
  }
  return answer;
}
