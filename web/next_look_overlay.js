// Legs to fly next on the map: a numbered arrow over the band of ground that its photographs show, and dots where ground
// may become landable.
/* global L */

import { el, svg } from './dom.js';
import { bandOf, gainText } from './next_look_shape.js';

const kTouch = 30;  // px, width of the line for fingers
const kSign = { width: 56, height: 44 };  // px, touch target of a leg's number
const kBefore = 24;  // px from the start of a leg to the middle of its number
const kDot = { least: 3.5, most: 8 };  // px, radius

const latLng = ([lon, lat]) => [lat, lon];

function casedLine(places, kind, suffix) {
  return [`next-leg-casing${suffix}`, `${kind}${suffix}`].map((className) => L.polyline(places, { className, interactive: false }));
}

// Stands before the start, so that it hides neither the leg nor the ground.
function numberSign({ geometry: { coordinates: [start] }, properties: p }, suffix, onLeg) {
  const turn = p.heading_deg * Math.PI / 180;
  const title = `Leg ${p.rank}, expected gain ${gainText(p.expected_gain)}`;
  return L.marker(latLng(start), {
    icon: L.divIcon({ className: `next-leg-sign${suffix}`, html: el('span', {}, `leg ${p.rank}`), iconSize: [kSign.width, kSign.height],
      iconAnchor: [kSign.width / 2 + kBefore * Math.sin(turn), kSign.height / 2 - kBefore * Math.cos(turn)] }),
    title, alt: title, zIndexOffset: 1300,
  }).on('click', onLeg).on('keypress', ({ originalEvent }) => { if (originalEvent.key === 'Enter') onLeg(); });
}

function arrowAt(place, { properties: { heading_deg } }, suffix) {
  const head = svg('svg', { viewBox: '-14 -14 28 28', width: 28, height: 28, 'aria-hidden': 'true' },
    svg('path', { d: 'M0 -12L10 9L0 4L-10 9Z', transform: `rotate(${heading_deg.toFixed(1)})` }));
  return L.marker(latLng(place), { icon: L.divIcon({ className: `next-leg-arrow${suffix}`, html: head, iconSize: [28, 28] }), interactive: false, keyboard: false });
}

// Larger where more is expected; a stored site has its own marker there.
const dotOf = ({ latitude_deg, longitude_deg, expected_gain }) => L.circleMarker([latitude_deg, longitude_deg], {
  className: 'next-place', interactive: false, radius: kDot.least + (kDot.most - kDot.least) * Math.min(1, expected_gain),
});

const ringOf = (place) => L.circleMarker([place.latitude_deg, place.longitude_deg], { className: 'next-place-shown', interactive: false, radius: 26 });

export function createNextLookOverlay(map) {
  // Below the layers of the ground, so that it does not change their colours.
  map.createPane('next-look-fill').style.zIndex = 241;
  map.createPane('next-look-touch').style.zIndex = 430;
  const group = L.featureGroup().addTo(map);
  const shown = L.layerGroup().addTo(map);

  function drawLeg(leg, suffix, onLeg) {
    const line = leg.geometry.coordinates.map(latLng);
    const [start, end] = leg.geometry.coordinates;
    for (const layer of casedLine(line, 'next-leg', suffix)) group.addLayer(layer);
    group.addLayer(L.polyline(line, { className: 'next-leg-touch', pane: 'next-look-touch', weight: kTouch, opacity: 0, bubblingMouseEvents: false })
      .on('click', onLeg));
    group.addLayer(arrowAt(start.map((value, i) => (value + end[i]) / 2), leg, suffix));
    group.addLayer(arrowAt(end, leg, suffix));
    group.addLayer(numberSign(leg, suffix, onLeg));
  }

  return {
    // look: the answer, or null; chosen: index of a leg, or null. onLeg(index) is called when the user selects a leg.
    draw(look, chosen = null, onLeg = () => {}) {
      group.clearLayers();
      shown.clearLayers();
      if (!look) return;
      const suffix = (index) => (chosen === null ? '' : index === chosen ? ' chosen' : ' aside');
      look.features.forEach((leg, i) => {
        const ring = bandOf(leg, look).map(latLng);
        group.addLayer(L.polygon(ring, { className: `next-band-fill${suffix(i)}`, pane: 'next-look-fill', stroke: false, interactive: false }));
        for (const name of ['next-band-casing', 'next-band']) {
          group.addLayer(L.polygon(ring, { className: `${name}${suffix(i)}`, fill: false, interactive: false }));
        }
      });
      look.features.filter((_, i) => chosen === null || i === chosen)
        .forEach(({ properties: { places } }) => places.forEach((place) => group.addLayer(dotOf(place))));
      look.features.forEach((leg, i) => drawLeg(leg, suffix(i), () => onLeg(i)));
    },
    // place: {latitude_deg, longitude_deg}
    mark(place) {
      shown.clearLayers();
      shown.addLayer(ringOf(place));
      map.panTo([place.latitude_deg, place.longitude_deg]);
    },
  };
}

const swatch = (name, text) => el('span', { class: 'swatch' }, el('i', { class: `key-${name}` }), text);

// The legend of what is drawn.
export const nextLookKey = (look) => (look?.features.length
  ? [swatch('next-leg', 'leg to fly next'), swatch('next-band', 'ground it photographs'), swatch('next-place', 'may become landable')] : []);
