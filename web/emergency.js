// Emergency mode: the three best sites in reach. Refreshes while the dialog is open.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el } from './dom.js';
import { emergencyCard } from './emergency_card.js';
import { createEmergencyMap } from './emergency_map.js';
import { nearestSites } from './nearest.js';
import { isLive } from './reach.js';
import { age, groundAge_s, isKnown, windFrom, windTo } from './units.js';
import { stripOfAnswer } from './watch_shape.js';

const kRefresh_ms = 5000;
const kRefreshLive_ms = 2000;
const kShown = 3;
const kept = 'freelsd.emergency';
const kOld_s = 60;
// A position of yesterday is worse than none: only what belongs to the aircraft is kept.
const keptFields = ['glide_ratio', 'altitude_datum'];

// --- Form ---

const input = (name) => byId(`em-${name}`);
const number = (name) => (input(name).value === '' ? null : Number(input(name).value));

// flight: the id of the flight whose position is asked for, or null. Its datum, its aircraft and its wind, which has an
// age, are those of the request.
function requestOfForm(flight) {
  const speed = number('wind_speed_mps');
  const from = number('wind_from_deg');
  const wind = flight || speed === null || from === null ? null : windTo(speed, from);
  return {
    latitude_deg: number('latitude_deg'), longitude_deg: number('longitude_deg'), altitude_m: number('altitude_m'),
    altitude_datum: input('altitude_datum').value, heading_deg: number('heading_deg'), glide_ratio: number('glide_ratio'),
    wind_east_mps: wind?.east_mps.toFixed(3), wind_north_mps: wind?.north_mps.toFixed(3), limit: kShown,
    flight: flight ?? undefined,
  };
}

const fill = (name, value, digits) => { input(name).value = isKnown(value) ? value.toFixed(digits) : ''; };

function setSource(text, isDoubtful) {
  byId('em-source').textContent = text;
  byId('em-source').className = isDoubtful ? 'bad' : '';
}

function setPosition({ latitude_deg, longitude_deg }, source, isDoubtful = false) {
  fill('latitude_deg', latitude_deg, 6);
  fill('longitude_deg', longitude_deg, 6);
  setSource(source, isDoubtful);
}

function keepForm() {
  localStorage.setItem(kept, JSON.stringify(Object.fromEntries(keptFields.map((name) => [name, input(name).value]))));
}

function fillKept() {
  const known = JSON.parse(localStorage.getItem(kept) ?? '{}');
  for (const name of keptFields) if (known[name] !== undefined) input(name).value = known[name];
}

const since = (age_s) => (isKnown(age_s) ? `${age(age_s)} old` : 'of unknown age');

// pose and wind: of the flight's last data, as its alternates tell them. Ages count from when they were measured.
function fillFromFlight({ pose, wind }, flightName) {
  const from = windFrom(wind ?? null);
  // A wind in the form is one of now.
  const filled = wind?.counts_as === 'known' ? from : null;
  const isOld = !isKnown(pose.age_s) || pose.age_s > kOld_s;
  setPosition(pose, `Position and altitude of flight ${flightName}, ${since(pose.age_s)}. ` +
    (from ? `Wind of the same flight, ${since(wind.age_s)}${filled ? '' : `: counts as ${wind.counts_as}`}. ` : 'Wind unknown. ') +
    (isKnown(pose.heading_deg) ? 'Heading from its track.' : 'Heading unknown.'), isOld);
  fill('altitude_m', pose.altitude_m, 0);
  input('altitude_datum').value = pose.altitude_datum ?? 'unknown';
  fill('heading_deg', pose.heading_deg, 0);
  fill('wind_speed_mps', filled?.speed_mps, 1);
  fill('wind_from_deg', filled?.from_deg, 0);
}

// --- Message ---

function say(text, className = '') {
  byId('em-message').textContent = text;
  byId('em-message').className = className;
}

const now = () => new Date().toLocaleTimeString();

function sayReach({ sites, nearest_miss: miss }) {
  if (sites.length > 0) say(`In reach, best first (${now()})`);
  else say(`No site in reach (${now()}). ${miss ? 'Closest miss:' : 'No usable site is stored nearby.'}`, 'bad');
}

// --- Sites ---

