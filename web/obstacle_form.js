// Draws or edits one obstacle: points on the map, values in a form, saved by PUT.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el, notify } from './dom.js';
import { signOf } from './obstacle_overlay.js';
import { draftOf, faultOf, featureOf, fieldOf, hasAltitudes, isCircle, kinds, newDraft } from './obstacle_shape.js';

const numeric = { type: 'number', step: 'any', inputmode: 'decimal' };
const datums = [['amsl', 'mean sea level (AMSL)'], ['ellipsoid', 'ellipsoid (GNSS)'], ['unknown', 'unknown']];
const hours = [['0.5', '30 min'], ['1', '1 h'], ['2', '2 h'], ['4', '4 h'], ['8', '8 h'], ['24', '24 h']];

const isTall = (draft) => draft.kind === 'wire' || draft.kind === 'mast';

// name: {label, attributes | options, isUsed(draft)}
const fields = {
  name: { label: 'Name', attributes: { maxlength: 128, autocomplete: 'off', placeholder: 'optional' }, isUsed: () => true },
  height_m: { label: 'Height above ground (m)', attributes: { ...numeric, min: 0 }, isUsed: (d) => isTall(d) && !hasAltitudes(d) },
  radius_m: { label: 'Radius (m)', attributes: { ...numeric, min: 0 }, isUsed: isCircle },
  floor_m: { label: 'Floor altitude (m)', attributes: { ...numeric, placeholder: 'ground' }, isUsed: (d) => d.kind === 'no_fly' },
  ceiling_m: { label: 'Ceiling altitude (m)', attributes: { ...numeric, placeholder: 'none' }, isUsed: (d) => d.kind === 'no_fly' },
  altitude_datum: { label: 'Altitude datum', options: () => datums, isUsed: (d) => d.kind === 'no_fly' || hasAltitudes(d) },
  expires_h: { label: 'Expires in', options: (d) => (d.values.expires_at
    ? [['kept', `as stored (${new Date(d.values.expires_at).toLocaleString()})`], ...hours] : hours), isUsed: (d) => d.kind === 'people' },
  position_sd_m: { label: 'Position uncertainty, 1 σ (m)', attributes: { ...numeric, min: 0, placeholder: 'unknown' }, isUsed: () => true },
};

function controlOf(name, draft) {
  const { attributes, options } = fields[name];
  const value = draft.values[name] ?? '';
  const id = `ob-${name}`;
  const keep = (event) => { draft.values[name] = event.target.value; };
  if (!options) return el('input', { id, ...attributes, value, oninput: keep });
  const select = el('select', { id, onchange: keep }, options(draft).map(([key, text]) => new Option(text, key)));
  select.value = value;
  draft.values[name] = select.value;
  return select;
}

class ObstacleForm {
  #on;
  #map;
  #form = byId('obstacle-form');
  #draft = null;
  #isSaving = false;

  constructor(map, on) {
    this.#map = map;
    this.#on = on;
    this.#form.addEventListener('submit', (event) => { event.preventDefault(); this.#save(); });
  }

  get draft() { return this.#draft; }

  start(kind) { this.#open(newDraft(kind)); }
  edit(feature) { this.#open(draftOf(feature)); }

  #open(draft) {
    this.#draft = draft;
    this.#on.changed();
    this.#draw();
    byId('obstacle-form-title').focus();
  }

  close() {
    this.#draft = null;
    this.#map.drawDraft(null);
    this.#on.changed();
  }

  addPoint({ lat, lng }) {
    const { points, kind } = this.#draft;
    const point = [lng, lat];
    if (kinds[kind].most === 1) points.splice(0, 1, point);
    else points.push(point);
    this.#drawPoints();
  }

  #setPoints(points) {
    this.#draft.points = points;
    this.#drawPoints();
  }

  #move(index, { lat, lng }) {
    // The altitude of a point moves along with it.
    this.#setPoints(this.#draft.points.map((point, i) => (i === index ? [lng, lat, ...point.slice(2)] : point)));
  }

