// Which stored sites are worth new photographs first, as the server ranks them.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el } from './dom.js';
import { offers } from './offers.js';
import { age, groundAge_s, isKnown, verdictSign } from './units.js';
import { isVisible, showView } from './views.js';

const kShown = 20;
const kRefresh_ms = 15000;

const ageText = (p) => (isKnown(groundAge_s(p)) ? age(groundAge_s(p)) : '?');

function row(p, index, { open, flightName }) {
  return el('li', {}, el('button', { type: 'button', class: `site-row verdict-${p.verdict}`, 'data-new-look': p.id, onclick: () => open(p) },
    el('span', { class: 'rank look', 'aria-hidden': 'true' }, index + 1),
    el('span', { class: 'site-text' },
      el('strong', {}, `${verdictSign[p.verdict]} ${p.verdict}`),
      el('small', {}, p.new_look.sentence), flightName(p.flight_id) ? el('small', {}, flightName(p.flight_id)) : null),
    el('span', { class: 'look-age' }, el('strong', {}, ageText(p)), el('small', {}, 'old'))));
}

class NewLook {
  #on;
  #features = [];
  #at_ms = -Infinity;
  #isLoading = false;

  constructor(on) {
    this.#on = on;
    byId('new-look-curl').append(curlButton('the sites worth a new look', () => curlOf(api.paths.newLook(kShown))));
    byId('open-new-look').addEventListener('click', () => {
      showView('new-look');
      byId('new-look-title').focus();
      this.#on.fit(this.#features);
    });
    addEventListener('freelsd-view', () => this.#mark());
  }

  async look() {
    if (this.#isLoading || performance.now() - this.#at_ms < kRefresh_ms) return;
    this.#isLoading = true;
    this.#at_ms = performance.now();
    try {
      if (!(await offers()).newLook) return;
      const { features } = await api.getNewLook(kShown);
      this.#features = features.filter(({ properties, geometry }) => properties.new_look && geometry);
      byId('open-new-look').hidden = false;
      this.#draw();
    } catch (error) {
      // An older list stays: it only names sites.
      if (error.status === 404) byId('open-new-look').hidden = true;
    } finally {
      this.#isLoading = false;
    }
  }

  #draw() {
    const focused = document.activeElement?.dataset?.newLook;
    byId('num-new-look').textContent = this.#features.length;
    byId('no-new-look').hidden = this.#features.length > 0;
    byId('new-look').replaceChildren(...this.#features.map(({ properties }, i) => row(properties, i, this.#on)));
    if (focused) byId('new-look').querySelector(`[data-new-look="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
    this.#mark();
  }

  // Marks stand on the map while the list is visible.
  #mark() {
    const marks = isVisible('new-look') ? this.#features : [];
    this.#on.mark(marks.map(({ properties: p, geometry: { coordinates: [longitude_deg, latitude_deg] } }, i) => ({
      place: { latitude_deg, longitude_deg }, sign: `${i + 1}`, title: `Worth a new look: ${p.new_look.sentence}` })));
  }
}

// on: {open(properties), mark(marks), fit(features), flightName(id)}
export const createNewLook = (on) => new NewLook(on);