// The nearest stored sites, for a server or a request without a reach computation.
async function uncheckedSites(from, signal) {
  const usable = new Set(['landable', 'unverified']);
  const nearest = await nearestSites(from, kShown, {
    list: (box) => api.getSitesIn(box, signal), isWanted: ({ properties }) => usable.has(properties.verdict) });
  return nearest.map(({ feature: { properties: p }, ...course }) => ({
    site_id: p.id, flight_id: p.flight_id, verdict: p.verdict, approach: p.approach, reach: 'unknown',
    unseen_ratio: p.unseen_ratio, age_s: groundAge_s(p), ...course,
  }));
}

// {sites, nearest_miss, warnings}, or null if this server has no reach computation.
async function askReach(request, signal) {
  try {
    return await api.getEmergency(request, signal);
  } catch (error) {
    if (error.status === 404) return null;
    throw error;
  }
}

// The wind of the answer's plans, null if it is unknown.
function windOf(request, answer) {
  const taken = answer?.taken_from_flight?.wind;
  if (taken && taken.counts_as !== 'unknown') return { east_mps: taken.east_mps, north_mps: taken.north_mps };
  if (request.wind_east_mps === undefined) return null;
  return { east_mps: Number(request.wind_east_mps), north_mps: Number(request.wind_north_mps) };
}

class Emergency {
  #on;
  #flight = null; // id of the flight whose position is filled in, null for any other position
  #isOwn = false; // the user has entered or chosen something: nothing is filled in any more
  #wind = null; // of the answer shown
  #pose = null; // of the followed flight
  #map = createEmergencyMap();
  #dialog = byId('emergency');
  #timer = 0;
  #running = new AbortController();

