// What the panel tells about the legs to fly next: their gain, how they are flown, and the sites they may turn landable.

import { byId, el } from './dom.js';
import { cameraText, countText, flown_m, gainText, legText, placesOf, transitText } from './next_look_shape.js';
import { distance, verdictSign } from './units.js';

const capital = (text) => text[0].toUpperCase() + text.slice(1);

function outcome(look) {
  const { features, expected_gain, landing_value } = look;
  if (features.length === 0) {
    return el('div', { class: 'outcome' }, el('strong', {}, 'No leg to suggest'),
      el('span', {}, 'No straight leg over this map, or up to 100 m beyond its edge, is expected to make another place landable.'));
  }
  return el('div', { class: 'outcome' },
    el('strong', {}, `Expected gain ${gainText(expected_gain)} with ${countText(features.length, 'leg')}`),
    el('span', {}, `To fly: ${distance(flown_m(look))}, with turns. Landing value now:\u00a0${landing_value.toFixed(1)}.`),
    el('small', {}, 'A gain is a forecast, most often too high: compare legs by it.'));
}

function siteRow(place, rank, on) {
  const name = on.nameOf(place.site_id);
  return el('li', {}, el('button', { type: 'button', class: `next-site verdict-${place.verdict}`, 'data-key': `${rank} ${place.site_id}`,
    title: 'Open this site', onclick: () => on.openSite(place.site_id) },
  el('span', {}, `${verdictSign[place.verdict] ?? '?'} ${capital(name)}, ${place.verdict}`), el('strong', {}, gainText(place.expected_gain)), el('b', { 'aria-hidden': 'true' }, '›')));
}

// Ground without a site has no name: the place that promises most is shown on the map.
function othersRow(others, rank, hasSites, on) {
  const text = `${countText(others.length, `${hasSites ? 'more ' : ''}place`)} without a site yet`;
  return el('li', {}, el('button', { type: 'button', class: 'next-site', 'data-key': `${rank} others`, title: 'Show the best of them on the map', onclick: () => on.showPlace(others[0]) },
    el('span', {}, text), el('strong', {}, gainText(others.reduce((sum, { expected_gain }) => sum + expected_gain, 0))), el('b', { 'aria-hidden': 'true' }, '◎')));
}

function legRow(leg, index, { look, chosen, on }) {
  const { rank, expected_gain } = leg.properties;
  const { sites, others } = placesOf(leg);
  const isChosen = index === chosen;
  return el('li', { class: 'next-leg-row', 'data-leg': rank },
    el('button', { type: 'button', class: 'quiet next-leg-name', 'data-key': `leg ${rank}`, 'aria-pressed': String(isChosen), title: 'Show on the map',
      onclick: () => on.chooseLeg(isChosen ? null : index) },
    el('span', { class: 'next-leg-text' }, el('strong', {}, `Leg ${rank}`), el('span', {}, capital(legText(leg, look))), el('small', {}, capital(transitText(leg)))),
    el('span', { class: 'next-gain' }, el('strong', {}, gainText(expected_gain)), el('small', {}, 'gain'))),
    el('ul', { class: 'plain', 'aria-label': `What leg ${rank} may turn landable` }, sites.map((place) => siteRow(place, rank, on)),
      others.length > 0 ? othersRow(others, rank, sites.length > 0, on) : null));
}

// state: {look: the answer, chosen: index of a leg or null, on: {nameOf(site id), openSite(site id), showPlace(place),
// chooseLeg(index or null)}}
export function drawNextLookAnswer(state) {
  const focused = document.activeElement?.dataset?.key;
  const { look } = state;
  byId('next-look-answer').hidden = !look;
  if (!look) return;
  byId('next-look-outcome').replaceChildren(outcome(look));
  byId('next-look-list').replaceChildren(...look.features.map((leg, i) => legRow(leg, i, state)));
  if (focused) byId('next-look-list').querySelector(`[data-key="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
  byId('next-look-more').hidden = look.features.length === 0;
  byId('next-look-camera').textContent = look.features.length ? cameraText(look) : '';
}
