// The obstacles of the part of a map in view, as the server has them.

import * as api from './api.js';
import { offers } from './offers.js';

const kRefresh_ms = 5000;
// A larger box would hold the obstacles of half a continent.
const kWidest_deg = 5;

const isWithin = (inner, outer) => inner.west >= outer.west && inner.east <= outer.east &&
  inner.south >= outer.south && inner.north <= outer.north;

// Half a view more on each side, so that a small move needs no request.
function widened({ west, south, east, north }) {
  const [x, y] = [(east - west) / 2, (north - south) / 2];
  return { west: Math.max(-180, west - x), south: Math.max(-90, south - y), east: Math.min(180, east + x), north: Math.min(90, north + y) };
}

export const boxText = ({ west, south, east, north }) => [west, south, east, north].map((side) => side.toFixed(6)).join(',');
const isExpired = ({ properties: p }) => p.expires_at !== undefined && p.expires_at !== null && Date.parse(p.expires_at) <= Date.now();

// isOffered: null until the server was asked. note: why obstacles may be missing, or ''.
class ObstacleSource {
  features = [];
  note = '';
  isOffered = null;
  #changed;
  #loaded = { box: null, at_ms: -Infinity };
  #isLoading = false;
  #wanted = null; // box of the latest look
  #shown = null;

  constructor(changed) { this.#changed = changed; }

  // Loads again if the box is not loaded, or if the list is old. box: {west, south, east, north} in degrees.
  async look(box) {
    this.#wanted = box;
    const isOld = performance.now() - this.#loaded.at_ms > kRefresh_ms;
    if (this.#isLoading || (!isOld && this.#has(box))) return;
    this.#isLoading = true;
    try {
      await this.#load(box);
      // The map has moved on meanwhile.
      if (this.isOffered && this.#wanted !== box && !this.#has(this.#wanted)) await this.#load(this.#wanted);
    } catch (error) {
      // Obstacles that were loaded stay: an old one is better than none.
      if (error.status === 404) this.isOffered = false;
      else this.note = `Obstacles not loaded: ${error.message}`;
    } finally {
      this.#isLoading = false;
      this.#tell();
    }
  }

  #has(box) { return this.#loaded.box !== null && isWithin(box, this.#loaded.box); }

  // The next look loads in any case.
  forget() { this.#loaded.at_ms = -Infinity; }

  async #load(box) {
    this.isOffered = (await offers()).obstacles;
    if (!this.isOffered) return;
    const wide = widened(box);
    const isTooWide = wide.east - wide.west > kWidest_deg;
    const { features } = isTooWide ? { features: [] } : await api.getObstacles(boxText(wide));
    for (const feature of features) feature.properties.id ??= feature.id;
    this.features = features.filter((feature) => !isExpired(feature));
    this.note = isTooWide ? 'Zoom in to see obstacles.' : '';
    this.#loaded = { box: isTooWide ? null : wide, at_ms: performance.now() };
  }

  #tell() {
    const shown = JSON.stringify([this.isOffered, this.features, this.note]);
    if (!this.isOffered && this.#shown === null) return;
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.#changed();
  }
}

// changed(): the obstacles, the note or isOffered are others than before.
export const createObstacleSource = (changed) => new ObstacleSource(changed);
