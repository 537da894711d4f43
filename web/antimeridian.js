// GeoJSON that the server has cut at the antimeridian (RFC 7946, 3.1.9), as the map draws it: lines are in one again, and
// longitudes go on beyond 180 degrees. Pure.

const nearTo = (other) => ([lon, ...rest]) => [lon - 360 * Math.round((lon - other) / 360), ...rest];

function wholeGeometry(geometry) {
  const { type, coordinates } = geometry ?? {};
  // The end of a part is the beginning of the next one.
  if (type === 'MultiLineString') {
    return { type: 'LineString', coordinates: coordinates.flatMap((part, i) => part.slice(i > 0 ? 1 : 0)).map(nearTo(coordinates[0][0][0])) };
  }
  if (type !== 'MultiPolygon') return geometry;
  const near = nearTo(coordinates[0][0][0][0]);
  return { type, coordinates: coordinates.map((rings) => rings.map((ring) => ring.map(near))) };
}

// answer: a FeatureCollection, or an answer with sites that have paths.
export function withWholeShapes(answer) {
  for (const feature of answer?.features ?? []) feature.geometry = wholeGeometry(feature.geometry);
  for (const site of answer?.sites ?? []) if (site.path) site.path = wholeGeometry(site.path);
  return answer;
}

// The outer rings of a polygon, and of one that was cut.
export const outerRings = ({ type, coordinates }) => (type === 'MultiPolygon' ? coordinates.map(([ring]) => ring) : [coordinates[0]]);
