// Emergency mode: the three best sites in reach, big. Asked again every few seconds.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el, svg } from './dom.js';
import { age, courseTo, distance, fixed, heading, isKnown, verdictSign, windFrom, windTo } from './units.js';

const kRefresh_ms = 5000;
const kShown = 3;
const kept = 'freelsd.emergency';
const fields = ['latitude_deg', 'longitude_deg', 'altitude_m', 'heading_deg', 'glide_ratio', 'wind_speed_mps',
  'wind_from_deg', 'altitude_datum'];

const input = (name) => byId(`em-${name}`);
const number = (name) => (input(name).value === '' ? null : Number(input(name).value));

const arrow = (bearing_deg) => svg('svg', { viewBox: '-20 -20 40 40', class: 'arrow', 'aria-hidden': 'true' },
  svg('path', { d: 'M0 -17L12 13L0 6L-12 13Z', transform: `rotate(${bearing_deg})` }));

const fact = (name, value, className = '') =>
  el('div', { class: className }, el('dt', {}, name), el('dd', {}, value));

function card(site, index, onShow) {
  const approach = site.approach;
  return el('article', { class: `em-card verdict-${site.verdict}`, 'aria-label': `Choice ${index + 1}` },
    el('header', {}, el('span', { class: 'rank' }, index + 1),
      el('strong', {}, `${verdictSign[site.verdict]} ${site.verdict}`),
      site.reach === 'unknown' ? el('span', { class: 'chip' }, 'reach not computed') : null),
    el('div', { class: 'em-course' }, arrow(site.bearing_deg),
      el('div', {}, el('strong', {}, heading(site.bearing_deg)), el('span', {}, distance(site.distance_m)))),
    el('dl', {},
      fact('Land on', approach ? heading(approach.heading_deg) : 'unknown', 'big'),
      site.arrival_margin_m === undefined ? null
        : fact('Arrive with', `${site.arrival_margin_m >= 0 ? '+' : '−'}${fixed(Math.abs(site.arrival_margin_m), 0, 'm')}`, 'big'),
      isKnown(site.time_s) ? fact('Time', `${Math.floor(site.time_s / 60)}:${String(Math.round(site.time_s % 60)).padStart(2, '0')}`) : null,
      fact('Seen', `${age(site.age_s)} ago`),
      site.unseen_ratio > 0 ? fact('Circle unseen', fixed(100 * site.unseen_ratio, 0, '%')) : null),
    el('button', { type: 'button', class: 'wide', onclick: () => onShow(site) }, 'Show on the map'));
}

// Where the server has no reach computation: the nearest stored sites, said to be no more than that.
async function nearestSites(from, signal) {
  const { features } = await api.getAllSites(signal);
  const order = { landable: 0, unverified: 1 };
  return features.filter(({ properties: p, geometry }) => p.verdict in order && geometry)
    .map(({ properties: p, geometry }) => {
      const touchdown = { latitude_deg: geometry.coordinates[1], longitude_deg: geometry.coordinates[0] };
      return {
        site_id: p.id, flight_id: p.flight_id, verdict: p.verdict, approach: p.approach, touchdown, reach: 'unknown',
        unseen_ratio: p.unseen_ratio, age_s: (Date.now() - Date.parse(p.updated_at)) / 1000, ...courseTo(from, touchdown),
      };
    })
    .sort((a, b) => order[a.verdict] - order[b.verdict] || a.distance_m - b.distance_m)
    .slice(0, kShown);
}

