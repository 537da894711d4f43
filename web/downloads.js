// Buttons that export a site or a flight for other programs.

import { Problem, getFile, paths, query } from './api.js';
import { curlButton, curlOf } from './curl.js';
import { el } from './dom.js';
import { words } from './units.js';

const formats = {
  html: ['Report', 'for paper, without a network', 'html'],
  plan: ['QGC plan', 'QGroundControl', 'plan'],
  waypoints: ['Waypoints', 'Mission Planner, MAVProxy', 'waypoints'],
  rally: ['Rally', 'ArduPilot rally points', 'rally'],
  kml: ['KML', 'Google Earth', 'kml'],
  cup: ['CUP', 'XCSoar, SeeYou', 'cup'],
  geojson: ['GeoJSON', 'QGIS, web maps', 'geojson'],
  csv: ['CSV', 'spreadsheets', 'csv'],
};
const needsHome = new Set(['plan', 'waypoints', 'rally']);
const keptHome = 'freelsd.home_altitude_m';

function save({ blob, name }) {
  const link = el('a', { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// A button that saves a file. path(): its address at the time of the click; check(): throws what is missing; failed(error):
// after the message was shown.
function fileButton({ title, reader, data, path, name, message, check = () => {}, failed = () => {} }) {
  const button = el('button', { type: 'button', class: 'download', ...data, onclick: async () => {
    message.hidden = true;
    button.setAttribute('aria-busy', 'true');
    try {
      check();
      save(await getFile(path(), name));
    } catch (error) {
      message.hidden = false;
      message.textContent = error.status === 409 ? error.message : `${title}: ${error.message}`;
      failed(error);
    } finally {
      button.removeAttribute('aria-busy');
    }
  } }, el('strong', {}, title), el('small', {}, reader));
  return button;
}

const messageNode = () => el('p', { class: 'bad', role: 'alert', hidden: true });

const homeInput = () => {
  const home = el('input', {
    type: 'number', step: '0.1', inputmode: 'decimal', class: 'short', value: sessionStorage.getItem(keptHome) ?? '',
    oninput: () => sessionStorage.setItem(keptHome, home.value),
  });
  return home;
};
const homeField = (home, datum) => el('label', { class: 'field' }, `Launch altitude (m, datum ${datum ?? 'of the flight'})`, home);
const focusIfNeeded = (home) => ({ code }) => { if (code === 'AltitudeUnknown') home.focus(); };

// path: of a site, or of the sites of a flight. reportPath: of what the report is about.
export function drawDownloads(path, reportPath, { id, altitude_datum }) {
  const home = homeInput();
  const message = messageNode();
  const urlOf = (f) => (f === 'html' ? reportPath : path) + query({ f, home_altitude_m: needsHome.has(f) ? home.value : null });
  const buttons = Object.entries(formats).map(([f, [title, reader, ending]]) => fileButton({
    title, reader, data: { 'data-format': f }, path: () => urlOf(f), name: `${id}.${ending}`, message, failed: focusIfNeeded(home) }));
  return el('div', { class: 'downloads' },
    el('div', { class: 'download-grid' }, buttons),
    homeField(home, altitude_datum),
    el('p', { class: 'faint' }, 'Rally points require it. Plan and waypoints require it unless altitudes are above mean sea level.'),
    message,
    el('div', { class: 'card-foot' }, curlButton('a download', () => curlOf(urlOf('plan'), '-OJ'))));
}

const hasKmz = new Set(['photo', 'hazard']);

// An unchanged box is not drawn again: it keeps the focus and its message. key: of what it shows.
function isDrawn(box, key) {
  const wanted = JSON.stringify(key);
  const isSame = box.dataset.shown === wanted;
  box.dataset.shown = wanted;
  return isSame;
}

// Buttons for the files of a flight's map. layers: of its TileJSON.
export function drawMapDownloads(box, flight, layers) {
  if (isDrawn(box, [flight, layers.map(({ name }) => name)])) return;
  const message = messageNode();
  const button = (name, ending, reader) => fileButton({ title: words(name), reader, data: { 'data-file': `${name}.${ending}` },
    path: () => paths.mapFile(flight, name, ending), name: `${flight}-${name}.${ending}`, message });
  const files = layers.flatMap(({ name }) => [button(name, 'tif', 'GeoTIFF, for QGIS'),
    ...(hasKmz.has(name) ? [button(name, 'kmz', 'KMZ, for Google Earth')] : [])]);
  box.replaceChildren(el('div', { class: 'download-grid' }, files), message,
    el('div', { class: 'card-foot' }, curlButton('a file of the map', () => curlOf(paths.mapFile(flight, layers[0].name, 'tif'), '-OJ'))));
}

// Buttons for the files of the legs to fly next. legs: the number of them.
export function drawLegDownloads(box, flight, { legs, altitude_datum }) {
  if (isDrawn(box, [flight, legs, altitude_datum])) return;
  const home = homeInput();
  const message = messageNode();
  const urlOf = (f) => paths.nextLook(flight, { legs, f, home_altitude_m: f === 'plan' ? home.value : null });
  // The server would choose the legs before it refuses the plan.
  const check = { plan() {
    if (altitude_datum !== 'amsl' && home.value === '') throw new Problem(409, { code: 'AltitudeUnknown', detail: 'Enter the launch altitude.' });
  } };
  const button = (f, reader) => fileButton({ title: formats[f][0], reader, data: { 'data-format': f }, path: () => urlOf(f),
    name: `${flight}-next-look.${formats[f][2]}`, message, check: check[f], failed: focusIfNeeded(home) });
  box.replaceChildren(el('div', { class: 'download-grid' }, button('plan', 'QGroundControl, one survey per leg'), button('geojson', formats.geojson[1])),
    homeField(home, altitude_datum),
    el('p', { class: 'faint' }, altitude_datum === 'amsl' ? 'With it, the altitudes of the plan are above the place of launch; without it, above mean sea level.'
      : 'The plan requires it, because the altitudes of this flight are not above mean sea level.'),
    message,
    el('div', { class: 'card-foot' }, curlButton('the plan', () => curlOf(urlOf('plan'), '-OJ'))));
}
