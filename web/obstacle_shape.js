// An obstacle while it is drawn (a draft) and as GeoJSON. A draft: {id, isNew, kind, points, values}; points are
// [lon, lat] or [lon, lat, altitude_m], values are the texts of the form.

export const kinds = {
  wire: { name: 'Wire', sign: 'wire', least: 2, most: Infinity, hint: 'Tap each pylon in turn.' },
  mast: { name: 'Mast', sign: 'mast', least: 1, most: 1, hint: 'Tap the mast.' },
  no_fly: { name: 'No-fly area', sign: 'no-fly', least: 1, most: Infinity, hint: 'Tap the corners, or the centre of a circle.' },
  people: { name: 'People', sign: 'people', least: 1, most: Infinity, hint: 'Tap the corners, or the centre of a circle.' },
};

const kCircleCorners = 24;
// The server's default for people at a point: it keeps clear of two deviations.
const kPeopleSd_m = 20;
const metresPerDegree = 111195;

// A regular polygon whose sides touch the circle from outside: the whole circle lies in it.
export function circleAround([lon, lat], radius_m) {
  const corner_deg = radius_m / Math.cos(Math.PI / kCircleCorners) / metresPerDegree;
  const ring = Array.from({ length: kCircleCorners }, (_, i) => {
    const turn = 2 * Math.PI * i / kCircleCorners;
    return [lon + corner_deg * Math.cos(turn) / Math.cos(lat * Math.PI / 180), lat + corner_deg * Math.sin(turn)];
  });
  return [...ring, ring[0]];
}

// Twice the signed area; positive if the ring runs counterclockwise.
const turnOf = (points) => points.reduce((sum, [x, y], i) => {
  const [nextX, nextY] = points[(i + 1) % points.length];
  return sum + x * nextY - nextX * y;
}, 0);

function ringOf(points) {
  const ring = turnOf(points) < 0 ? [...points].reverse() : points;
  return [...ring, ring[0]];
}

const isArea = (kind) => kind === 'no_fly' || kind === 'people';
export const isCircle = ({ kind, points }) => isArea(kind) && points.length === 1;
export const hasAltitudes = ({ points }) => points.length > 0 && points.every((point) => point.length > 2);

// What is still missing, as {field, detail}; null if the draft can be saved.
export function faultOf(draft) {
  const { least, name } = kinds[draft.kind];
  const count = draft.points.length;
  if (count < least) return { field: 'points', detail: `${name}: at least ${least === 1 ? '1 point' : `${least} points`} needed.` };
  if (isArea(draft.kind) && count === 2) return { field: 'points', detail: 'Add a third corner.' };
  if (isCircle(draft) && !(Number(draft.values.radius_m) > 0)) return { field: 'radius_m', detail: 'Enter the radius.' };
  const needsHeight = draft.kind === 'wire' || draft.kind === 'mast';
  if (needsHeight && !hasAltitudes(draft) && !(Number(draft.values.height_m) > 0)) return { field: 'height_m', detail: 'Enter the height.' };
  return null;
}

function geometryOf(draft) {
  const points = hasAltitudes(draft) ? draft.points : draft.points.map(([lon, lat]) => [lon, lat]);
  if (draft.kind === 'mast') return { type: 'Point', coordinates: points[0] };
  if (draft.kind === 'wire') return { type: 'LineString', coordinates: points };
  return { type: 'Polygon', coordinates: [isCircle(draft) ? circleAround(points[0], Number(draft.values.radius_m)) : ringOf(points)] };
}

const numberOf = (text) => (text === undefined || text === '' ? undefined : Number(text));

