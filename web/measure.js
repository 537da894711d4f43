// Measures on the map: distance and true bearing from point to point, and the distance of all.
/* global L */

import { el, svg } from './dom.js';
import { courseTo, heading } from './units.js';

const placeOf = ({ lat, lng }) => ({ latitude_deg: lat, longitude_deg: lng });
const legOf = (from, to) => courseTo(placeOf(from), placeOf(to));

// Below 10 m with decimetres, below 10 km in metres.
export const length = (value_m) => {
  if (value_m < 10) return `${value_m.toFixed(1)} m`;
  return value_m < 10000 ? `${Math.round(value_m)} m` : `${(value_m / 1000).toFixed(2)} km`;
};

const legText = ({ distance_m, bearing_deg }) => `${length(distance_m)} · ${heading(bearing_deg)}`;

// points: [{lat, lng}]. The line below the map's points, for the eye and for screen readers.
export function measureText(points) {
  if (points.length === 0) return 'Tap the first point. Keyboard: arrows and Enter.';
  if (points.length === 1) return 'Tap the next point.';
  const legs = points.slice(1).map((point, i) => legOf(points[i], point));
  const last = legs.at(-1);
  const total = legs.length > 1 ? `. Total ${length(legs.reduce((sum, { distance_m }) => sum + distance_m, 0))}` : '';
  return `${length(last.distance_m)}, bearing ${heading(last.bearing_deg)}${total}`;
}

const ruler = () => svg('svg', { viewBox: '0 0 24 24', width: 24, height: 24, 'aria-hidden': 'true' },
  svg('path', { d: 'M3 16L16 3L21 8L8 21Z M6.5 12.5L9 15M10 9L12 11M13.5 5.5L16 8', class: 'ruler' }));

class Measure {
  #map; #group; #points = null;  // null: off
  #button = el('button', { type: 'button', class: 'map-button', 'aria-pressed': 'false', 'aria-label': 'Measure distance and bearing',
    title: 'Measure distance and bearing (M)', onclick: () => this.toggle() }, ruler());
  #text = el('output', { 'aria-live': 'polite' });
  #box = el('div', { class: 'measure-box', hidden: true }, this.#text,
    el('button', { type: 'button', onclick: () => this.#back() }, 'Undo'),
    el('button', { type: 'button', onclick: () => this.end() }, 'End'));
  #band = L.polyline([], { className: 'measure-band', interactive: false });

  constructor(map) {
    this.#map = map;
    this.#group = L.featureGroup().addTo(map);
    const control = L.control({ position: 'topright' });
    control.onAdd = () => this.#button;
    control.addTo(map);
    for (const node of [this.#button, this.#box]) L.DomEvent.disableClickPropagation(node);
    map.getContainer().append(this.#box);
  }

  get isOn() { return this.#points !== null; }

  toggle() {
    if (!this.end()) {
      this.#points = [];
      this.#draw();
    }
  }

  // Returns whether a measurement was on.
  end() {
    const wasOn = this.isOn;
    this.#points = null;
    this.#draw();
    return wasOn;
  }

  // Returns whether the place became a point.
  take(latlng) {
    if (!this.isOn) return false;
    this.#points.push(latlng);
    this.#draw();
    return true;
  }

  // Returns whether it took the key.
  key({ key }, latlng) {
    if (key.toLowerCase() === 'm') this.toggle();
    else if (!this.isOn) return false;
    else if (key === 'Enter') this.take(latlng);
    else if (key === 'Backspace') this.#back();
    else return false;
    return true;
  }

  // The line to the cursor.
  follow(latlng) {
    this.#band.setLatLngs(this.#points?.length ? [this.#points.at(-1), latlng] : []);
  }

  #back() {
    this.#points?.pop();
    this.#draw();
  }

  #draw() {
    const points = this.#points ?? [];
    this.#group.clearLayers();
    this.#band.setLatLngs([]);
    this.#button.setAttribute('aria-pressed', String(this.isOn));
    this.#map.getContainer().classList.toggle('measuring', this.isOn);
    this.#box.hidden = !this.isOn;
    this.#text.textContent = this.isOn ? measureText(points) : '';
    if (!this.isOn) return;
    for (const className of ['measure-casing', 'measure-line']) this.#group.addLayer(L.polyline(points, { className, interactive: false }));
    this.#group.addLayer(this.#band);
    points.forEach((point, i) => this.#mark(point, i === 0 ? '' : legText(legOf(points[i - 1], point)), i === points.length - 1));
  }

  // The text stands towards the middle of the map.
  #mark(point, text, isLast) {
    const isRight = this.#map.latLngToContainerPoint(point).x > 0.6 * this.#map.getSize().x;
    const label = el('span', {}, el('i'), text ? el('b', {}, text) : null);
    const className = `measure-point${isLast ? ' last' : ''}${isRight ? ' on-right' : ''}`;
    this.#group.addLayer(L.marker(point, { icon: L.divIcon({ className, html: label, iconSize: [12, 12] }),
      interactive: false, keyboard: false, zIndexOffset: 1800 }));
  }
}

export const createMeasure = (map) => new Measure(map);
