// Emergency mode: the three best sites in reach. Refreshes while the dialog is open.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el } from './dom.js';
import { emergencyCard } from './emergency_card.js';
import { ageText, headline, isOldPosition, isWindKnown, isWindOld, sentence, sourceText } from './emergency_text.js';
import { createEmergencyMap } from './emergency_map.js';
import { nearestSites } from './nearest.js';
import { createNotices } from './notices.js';
import { isLive } from './reach.js';
import { groundAge_s, isKnown, windFrom, windTo } from './units.js';

const kRefresh_ms = 5000;
const kRefreshLive_ms = 2000;
const kShown = 3;
const kept = 'freelsd.emergency';
// A position of yesterday is worse than none: only what belongs to the aircraft is kept.
const keptFields = ['glide_ratio', 'altitude_datum'];

// --- Form ---

const input = (name) => byId(`em-${name}`);
const number = (name) => (input(name).value === '' ? null : Number(input(name).value));

const positionFields = ['latitude_deg', 'longitude_deg'];
const windFields = ['wind_speed_mps', 'wind_from_deg'];
const ofFlight = ['altitude_m', 'heading_deg', ...windFields];

// flight: the id of the flight whose position is asked for, or null. The server takes its datum, aircraft, heading and wind
// from there, with their ages: a value in the request counts as one of now. entered: the names of fields that the user entered.
function requestOfForm(flight, entered) {
  const isGiven = (...names) => !flight || names.some((name) => entered.has(name));
  const speed = number('wind_speed_mps');
  const from = number('wind_from_deg');
  const wind = speed === null || from === null || !isGiven(...windFields) ? null : windTo(speed, from);
  return {
    latitude_deg: number('latitude_deg'), longitude_deg: number('longitude_deg'), altitude_m: number('altitude_m'),
    altitude_datum: isGiven('altitude_datum') ? input('altitude_datum').value : undefined,
    heading_deg: isGiven('heading_deg') ? number('heading_deg') : undefined, glide_ratio: number('glide_ratio'),
    wind_east_mps: wind?.east_mps.toFixed(3), wind_north_mps: wind?.north_mps.toFixed(3), limit: kShown,
    flight: flight ?? undefined,
  };
}

