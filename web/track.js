// The track of the flight: positions of the photographs, with the aircraft at the end.
/* global L */

import { svg } from './dom.js';
import { courseTo, heading } from './units.js';

// Below this distance the error of the receiver outweighs the movement.
const kLeastStep_m = 3;
const kMark = 30;  // px

const placeOf = ([longitude_deg, latitude_deg]) => ({ latitude_deg, longitude_deg });

// Course at the end of [[lon, lat, altitude], …], in degrees. null if the aircraft never moved.
export function lastCourse(positions) {
  const end = placeOf(positions.at(-1));
  for (let i = positions.length - 2; i >= 0; --i) {
    const { distance_m, bearing_deg } = courseTo(placeOf(positions[i]), end);
    if (distance_m >= kLeastStep_m) return bearing_deg;
  }
  return null;
}

function mark(course_deg) {
  const shape = course_deg === null ? svg('circle', { r: 6 })
    : svg('path', {
      d: 'M0-13L2-5L13 2V5L2 2L1.5 8L5 11V13L0 11.5L-5 13V11L-1.5 8L-2 2L-13 5V2L-2-5Z',
      transform: `rotate(${course_deg.toFixed(1)})`,
    });
  const text = course_deg === null ? 'Last photograph' : `Last photograph, course ${heading(course_deg)}`;
  return svg('svg', { viewBox: '-15 -15 30 30', role: 'img', 'aria-label': text }, shape);
}

// Lies below regions and sites and receives no clicks.
export function createTrack(map) {
  map.createPane('track').style.zIndex = 300;
  const group = L.featureGroup().addTo(map);
  return {
    // collection: GeoJSON of the server, or null to remove the track. hasMark: false where the aircraft's
    // own sign is on the map: it is farther on by now.
    draw(collection, { hasMark = true } = {}) {
      group.clearLayers();
      const positions = collection?.features[0]?.geometry.coordinates;
      if (!positions) return;
      const places = positions.map(([lon, lat]) => [lat, lon]);
      for (const className of ['track-casing', 'track']) {
        group.addLayer(L.polyline(places, { pane: 'track', interactive: false, className }));
      }
      if (!hasMark) return;
      group.addLayer(L.marker(places.at(-1), {
        interactive: false, keyboard: false, zIndexOffset: -10000,
        icon: L.divIcon({ className: 'aircraft', html: mark(lastCourse(positions)), iconSize: [kMark, kMark] }),
      }));
    },
    bounds: () => group.getBounds(),
  };
}
