// The ground on the map, as tiles: the user's base map, the photograph of the flight, and one data layer over it.
/* global L */

import { marksUnseen } from './colors.js';
import { el, plainText } from './dom.js';
import { createTileLayer } from './tile_layer.js';

// From below to above. They lie below the track and all lines. `layers` is shared with the pictures of a single site.
const panes = { base: { name: 'base-map', zIndex: 205 }, photo: { name: 'photo', zIndex: 210 }, data: { name: 'layers', zIndex: 250 } };

function createCredit(map) {
  const node = el('div', { class: 'map-credit' });
  map.getContainer().append(node);
  return (credits) => { node.textContent = [...credits].map(plainText).join(' · '); };
}

class Ground {
  #map; #onChange; #credit;
  #shown = {};  // by kind: {layer: TileJSON, tiles}

  constructor(map, onChange) {
    this.#map = map;
    this.#onChange = onChange;
    this.#credit = createCredit(map);
    for (const { name, zIndex } of Object.values(panes)) (map.getPane(name) ?? map.createPane(name)).style.zIndex = zIndex;
  }

  // kind: 'base', 'photo' or 'data'. layer: TileJSON, or null to remove it. A layer of the same name is refreshed.
  draw(kind, layer, opacity = 1) {
    const former = this.#shown[kind];
    if (!layer) this.#remove(kind);
    else if (former?.layer.name === layer.name && former.layer.tiles[0] === layer.tiles[0] && former.tiles.isSame(layer)) {
      former.layer = layer;
      former.tiles.refresh(layer);
    } else this.#add(kind, layer, opacity);
    this.#credit(new Set(Object.values(this.#shown).map(({ layer: { attribution } }) => attribution).filter(Boolean)));
    this.#onChange();
  }

  #add(kind, layer, opacity) {
    this.#remove(kind);
    const isData = kind === 'data';
    const tiles = createTileLayer(layer, { pane: panes[kind].name, className: `ground-tiles ${kind}-tiles`, opacity, dropsOld: isData,
      hatchesUnseen: isData && marksUnseen(layer.name) }, { canBeElsewhere: kind === 'base' });
    tiles.on('loading load tilesettled', this.#onChange);
    tiles.addTo(this.#map);
    tiles.getContainer().dataset.layer = layer.name;
    this.#shown[kind] = { layer, tiles };
    if (kind === 'photo') this.#map.getContainer().classList.add('has-photo');
  }

  #remove(kind) {
    const former = this.#shown[kind];
    if (!former) return;
    delete this.#shown[kind];
    former.tiles.remove();
    former.tiles.off();
    if (kind === 'photo') this.#map.getContainer().classList.remove('has-photo');
  }

  setOpacity(kind, opacity) { this.#shown[kind]?.tiles.setOpacity(opacity); }

  // {isLoading, numMissing: tiles that could not be loaded} of all that is shown.
  state() {
    const all = Object.values(this.#shown).map(({ tiles }) => tiles);
    return { isLoading: all.some((tiles) => tiles.isLoading()), numMissing: all.reduce((sum, tiles) => sum + tiles.numMissing(), 0) };
  }

  bounds() {
    const [west, south, east, north] = this.#shown.photo?.layer.bounds ?? this.#shown.data?.layer.bounds ?? [];
    return west === undefined ? L.latLngBounds([]) : L.latLngBounds([south, west], [north, east]);
  }
}

// onChange(): tiles began to load, arrived or failed.
export const createGround = (map, onChange) => new Ground(map, onChange);
