// The ground in reach and the arrival heights of sites, drawn on a map.
/* global L */

import { el } from './dom.js';
import { margin } from './units.js';

const kLabel = { width: 66, height: 26, right: 20 };  // px, beside the disc of a site

const ringsOf = ({ type, coordinates }) => (type === 'MultiPolygon' ? coordinates.flat() : coordinates);
const latLngs = (ring) => ring.map(([lon, lat]) => [lat, lon]);
const ringsOfKind = (collection, kind) => collection.features
  .filter(({ properties, geometry }) => properties.kind === kind && geometry)
  .flatMap(({ geometry }) => ringsOf(geometry).map(latLngs));

function labelOf({ properties, geometry: { coordinates: [lon, lat] } }) {
  const value_m = properties.arrival_margin_m;
  const text = el('span', { class: value_m >= 0 ? 'enough' : 'short' }, margin(value_m));
  return L.marker([lat, lon], {
    icon: L.divIcon({ className: 'arrival', html: text, iconSize: [0, 0] }), interactive: false, keyboard: false, zIndexOffset: 500,
  });
}

// Hides each label that would cover an earlier one.
function keepApart(map, labels) {
  const taken = [];
  for (const label of labels) {
    const at = map.latLngToContainerPoint(label.getLatLng());
    const isFree = taken.every((other) => Math.abs(other.x - at.x) > kLabel.width || Math.abs(other.y - at.y) > kLabel.height);
    if (isFree) taken.push(at);
    label.getElement().hidden = !isFree;
  }
}

// Fills lie below the layers of a site, so that they do not change the layers' colours; outlines lie above.
export function createReachOverlay(map) {
  map.createPane('reach').style.zIndex = 240;
  map.createPane('reach-outline').style.zIndex = 310;
  const group = L.featureGroup().addTo(map);
  let labels = [];
  map.on('zoomend', () => keepApart(map, labels));

  const add = (rings, options) => {
    if (rings.length > 0) group.addLayer(L.polygon(rings, { interactive: false, ...options }));
  };

  return {
    // collection: GeoJSON of the server, or null.
    draw(collection) {
      group.clearLayers();
      labels = [];
      if (!collection) return;
      const reach = ringsOfKind(collection, 'reach');
      const unknown = ringsOfKind(collection, 'unknown_terrain');
      // The unknown part is cut out of the fill (even-odd rule): it never looks like ground that was checked.
      add([...reach, ...unknown], { pane: 'reach', className: 'reach-fill', stroke: false });
      add(unknown, { pane: 'reach', className: 'reach-unknown', stroke: false, fillColor: 'url(#unknown-terrain)' });
      for (const className of ['reach-casing', 'reach']) add(reach, { pane: 'reach-outline', className, fill: false });
      add(unknown, { pane: 'reach-outline', className: 'unknown-terrain', fill: false });
      labels = collection.features
        .filter(({ properties: p, geometry }) => p.kind === 'site' && geometry && Number.isFinite(p.arrival_margin_m))
        .map(labelOf);
      for (const label of labels) group.addLayer(label);
      keepApart(map, labels);
    },
    bounds() {
      const bounds = L.latLngBounds([]);
      group.eachLayer((layer) => { if (layer.getBounds) bounds.extend(layer.getBounds()); });
      return bounds;
    },
  };
}

const swatch = (name, text) => el('span', { class: 'swatch' }, el('i', { class: `key-${name}` }), text);

// The legend of what is drawn.
export function reachKey(collection) {
  if (!collection) return [];
  const has = (kind) => collection.features.some(({ properties }) => properties.kind === kind);
  return [
    has('reach') ? swatch('reach', 'in reach') : null,
    has('unknown_terrain') ? swatch('unknown-terrain', 'in reach, terrain unknown') : null,
    has('site') ? swatch('arrival', 'arrival margin') : null,
  ].filter(Boolean);
}