  #draw() {
    const { kind, isNew } = this.#draft;
    const button = (text, onclick, id) => el('button', { type: 'button', class: 'wide', id, onclick }, text);
    this.#form.replaceChildren(
      el('h3', { id: 'obstacle-form-title', tabindex: -1 }, signOf(kind), `${isNew ? 'New' : 'Edit'}: ${kinds[kind].name.toLowerCase()}`),
      el('p', {}, kinds[kind].hint, el('span', { class: 'faint' }, ' By keyboard: move the map, then add its centre.')),
      el('p', { id: 'ob-points', role: 'status' }),
      el('p', { id: 'ob-points-fault', class: 'bad', role: 'alert', hidden: true }),
      el('div', { class: 'row' }, button('Add map centre', () => this.addPoint(this.#map.centerPoint()), 'ob-add'),
        button('Undo point', () => this.#setPoints(this.#draft.points.slice(0, -1)), 'ob-undo'),
        button('Clear points', () => this.#setPoints([]), 'ob-clear')),
      el('div', { id: 'ob-fields' }),
      el('p', { id: 'ob-message', class: 'bad', role: 'alert', hidden: true }),
      el('div', { class: 'row' }, el('button', { class: 'wide primary', id: 'ob-save' }, 'Save'),
        button('Cancel', () => this.close(), 'ob-cancel')),
      el('div', { class: 'card-foot' }, curlButton('saving this obstacle', () => curlOf(api.paths.obstacle(this.#draft.id),
        `-X PUT -H 'Content-Type: application/geo+json' -d '${JSON.stringify(featureOf(this.#draft, Date.now())).replaceAll("'", "'\\''")}'`))));
    this.#drawPoints();
  }

  // Points on the map; fields that depend on their number.
  #drawPoints() {
    const draft = this.#draft;
    const fault = faultOf(draft);
    const canShow = fault === null || fault.field === 'height_m';
    this.#map.drawDraft(draft.points, canShow ? featureOf(draft, Date.now()) : null, (i, at) => this.#move(i, at));
    byId('ob-points').textContent = isCircle(draft) ? 'Centre set. Enter the radius, or tap more corners.'
      : `${draft.points.length} ${draft.points.length === 1 ? 'point' : 'points'}${hasAltitudes(draft) ? ', with altitudes' : ''}`;
    for (const id of ['ob-undo', 'ob-clear']) byId(id).disabled = draft.points.length === 0;
    byId('ob-points-fault').hidden = true;
    const names = Object.keys(fields).filter((name) => fields[name].isUsed(draft));
    const shown = [...byId('ob-fields').children].map((field) => field.dataset.field);
    if (shown.join() === names.join()) return;
    byId('ob-fields').replaceChildren(...names.map((name) => el('div', { 'data-field': name },
      el('label', { class: 'field' }, fields[name].label, controlOf(name, draft)),
      el('p', { id: `ob-${name}-fault`, class: 'bad', role: 'alert', hidden: true }))));
    byId('ob-radius_m')?.addEventListener('input', () => this.#drawPoints());
  }

  #showFault(field, detail) {
    const line = byId(`ob-${field}-fault`) ?? byId('ob-message');
    const control = byId(`ob-${field}`);
    line.textContent = line === byId('ob-message') && field ? `${field}: ${detail}` : detail;
    line.hidden = false;
    if (!control?.matches('input, select')) return;
    control.setAttribute('aria-invalid', 'true');
    control.setAttribute('aria-describedby', line.id);
    control.focus();
  }

  #clearFaults() {
    for (const line of this.#form.querySelectorAll('.bad')) line.hidden = true;
    for (const control of this.#form.querySelectorAll('[aria-invalid]')) control.removeAttribute('aria-invalid');
  }

  async #save() {
    if (this.#isSaving) return;
    this.#clearFaults();
    const draft = this.#draft;
    const fault = faultOf(draft);
    if (fault) return this.#showFault(fault.field, fault.detail);
    this.#isSaving = true;
    this.#form.setAttribute('aria-busy', 'true');
    try {
      await api.putObstacle(draft.id, featureOf(draft, Date.now()));
      notify(`${kinds[draft.kind].name} saved`);
      if (this.#draft === draft) this.close();
      this.#on.saved(draft.id);
    } catch (error) {
      if (this.#draft === draft) this.#showProblem(error);
    } finally {
      this.#isSaving = false;
      this.#form.removeAttribute('aria-busy');
    }
  }

  // The last fault is shown first in the form: its field gets the focus.
  #showProblem(error) {
    const faults = error.errors ?? [];
    for (const { pointer, detail } of faults.toReversed()) this.#showFault(fieldOf(pointer), detail);
    if (faults.length === 0) this.#showFault(null, `Not saved: ${error.message}`);
  }
}

// map: {drawDraft(points or null, feature, onMove), centerPoint()}; on: {changed(), saved(id)}
export const createObstacleForm = (map, on) => new ObstacleForm(map, on);
