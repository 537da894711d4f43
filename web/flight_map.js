// The map of the selected flight: its photograph as the ground, and its layers for the layer box. It grows while the
// flight is evaluated.

import * as api from './api.js';
import { marksUnseen } from './colors.js';
import { offers } from './offers.js';
import { tilePath } from './tile_queue.js';

// Without an event the map is read this seldom.
const kLook_ms = 10000;
const kOverPhoto = 0.5;  // the opacity at which both the layer and the photograph can be read

const pathOf = (url) => tilePath(url, {});

// The layers of a flight's map for the layer box; see site_layers.js. Outside of hazard and distance, unseen cells have no colour.
function sourceOf(flight, ground, layers) {
  return {
    of: `map of ${flight}`,
    list: layers.filter(({ name }) => name !== 'photo'),
    opacity: layers.some(({ name }) => name === 'photo') ? kOverPhoto : 1,
    async show(layer, opacity) { ground.draw('data', layer, opacity); },
    hide: () => ground.draw('data', null),
    setOpacity: (value) => ground.setOpacity('data', value),
    note: ({ name }) => ({ text: marksUnseen(name) ? 'outside map' : 'unseen', isBlank: true, hatchesUnseen: marksUnseen(name) }),
    legend: ({ legend }, signal) => (typeof legend === 'string' ? api.getBlob(pathOf(legend), signal) : null),
    picturePath: ({ name }) => api.paths.mapFile(flight, name, 'tif'),
    pictureEnding: 'tif',
  };
}

class FlightMap {
  #ground; #onChange;
  #flight = null;
  #answer = null;
  #looked_ms = 0;
  #isLooking = false;
  #isStale = false;  // it changed while it was read

  constructor(ground, onChange) {
    this.#ground = ground;
    this.#onChange = onChange;
  }

  get layers() { return this.#answer?.layers ?? []; }
  get isThere() { return this.layers.length > 0; }
  // When it changed; null without a map.
  get updatedAt() { return this.isThere ? this.#answer.updated_at : null; }

  follow(flight) {
    this.#flight = flight;
    this.#take(null);
    this.#looked_ms = 0;
  }

  // event: {flight_id, updated_at} of a map that changed, or undefined.
  async look(event) {
    const isNews = event ? event.updated_at !== this.#answer?.updated_at : performance.now() - this.#looked_ms >= kLook_ms;
    const isOther = event?.flight_id !== undefined && event.flight_id !== this.#flight;
    if (!this.#flight || isOther || (this.#looked_ms > 0 && !isNews) || !(await offers()).flightMap) return;
    if (this.#isLooking) {
      this.#isStale ||= event !== undefined;
      return;
    }
    this.#isLooking = true;
    try {
      do {
        this.#isStale = false;
        await this.#read(this.#flight);
      } while (this.#isStale);
    } finally {
      this.#isLooking = false;
    }
  }

  async #read(flight) {
    const answer = await api.getMap(flight);
    if (flight !== this.#flight) {
      this.#isStale = this.#flight !== null;
      return;
    }
    this.#looked_ms = performance.now();
    if (answer?.updated_at !== this.#answer?.updated_at || this.#ground.state().numMissing > 0) this.#take(answer);
  }

  showPhoto(isShown) {
    this.#ground.draw('photo', isShown ? this.layers.find(({ name }) => name === 'photo') ?? null : null);
  }

  #take(answer) {
    if (!answer && !this.#answer) return;
    this.#answer = answer;
    this.#onChange(this.isThere ? sourceOf(this.#flight, this.#ground, this.layers) : null, this.layers);
  }
}

// onChange(source or null, layers: all, with the photograph): the map was read, grew, or belongs to another flight.
export const createFlightMap = (ground, onChange) => new FlightMap(ground, onChange);
