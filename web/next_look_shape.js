// The legs of an answer of next-look as places and texts. A leg: a Feature, LineString from its start to its end.

import { distance, heading } from './units.js';

const metresPerDegree = 111195;
const datums = { amsl: 'AMSL', ellipsoid: 'above the ellipsoid' };

// [lon, lat], ahead_m along the heading and right_m to its right.
function placeFrom([lon, lat], heading_deg, ahead_m, right_m) {
  const turn = heading_deg * Math.PI / 180;
  const north_m = ahead_m * Math.cos(turn) - right_m * Math.sin(turn);
  const east_m = ahead_m * Math.sin(turn) + right_m * Math.cos(turn);
  return [lon + east_m / metresPerDegree / Math.cos(lat * Math.PI / 180), lat + north_m / metresPerDegree];
}

// The flat ground that the photographs of a leg show, as a ring: the first is taken at its start, the last at its end.
export function bandOf({ geometry: { coordinates: [start, end] }, properties: { heading_deg } }, { photo_along_m, photo_across_m }) {
  const [ahead_m, right_m] = [photo_along_m / 2, photo_across_m / 2];
  const ring = [[start, -ahead_m, -right_m], [end, ahead_m, -right_m], [end, ahead_m, right_m], [start, -ahead_m, right_m]]
    .map(([place, ahead, right]) => placeFrom(place, heading_deg, ahead, right));
  return [...ring, ring[0]];
}

// As GeoJSON, to be fitted into the map.
export const bandFeature = (leg, look) => ({ type: 'Feature', properties: {}, geometry: { type: 'Polygon', coordinates: [bandOf(leg, look)] } });

// "+6.2", "+0.29".
export const gainText = (gain) => `+${gain.toFixed(gain >= 1 ? 1 : 2)}`;

// {sites: places that are a stored site, others: places without one}; largest gain first in both.
export function placesOf({ properties: { places } }) {
  return { sites: places.filter(({ site_id }) => site_id), others: places.filter(({ site_id }) => !site_id) };
}

// One word for the line break.
export const altitudeText = (altitude_m, datum) => `${altitude_m.toFixed(0)}\u00a0m ${datums[datum] ?? '(datum unknown)'}`;

// What to fly: "heading 015°, 300 m long, 558 m AMSL".
export const legText = ({ properties: p }, { altitude_datum }) =>
  `heading ${heading(p.heading_deg)}, ${distance(p.length_m)} long, ${altitudeText(p.altitude_m, altitude_datum)}`;

// How far it is to a leg: "393 m to its start from the last photograph".
export const transitText = ({ properties: { transit_m, rank } }) =>
  `${distance(transit_m)} to its start from ${rank === 1 ? 'the last photograph' : `leg ${rank - 1}`}`;

// Of all legs with the way to them.
export const flown_m = ({ features }) => features.reduce((sum, { properties: p }) => sum + p.length_m + p.transit_m, 0);

// The camera as the legs suppose it.
export const cameraText = ({ photo_spacing_m, photo_across_m, height_above_ground_m, turn_radius_m }) =>
  `A photograph every ${photo_spacing_m.toFixed(0)} m from about ${height_above_ground_m.toFixed(0)} m above ground shows a band of ` +
  `${photo_across_m.toFixed(0)} m. Turn radius ${turn_radius_m.toFixed(0)} m.`;

// "14:02:11", with the date unless it is today.
export function momentOf(text, now = new Date()) {
  const moment = new Date(text);
  const time = moment.toLocaleTimeString('en-GB');
  return moment.toDateString() === now.toDateString() ? time
    : `${moment.toLocaleDateString('en-GB', { day: 'numeric', month: 'short', year: 'numeric' })}, ${time}`;
}

export const countText = (count, one, many = `${one}s`) => `${count} ${count === 1 ? one : many}`;
