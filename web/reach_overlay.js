// The ground in reach and the arrival heights of sites, drawn on a map.
/* global L */

import { el } from './dom.js';
import { margin } from './units.js';

const kLabel = { width: 72, height: 28 };  // px
const kDisc = 34;  // px, of a site with a number
const kDot = 12;  // px, of a site without one
// Where a label may stand: the centre of it, in px from the site. The first free side is taken.
const kSides = {
  right: [20 + kLabel.width / 2, 0], left: [-20 - kLabel.width / 2, 0], below: [0, 20 + kLabel.height / 2], above: [0, -20 - kLabel.height / 2],
};

const ringsOf = ({ type, coordinates }) => (type === 'MultiPolygon' ? coordinates.flat() : coordinates);
const latLngs = (ring) => ring.map(([lon, lat]) => [lat, lon]);
const ringsOfKind = (collection, kind) => collection.features
  .filter(({ properties, geometry }) => properties.kind === kind && geometry)
  .flatMap(({ geometry }) => ringsOf(geometry).map(latLngs));

// {id, place, margin_m, disc} of each site; disc: px. The answer that the cards show comes first: its numbers win.
function sitesOf(collection, cards) {
  const shown = cards.filter(({ arrival_margin_m }) => Number.isFinite(arrival_margin_m)).map((card) => ({
    id: card.site_id, place: [card.touchdown.latitude_deg, card.touchdown.longitude_deg], margin_m: card.arrival_margin_m, disc: kDisc }));
  const others = (collection?.features ?? [])
    .filter(({ properties: p, geometry }) => p.kind === 'site' && geometry && Number.isFinite(p.arrival_margin_m))
    .map(({ properties: p, geometry: { coordinates: [lon, lat] } }) => ({ id: p.site_id ?? p.id, place: [lat, lon], margin_m: p.arrival_margin_m,
      disc: shown.length > 0 ? kDot : kDisc }))
    .filter(({ id }) => !shown.some((card) => card.id === id));
  return [...shown, ...others];
}

function labelOf({ place, margin_m }) {
  const text = el('span', { class: margin_m >= 0 ? 'enough' : 'short' }, margin(margin_m));
  return L.marker(place, {
    icon: L.divIcon({ className: 'arrival', html: text, iconSize: [0, 0] }), interactive: false, keyboard: false, zIndexOffset: 1200,
  });
}

const dotOf = (place) => L.marker(place, {
  icon: L.divIcon({ className: 'site-dot', iconSize: [kDot, kDot] }), interactive: false, keyboard: false,
});

// Puts each label beside its site where it covers no other site and no earlier label; hides it if there is no such side.
function keepApart(map, labels, sites) {
  const places = labels.map((label) => map.latLngToContainerPoint(label.getLatLng()));
  const taken = [];
  labels.forEach((label, i) => {
    const { x, y } = places[i];
    const isFree = ([right, down]) => {
      const [cx, cy] = [x + right, y + down];
      // The dot of a site without a number gives way to one with a number.
      return places.every((disc, k) => k === i || sites[k].disc < sites[i].disc || Math.abs(disc.x - cx) > (kLabel.width + sites[k].disc) / 2 ||
        Math.abs(disc.y - cy) > (kLabel.height + sites[k].disc) / 2) &&
        taken.every((other) => Math.abs(other.x - cx) > kLabel.width || Math.abs(other.y - cy) > kLabel.height);
    };
    const side = Object.keys(kSides).find((name) => isFree(kSides[name]));
    if (side) taken.push({ x: x + kSides[side][0], y: y + kSides[side][1] });
    const text = label.getElement().firstElementChild;
    text.hidden = !side;
    text.style.translate = side ? `${kSides[side][0]}px ${kSides[side][1]}px` : '';
  });
}

// Fills lie below the layers of a site, so that they do not change the layers' colours; outlines lie above.
export function createReachOverlay(map) {
  map.createPane('reach').style.zIndex = 240;
  map.createPane('reach-outline').style.zIndex = 310;
  const group = L.featureGroup().addTo(map);
  let labels = [];
  let sites = [];
  map.on('zoomend', () => keepApart(map, labels, sites));

  const add = (rings, options) => {
    if (rings.length > 0) group.addLayer(L.polygon(rings, { interactive: false, ...options }));
  };

  return {
    // collection: GeoJSON of the server, or null. cards: sites of an emergency answer.
    draw(collection, cards = []) {
      group.clearLayers();
      sites = sitesOf(collection, cards);
      labels = sites.map(labelOf);
      for (const label of labels) group.addLayer(label);
      for (const { place } of sites.filter(({ disc }) => disc === kDot)) group.addLayer(dotOf(place));
      keepApart(map, labels, sites);
      if (!collection) return;
      const reach = ringsOfKind(collection, 'reach');
      const unknown = ringsOfKind(collection, 'unknown_terrain');
      // The unknown part is cut out of the fill (even-odd rule): it never looks like ground that was checked.
      add([...reach, ...unknown], { pane: 'reach', className: 'reach-fill', stroke: false });
      add(unknown, { pane: 'reach', className: 'reach-unknown', stroke: false, fillColor: 'url(#unknown-terrain)' });
      for (const className of ['reach-casing', 'reach']) add(reach, { pane: 'reach-outline', className, fill: false });
      add(unknown, { pane: 'reach-outline', className: 'unknown-terrain', fill: false });
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
