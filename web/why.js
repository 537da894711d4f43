// "Why not here?": what the stored layers say about one place, rule by rule, for an aircraft.
// It never says yes: final, circle and ground roll from here are not planned by it.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { el } from './dom.js';
import { readGeoTiff } from './geotiff.js';
import { fixed, isKnown } from './units.js';

const kLayers = ['hazard', 'grass', 'slope', 'roughness', 'distance', 'elevation'];
const hazardUnseen = 2;

// Row and column of a place in a layer; corners go from the north-west clockwise, as [lon, lat].
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

// [{name, state: 'pass' | 'fail' | 'unknown', text}] in the order in which they count.
export function judge(values, aircraft) {
  const { hazard, grass, slope, roughness, distance } = values;
  const limited = (name, value, limit, digits, unit) => {
    if (!isKnown(value)) return { name, state: 'unknown', text: 'not seen' };
    if (!isKnown(limit)) return { name, state: 'unknown', text: `${fixed(value, digits, unit)}, limit unknown` };
    const excess = value - limit;
    return {
      name,
      state: excess > 0 ? 'fail' : 'pass',
      text: `${fixed(value, digits, unit)}, at most ${fixed(limit, digits, unit)}` +
        (excess > 0 ? `: ${fixed(excess, digits, unit)} too much` : ''),
    };
  };
  const isSeen = isKnown(hazard) && hazard !== hazardUnseen;
  const wanted = aircraft?.touchdown_uncertainty_m;
  const missing = wanted - distance;
  const rules = [
    { name: 'seen', state: isSeen ? 'pass' : 'fail',
      text: isSeen ? 'in enough photographs' : 'not seen well enough; unknown is never safe' },
    { name: 'grass', state: !isKnown(grass) ? 'unknown' : grass > 0 ? 'pass' : 'fail',
      text: !isKnown(grass) ? 'not classified' : grass > 0 ? 'classified as grass' : 'not classified as grass' },
    limited('slope', slope, aircraft?.max_slope_deg, 1, '°'),
    limited('roughness', roughness, aircraft?.max_roughness_m, 2, 'm'),
  ];
  if (!isKnown(distance) || !isKnown(wanted)) {
    rules.push({ name: 'free disc', state: 'unknown', text: 'not known' });
  } else {
    rules.push({
      name: 'free disc',
      state: missing > 0 ? 'fail' : 'pass',
      text: `next hazard or unseen ground ${fixed(distance, 1, 'm')} away, more than ` +
        `${fixed(wanted, 0, 'm')} needed` + (missing > 0 ? `: ${fixed(missing, 1, 'm')} too near` : ''),
    });
  }
  return rules;
}

const sign = { pass: '✓', fail: '✕', unknown: '?' };

function headline(rules, hazard) {
  const first = rules.find((rule) => rule.state !== 'pass');
  if (first) return first.state === 'fail' ? `Not here: ${first.name}` : `Not here: ${first.name} unknown`;
  if (hazard !== 0) return 'Not here: marked as hazard';
  return 'The ground passes; landing here is not checked';
}

export function answerNode(rules, values) {
  const isClear = rules.every((rule) => rule.state === 'pass') && values.hazard === 0;
  return el('div', { class: 'answer' },
    el('h3', {}, headline(rules, values.hazard)),
    el('ul', { class: 'rules' }, rules.map((rule) => el('li', { class: rule.state },
      el('b', { 'aria-label': rule.state }, sign[rule.state]), el('span', {}, el('strong', {}, rule.name), ` ${rule.text}`)))),
    isKnown(values.elevation) ? el('p', { class: 'faint' }, `Ground at ${fixed(values.elevation, 1, 'm')}`) : null,
    el('p', { class: 'faint' }, isClear
      ? 'That is no verdict: final, circle, ground roll and the map’s own uncertainty are only checked for the sites.'
      : 'The first rule that fails is named; below it, what the others say.'));
}

// The answer, with the way to the region that lies here.
export function answerNodeOf(answer, region, openHistory) {
  if (region) {
    answer.append(el('button', { type: 'button', class: 'wide', onclick: openHistory },
      `Region ${region.properties.id}, grade ${region.properties.grade.toFixed(2)}: history`));
  }
  return answer;
}

const nothing = () => el('div', { class: 'answer' }, el('h3', {}, 'Not here: never seen'),
  el('p', {}, 'No map covers this place. Unknown is never safe.'));

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

  // The node to show for a place; site and layers are those on the map, or null.
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
    answer.append(el('div', { class: 'card-foot' }, curlButton('the layers that were asked', () =>
      known.map(({ name }) => curlOf(api.paths.layerTiff(site.properties.id, name), `-o ${name}.tif`)).join('\n'))));
    return answer;
  };
}
