// "Winds you can land in": what the server plans for each of many winds, as cells by direction and
// speed around a calm. A cell takes its wind into the wind control.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el, svg } from './dom.js';
import { fixed, heading, verdictSign, words } from './units.js';

const kSpeeds_mps = [0, 2.5, 5, 7.5, 10];
const kCalmRadius = 20;
const kRingWidth = 26;
const kRim = kCalmRadius + kRingWidth * (kSpeeds_mps.length - 1);
const kVerdicts = ['landable', 'unverified', 'rejected'];

// Each wind once: a calm comes from nowhere.
const windsOf = (rose) => rose.entries.filter((e) => e.wind_speed_mps > 0 || e.wind_from_deg === 0);

// {from_deg, to_deg}: the longest row of directions in which most winds can be landed in; isAlike
// where that is all of them, null where it is none.
export function bestDirections(rose) {
  const worth = rose.directions_deg.map((from_deg) => rose.entries
    .filter((e) => e.wind_from_deg === from_deg && e.wind_speed_mps > 0)
    .reduce((sum, e) => sum + { landable: 1000, unverified: 1, rejected: 0 }[e.verdict], 0));
  const most = Math.max(...worth);
  if (!(most > 0)) return null;
  const count = worth.length;
  if (worth.every((each) => each === most)) return { isAlike: true };
  let best = { length: 0 };
  for (let first = 0; first < count; ++first) {
    let length = 0;
    while (worth[(first + length) % count] === most) ++length;
    if (length > best.length) best = { first, length };
  }
  const { first, length } = best;
  return { from_deg: rose.directions_deg[first], to_deg: rose.directions_deg[(first + length - 1) % count] };
}

// The picture in words.
export function roseText(rose) {
  const winds = windsOf(rose);
  const [numLandable, numUnverified] = kVerdicts.map((verdict) => winds.filter((e) => e.verdict === verdict).length);
  const best = bestDirections(rose);
  const where = !best ? '' : best.isAlike ? '; alike from every direction'
    : `; best from ${heading(best.from_deg)}${best.from_deg === best.to_deg ? '' : ` to ${heading(best.to_deg)}`}`;
  return `Landable in ${numLandable || 'none'} of ${winds.length} winds` +
    (numUnverified ? `, unverified in ${numUnverified}` : '') + `${where}.`;
}

export const windName = ({ wind_speed_mps, wind_from_deg }) =>
  (wind_speed_mps > 0 ? `${fixed(wind_speed_mps, 1, 'm/s')} from ${heading(wind_from_deg)}` : 'Calm');

function cellName(entry) {
  const how = entry.verdict === 'rejected' ? `rejected, ${words(entry.reject_reason ?? 'for no reason given')}`
    : `${entry.verdict} on ${heading(entry.heading_deg)}`;
  return `${windName(entry)}: ${how}`;
}

// How far from the middle a speed stands: a cell's own in the middle of its ring.
export function radiusOf(speed_mps) {
  const middles = kSpeeds_mps.map((_, i) => (i === 0 ? 0 : kCalmRadius + (i - 0.5) * kRingWidth));
  const i = kSpeeds_mps.findIndex((each) => each >= speed_mps);
  if (i < 0) return kRim;
  if (i === 0) return 0;
  const share = (speed_mps - kSpeeds_mps[i - 1]) / (kSpeeds_mps[i] - kSpeeds_mps[i - 1]);
  return middles[i - 1] + share * (middles[i] - middles[i - 1]);
}

const at = (radius, from_deg) => {
  const from_rad = from_deg * Math.PI / 180;
  return `${(radius * Math.sin(from_rad)).toFixed(2)} ${(-radius * Math.cos(from_rad)).toFixed(2)}`;
};

function cellPath(ring, from_deg, width_deg) {
  if (ring === 0) return `M0 ${-kCalmRadius}A${kCalmRadius} ${kCalmRadius} 0 1 1 -0.01 ${-kCalmRadius}Z`;
  const [inner, outer] = [kCalmRadius + (ring - 1) * kRingWidth, kCalmRadius + ring * kRingWidth];
  const [left, right] = [from_deg - width_deg / 2, from_deg + width_deg / 2];
  return `M${at(inner, left)}L${at(outer, left)}A${outer} ${outer} 0 0 1 ${at(outer, right)}` +
    `L${at(inner, right)}A${inner} ${inner} 0 0 0 ${at(inner, left)}Z`;
}

// Full, striped, crossed: told apart without colour too.
const patterns = () => svg('defs', {},
  svg('pattern', { id: 'rose-unverified', width: 6, height: 6, patternUnits: 'userSpaceOnUse', patternTransform: 'rotate(45)' },
    svg('rect', { width: 6, height: 6, class: 'rose-wash' }), svg('rect', { width: 3, height: 6, class: 'rose-stripe' })),
  svg('pattern', { id: 'rose-rejected', width: 8, height: 8, patternUnits: 'userSpaceOnUse' },
    svg('rect', { width: 8, height: 8, class: 'rose-empty' }), svg('path', { d: 'M2 2L6 6M6 2L2 6', class: 'rose-cross' })));

const paint = (verdict) => (verdict === 'landable' ? {} : { fill: `url(#rose-${verdict})` });

const legendItem = (verdict) => el('span', { class: 'swatch' },
  svg('svg', { width: 20, height: 20, 'aria-hidden': 'true' },
    svg('rect', { x: 1, y: 1, width: 18, height: 18, class: `rose-cell ${verdict}`, ...paint(verdict) })),
  `${verdictSign[verdict]} ${verdict}`);

