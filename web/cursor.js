// The place under the cursor: its coordinates in a corner of the map, and the keys of the map. While the user moves the
// map by keyboard, the place is the centre, under a crosshair.
/* global L */

import { copy } from './curl.js';
import { el } from './dom.js';

// WGS84, decimal degrees. Six digits are 0.1 m.
export const placeText = ({ lat, lng }) => `${lat.toFixed(6)}, ${(((lng + 540) % 360 + 360) % 360 - 180).toFixed(6)}`;

const isOnMap = ({ originalEvent }) => !originalEvent?.target.closest?.('.leaflet-control, .leaflet-popup');

// on: {place(latlng): Enter, moved(latlng), key(event): returns whether it took the key}
export function createCursor(map, on) {
  const element = map.getContainer();
  const text = el('span');
  const button = el('button', {
    type: 'button', class: 'place-button', title: 'WGS84 latitude, longitude. Click, or press C on the map, to copy.',
    onclick: () => copy(text.textContent),
  }, text);
  const control = L.control({ position: 'bottomright' });
  control.onAdd = () => button;
  control.addTo(map);
  L.DomEvent.disableClickPropagation(button);

  let pointed = null;  // under the pointer; null: the centre counts
  const place = () => pointed ?? map.getCenter();
  function show() {
    text.textContent = placeText(place());
    button.setAttribute('aria-label', `Copy the coordinates ${text.textContent}`);
    on.moved(place());
  }
  const point = (event) => {
    if (!isOnMap(event)) return;
    pointed = event.latlng;
    show();
  };
  map.on('mousemove click', point);
  map.on('move', () => {
    if (!pointed) show();
  });

  // Other keys belong to Leaflet: arrows pan, + and - zoom.
  element.addEventListener('keydown', (event) => {
    if (event.target !== element || event.ctrlKey || event.metaKey || event.altKey) return;
    const isPan = event.key.startsWith('Arrow');
    if (isPan || event.key === 'Enter') pointed = null;
    if (isPan) show();
    if (event.key.toLowerCase() === 'c') copy(placeText(place()));
    else if (on.key(event, place())) event.preventDefault();
    else if (event.key === 'Enter') on.place(place());
  });
  element.addEventListener('focus', () => {
    if (!element.matches(':focus-visible')) return;
    pointed = null;
    show();
  });
  show();
}
