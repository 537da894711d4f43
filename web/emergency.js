// Emergency mode: the three best sites in reach. Refreshes while the dialog is open.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el } from './dom.js';
import { emergencyCard } from './emergency_card.js';
import { courseTo, isKnown, windFrom, windTo } from './units.js';

const kRefresh_ms = 5000;
const kShown = 3;
const kept = 'freelsd.emergency';
const fields = ['latitude_deg', 'longitude_deg', 'altitude_m', 'heading_deg', 'glide_ratio', 'wind_speed_mps',
  'wind_from_deg', 'altitude_datum'];

// --- Form ---

const input = (name) => byId(`em-${name}`);
const number = (name) => (input(name).value === '' ? null : Number(input(name).value));

function requestOfForm() {
  const speed = number('wind_speed_mps');
  const from = number('wind_from_deg');
  const wind = speed === null || from === null ? null : windTo(speed, from);
  return {
    latitude_deg: number('latitude_deg'), longitude_deg: number('longitude_deg'), altitude_m: number('altitude_m'),
    altitude_datum: input('altitude_datum').value, heading_deg: number('heading_deg'), glide_ratio: number('glide_ratio'),
    wind_east_mps: wind?.east_mps.toFixed(3), wind_north_mps: wind?.north_mps.toFixed(3), limit: kShown,
  };
}

function setPosition({ latitude_deg, longitude_deg }) {
  input('latitude_deg').value = latitude_deg.toFixed(6);
  input('longitude_deg').value = longitude_deg.toFixed(6);
}

function keepForm() {
  localStorage.setItem(kept, JSON.stringify(Object.fromEntries(fields.map((name) => [name, input(name).value]))));
}

// Former values first; the map's centre and the site's wind fill what is empty.
function fillForm(center, storedWind) {
  const known = JSON.parse(localStorage.getItem(kept) ?? '{}');
  for (const name of fields) if (known[name] !== undefined) input(name).value = known[name];
  if (input('latitude_deg').value === '') setPosition(center);
  const wind = windFrom(storedWind);
  if (wind && input('wind_speed_mps').value === '') {
    input('wind_speed_mps').value = wind.speed_mps.toFixed(1);
    input('wind_from_deg').value = Math.round(wind.from_deg);
  }
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
async function nearestSites(from, signal) {
  const { features } = await api.getAllSites(signal);
  const order = { landable: 0, unverified: 1 };
  return features.filter(({ properties: p, geometry }) => p.verdict in order && geometry)
    .map(({ properties: p, geometry }) => {
      const touchdown = { latitude_deg: geometry.coordinates[1], longitude_deg: geometry.coordinates[0] };
      return {
        site_id: p.id, flight_id: p.flight_id, verdict: p.verdict, approach: p.approach, touchdown, reach: 'unknown',
        unseen_ratio: p.unseen_ratio, age_s: (Date.now() - Date.parse(p.last_seen_at ?? p.updated_at)) / 1000,
        ...courseTo(from, touchdown),
      };
    })
    .sort((a, b) => order[a.verdict] - order[b.verdict] || a.distance_m - b.distance_m)
    .slice(0, kShown);
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
  #dialog = byId('emergency');
  #timer = 0;
  #running = new AbortController();

  constructor(on) {
    this.#on = on;
    byId('em-form').addEventListener('input', () => this.#ask());
    byId('em-form').addEventListener('submit', (event) => { event.preventDefault(); this.#ask(); });
    byId('em-center').addEventListener('click', () => { setPosition(on.center()); this.#ask(); });
    byId('em-locate').addEventListener('click', () => this.#locate());
    byId('em-locate').hidden = !('geolocation' in navigator) || !isSecureContext;
    byId('em-close').addEventListener('click', () => this.#dialog.close());
    this.#dialog.addEventListener('close', () => this.#stop());
    byId('em-curl').append(curlButton('the emergency sites', () => curlOf(api.paths.emergency(requestOfForm()))));
    for (const button of document.querySelectorAll('[data-emergency]')) {
      button.addEventListener('click', () => this.#open());
    }
  }

  #open() {
    fillForm(this.#on.center(), this.#on.wind());
    this.#dialog.showModal();
    this.#ask();
  }

  #stop() {
    clearTimeout(this.#timer);
    this.#running.abort();
  }

  #show(site) {
    this.#stop();
    this.#dialog.close();
    this.#on.show(site);
  }

  #draw({ sites, nearest_miss: miss, warnings = [] }, from) {
    const shown = sites.slice(0, kShown);
    const cards = shown.length === 0 && miss ? [miss] : shown;
    byId('em-cards').replaceChildren(...cards.map((site, i) => emergencyCard(site, i, () => this.#show(site))));
    byId('em-warnings').replaceChildren(...warnings.map((w) => el('li', {}, typeof w === 'string' ? w : w.detail)));
    this.#on.drawBearings(from, shown);
  }

  async #refresh(request, signal) {
    const from = { latitude_deg: request.latitude_deg, longitude_deg: request.longitude_deg };
    const isAltitudeKnown = request.altitude_m !== null;
    const answer = isAltitudeKnown ? await askReach(request, signal) : null;
    this.#draw(answer ?? { sites: await nearestSites(from, signal) }, from);
    if (answer) sayReach(answer);
    else if (isAltitudeKnown) say(`This server cannot check reach. Sites below are unchecked (${now()}).`, 'bad');
    else say('Enter altitude to check reach. Sites below are unchecked.', 'bad');
  }

  // A newer request aborts the former one: a late answer must not replace a newer one.
  async #ask() {
    this.#stop();
    this.#running = new AbortController();
    const { signal } = this.#running;
    const request = requestOfForm();
    if (request.latitude_deg === null || request.longitude_deg === null) {
      say('Enter your position.', 'bad');
      return;
    }
    keepForm();
    try {
      await this.#refresh(request, signal);
    } catch (error) {
      if (signal.aborted) return;
      // An old answer is better than none, but must be marked as old.
      say(`Update failed: ${error.message}. Sites below may be outdated.`, 'bad');
    }
    if (this.#dialog.open && !signal.aborted) this.#timer = setTimeout(() => this.#ask(), kRefresh_ms);
  }

  #locate() {
    say('Reading device position …');
    navigator.geolocation.getCurrentPosition(({ coords }) => {
      setPosition({ latitude_deg: coords.latitude, longitude_deg: coords.longitude });
      if (isKnown(coords.altitude)) input('altitude_m').value = coords.altitude.toFixed(0);
      if (isKnown(coords.heading)) input('heading_deg').value = coords.heading.toFixed(0);
      this.#ask();
    }, (error) => say(`No device position: ${error.message}`, 'bad'), { timeout: 8000 });
  }
}

// on: {show(site), center(): place, drawBearings(from, sites), wind(): of the selected site}
export const createEmergency = (on) => new Emergency(on);
