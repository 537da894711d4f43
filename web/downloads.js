// Buttons that export a site or a flight for other programs.

import { getFile, paths, query } from './api.js';
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

// path: of a site, or of the sites of a flight. reportPath: of what the report is about.
export function drawDownloads(path, reportPath, { id, altitude_datum }) {
  const home = el('input', {
    type: 'number', step: '0.1', inputmode: 'decimal', class: 'short', value: sessionStorage.getItem(keptHome) ?? '',
    oninput: () => sessionStorage.setItem(keptHome, home.value),
  });
  const message = el('p', { class: 'bad', role: 'alert', hidden: true });
  const urlOf = (f) => (f === 'html' ? reportPath : path) + query({ f, home_altitude_m: needsHome.has(f) ? home.value : null });

  async function download(f, button) {
    message.hidden = true;
    button.setAttribute('aria-busy', 'true');
    try {
      save(await getFile(urlOf(f), `${id}.${formats[f][2]}`));
    } catch (error) {
      message.hidden = false;
      message.textContent = error.status === 409 ? error.message : `${formats[f][0]}: ${error.message}`;
      if (error.code === 'AltitudeUnknown') home.focus();
    } finally {
      button.removeAttribute('aria-busy');
    }
  }

  const buttons = Object.entries(formats).map(([f, [name, reader]]) => {
    const button = el('button', { type: 'button', class: 'download', 'data-format': f, onclick: () => download(f, button) },
      el('strong', {}, name), el('small', {}, reader));
    return button;
  });
  return el('div', { class: 'downloads' },
    el('div', { class: 'download-grid' }, buttons),
    el('label', { class: 'field' }, `Launch altitude (m, datum ${altitude_datum ?? 'of the flight'})`, home),
    el('p', { class: 'faint' }, 'Rally points require it. Plan and waypoints require it unless altitudes are above mean sea level.'),
    message,
    el('div', { class: 'card-foot' }, curlButton('a download', () => curlOf(urlOf('plan'), '-OJ'))));
}

const hasKmz = new Set(['photo', 'hazard']);

// Buttons for the files of a flight's map. layers: of its TileJSON.
export function drawMapDownloads(box, flight, layers) {
  const key = JSON.stringify([flight, layers.map(({ name }) => name)]);
  if (box.dataset.shown === key) return;
  box.dataset.shown = key;
  const message = el('p', { class: 'bad', role: 'alert', hidden: true });
  const button = (name, ending, reader) => {
    const node = el('button', { type: 'button', class: 'download', 'data-file': `${name}.${ending}`, onclick: async () => {
      message.hidden = true;
      node.setAttribute('aria-busy', 'true');
      try {
        save(await getFile(paths.mapFile(flight, name, ending), `${flight}-${name}.${ending}`));
      } catch (error) {
        message.hidden = false;
        message.textContent = `${words(name)}: ${error.message}`;
      } finally {
        node.removeAttribute('aria-busy');
      }
    } }, el('strong', {}, words(name)), el('small', {}, reader));
    return node;
  };
  const files = layers.flatMap(({ name }) => [button(name, 'tif', 'GeoTIFF, for QGIS'),
    ...(hasKmz.has(name) ? [button(name, 'kmz', 'KMZ, for Google Earth')] : [])]);
  box.replaceChildren(el('div', { class: 'download-grid' }, files), message,
    el('div', { class: 'card-foot' }, curlButton('a file of the map', () => curlOf(paths.mapFile(flight, layers[0].name, 'tif'), '-OJ'))));
}
