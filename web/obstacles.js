// The obstacles of the part of the map in view: loads them, lists them, deletes them.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el, notify } from './dom.js';
import { createObstacleForm } from './obstacle_form.js';
import { nameOf, signOf } from './obstacle_overlay.js';
import { extentOf, kinds } from './obstacle_shape.js';
import { offers } from './offers.js';
import { isVisible, showView } from './views.js';

const kRefresh_ms = 5000;
// A larger box would hold obstacles of half a continent.
const kWidest_deg = 5;

const isWithin = (inner, outer) => inner.west >= outer.west && inner.east <= outer.east &&
  inner.south >= outer.south && inner.north <= outer.north;

// Half a screen more on each side, so that a small move needs no request.
function widened({ west, south, east, north }) {
  const [x, y] = [(east - west) / 2, (north - south) / 2];
  return { west: Math.max(-180, west - x), south: Math.max(-90, south - y), east: Math.min(180, east + x), north: Math.min(90, north + y) };
}

const textOf = ({ west, south, east, north }) => [west, south, east, north].map((side) => side.toFixed(6)).join(',');
const isExpired = ({ properties: p }) => p.expires_at !== undefined && p.expires_at !== null && Date.parse(p.expires_at) <= Date.now();

// Asks for a yes. Resolves to whether the user gave it.
function confirmed(question, yes) {
  const dialog = byId('confirm');
  byId('confirm-text').textContent = question;
  byId('confirm-yes').textContent = yes;
  dialog.returnValue = '';
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.addEventListener('close', () => resolve(dialog.returnValue === 'yes'), { once: true });
  });
}

class Obstacles {
  #map;
  #on;
  #form;
  #features = [];
  #chosenId = null;
  #loaded = { box: null, at_ms: -Infinity };
  #isLoading = false;
  #isDrawn = false;

  constructor(map, on) {
    this.#map = map;
    this.#on = on;
    this.#form = createObstacleForm(map, { changed: () => this.#draw(), saved: (id) => { this.#chosenId = id; this.#reload(); } });
    byId('obstacle-kinds').append(...Object.entries(kinds).map(([kind, { name }]) => el('button',
      { type: 'button', class: 'wide', 'data-kind': kind, onclick: () => this.#form.start(kind) }, signOf(kind), ` ${name}`)));
    byId('obstacles-curl').append(curlButton('the obstacles in view', () => curlOf(api.paths.obstacles(textOf(map.box())))));
    byId('open-obstacles').addEventListener('click', () => { showView('obstacles'); byId('obstacles-title').focus(); });
    map.onMove(() => this.look());
    // A hidden form must not keep taking clicks on the map.
    addEventListener('freelsd-view', ({ detail }) => { if (detail !== 'obstacles' && this.#form.draft) this.#form.close(); });
  }

  get features() { return this.#features; }

  // Returns whether the place became a point of the obstacle that is being drawn.
  takePlace(latlng) {
    if (!this.#form.draft) return false;
    this.#form.addPoint(latlng);
    return true;
  }

  // Returns whether a form was open.
  cancel() {
    if (!this.#form.draft) return false;
    this.#form.close();
    return true;
  }

  // Shows one obstacle in the panel.
  show(id) {
    this.#chosenId = id;
    showView('obstacles');
    this.#draw();
    byId('obstacles').querySelector(`[data-obstacle="${CSS.escape(id)}"] button`)?.focus();
  }

  find(id) { return this.#features.find(({ properties }) => properties.id === id); }

  // Loads again if the map shows a part that is not loaded, or if the list is old.
  async look() {
    const box = this.#map.box();
    const isOld = performance.now() - this.#loaded.at_ms > kRefresh_ms;
    if (this.#isLoading || (!isOld && this.#loaded.box && isWithin(box, this.#loaded.box))) return;
    this.#isLoading = true;
    try {
      await this.#load(box);
    } catch (error) {
      // Obstacles that were loaded stay: an old one is better than none.
      if (error.status === 404) byId('open-obstacles').hidden = true;
    } finally {
      this.#isLoading = false;
    }
  }

  async #load(box) {
    if (!(await offers()).obstacles) return;
    byId('open-obstacles').hidden = false;
    const wide = widened(box);
    const isTooWide = wide.east - wide.west > kWidest_deg;
    const { features } = isTooWide ? { features: [] } : await api.getObstacles(textOf(wide));
    for (const feature of features) feature.properties.id ??= feature.id;
    const shown = features.filter((feature) => !isExpired(feature));
    this.#loaded = { box: wide, at_ms: performance.now() };
    if (this.#isDrawn && JSON.stringify(shown) === JSON.stringify(this.#features)) return;
    this.#isDrawn = true;
    this.#features = shown;
    this.#draw();
  }

  #reload() {
    this.#loaded.at_ms = -Infinity;
    this.look();
    this.#on.changed();
  }

  #draw() {
    const isDrawing = Boolean(this.#form.draft);
    byId('obstacle-form').hidden = !isDrawing;
    byId('obstacle-list').hidden = isDrawing;
    byId('num-obstacles').textContent = this.#features.length;
    byId('no-obstacles').hidden = this.#features.length > 0;
    byId('obstacles').replaceChildren(...this.#features.map((feature) => this.#row(feature)));
    this.#on.draw(this.#features, { chosenId: isVisible('obstacles') ? this.#chosenId : null, editedId: this.#form.draft?.id ?? null });
  }

  #row(feature) {
    const { id, kind, name } = feature.properties;
    const what = `${kinds[kind]?.name ?? kind}${name ? ` ${name}` : ''}`;
    return el('li', { class: 'obstacle-row', 'data-obstacle': id },
      el('button', { type: 'button', class: 'quiet obstacle-name', 'aria-current': id === this.#chosenId ? 'true' : null,
        onclick: () => { this.#chosenId = id; this.#map.panToFeature(feature); this.#draw(); } },
      kinds[kind] ? signOf(kind) : null,
      el('span', { class: 'site-text' }, el('strong', {}, kinds[kind] ? nameOf(feature) : kind),
        el('small', {}, `${kinds[kind]?.name ?? kind}, ${extentOf(feature)}`))),
      el('button', { type: 'button', 'aria-label': `Edit ${what}`, onclick: () => this.#form.edit(feature) }, 'Edit'),
      el('button', { type: 'button', 'aria-label': `Delete ${what}`, onclick: () => this.#delete(id, what) }, 'Delete'));
  }

  async #delete(id, what) {
    if (!await confirmed(`Delete ${what}? Approaches may then cross this place.`, 'Delete')) return;
    try {
      await api.deleteObstacle(id);
      this.#features = this.#features.filter(({ properties }) => properties.id !== id);
      notify(`${what} deleted`);
    } catch (error) {
      notify(`Not deleted: ${error.message}`);
    }
    this.#draw();
    this.#reload();
    byId('obstacles-title').focus();
  }
}

// map: {box(), onMove(f), panToFeature(feature), drawDraft, centerPoint}
// on: {draw(features, {chosenId, editedId}), changed(): an obstacle was saved or deleted}
export const createObstacles = (map, on) => new Obstacles(map, on);
