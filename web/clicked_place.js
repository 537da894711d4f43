// A clicked place: why the planner would, or would not, touch down there, its coordinates, and the best landing near it.

import * as api from './api.js';
import { copy, curlButton, curlOf } from './curl.js';
import { placeText } from './cursor.js';
import { el, notify } from './dom.js';
import { drawLanding, landingPath } from './landing.js';
import { offers } from './offers.js';
import { findRegion } from './places.js';
import { showView } from './views.js';
import { whyNot } from './why.js';

const wide = (text, onclick) => el('button', { type: 'button', class: 'wide', onclick }, text);

class ClickedPlace {
  #map; #shown; #openRegion;
  #asking = new AbortController();

  constructor(map, shown, openRegion) {
    this.#map = map;
    this.#shown = shown;
    this.#openRegion = openRegion;
    // The landing belongs to its view.
    addEventListener('freelsd-view', ({ detail }) => {
      if (detail !== 'landing') this.#map.drawLanding(null);
    });
  }

  #ask() {
    this.#asking.abort();
    this.#asking = new AbortController();
    return this.#asking.signal;
  }

  async check(latlng) {
    const signal = this.#ask();
    const { flight, site, regions, plan } = this.#shown();
    try {
      const can = await offers();
      const answer = await whyNot(latlng, { flight: can.flightWhy ? flight : null, site }, plan, signal);
      if (signal.aborted) return;
      const region = findRegion(regions, latlng);
      const buttons = [
        flight && can.landing ? wide('Plan a landing here', ({ currentTarget }) => this.#land(latlng, currentTarget)) : null,
        region ? wide(`Region ${region.properties.id}: grade ${region.properties.grade.toFixed(2)}`, () => this.#openRegion(region)) : null,
      ].filter(Boolean);
      // Above what is long: a popup on a phone shows its beginning.
      const below = answer.querySelector('.patch-row, .evidence');
      if (buttons.length) answer.insertBefore(el('div', { class: 'row' }, buttons), below);
      if (!answer.querySelector('.card-foot')) answer.append(el('div', { class: 'card-foot' }));
      answer.querySelector('.card-foot').prepend(el('button', { type: 'button', class: 'quiet place', onclick: () => copy(placeText(latlng)),
        'aria-label': `Copy the coordinates ${placeText(latlng)}`, title: 'Copy the coordinates' }, placeText(latlng)));
      this.#map.drawAnswer(latlng, answer);
    } catch (error) {
      if (error.name !== 'AbortError') notify(`Place not checked: ${error.message}`);
    }
  }

  async #land(latlng, button) {
    const signal = this.#ask();
    const { flight, plan, aircraft: own } = this.#shown();
    const path = landingPath(flight, latlng, plan);
    button.setAttribute('aria-busy', 'true');
    button.textContent = 'Planning …';
    try {
      const answer = await api.getLanding(path, signal);
      if (signal.aborted) return;
      const aircraft = answer.collection?.plan?.aircraft ?? own;
      this.#map.drawAnswer(null);
      showView('landing');
      drawLanding(answer, latlng, aircraft, curlButton('this landing', () => curlOf(path)));
      this.#map.drawLanding(answer.collection ?? null, { touchdownRadius_m: aircraft?.touchdown_uncertainty_m, isReplanned: true });
    } catch (error) {
      if (error.name === 'AbortError') return;
      notify(`Landing not planned: ${error.message}`);
      button.removeAttribute('aria-busy');
      button.textContent = 'Plan a landing here';
    }
  }
}

// shown(): {flight: with a map, or null, site, regions, plan: {wind, aircraft}, aircraft}.
// openRegion(feature) shows the history of a region.
export const createClickedPlace = (map, shown, openRegion) => new ClickedPlace(map, shown, openRegion);
