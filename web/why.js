// Checks one place against the limits of the aircraft, rule by rule, from the stored layers.
// A passed check is no verdict: only the server plans final, loiter circle and ground roll.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { el } from './dom.js';
import { readGeoTiff } from './geotiff.js';
import { fixed, isKnown } from './units.js';

const kLayers = ['hazard', 'grass', 'slope', 'roughness', 'distance', 'elevation'];
const hazardUnseen = 2;

// Row and column of a place in a layer. layer.corners: clockwise from the north-west, [lon, lat].
export function cellAt(layer, { lat, lng }) {
  const [nw, ne, , sw] = layer.corners;
  const [ax, ay] = [ne[0] - nw[0], ne[1] - nw[1]];
  const [bx, by] = [sw[0] - nw[0], sw[1] - nw[1]];
  const [px, py] = [lng - nw[0], lat - nw[1]];
  const area = ax * by - ay * bx;
  return {
    row: Math.floor((ax * py - ay * px) / area * layer.height_px),
    col: Math.floor((px * by - py * bx) / area * layer.width_px),
  };
}

const isIn = (layer, { row, col }) =>
  row >= 0 && col >= 0 && row < layer.height_px && col < layer.width_px;

function ruleOfCoverage(hazard) {
  const isSeen = isKnown(hazard) && hazard !== hazardUnseen;
  return { name: 'coverage', state: isSeen ? 'pass' : 'fail',
    text: isSeen ? 'sufficient' : 'not sufficient. Unseen ground is never safe.' };
}

function ruleOfGrass(grass) {
  if (!isKnown(grass)) return { name: 'grass', state: 'unknown', text: 'not classified' };
  return grass > 0 ? { name: 'grass', state: 'pass', text: 'classified as grass' }
    : { name: 'grass', state: 'fail', text: 'not classified as grass' };
}

function ruleOfMaximum(name, value, limit, digits, unit) {
  if (!isKnown(value)) return { name, state: 'unknown', text: 'unseen' };
  if (!isKnown(limit)) return { name, state: 'unknown', text: `${fixed(value, digits, unit)}, limit unknown` };
  const excess = value - limit;
  const text = `${fixed(value, digits, unit)}, max ${fixed(limit, digits, unit)}`;
  return excess > 0 ? { name, state: 'fail', text: `${text}: ${fixed(excess, digits, unit)} over limit` }
    : { name, state: 'pass', text };
}

function ruleOfDistance(distance, needed) {
  const name = 'nearest hazard';
  if (!isKnown(distance) || !isKnown(needed)) return { name, state: 'unknown', text: 'unknown' };
  const missing = needed - distance;
  const text = `or unseen ground at ${fixed(distance, 1, 'm')}, min ${fixed(needed, 0, 'm')}`;
  return missing > 0 ? { name, state: 'fail', text: `${text}: ${fixed(missing, 1, 'm')} too close` }
    : { name, state: 'pass', text };
}

// [{name, state: 'pass' | 'fail' | 'unknown', text}], the decisive rule first.
export function judge({ hazard, grass, slope, roughness, distance }, aircraft) {
  return [
    ruleOfCoverage(hazard),
    ruleOfGrass(grass),
    ruleOfMaximum('slope', slope, aircraft?.max_slope_deg, 1, '°'),
    ruleOfMaximum('roughness', roughness, aircraft?.max_roughness_m, 2, 'm'),
    ruleOfDistance(distance, aircraft?.touchdown_uncertainty_m),
  ];
}

const sign = { pass: '✓', fail: '✕', unknown: '?' };

function headline(rules, hazard) {
  const first = rules.find((rule) => rule.state !== 'pass');
  if (first) return first.state === 'fail' ? `Not landable: ${first.name}` : `Not landable: ${first.name} unknown`;
  if (hazard !== 0) return 'Not landable: marked as hazard';
  return 'Ground passes. Landing is unchecked.';
}

export function answerNode(rules, values) {
  const isClear = rules.every((rule) => rule.state === 'pass') && values.hazard === 0;
  return el('div', { class: 'answer' },
    el('h3', {}, headline(rules, values.hazard)),
    el('ul', { class: 'rules' }, rules.map((rule) => el('li', { class: rule.state },
      el('b', { 'aria-label': rule.state }, sign[rule.state]), el('span', {}, el('strong', {}, rule.name), ` ${rule.text}`)))),
    isKnown(values.elevation) ? el('p', { class: 'faint' }, `Ground elevation ${fixed(values.elevation, 1, 'm')}`) : null,
    el('p', { class: 'faint' }, isClear
      ? 'This is not a verdict. Final, loiter circle, ground roll and map uncertainty are checked for sites only.'
      : 'The title names the first failed rule.'));
}

// Adds a button to the region at this place. region: null if none.
export function answerNodeOf(answer, region, openHistory) {
  if (region) {
    answer.append(el('button', { type: 'button', class: 'wide', onclick: openHistory },
      `Region ${region.properties.id}: grade ${region.properties.grade.toFixed(2)}`));
  }
  return answer;
}

const nothing = () => el('div', { class: 'answer' }, el('h3', {}, 'Not landable: unseen'),
  el('p', {}, 'No map covers this place. Unseen ground is never safe.'));

export function createWhy() {
  const cache = new Map();

  function rasterOf(site, name) {
    const key = `${site.properties.id} ${site.properties.updated_at} ${name}`;
    if (!cache.has(key)) {
      if (cache.size > 4 * kLayers.length) cache.clear();
      const raster = api.getBytes(api.paths.layerTiff(site.properties.id, name)).then(readGeoTiff);
      raster.catch(() => cache.delete(key));
      cache.set(key, raster);
    }
    return cache.get(key);
  }

  // Returns the answer as a DOM node. site: the selected site or null; layers: its layers.
  return async function whyNot(latlng, site, layers) {
    const known = layers.filter((layer) => kLayers.includes(layer.name));
    if (!site || known.length === 0 || !known.every((layer) => isIn(layer, cellAt(layer, latlng)))) {
      return nothing();
    }
    const values = {};
    await Promise.all(known.map(async (layer) => {
      const { row, col } = cellAt(layer, latlng);
      values[layer.name] = (await rasterOf(site, layer.name)).at(row, col);
    }));
    const answer = answerNode(judge(values, site.properties.aircraft), values);
    answer.append(el('div', { class: 'card-foot' }, curlButton('these layers', () =>
      known.map(({ name }) => curlOf(api.paths.layerTiff(site.properties.id, name), `-o ${name}.tif`)).join('\n'))));
    return answer;
  };
}