// on: {show(site), center(): place, drawBearings(from, sites), wind(): of the chosen site}
export function createEmergency(on) {
  const dialog = byId('emergency');
  let timer = 0;
  let running = new AbortController();

  function request() {
    const speed = number('wind_speed_mps');
    const from = number('wind_from_deg');
    const wind = speed === null || from === null ? null : windTo(speed, from);
    return {
      latitude_deg: number('latitude_deg'), longitude_deg: number('longitude_deg'), altitude_m: number('altitude_m'),
      altitude_datum: input('altitude_datum').value, heading_deg: number('heading_deg'), glide_ratio: number('glide_ratio'),
      wind_east_mps: wind?.east_mps.toFixed(3), wind_north_mps: wind?.north_mps.toFixed(3), limit: kShown,
    };
  }

  function say(text, className = '') {
    byId('em-message').textContent = text;
    byId('em-message').className = className;
  }

  function draw({ sites, nearest_miss: miss, warnings = [] }, from, isReachKnown) {
    const shown = sites.slice(0, kShown);
    byId('em-cards').replaceChildren(...shown.map((site, i) => card(site, i, show)));
    byId('em-warnings').replaceChildren(...warnings.map((w) => el('li', {}, typeof w === 'string' ? w : w.detail)));
    on.drawBearings(from, shown);
    const time = new Date().toLocaleTimeString();
    if (!isReachKnown) {
      say(`This server does not compute reach. Nearest known sites at ${time}: whether you can glide there is not known.`, 'bad');
    } else if (shown.length === 0) {
      say(`Nothing in reach (${time}).${miss ? ' The nearest miss:' : ' No site that one could land on is stored nearby.'}`, 'bad');
      if (miss) byId('em-cards').append(card(miss, 0, show));
    } else {
      say(`In reach, best first (${time})`);
    }
  }

  // A newer question aborts this one, whatever it waits for: its answer must not be drawn over the newer one.
  async function answer(values, from, signal) {
    if (values.altitude_m === null) {
      draw({ sites: await nearestSites(from, signal) }, from, false);
      say('Fill in your altitude to know what is in reach. Until then: the nearest known sites.', 'bad');
      return;
    }
    try {
      draw(await api.getEmergency(values, signal), from, true);
    } catch (error) {
      if (error.status !== 404) throw error;
      draw({ sites: await nearestSites(from, signal) }, from, false);
    }
  }

  async function ask() {
    clearTimeout(timer);
    running.abort();
    running = new AbortController();
    const { signal } = running;
    const values = request();
    const from = { latitude_deg: values.latitude_deg, longitude_deg: values.longitude_deg };
    const missing = ['latitude_deg', 'longitude_deg'].filter((name) => values[name] === null);
    if (missing.length > 0) return say('Where are you? Fill in the position.', 'bad');
    localStorage.setItem(kept, JSON.stringify(Object.fromEntries(fields.map((name) => [name, input(name).value]))));
    try {
      await answer(values, from, signal);
    } catch (error) {
      if (signal.aborted) return undefined;
      fail(error);
    }
    if (dialog.open && !signal.aborted) timer = setTimeout(ask, kRefresh_ms);
    return undefined;
  }

  // What was shown stays: an old answer is better than none, but it says that it is old.
  function fail(error) {
    say(`No answer: ${error.message}. What is shown is the last answer.`, 'bad');
  }

  function close() {
    clearTimeout(timer);
    running.abort();
    dialog.close();
  }

  function show(site) {
    close();
    on.show(site);
  }

  function place({ latitude_deg, longitude_deg }) {
    input('latitude_deg').value = latitude_deg.toFixed(6);
    input('longitude_deg').value = longitude_deg.toFixed(6);
  }

  function open() {
    const known = JSON.parse(localStorage.getItem(kept) ?? '{}');
    for (const name of fields) if (known[name] !== undefined) input(name).value = known[name];
    if (input('latitude_deg').value === '') place(on.center());
    const wind = windFrom(on.wind());
    if (wind && input('wind_speed_mps').value === '') {
      input('wind_speed_mps').value = wind.speed_mps.toFixed(1);
      input('wind_from_deg').value = Math.round(wind.from_deg);
    }
    dialog.showModal();
    ask();
  }

  byId('em-form').addEventListener('input', ask);
  byId('em-form').addEventListener('submit', (event) => { event.preventDefault(); ask(); });
  byId('em-center').addEventListener('click', () => { place(on.center()); ask(); });
  byId('em-locate').addEventListener('click', () => {
    say('Asking this device where it is …');
    navigator.geolocation.getCurrentPosition(({ coords }) => {
      place({ latitude_deg: coords.latitude, longitude_deg: coords.longitude });
      if (isKnown(coords.altitude)) input('altitude_m').value = coords.altitude.toFixed(0);
      if (isKnown(coords.heading)) input('heading_deg').value = coords.heading.toFixed(0);
      ask();
    }, (error) => say(`This device does not tell where it is: ${error.message}`, 'bad'), { timeout: 8000 });
  });
  byId('em-locate').hidden = !('geolocation' in navigator) || !isSecureContext;
  byId('em-close').addEventListener('click', close);
  dialog.addEventListener('close', () => { clearTimeout(timer); running.abort(); });
  byId('em-curl').append(curlButton('the emergency answer', () => curlOf(api.paths.emergency(request()))));
  for (const button of document.querySelectorAll('[data-emergency]')) button.addEventListener('click', open);
  return { open };
}
