// The view "Where to fly next": asks which legs over the flight's map promise most, and follows the map while it grows.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId } from './dom.js';
import { drawLegDownloads } from './downloads.js';
import { setKey } from './key.js';
import { drawNextLookAnswer } from './next_look_answer.js';
import { nextLookKey } from './next_look_overlay.js';
import { bandFeature, momentOf } from './next_look_shape.js';
import { offers } from './offers.js';
import { isVisible, showView } from './views.js';

const kMostLegs = 8;
const kFewLegs = 2;
// An answer costs the server seconds of work, on a large map half a minute, and a map that is being painted changes more
// often. So the page asks for at most a quarter of the time.
const kLeastPause_ms = 5000;
const kPauseRatio = 3;
// Arrow keys step through the numbers of legs.
const kChoosing_ms = 500;
const kPauseAfterError_ms = 15000;

const sameLine = (a, b) => JSON.stringify(a?.geometry) === JSON.stringify(b?.geometry);

class NextLook {
  #map;
  #on;
  #legs = byId('next-look-legs');
  #look = null; // the answer
  #of = {}; // {flight, map: its time} that the answer is about
  #key = null; // of the request that it answers
  #chosen = null; // index of a leg
  #running = null;
  #error = '';
  #isFitted = false;
  #mayAsk_ms = 0;
  #timer = 0;
  #drawn = []; // on the map

  constructor(map, on) {
    this.#map = map;
    this.#on = on;
    this.#legs.replaceChildren(...Array.from({ length: kMostLegs }, (_, i) => new Option(String(i + 1), i + 1, false, i + 1 === kFewLegs)));
    this.#legs.addEventListener('change', () => this.#chooseCount());
    byId('open-next-look').addEventListener('click', () => this.#open());
    byId('next-look-curl').append(curlButton('the legs to fly next', () => curlOf(this.#path())));
    addEventListener('freelsd-view', () => this.#draw());
  }

  async look() {
    byId('open-next-look').hidden = !(await offers().catch(() => ({}))).nextLook;
    if (isVisible('next-look')) this.#askIfChanged();
  }

  // Obstacles changed: the answer may be another one on the same map.
  forget() { this.#key = null; }

  #path() { return api.paths.nextLook(this.#on.source().flight, { legs: this.#legs.value }); }

  #open() {
    showView('next-look');
    byId('next-look-title').focus({ preventScroll: true });
    this.#isFitted = false;
    this.#fitOnce();
    this.#askIfChanged();
  }

  // --- The request ---

  // Changes when the answer may change.
  #source() {
    const { flight, map, sites } = this.#on.source();
    const key = JSON.stringify([flight, map, this.#legs.value, sites.map(({ properties: p }) => [p.id, p.verdict, p.updated_at])]);
    return { flight, map, key };
  }

  #chooseCount() {
    this.#running?.abort();
    this.#running = null;
    this.#mayAsk_ms = performance.now() + kChoosing_ms;
    this.#isFitted = false;
    this.#askIfChanged();
  }

  #askIfChanged() {
    const source = this.#source();
    if (this.#of.flight !== source.flight || (this.#look && !source.map)) this.#turnTo(source);
    const wait_ms = this.#mayAsk_ms - performance.now();
    clearTimeout(this.#timer);
    if (this.#running || !source.map || source.key === this.#key) return this.#draw();
    if (wait_ms > 0) this.#timer = setTimeout(() => this.look(), wait_ms);
    else this.#ask(source);
    return this.#draw();
  }

  #turnTo({ flight }) {
    this.#running?.abort();
    this.#running = null;
    this.#error = '';
    this.#mayAsk_ms = 0;
    this.#isFitted = false;
    this.#take(null, { flight, map: null, key: null });
  }

  async #ask(source) {
    const running = new AbortController();
    this.#running = running;
    const asked_ms = performance.now();
    let pause_ms = kPauseAfterError_ms;
    try {
      const look = await api.getNextLook(api.paths.nextLook(source.flight, { legs: this.#legs.value }), running.signal);
      if (this.#running !== running) return;
      this.#error = '';
      pause_ms = Math.max(kLeastPause_ms, kPauseRatio * (performance.now() - asked_ms));
      this.#take(look, source);
      this.#fitOnce();
    } catch (error) {
      if (this.#running !== running) return;
      this.#error = error.message;
    }
    this.#running = null;
    this.#mayAsk_ms = performance.now() + pause_ms;
    // The map may have grown in the meantime.
    this.look();
  }

  #take(look, source) {
    const chosen = this.#look?.features[this.#chosen];
    const index = look?.features.findIndex((leg) => sameLine(leg, chosen)) ?? -1;
    this.#chosen = index < 0 ? null : index;
    this.#look = look;
    this.#of = { flight: source.flight, map: source.map };
    this.#key = source.key;
    this.#drawAnswer();
  }

  // --- Drawing ---

  #fitOnce() {
    if (this.#isFitted || !this.#look?.features.length || !isVisible('next-look')) return;
    this.#isFitted = true;
    this.#fit(this.#look.features);
  }

  #fit(legs) { this.#map.fitFeatures(legs.map((leg) => bandFeature(leg, this.#look))); }

  #chooseLeg(index) {
    this.#chosen = index;
    this.#drawAnswer();
    this.#draw();
    this.#fit(index === null ? this.#look.features : [this.#look.features[index]]);
    if (index !== null) byId('next-look-list').children[index].scrollIntoView({ block: 'nearest' });
  }

  #message() {
    const { map, key } = this.#source();
    if (this.#error) return `${this.#look ? 'Not updated' : 'No answer'}: ${this.#error}. The page tries again by itself.`.replace('..', '.');
    if (!map) return 'This flight has no map yet. Legs appear here after its first evaluation. "Evaluate all regions" under Flight starts one.';
    if (!this.#look) return 'Choosing legs … On a large map this takes half a minute.';
    return `From the flight's map of ${momentOf(this.#of.map)}.${key === this.#key ? '' : ' Updating …'}`;
  }

  #drawAnswer() {
    drawNextLookAnswer({ look: this.#look, chosen: this.#chosen, on: { nameOf: this.#on.nameOf, openSite: this.#on.openSite,
      showPlace: (place) => this.#map.nextLook.mark(place), chooseLeg: (index) => this.#chooseLeg(index) } });
    if (this.#look?.features.length) {
      drawLegDownloads(byId('next-look-downloads'), this.#of.flight, { legs: this.#legs.value, altitude_datum: this.#look.altitude_datum });
    }
  }

  // Only changes: signs on the map keep the focus.
  #drawMap(look) {
    const wanted = [look, this.#chosen];
    if (wanted.every((value, i) => value === this.#drawn[i])) return;
    this.#drawn = wanted;
    this.#map.nextLook.draw(look, this.#chosen, (index) => this.#chooseLeg(index));
    setKey('next-look', nextLookKey(look));
  }

  #draw() {
    const isShown = isVisible('next-look');
    const look = isShown && this.#of.flight === this.#on.source().flight ? this.#look : null;
    this.#drawMap(look);
    const text = this.#message();
    if (byId('next-look-message').textContent !== text) byId('next-look-message').textContent = text;
    byId('next-look-message').classList.toggle('bad', this.#error !== '');
  }
}

// map: {nextLook: see next_look_overlay.js, fitFeatures}; on: {source(): {flight, map: when the flight's map changed, or
// null without one, sites: its features}, nameOf(site id), openSite(site id)}
export const createNextLook = (map, on) => new NextLook(map, on);