function labels() {
  const compass = ['N', 'E', 'S', 'W'].map((name, i) => {
    const [x, y] = at(kRim + 12, 90 * i).split(' ');
    return svg('text', { x, y, class: 'rose-label' }, name);
  });
  // Between two directions of the cells' own.
  const speeds = kSpeeds_mps.slice(1).map((speed_mps) => {
    const [x, y] = at(radiusOf(speed_mps), 45).split(' ');
    return svg('text', { x, y, class: 'rose-label rose-speed' }, speed_mps);
  });
  return svg('g', { 'aria-hidden': 'true' }, [...compass, ...speeds]);
}

// choose(speed_mps, from_deg) is called with the wind of a cell.
export function createWindRose(choose) {
  const box = byId('wind-rose');
  const text = byId('wind-rose-text');
  let loading = new AbortController();
  let rose = null;
  let cells = [];
  let now = null;

  const cellOf = (ring, direction) => {
    const count = rose.directions_deg.length;
    return cells.find((cell) => cell.ring === ring && (ring === 0 || cell.direction === (direction + count) % count));
  };

  // The cell in which a wind lies.
  function nearest({ speed_mps, from_deg }) {
    const ring = kSpeeds_mps.reduce((best, each, i) =>
      (Math.abs(each - speed_mps) < Math.abs(kSpeeds_mps[best] - speed_mps) ? i : best), 0);
    return cellOf(ring, Math.round(from_deg * rose.directions_deg.length / 360));
  }

  // One stop of the Tab key for all of them.
  function makeStop(cell) {
    for (const each of cells) each.node.setAttribute('tabindex', each === cell ? '0' : '-1');
  }

  const take = ({ entry }) => choose(entry.wind_speed_mps, entry.wind_from_deg);

  function pressed(event, { ring, direction }) {
    const moves = { ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowUp: [1, 0], ArrowDown: [-1, 0] };
    const cell = cells.find((each) => each.ring === ring && each.direction === direction);
    if (['Enter', ' '].includes(event.key)) take(cell);
    else if (moves[event.key]) {
      const next = cellOf(Math.min(Math.max(ring + moves[event.key][0], 0), kSpeeds_mps.length - 1), direction + moves[event.key][1]);
      makeStop(next);
      next.node.focus();
    } else return;
    event.preventDefault();
  }

  function makeCell(entry) {
    const ring = kSpeeds_mps.indexOf(entry.wind_speed_mps);
    const direction = ring === 0 ? 0 : rose.directions_deg.indexOf(entry.wind_from_deg);
    const name = cellName(entry);
    const node = svg('path', { d: cellPath(ring, entry.wind_from_deg, 360 / rose.directions_deg.length),
      class: `rose-cell ${entry.verdict}`, ...paint(entry.verdict), role: 'button', tabindex: '-1', 'aria-label': name },
      svg('title', {}, name));
    const cell = { entry, ring, direction, node };
    node.addEventListener('click', () => { makeStop(cell); take(cell); });
    node.addEventListener('keydown', (event) => pressed(event, cell));
    return cell;
  }

  function drawMark() {
    box.querySelector('.rose-now')?.remove();
    for (const { node } of cells) node.removeAttribute('aria-current');
    if (!rose || !now) return;
    const isBeyond = now.speed_mps > kSpeeds_mps.at(-1);
    const [cx, cy] = at(radiusOf(now.speed_mps), now.from_deg).split(' ');
    const mark = svg('g', { class: `rose-now${isBeyond ? ' beyond' : ''}`, 'aria-hidden': 'true' },
      svg('circle', { cx, cy, r: 7, class: 'rose-halo' }), svg('circle', { cx, cy, r: 7 }));
    box.firstElementChild.append(mark);
    const cell = nearest(now);
    if (!isBeyond) cell.node.setAttribute('aria-current', 'true');
    if (!box.contains(document.activeElement)) makeStop(cell);
  }

  function draw() {
    const size = kRim + 22;
    const picture = svg('svg', { viewBox: `${-size} ${-size} ${2 * size} ${2 * size}`, role: 'group',
      'aria-labelledby': 'wind-rose-title', 'aria-describedby': 'wind-rose-text wind-rose-help' }, patterns());
    cells = windsOf(rose).map(makeCell);
    picture.append(...cells.map(({ node }) => node), labels());
    box.replaceChildren(picture);
    text.textContent = roseText(rose);
    makeStop(cells[0]);
    drawMark();
  }

  function clear(words = '') {
    rose = null;
    cells = [];
    box.replaceChildren();
    byId('wind-rose-legend').hidden = true;
    text.textContent = words;
  }

  byId('wind-rose-legend').replaceChildren(...kVerdicts.map(legendItem),
    el('span', { class: 'swatch' }, svg('svg', { width: 20, height: 20, class: 'rose-now', 'aria-hidden': 'true' },
      svg('circle', { cx: 10, cy: 10, r: 7 })), 'the wind above'));

  return {
    // The rose of another site, or null for none.
    async show(siteId) {
      loading.abort();
      loading = new AbortController();
      const { signal } = loading;
      clear(siteId ? 'Planning for every wind …' : '');
      if (!siteId) return;
      byId('wind-rose-curl').replaceChildren(curlButton('the wind rose', () => curlOf(api.paths.windRose(siteId, kSpeeds_mps))));
      try {
        rose = await api.getWindRose(siteId, kSpeeds_mps, signal);
        byId('wind-rose-legend').hidden = false;
        draw();
      } catch (error) {
        if (error.name === 'AbortError') return;
        clear(`No wind rose: ${error.message}`);
      }
    },
    // The wind that is planned for, null where none is known.
    mark(wind) {
      now = wind;
      drawMark();
    },
  };
}
