// The ground in reach and the arrival heights of sites, drawn on a map.
/* global L */

import { el } from './dom.js';
import { kinds, marginKind, marginText } from './emergency_text.js';
import { siteLetter } from './units.js';

const kLabel = { width: 88, height: 28 };  // px
const kDisc = 34;  // px, of a site with a letter or a number
const kSign = 28;  // px, of an arrow or another sign
const kDot = 12;  // px, of a site without one
// Where a label may stand: the centre of it, in px from the site. The first free side is taken.
const kBeside = 20 + kLabel.width / 2;
const kOver = 20 + kLabel.height / 2;
const kSides = [[kBeside, 0], [-kBeside, 0], [0, kOver], [0, -kOver],
  [kBeside - 10, kOver - 6], [kBeside - 10, 6 - kOver], [10 - kBeside, kOver - 6], [10 - kBeside, 6 - kOver]];

const ringsOf = ({ type, coordinates }) => (type === 'MultiPolygon' ? coordinates.flat() : coordinates);
const latLngs = (ring) => ring.map(([lon, lat]) => [lat, lon]);
const ringsOfKind = (collection, kind) => collection.features
  .filter(({ properties, geometry }) => properties.kind === kind && geometry)
  .flatMap(({ geometry }) => ringsOf(geometry).map(latLngs));

// {id, place, kind, text, disc, name} of each site; kind, text: of its margin; disc: px. The answer that the cards show comes first: its letters win, not the ranks.
function sitesOf(collection, cards, ranks) {
  const shown = cards.map((card, i) => ({ ...card, name: siteLetter(i) })).filter((card) => Number.isFinite(card.arrival_margin_m)).map((card) => ({
    id: card.site_id, place: [card.touchdown.latitude_deg, card.touchdown.longitude_deg], kind: marginKind(card), text: marginText(card),
    disc: kDisc, name: card.name }));
  const others = (collection?.features ?? [])
    .filter(({ properties: p, geometry }) => p.kind === 'site' && geometry && Number.isFinite(p.arrival_margin_m))
    .map(({ properties: p, geometry: { coordinates: [lon, lat] } }) => ({ id: p.site_id ?? p.id, place: [lat, lon], kind: marginKind(p), text: marginText(p),
      disc: shown.length > 0 ? kDot : kDisc, name: shown.length > 0 ? '' : ranks.get(p.site_id ?? p.id) ?? '' }))
    .filter(({ id }) => !shown.some((card) => card.id === id));
  return [...shown, ...others];
}

function labelOf({ place, kind, text, name }) {
  const node = el('span', { class: kind, 'data-name': name }, text);
  return L.marker(place, {
    icon: L.divIcon({ className: 'arrival', html: node, iconSize: [0, 0] }), interactive: false, keyboard: false, zIndexOffset: 1200,
  });
}

const dotOf = (place) => L.marker(place, {
  icon: L.divIcon({ className: 'site-dot', iconSize: [kDot, kDot] }), interactive: false, keyboard: false,
});

// Puts each label beside its site where it covers no other site, no sign and no earlier label; hides it if there is no
// such side. signs: their places.
function keepApart(map, labels, sites, signs) {
  const places = labels.map((label) => map.latLngToContainerPoint(label.getLatLng()));
  const taken = [];
  const standing = signs.map((place) => map.latLngToContainerPoint(place));
  const covers = (disc, size, cx, cy) => Math.abs(disc.x - cx) <= (kLabel.width + size) / 2 && Math.abs(disc.y - cy) <= (kLabel.height + size) / 2;
  labels.forEach((label, i) => {
    const { x, y } = places[i];
    const isFree = ([right, down]) => {
      const [cx, cy] = [x + right, y + down];
      // The dot of a site without a number gives way to one with a number.
      return places.every((disc, k) => k === i || sites[k].disc < sites[i].disc || !covers(disc, sites[k].disc, cx, cy)) &&
        !standing.some((sign) => covers(sign, kSign, cx, cy)) &&
        taken.every((other) => Math.abs(other.x - cx) > kLabel.width || Math.abs(other.y - cy) > kLabel.height);
    };
    const side = kSides.find(isFree);
    if (side) taken.push({ x: x + side[0], y: y + side[1] });
    const text = label.getElement().firstElementChild;
    text.hidden = !side;
    // Beside another site a label names its own.
    text.classList.toggle('aside', side !== kSides[0]);
    text.style.translate = side ? `${side[0]}px ${side[1]}px` : '';
  });
}

// Fills lie below the layers of the ground, so that they do not change the layers' colours; outlines lie above. So does
// unknown terrain: no layer's colour may tint it.
export function createReachOverlay(map) {
  map.createPane('reach').style.zIndex = 240;
  map.createPane('reach-unknown').style.zIndex = 255;
  map.createPane('reach-outline').style.zIndex = 310;
  const group = L.featureGroup().addTo(map);
  let labels = [];
  let sites = [];
  let signs = [];
  let ranks = new Map();
  const arrange = () => keepApart(map, labels, sites, signs);
  map.on('zoomend', arrange);

  const add = (rings, options) => {
    if (rings.length > 0) group.addLayer(L.polygon(rings, { interactive: false, ...options }));
  };

  return {
    // collection: GeoJSON of the server, or null. cards: sites of an emergency answer.
    draw(collection, cards = []) {
      group.clearLayers();
      sites = sitesOf(collection, cards, ranks);
      labels = sites.map(labelOf);
      for (const label of labels) group.addLayer(label);
      for (const { place } of sites.filter(({ disc }) => disc === kDot)) group.addLayer(dotOf(place));
      arrange();
      if (!collection) return;
      const reach = ringsOfKind(collection, 'reach');
      const unknown = ringsOfKind(collection, 'unknown_terrain');
      // The pattern of the unknown part is opaque: it never looks like ground that was checked, in or beside the reach.
      add(reach, { pane: 'reach', className: 'reach-fill', stroke: false });
      add(unknown, { pane: 'reach-unknown', className: 'reach-unknown', stroke: false, fillColor: 'url(#unknown-terrain)' });
      for (const className of ['reach-casing', 'reach']) add(reach, { pane: 'reach-outline', className, fill: false });
      add(unknown, { pane: 'reach-outline', className: 'unknown-terrain', fill: false });
    },
    // collection: the sites whose ranks stand on the map, from the next draw on.
    nameSites({ features }) { ranks = new Map(features.map(({ properties: p }) => [p.id, p.rank])); },
    // places: of signs that no label may cover.
    keepClear(places) {
      signs = places;
      arrange();
    },
    bounds() {
      const bounds = L.latLngBounds([]);
      group.eachLayer((layer) => { if (layer.getBounds) bounds.extend(layer.getBounds()); });
      return bounds;
    },
  };
}

const swatch = (name, text) => el('span', { class: 'swatch' }, el('i', { class: `key-${name}` }), text);

// The legend of what is drawn. cards: as of draw.
export function reachKey(collection, cards = []) {
  if (!collection) return [];
  const has = (kind) => collection.features.some(({ properties }) => properties.kind === kind);
  const drawn = new Set(sitesOf(collection, cards, new Map()).map(({ kind }) => kind));
  return [
    has('reach') ? swatch('reach', 'in reach') : null,
    has('unknown_terrain') ? swatch('unknown-terrain', 'in reach, terrain unknown') : null,
    ...Object.keys(kinds).filter((kind) => drawn.has(kind)).map((kind) => swatch(`arrival ${kind}`, kinds[kind])),
  ].filter(Boolean);
}
