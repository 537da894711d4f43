// Obstacles on a map, and the one that is being drawn. Each kind has its own sign, line and pattern.
/* global L */

import { el, svg } from './dom.js';
import { extentOf, kinds, obstacleText } from './obstacle_shape.js';

const kMarker = 44;  // px
const kLabelZoom = 15;  // below it the texts would cover each other

const signs = {
  wire: ['M4 21V5M20 21V5M1 8H7M17 8H23', 'M4 8Q12 17 20 8'],
  mast: ['M12 2V21M12 5L6 21M12 5L18 21M9 14H15'],
  'no-fly': ['M12 3A9 9 0 1 1 12 21A9 9 0 1 1 12 3Z', 'M6 6L18 18'],
  people: ['M12 3A3.4 3.4 0 1 1 12 9.8A3.4 3.4 0 1 1 12 3Z', 'M4 21Q4 13 12 13Q20 13 20 21Z'],
};

export const signOf = (kind) => svg('svg', { viewBox: '0 0 24 24', width: 24, height: 24, class: `sign-${kinds[kind].sign}`, 'aria-hidden': 'true' },
  signs[kinds[kind].sign].map((d) => svg('path', { d })));

const latLng = ([lon, lat]) => [lat, lon];

export const nameOf = ({ properties: p }) => p.name || kinds[p.kind].name;

// Where the sign stands: the middle of a line, the centre of an area.
function placeOf({ geometry: { type, coordinates } }) {
  if (type === 'Point') return latLng(coordinates);
  if (type === 'LineString') {
    const i = Math.max(0, Math.floor(coordinates.length / 2) - 1);
    const [a, b] = [coordinates[i], coordinates[Math.min(i + 1, coordinates.length - 1)]];
    return [(a[1] + b[1]) / 2, (a[0] + b[0]) / 2];
  }
  return L.latLngBounds(coordinates[0].map(latLng)).getCenter();
}

// The server keeps clear of two deviations around a position; its default deviations of a point, in metres.
const kSd_m = { people: 20, mast: 5 };

function shapesOf({ geometry: { type, coordinates }, properties: { kind, position_sd_m } }) {
  const sign = kinds[kind].sign;
  const options = { interactive: false, pane: 'obstacles' };
  if (type === 'LineString') {
    const line = coordinates.map(latLng);
    return [
      L.polyline(line, { ...options, className: `${sign}-casing`, fill: false }),
      L.polyline(line, { ...options, className: sign, fill: false }),
      ...line.map((at) => L.circleMarker(at, { ...options, radius: 4, className: 'pylon' })),
    ];
  }
  const area = (className, more) => (type === 'Point'
    ? L.circle(latLng(coordinates), { radius: 2 * (position_sd_m ?? kSd_m[kind] ?? 0), ...options, className, ...more })
    : L.polygon(coordinates.map((ring) => ring.map(latLng)), { ...options, className, ...more }));
  return [
    area(`${sign}-casing`, { fill: false }),
    area(sign, kind === 'mast' ? { fill: false } : { fillColor: `url(#${sign}-pattern)`, fillOpacity: 1 }),
  ];
}

function markerOf(feature, isChosen, onChoose) {
  const { kind } = feature.properties;
  const text = obstacleText(feature);
  const sign = el('span', {}, signOf(kind), el('b', {}, extentOf(feature)));
  return L.marker(placeOf(feature), {
    icon: L.divIcon({ className: `obstacle-sign${isChosen ? ' chosen' : ''}`, html: sign, iconSize: [kMarker, kMarker] }),
    title: text, alt: text, keyboard: Boolean(onChoose), interactive: Boolean(onChoose), zIndexOffset: isChosen ? 900 : -500,
  }).on('click', () => onChoose?.(feature)).on('keypress', (event) => {
    if (event.originalEvent.key === 'Enter') onChoose?.(feature);
  });
}

// onChoose(feature) is called when the user selects a sign; without it signs take no clicks.
export function createObstacleOverlay(map, onChoose) {
  map.createPane('obstacles').style.zIndex = 420;
  const group = L.featureGroup().addTo(map);
  const element = map.getContainer();
  const showTexts = () => element.classList.toggle('far', map.getZoom() < kLabelZoom);
  map.on('zoomend', showTexts);
  showTexts();
  return {
    // chosenId: of the obstacle that the panel shows; editedId: of one that is being edited, so not drawn here.
    draw(features, { chosenId = null, editedId = null } = {}) {
      group.clearLayers();
      for (const feature of features.filter(({ properties }) => properties.id !== editedId && kinds[properties.kind])) {
        for (const layer of [...shapesOf(feature), markerOf(feature, feature.properties.id === chosenId, onChoose)]) group.addLayer(layer);
      }
    },
  };
}

// The draft: numbered points that can be dragged, joined by a line.
export function createDraftOverlay(map) {
  const group = L.featureGroup().addTo(map);
  const element = map.getContainer();
  return {
    // shape: the draft as GeoJSON feature, or null while it has too few points. onMove(index, latlng).
    draw(points, shape, onMove) {
      element.classList.toggle('drawing', points !== null);
      group.clearLayers();
      if (!points) return;
      if (shape) for (const layer of shapesOf(shape)) group.addLayer(layer);
      else group.addLayer(L.polyline(points.map(latLng), { className: 'draft-line', interactive: false }));
      points.forEach((point, i) => {
        const disc = el('span', {}, i + 1);
        group.addLayer(L.marker(latLng(point), {
          icon: L.divIcon({ className: 'disc-marker draft', html: disc, iconSize: [kMarker, kMarker] }),
          draggable: true, autoPan: true, keyboard: false, title: `Point ${i + 1}`, zIndexOffset: 2000,
        }).on('dragend', (event) => onMove(i, event.target.getLatLng())));
      });
    },
  };
}

// The legend of the kinds that are drawn.
export function obstacleKey(features) {
  const drawn = new Set(features.map(({ properties }) => properties.kind));
  return Object.entries(kinds).filter(([kind]) => drawn.has(kind)).map(([kind, { name, sign }]) =>
    el('span', { class: 'swatch' }, el('i', { class: `key-${sign}` }, signOf(kind)), name.toLowerCase()));
}
