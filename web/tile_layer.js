// A layer of map tiles that are requested with the token. A tile that is loaded again stays visible until the new picture
// is decoded.
/* global L */

import { getTile } from './api.js';
import { createQueue, isElsewhere, tilePath } from './tile_queue.js';
import { withoutUnseen } from './unseen_hatch.js';

// A browser opens six connections to a server; two remain for other requests and for events.
const kTilesAtOnce = 4;
const kZoomsBelow = 3;  // zoom levels below the first one at which tiles are still drawn, smaller
const kHatch_px = 16;  // divides a tile, so that the hatches of tiles fit together
const inTurn = createQueue(kTilesAtOnce);

// mask: URL of a picture that has a colour where the hatch may be; null for the whole tile.
function setHatch(image, hasUnseen, mask) {
  image.classList.toggle('unseen-hatch', hasUnseen);
  image.style.maskImage = mask ? `url(${mask})` : '';
}

function clearPicture(image) {
  image.removeAttribute('src');
  setHatch(image, false, null);
}

// Sets the picture of a tile without a moment in which it is empty.
async function setPicture(image, blob, signal, isHatched) {
  const { picture: shown, hasUnseen, mask } = isHatched ? await withoutUnseen(blob) : { picture: blob, hasUnseen: false, mask: null };
  const url = URL.createObjectURL(shown);
  try {
    const picture = new Image();
    picture.src = url;
    await picture.decode();
    signal.throwIfAborted();
    image.src = url;
    setHatch(image, hasUnseen, mask);
    await image.decode();
  } finally {
    URL.revokeObjectURL(url);
  }
}

const boundsOf = ([west, south, east, north]) => L.latLngBounds([south, west], [north, east]);

// minzoom and maxzoom of a TileJSON as options of Leaflet.
const optionsOf = ({ bounds, minzoom = 0, maxzoom = 22 }) => ({
  bounds: bounds ? boundsOf(bounds) : undefined, minNativeZoom: minzoom, maxNativeZoom: maxzoom,
  minZoom: Math.max(0, minzoom - kZoomsBelow), maxZoom: 24, updateWhenIdle: true, keepBuffer: 1,
});

// Fires `tilesettled` after each tile that arrived or failed.
const TileLayer = L.GridLayer.extend({
  initialize(layer, options) {
    this._template = layer.tiles[0];
    this._loads = new WeakMap();  // image -> {loading: AbortController, etag}
    L.GridLayer.prototype.initialize.call(this, { ...optionsOf(layer), ...options });
    this.on('tileunload', ({ tile }) => this._loads.get(tile)?.loading.abort());
  },

  getEvents() { return { ...L.GridLayer.prototype.getEvents.call(this), zoomend: this._fitHatch }; },

  onAdd(map) {
    L.GridLayer.prototype.onAdd.call(this, map);
    this._fitHatch();
  },

  // Enlarged tiles keep a hatch of the same size.
  _fitHatch() {
    const zoom = Math.round(this._map.getZoom());
    this.getContainer().style.setProperty('--hatch-size', `${kHatch_px * 2 ** (this._clampZoom(zoom) - zoom)}px`);
  },

  createTile(coords, done) {
    const image = document.createElement('img');
    image.alt = '';
    this._load(image, coords).then(() => done(null, image));
    return image;
  },

  // Never rejects. A tile that failed is marked: a gap must not look like a place without colour.
  async _load(image, coords) {
    const former = this._loads.get(image);
    former?.loading.abort();
    const load = { loading: new AbortController(), etag: former?.etag };
    this._loads.set(image, load);
    const { signal } = load.loading;
    try {
      const answer = await inTurn(() => getTile(tilePath(this._template, coords), signal), signal);
      if (answer === null) clearPicture(image);
      else if (!answer.etag || answer.etag !== load.etag) await setPicture(image, answer.blob, signal, this.options.hatchesUnseen);
      load.etag = answer?.etag;
      image.classList.remove('missing');
    } catch (error) {
      if (signal.aborted) return;
      image.classList.add('missing');
      // An old photograph is still the ground; an old hazard may be wrong by now.
      if (this.options.dropsOld) clearPicture(image);
      load.etag = undefined;
    }
    this.fire('tilesettled');
  },

  numMissing() {
    return Object.values(this._tiles ?? {}).filter(({ el }) => el.classList.contains('missing')).length;
  },

  // Loads again what changed, and the tiles of new ground. isSame(layer) must hold.
  refresh(layer) {
    this._template = layer.tiles[0];
    if (layer.bounds) this.options.bounds = boundsOf(layer.bounds);
    if (!this._map) return;
    for (const { el, coords } of Object.values(this._tiles)) this._load(el, this._wrapCoords(coords));
    this._update();
  },

  // Whether the layer has the zoom levels of this one: else the tiles must be laid out anew.
  isSame(layer) {
    const { minNativeZoom, maxNativeZoom } = optionsOf(layer);
    return this.options.minNativeZoom === minNativeZoom && this.options.maxNativeZoom === maxNativeZoom;
  },
});

// Tiles of another server, for the base map that the operator chose: plain pictures, so that the token stays here.
const OutsideLayer = L.TileLayer.extend({ numMissing: () => 0, refresh() {}, isSame: () => true });

// layer: TileJSON. options: of Leaflet's GridLayer; dropsOld: a tile that cannot be loaded again is emptied; hatchesUnseen. canBeElsewhere: the tiles may come from another server.
export function createTileLayer(layer, options, { canBeElsewhere = false } = {}) {
  const [template] = layer.tiles;
  return canBeElsewhere && isElsewhere(template, location.origin)
    ? new OutsideLayer(template, { ...optionsOf(layer), ...options }) : new TileLayer(layer, options);
}
