// A stored strip on which something new stands: the event, and the obstacle that covers the strip.

import { offset } from './sample_parts.mjs';

export const soon = (seconds) => new Date(Date.now() + 1000 * seconds).toISOString();
const at = ([longitude_deg, latitude_deg]) => ({ longitude_deg, latitude_deg });

export const obstacleIdOf = (siteId) => `strip-${siteId}`;

// site: {flight, properties, place}. more: what differs.
export const sampleStripEvent = ({ flight, properties: { id }, place }, more = {}) => ({
  flight_id: flight, site_id: id, obstacle_id: obstacleIdOf(id), seen_at: soon(-20), state: 'occupied', expires_at: soon(580),
  things: [{ ...at(offset(place, 6, 9)), length_m: 4.2, width_m: 1.9, cue: 'color' }], frames: ['a', 'b'], alternate: null, ...more,
});

export const sampleStripObstacle = ({ properties: { id }, place }, { seen_at = soon(-20), expires_at = soon(580) } = {}) => ({
  type: 'Feature', id: obstacleIdOf(id),
  properties: { kind: 'no_fly', name: `something new stands on this strip, seen ${seen_at}`, ceiling_m: 480, altitude_datum: 'unknown', expires_at },
  geometry: { type: 'Polygon', coordinates: [[[-8, -40], [8, -40], [8, 40], [-8, 40], [-8, -40]].map(([east_m, north_m]) => offset(place, east_m, north_m))] },
});
