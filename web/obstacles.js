// The obstacles of the part of the map in view: lists them, draws new ones, deletes them.

import * as api from './api.js';
import { confirmed } from './confirm.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el, notify } from './dom.js';
import { createObstacleForm } from './obstacle_form.js';
import { nameOf, signOf } from './obstacle_overlay.js';
import { extentOf, kinds } from './obstacle_shape.js';
import { boxText, createObstacleSource } from './obstacle_source.js';
import { isVisible, showView } from './views.js';

class Obstacles {
  #map;
  #on;
  #form;
  #source = createObstacleSource(() => this.#draw());
  #chosenId = null;

  constructor(map, on) {
    this.#map = map;
    this.#on = on;
    this.#form = createObstacleForm(map, { changed: () => this.#draw(), saved: (id) => { this.#chosenId = id; this.#reload(); } });
    byId('obstacle-kinds').append(...Object.entries(kinds).map(([kind, { name }]) => el('button',
      { type: 'button', class: 'wide', 'data-kind': kind, onclick: () => this.#form.start(kind) }, signOf(kind), ` ${name}`)));
    byId('obstacles-curl').append(curlButton('the obstacles in view', () => curlOf(api.paths.obstacles(boxText(map.box())))));
    byId('open-obstacles').addEventListener('click', () => { showView('obstacles'); byId('obstacles-title').focus(); });
    map.onMove(() => this.look());
    // A hidden form must not keep taking clicks on the map.
    addEventListener('freelsd-view', ({ detail }) => { if (detail !== 'obstacles' && this.#form.draft) this.#form.close(); });
  }

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

  find(id) { return this.#source.features.find(({ properties }) => properties.id === id); }

  look() { this.#source.look(this.#map.box()); }

  #reload() {
    this.#source.forget();
    this.look();
    this.#on.changed();
  }

  #draw() {
    const isDrawing = Boolean(this.#form.draft);
    byId('obstacle-form').hidden = !isDrawing;
    byId('obstacle-list').hidden = isDrawing;
    const { features, note, isOffered } = this.#source;
    byId('open-obstacles').hidden = !isOffered;
    byId('num-obstacles').textContent = features.length;
    byId('no-obstacles').hidden = features.length > 0;
    byId('no-obstacles').textContent = note || 'No obstacles in this part of the map.';
    byId('obstacles').replaceChildren(...features.map((feature) => this.#row(feature)));
    this.#on.draw(features, { note, chosenId: isVisible('obstacles') ? this.#chosenId : null, editedId: this.#form.draft?.id ?? null });
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
      this.#source.features = this.#source.features.filter(({ properties }) => properties.id !== id);
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
// on: {draw(features, {chosenId, editedId, note}), changed(): an obstacle was saved or deleted}
export const createObstacles = (map, on) => new Obstacles(map, on);
