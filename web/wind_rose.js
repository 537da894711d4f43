// The wind rose: the server's verdict for winds of many directions and speeds. A cell is a button that
// selects its wind.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el, svg } from './dom.js';
import { fixed, heading, verdictSign, words } from './units.js';
import { cellPath, kRim, kSpeeds_mps, kVerdicts, pointAt, radiusOf, roseText, windsOf } from './wind_rose_shape.js';

const windName = ({ wind_speed_mps, wind_from_deg }) =>
  (wind_speed_mps > 0 ? `${fixed(wind_speed_mps, 1, 'm/s')} from ${heading(wind_from_deg)}` : 'Calm');

function cellName(entry) {
  const outcome = entry.verdict === 'rejected' ? `rejected, ${words(entry.reject_reason ?? 'reason unknown')}`
    : `${entry.verdict}, final ${heading(entry.heading_deg)}`;
  return `${windName(entry)}: ${outcome}`;
}

// Solid, striped, crossed: the verdicts differ without colour too.
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

const markLegend = () => el('span', { class: 'swatch' },
  svg('svg', { width: 20, height: 20, class: 'rose-now', 'aria-hidden': 'true' }, svg('circle', { cx: 10, cy: 10, r: 7 })),
  'selected wind');

function labels() {
  const compass = ['N', 'E', 'S', 'W'].map((name, i) => {
    const [x, y] = pointAt(kRim + 12, 90 * i).split(' ');
    return svg('text', { x, y, class: 'rose-label' }, name);
  });
  // 45° lies between two columns of cells.
  const speeds = kSpeeds_mps.slice(1).map((speed_mps) => {
    const [x, y] = pointAt(radiusOf(speed_mps), 45).split(' ');
    return svg('text', { x, y, class: 'rose-label rose-speed' }, speed_mps === kSpeeds_mps.at(-1) ? `${speed_mps} m/s` : speed_mps);
  });
  return svg('g', { 'aria-hidden': 'true' }, [...compass, ...speeds]);
}

// The drawn cells of one rose. choose(speed_mps, from_deg) is called with the wind of a selected cell.
class Cells {
  #numDirections;
  #cells;
  #choose;

  constructor(rose, choose) {
    this.#choose = choose;
    this.#numDirections = rose.directions_deg.length;
    this.#cells = windsOf(rose).map((entry) => this.#make(entry, rose));
    this.makeStop(this.#cells[0]);
  }

  nodes() { return this.#cells.map(({ node }) => node); }

  nearest({ speed_mps, from_deg }) {
    const ring = kSpeeds_mps.reduce((best, each, i) =>
      (Math.abs(each - speed_mps) < Math.abs(kSpeeds_mps[best] - speed_mps) ? i : best), 0);
    return this.#at(ring, Math.round(from_deg * this.#numDirections / 360));
  }

  // The only cell that the Tab key reaches; arrow keys reach the others.
  makeStop(cell) {
    for (const each of this.#cells) each.node.setAttribute('tabindex', each === cell ? '0' : '-1');
  }

  #make(entry, rose) {
    const ring = kSpeeds_mps.indexOf(entry.wind_speed_mps);
    const direction = ring === 0 ? 0 : rose.directions_deg.indexOf(entry.wind_from_deg);
    const name = cellName(entry);
    const node = svg('path', { d: cellPath(ring, entry.wind_from_deg, 360 / this.#numDirections),
      class: `rose-cell ${entry.verdict}`, ...paint(entry.verdict), role: 'button', tabindex: '-1', 'aria-label': name },
      svg('title', {}, name));
    const cell = { entry, ring, direction, node };
    node.addEventListener('click', () => { this.makeStop(cell); this.#take(cell); });
    node.addEventListener('keydown', (event) => this.#press(event, cell));
    return cell;
  }

  #at(ring, direction) {
    const wrapped = (direction + this.#numDirections) % this.#numDirections;
    return this.#cells.find((cell) => cell.ring === ring && (ring === 0 || cell.direction === wrapped));
  }

  #take({ entry }) { this.#choose(entry.wind_speed_mps, entry.wind_from_deg); }

  #press(event, cell) {
    const move = { ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowUp: [1, 0], ArrowDown: [-1, 0] }[event.key];
    if (['Enter', ' '].includes(event.key)) this.#take(cell);
    else if (move) {
      const next = this.#at(Math.min(Math.max(cell.ring + move[0], 0), kSpeeds_mps.length - 1), cell.direction + move[1]);
      this.makeStop(next);
      next.node.focus();
    } else return;
    event.preventDefault();
  }
}

class WindRose {
  #choose;
  #box = byId('wind-rose');
  #text = byId('wind-rose-text');
  #loading = new AbortController();
  #cells = null;
  #now = null;

  constructor(choose) {
    this.#choose = choose;
    byId('wind-rose-legend').replaceChildren(...kVerdicts.map(legendItem), markLegend());
  }

  // The rose of a site; null clears it.
  async show(siteId) {
    this.#loading.abort();
    this.#loading = new AbortController();
    const { signal } = this.#loading;
    this.#clear(siteId ? 'Planning for all winds …' : '');
    if (!siteId) return;
    byId('wind-rose-curl').replaceChildren(curlButton('the wind rose', () => curlOf(api.paths.windRose(siteId, kSpeeds_mps))));
    try {
      const rose = await api.getWindRose(siteId, kSpeeds_mps, signal);
      byId('wind-rose-legend').hidden = false;
      this.#draw(rose);
    } catch (error) {
      if (error.name !== 'AbortError') this.#clear(`No wind rose: ${error.message}`);
    }
  }

  // The selected wind, null if unknown.
  mark(wind) {
    this.#now = wind;
    this.#drawMark();
  }

  #clear(message) {
    this.#cells = null;
    this.#box.replaceChildren();
    byId('wind-rose-legend').hidden = true;
    this.#text.textContent = message;
  }

  #draw(rose) {
    const size = kRim + 22;
    this.#cells = new Cells(rose, this.#choose);
    this.#box.replaceChildren(svg('svg', { viewBox: `${-size} ${-size} ${2 * size} ${2 * size}`, role: 'group',
      'aria-labelledby': 'wind-rose-title', 'aria-describedby': 'wind-rose-text wind-rose-help' },
    patterns(), ...this.#cells.nodes(), labels()));
    this.#text.textContent = roseText(rose);
    this.#drawMark();
  }

  #drawMark() {
    this.#box.querySelector('.rose-now')?.remove();
    this.#box.querySelector('[aria-current]')?.removeAttribute('aria-current');
    if (!this.#cells || !this.#now) return;
    const isBeyond = this.#now.speed_mps > kSpeeds_mps.at(-1);
    const [cx, cy] = pointAt(radiusOf(this.#now.speed_mps), this.#now.from_deg).split(' ');
    this.#box.firstElementChild.append(svg('g', { class: `rose-now${isBeyond ? ' beyond' : ''}`, 'aria-hidden': 'true' },
      svg('circle', { cx, cy, r: 7, class: 'rose-halo' }), svg('circle', { cx, cy, r: 7 })));
    const cell = this.#cells.nearest(this.#now);
    if (!isBeyond) cell.node.setAttribute('aria-current', 'true');
    if (!this.#box.contains(document.activeElement)) this.#cells.makeStop(cell);
  }
}

// choose(speed_mps, from_deg) is called with the wind of a selected cell.
export const createWindRose = (choose) => new WindRose(choose);