  constructor(on) {
    this.#on = on;
    fillKept();
    byId('em-form').addEventListener('input', (event) => this.#takeOver(event.target));
    byId('em-form').addEventListener('submit', (event) => { event.preventDefault(); this.#ask(); });
    byId('em-flight').addEventListener('click', () => { this.#isOwn = false; this.#ask(); });
    byId('em-center').addEventListener('click', () => {
      this.#isOwn = true;
      setPosition(on.center(), 'Position: centre of the map.', true);
      this.#ask();
    });
    byId('em-locate').addEventListener('click', () => this.#locate());
    byId('em-locate').hidden = !('geolocation' in navigator) || !isSecureContext;
    byId('em-close').addEventListener('click', () => this.#dialog.close());
    this.#dialog.addEventListener('close', () => {
      this.#stop();
      this.#on.useReach(null);
    });
    byId('em-curl').append(curlButton('the emergency sites', () => curlOf(api.paths.emergency(requestOfForm(this.#flight)))));
    for (const button of document.querySelectorAll('[data-emergency]')) {
      button.addEventListener('click', () => this.#open());
    }
    addEventListener('keydown', (event) => {
      const isTyping = event.target.closest?.('input, textarea, select, dialog[open]');
      if (event.key === 'e' && !isTyping && !event.ctrlKey && !event.metaKey && !event.altKey) this.#open();
    });
  }

  #open() {
    if (this.#dialog.open) return;
    byId('em-flight').hidden = !this.#on.flight();
    if (!this.#isOwn) setPosition(this.#on.center(), 'Position: centre of the map. Enter yours.', true);
    this.#dialog.showModal();
    this.#map.open();
    this.#ask();
  }

  // The user has entered a value. An age of the flight's data would stand still from now on.
  #takeOver(changed) {
    if (changed === input('latitude_deg') || changed === input('longitude_deg')) setSource('Position as entered.', false);
    else if (!this.#isOwn && this.#pose) setSource(`Values as entered. Position of flight ${this.#on.flightName()} at ${now()}.`, true);
    this.#isOwn = true;
    this.#ask();
  }

  glideRatio() { return number('glide_ratio'); }

  // shown: see reach.js
  showReach(shown) { this.#map.show({ reach: shown?.collection ?? null, reachText: shown?.text }); }

  // The selected flight's last position, altitude and wind, unless the user has entered others.
  async #follow(signal) {
    const flight = this.#on.flight();
    this.#flight = null;
    this.#pose = null;
    if (this.#isOwn || !flight) return;
    const answer = await api.getAlternates(flight, signal).catch(() => null);
    if (!answer?.pose || this.#isOwn || signal.aborted) return;
    fillFromFlight(answer, this.#on.flightName());
    this.#flight = flight;
    this.#pose = answer.pose;
  }

  // A live flight's own reach is always shown. Else the reach of the position in the form, if its altitude is known.
  #useReach({ limit, ...request }) {
    if (isLive(this.#pose)) this.#on.useReach(null);
    else {
      const text = this.#pose ? `position ${since(this.#pose.age_s)}` : 'from the entered position';
      this.#on.useReach({ request: request.altitude_m === null ? null : request, text });
    }
  }

  #stop() {
    clearTimeout(this.#timer);
    this.#running.abort();
  }

  #show(site) {
    this.#stop();
    this.#dialog.close();
    this.#on.show(site, site.reach === 'unknown' ? undefined : this.#wind);
  }

  #draw({ sites, nearest_miss: miss, warnings = [] }, from) {
    const shown = sites.slice(0, kShown);
    const cards = shown.length === 0 && miss ? [miss] : shown;
    const focused = [...byId('em-cards').querySelectorAll('button')].indexOf(document.activeElement);
    byId('em-cards').replaceChildren(...cards.map((site, i) =>
      emergencyCard(site, i, { flightName: this.#on.nameOf(site.flight_id), strip: this.#on.stripOf(site.site_id) ?? stripOfAnswer(site),
        onShow: () => this.#show(site) })));
    byId('em-cards').querySelectorAll('button')[focused]?.focus();
    byId('em-warnings').replaceChildren(...warnings.map((w) => el('li', {}, typeof w === 'string' ? w : w.detail)));
    this.#map.show({ from, sites: cards });
    this.#on.drawBearings(from, shown);
  }

  async #refresh(request, signal) {
    const from = { latitude_deg: request.latitude_deg, longitude_deg: request.longitude_deg };
    const isAltitudeKnown = request.altitude_m !== null;
    const answer = isAltitudeKnown ? await askReach(request, signal) : null;
    this.#wind = windOf(request, answer);
    this.#draw(answer ?? { sites: await uncheckedSites(from, signal) }, from);
    if (answer) sayReach(answer);
    else if (isAltitudeKnown) say(`This server cannot check reach. Sites below are unchecked (${now()}).`, 'bad');
    else say('Enter altitude to check reach. Sites below are unchecked.', 'bad');
  }

  // A newer request aborts the former one: a late answer must not replace a newer one.
  async #ask() {
    this.#stop();
    this.#running = new AbortController();
    const { signal } = this.#running;
    await this.#follow(signal);
    if (signal.aborted) return;
    const request = requestOfForm(this.#flight);
    if (request.latitude_deg === null || request.longitude_deg === null) {
      say('Enter your position.', 'bad');
      return;
    }
    keepForm();
    this.#useReach(request);
    try {
      await this.#refresh(request, signal);
    } catch (error) {
      if (signal.aborted) return;
      // An old answer is better than none, but must be marked as old.
      say(`Update failed: ${error.message}. Sites below may be outdated.`, 'bad');
    }
    if (this.#dialog.open && !signal.aborted) this.#timer = setTimeout(() => this.#ask(), isLive(this.#pose) ? kRefreshLive_ms : kRefresh_ms);
  }

  #locate() {
    say('Reading device position …');
    navigator.geolocation.getCurrentPosition(({ coords }) => {
      this.#isOwn = true;
      setPosition({ latitude_deg: coords.latitude, longitude_deg: coords.longitude }, 'Position of this device.');
      if (isKnown(coords.altitude)) input('altitude_m').value = coords.altitude.toFixed(0);
      if (isKnown(coords.heading)) input('heading_deg').value = coords.heading.toFixed(0);
      this.#ask();
    }, (error) => say(`No device position: ${error.message}`, 'bad'), { timeout: 8000 });
  }
}

// on: {show(site, wind of its plan; null if unknown, undefined if it was not planned), center(): place,
// drawBearings(from, sites), flight(): id or null, flightName(), nameOf(flight id),
// stripOf(site id): see watch.js, useReach: as of reach.js}
export const createEmergency = (on) => new Emergency(on);
