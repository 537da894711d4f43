// Asks for the ground in reach: of the selected flight while it is live, or of a position that the user entered.
// Never two requests at once, and at most one a second.

import * as api from './api.js';
import { offers } from './offers.js';
import { age, isKnown } from './units.js';

const kPeriod_ms = 1000;
// A flight without a position for longer is not live: it may be anywhere.
const kLive_s = 60;
// The same position is asked for again after this time: stored sites and obstacles change.
const kSame_ms = 10000;

// Sites with an arrival margin.
const kSites = 20;

export const isLive = (pose) => isKnown(pose?.age_s) && pose.age_s <= kLive_s;

// The request for a flight's last position. The server takes the rest from the flight, the wind with its age.
// glide_ratio: null for the aircraft's own.
export const requestOf = (flight, { pose: { latitude_deg, longitude_deg, altitude_m } }, glide_ratio) =>
  ({ latitude_deg, longitude_deg, altitude_m, glide_ratio, flight });

const placeOf = ({ latitude_deg, longitude_deg }) => ({ latitude_deg, longitude_deg });

class Reach {
  #on;
  #flight = null;
  #own = null; // {request, text} of a position in a form; it comes before the flight's
  #isRunning = false;
  #timer = 0;
  #started_ms = -Infinity;
  #asked = { key: '', at_ms: 0 };
  #shown = null;

  constructor(on) { this.#on = on; }

  // id: of the selected flight, or null.
  follow(flight) {
    if (flight === this.#flight) return;
    this.#flight = flight;
    this.#show(null);
    this.look();
  }

  // own: {request, text} of a position in a form, request null if it is incomplete; null returns to the flight.
  use(own) {
    if (JSON.stringify(own) === JSON.stringify(this.#own)) return;
    this.#own = own;
    this.look();
  }

  // Asks now, or a second after the last request began.
  look() {
    clearTimeout(this.#timer);
    if (this.#isRunning) return;
    const wait_ms = Math.max(0, this.#started_ms + kPeriod_ms - performance.now());
    this.#timer = setTimeout(() => this.#run(), wait_ms);
  }

  async #run() {
    this.#isRunning = true;
    this.#started_ms = performance.now();
    const [flight, own] = [this.#flight, this.#own];
    const isOurs = () => flight === this.#flight && own === this.#own;
    let isFollowed = false;
    try {
      const offered = await offers();
      if (!offered.reach) return;
      const source = own ?? await this.#liveSource(flight);
      isFollowed = Boolean(source) && !own;
      const shown = source?.request ? await this.#ask(source, offered.reachLimit ? kSites : undefined) : null;
      if (isOurs()) this.#show(shown);
    } catch (error) {
      // The aircraft moves on: an old answer would mislead.
      if (isOurs()) this.#show(error.status === 404 ? null : { collection: null, text: `Reach unknown: ${error.message}` });
    } finally {
      this.#isRunning = false;
      if (isFollowed || !isOurs()) this.look();
    }
  }

  async #liveSource(flight) {
    if (!flight) return null;
    const answer = await api.getAlternates(flight);
    if (!isLive(answer.pose)) return null;
    return { request: requestOf(flight, answer, this.#on.glideRatio()), text: `position ${age(answer.pose.age_s)} old` };
  }

  async #ask({ request, text }, limit) {
    const key = JSON.stringify(request);
    const now_ms = performance.now();
    if (this.#shown?.collection && key === this.#asked.key && now_ms - this.#asked.at_ms < kSame_ms) {
      return { ...this.#shown, text: `Reach, ${text}` };
    }
    const collection = await api.getReach({ ...request, limit });
    this.#asked = { key, at_ms: now_ms };
    return { collection, from: placeOf(request), text: `Reach, ${text}` };
  }

  #show(shown) {
    if (!shown && !this.#shown) return;
    this.#shown = shown;
    this.#on.draw(shown);
  }
}

// on: {draw(shown), glideRatio()}. shown: {collection: GeoJSON or null, from, text}, or null if nothing is known.
export const createReach = (on) => new Reach(on);