// now_ms: the time from which expires_h counts.
export function featureOf(draft, now_ms) {
  const { kind, values } = draft;
  const usesAltitude = hasAltitudes(draft) || (kind === 'no_fly' && (values.floor_m || values.ceiling_m));
  const properties = {
    kind, name: values.name?.trim() || undefined,
    height_m: isArea(kind) ? undefined : numberOf(values.height_m),
    floor_m: kind === 'no_fly' ? numberOf(values.floor_m) : undefined,
    ceiling_m: kind === 'no_fly' ? numberOf(values.ceiling_m) : undefined,
    // As imported, unless an altitude was entered instead.
    floor_above_ground_m: values.floor_m ? undefined : values.floor_above_ground_m,
    ceiling_above_ground_m: values.ceiling_m ? undefined : values.ceiling_above_ground_m,
    altitude_datum: usesAltitude ? values.altitude_datum || undefined : undefined,
    position_sd_m: numberOf(values.position_sd_m),
    expires_at: expiryOf(kind, values, now_ms),
  };
  return { type: 'Feature', geometry: geometryOf(draft), properties: JSON.parse(JSON.stringify(properties)) };
}

function expiryOf(kind, { expires_h, expires_at }, now_ms) {
  if (kind !== 'people') return undefined;
  return expires_h === 'kept' ? expires_at : new Date(now_ms + Number(expires_h) * 3600000).toISOString();
}

const textOf = (value) => (value === null || value === undefined ? '' : String(value));

export function draftOf({ geometry, properties: p, id }) {
  const { coordinates, type } = geometry;
  const points = type === 'Point' ? [coordinates] : type === 'Polygon' ? coordinates[0].slice(0, -1) : coordinates;
  return { id: p.id ?? id, isNew: false, kind: p.kind, points, values: {
    name: textOf(p.name), height_m: textOf(p.height_m), floor_m: textOf(p.floor_m), ceiling_m: textOf(p.ceiling_m),
    radius_m: p.kind === 'people' && type === 'Point' ? textOf(2 * (p.position_sd_m ?? kPeopleSd_m)) : '', altitude_datum: p.altitude_datum ?? 'unknown', position_sd_m: textOf(p.position_sd_m),
    floor_above_ground_m: p.floor_above_ground_m, ceiling_above_ground_m: p.ceiling_above_ground_m,
    expires_at: p.expires_at, expires_h: p.expires_at ? 'kept' : '1',
  } };
}

// An id that no other client makes. crypto.randomUUID needs HTTPS; this does not.
export function newDraft(kind) {
  const bytes = crypto.getRandomValues(new Uint8Array(8));
  const id = `o-${[...bytes].map((byte) => byte.toString(16).padStart(2, '0')).join('')}`;
  return { id, isNew: true, kind, points: [], values: { altitude_datum: 'amsl', expires_h: '1' } };
}

// The field of the form that a JSON pointer names: "/properties/height_m" -> "height_m". null if none.
export function fieldOf(pointer = '') {
  if (pointer.includes('geometry') || pointer.includes('coordinates')) return 'points';
  const last = pointer.split('/').at(-1);
  return { expires_at: 'expires_h' }[last] ?? (last || null);
}

// "45 m", "from 300 m to 900 m", "until 14:30".
export function extentOf({ properties: p, geometry }) {
  if (p.kind === 'people') return p.expires_at ? `until ${new Date(p.expires_at).toLocaleTimeString([], { timeStyle: 'short' })}` : '';
  if (p.kind === 'no_fly') {
    const [floor, ceiling] = ['floor', 'ceiling'].map((bound) => {
      const [altitude_m, height_m] = [p[`${bound}_m`], p[`${bound}_above_ground_m`]];
      if (Number.isFinite(altitude_m)) return `${Math.round(altitude_m)} m`;
      return Number.isFinite(height_m) ? `${Math.round(height_m)} m above ground` : null;
    });
    return `${floor ? `from ${floor}` : 'from the ground'} ${ceiling ? `to ${ceiling}` : 'up'}`;
  }
  if (Number.isFinite(p.height_m)) return `${Math.round(p.height_m)} m`;
  const tops = [geometry.coordinates].flat(geometry.type === 'Point' ? 0 : 1).map((point) => point[2]).filter(Number.isFinite);
  return tops.length ? `top at ${Math.round(Math.max(...tops))} m` : 'height unknown';
}

// "Wire Alpha, 45 m"
export function obstacleText(feature) {
  const { kind, name } = feature.properties;
  const extent = extentOf(feature);
  return `${kinds[kind]?.name ?? kind}${name ? ` ${name}` : ''}${extent ? `, ${extent}` : ''}`;
}
