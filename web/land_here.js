// "Land here": shows what the aircraft will fly, and sends the command once the user has confirmed it.

import * as api from './api.js';
import { byId, el, notify } from './dom.js';
import { landingRows, landingWarnings, linkName, refusalText } from './link_shape.js';
import { groundAge_s, verdictSign } from './units.js';

class LandHere {
  #on;
  #links = [];
  #site = null; // properties
  #approach = null; // the stored one: another wind's plan is not flown
  #dialog = byId('land');

  constructor(on) {
    this.#on = on;
    byId('site-land').addEventListener('click', () => this.#open());
    byId('land-link').addEventListener('change', () => this.#draw());
    byId('land-checked').addEventListener('change', () => this.#allow());
    byId('land-cancel').addEventListener('click', () => this.#dialog.close());
    byId('land-form').addEventListener('submit', (event) => { event.preventDefault(); this.#send(); });
  }

  // The links that hear their autopilot.
  takeLinks(links) {
    this.#links = links;
    this.draw();
    if (this.#dialog.open) this.#drawLinks();
  }

  // After another site was selected.
  draw() {
    const { site } = this.#on.shown();
    byId('site-land').hidden = this.#links.length === 0 || !site?.properties.approach || site.properties.verdict === 'rejected';
  }

  #link() { return this.#links.find(({ id }) => id === byId('land-link').value); }

  #open() {
    const { site, approach } = this.#on.shown();
    if (!site || !approach) return notify('The approach of this site is not loaded yet.');
    this.#site = site.properties;
    this.#approach = approach;
    byId('land-message').textContent = '';
    byId('land-checked').checked = false;
    byId('land-link').replaceChildren();
    this.#drawLinks();
    this.#dialog.showModal();
    return byId('land-cancel').focus();
  }

  // Keeps the chosen link: another aircraft must not take its place.
  #drawLinks() {
    const select = byId('land-link');
    const chosen = select.value;
    const ids = this.#links.map(({ id }) => id);
    const options = [...select.options].map(({ value }) => value);
    const shown = chosen && !ids.includes(chosen) ? [chosen, ...ids] : ids;
    if (JSON.stringify(shown) !== JSON.stringify(options)) {
      select.replaceChildren(...shown.map((id) => el('option', { value: id }, ids.includes(id) ? linkName(this.#links.find((link) => link.id === id)) : `${id} (silent)`)));
      if (chosen) select.value = chosen;
    }
    this.#draw();
  }

  #draw() {
    const p = this.#site;
    const link = this.#link();
    byId('land-title').textContent = `Land at ${this.#on.nameOf(p.id)}?`;
    byId('land-verdict').className = `outcome ${p.verdict}`;
    byId('land-verdict').textContent = `${verdictSign[p.verdict]} ${p.verdict}`;
    byId('land-rows').replaceChildren(...landingRows(p, this.#approach).map(([name, value]) =>
      el('tr', {}, el('th', { scope: 'row' }, name), el('td', {}, value))));
    const warnings = link ? landingWarnings(p, link, groundAge_s(p)) : ['This aircraft is not heard any more.'];
    byId('land-warnings').replaceChildren(...warnings.map((text) => el('li', {}, text)));
    byId('land-checked-row').hidden = p.verdict !== 'unverified';
    this.#allow();
  }

  #allow() {
    const isChecked = this.#site.verdict !== 'unverified' || byId('land-checked').checked;
    byId('land-yes').disabled = !this.#link() || !isChecked;
  }

  async #send() {
    byId('land-yes').disabled = true;
    byId('land-message').textContent = 'Sending …';
    try {
      await api.landAt(byId('land-link').value, this.#site.id);
      this.#dialog.close();
      this.#on.sent();
    } catch (error) {
      byId('land-message').textContent = refusalText(error);
      this.#allow();
    }
  }
}

// on: {shown(): {site: the stored feature, approach: its collection}, nameOf(site id), sent()}
export const createLandHere = (on) => new LandHere(on);