// The wind of the answer, with its age; null if it is unknown.
function windOf(request, answer) {
  if (request.wind_east_mps === undefined) return answer?.taken_from_flight?.wind ?? null;
  return { east_mps: Number(request.wind_east_mps), north_mps: Number(request.wind_north_mps), age_s: 0 };
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

// What the flight has measured, but for what the user entered.
function fillFromFlight({ pose, wind }, flightName, entered) {
  // A wind in the form is one of now.
  const from = wind && !isWindOld(wind) ? windFrom(wind) : null;
  setSource(sourceText({ pose, wind, isWindEntered: windFields.some((name) => entered.has(name)) }, flightName), isOldPosition(pose));
  const values = { latitude_deg: [pose.latitude_deg, 6], longitude_deg: [pose.longitude_deg, 6], altitude_m: [pose.altitude_m, 0],
    heading_deg: [pose.heading_deg, 0], wind_speed_mps: [from?.speed_mps, 1], wind_from_deg: [from?.from_deg, 0] };
  for (const [name, [value, digits]] of Object.entries(values)) if (!entered.has(name)) fill(name, value, digits);
  if (!entered.has('altitude_datum')) input('altitude_datum').value = pose.altitude_datum ?? 'unknown';
}

// --- Message ---

function say(text, className = '') {
  byId('em-message').textContent = text;
  byId('em-message').className = className;
}

const now = () => new Date().toLocaleTimeString();

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

class Emergency {
  #on;
  #flight = null; // id of the flight whose position is filled in, null for any other position
  #isOwn = false; // the user has entered a place, an altitude or a heading: nothing is filled in any more
  #entered = new Set(); // names of the fields that the user entered
  #wind = null; // of the answer shown
  #pose = null; // of the followed flight
  #notices = createNotices();
  #map = createEmergencyMap();
  #dialog = byId('emergency');
  #timer = 0;
  #running = new AbortController();

  constructor(on) {
    this.#on = on;
    fillKept();
    byId('em-form').addEventListener('input', (event) => this.#takeOver(event.target));
    byId('em-form').addEventListener('submit', (event) => { event.preventDefault(); this.#ask(); });
    byId('em-flight').addEventListener('click', () => {
      this.#isOwn = false;
      this.#entered.clear();
      this.#ask();
    });
    byId('em-center').addEventListener('click', () => {
      this.#leaveFlight();
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
    byId('em-curl').append(curlButton('the emergency sites', () => curlOf(api.paths.emergency(requestOfForm(this.#flight, this.#entered)))));
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
    this.#notices.look();
    this.#ask();
  }

  // A place, an altitude or a heading stands still from now on, so an age of the flight's data would too. The wind, the
  // datum and the glide ratio do not move with the aircraft.
  #takeOver(changed) {
    const name = changed.id.replace('em-', '');
    this.#entered.add(name);
    if (positionFields.includes(name)) {
      this.#leaveFlight();
      setSource('Position as entered.', false);
    } else if (name === 'altitude_m' || name === 'heading_deg') {
      if (!this.#isOwn && this.#pose) setSource(`Values as entered. Position of flight ${this.#on.flightName()} at ${now()}.`, true);
      this.#isOwn = true;
    }
    this.#ask();
  }

  // What was measured on the flight does not belong to another place.
  #leaveFlight() {
    if (this.#flight) for (const name of ofFlight) if (!this.#entered.has(name)) fill(name, null);
    if (this.#flight && !this.#entered.has('altitude_datum')) input('altitude_datum').value = 'unknown';
    this.#flight = null;
    this.#isOwn = true;
  }

  glideRatio() { return number('glide_ratio'); }

  // shown: see reach.js
  showReach(shown) { this.#map.show({ reach: shown?.collection ?? null, reachText: shown?.text }); }

  // The selected flight's last position, altitude and wind, unless the user has entered others.
  async #follow(signal) {
    const flight = this.#on.flight();
    if (this.#isOwn) {
      this.#pose = null;
      return;
    }
    const answer = flight ? await api.getAlternates(flight, signal).catch(() => null) : null;
    if (this.#isOwn || signal.aborted) return;
    this.#pose = answer?.pose ?? null;
    this.#flight = this.#pose ? flight : null;
    if (this.#pose) fillFromFlight(answer, this.#on.flightName(), this.#entered);
  }

  // A live flight's own reach is always shown. Else the reach of the position in the form, if its altitude is known.
  #useReach({ limit, ...request }) {
    if (isLive(this.#pose)) this.#on.useReach(null);
    else {
      const text = this.#pose ? `position ${ageText(this.#pose.age_s)}` : 'from the entered position';
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
    const wind = isWindKnown(this.#wind) ? { east_mps: this.#wind.east_mps, north_mps: this.#wind.north_mps } : null;
    this.#on.show(site, site.reach === 'unknown' ? undefined : wind);
  }

  #draw({ sites, nearest_miss: miss, warnings = [] }, from) {
    const shown = sites.slice(0, kShown);
    const cards = shown.length === 0 && miss ? [miss] : shown;
    const focused = [...byId('em-cards').querySelectorAll('button')].indexOf(document.activeElement);
    byId('em-cards').replaceChildren(...cards.map((site, i) =>
      emergencyCard(site, i, { flightName: this.#on.nameOf(site.flight_id), wind: this.#wind, onShow: () => this.#show(site) })));
    byId('em-cards').querySelectorAll('button')[focused]?.focus();
    byId('em-warnings').replaceChildren(...this.#notices.without(warnings).map((warning) => el('li', {}, sentence(warning))));
    this.#map.show({ from, sites: cards });
    this.#on.drawBearings(from, shown);
  }

  async #refresh(request, signal) {
    const from = { latitude_deg: request.latitude_deg, longitude_deg: request.longitude_deg };
    const isAltitudeKnown = request.altitude_m !== null;
    const answer = isAltitudeKnown ? await askReach(request, signal) : null;
    this.#wind = windOf(request, answer);
    this.#draw(answer ?? { sites: await uncheckedSites(from, signal) }, from);
    const { text, isBad } = answer ? headline(answer, this.#pose) : {};
    if (answer) say(`${text} (${now()})`, isBad ? 'bad' : '');
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
    const request = requestOfForm(this.#flight, this.#entered);
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
      this.#leaveFlight();
      setPosition({ latitude_deg: coords.latitude, longitude_deg: coords.longitude }, 'Position of this device.');
      if (isKnown(coords.altitude)) input('altitude_m').value = coords.altitude.toFixed(0);
      if (isKnown(coords.heading)) input('heading_deg').value = coords.heading.toFixed(0);
      this.#ask();
    }, (error) => say(`No device position: ${error.message}`, 'bad'), { timeout: 8000 });
  }
}

// on: {show(site, wind of its plan; null if unknown, undefined if it was not planned), center(): place,
// drawBearings(from, sites), flight(): id or null, flightName(), nameOf(flight id),
// useReach: as of reach.js}
export const createEmergency = (on) => new Emergency(on);
