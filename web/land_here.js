// "Land here": shows what the aircraft will fly in its present wind, and sends the command once the user has confirmed it.

import * as api from './api.js';
import { byId, el, notify } from './dom.js';
import { landingRows, landingWarnings, landingWind, linkName, refusalText } from './link_shape.js';
import { siteWithPlan } from './plan.js';
import { groundAge_s, verdictSign } from './units.js';

class LandHere {
  #on;
  #links = [];
  #site = null; // the stored feature
  #plan = null; // {p: its properties with the plan that will be flown, collection, wind}, {refusal}, or null while it is asked for
  #dialog = byId('land');

  constructor(on) {
    this.#on = on;
    byId('site-land').addEventListener('click', () => this.#open());
    byId('land-link').addEventListener('change', () => this.#ask());
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
    const site = this.#on.site();
    byId('site-land').hidden = this.#links.length === 0 || !site?.properties.approach || site.properties.verdict === 'rejected';
  }

  #link() { return this.#links.find(({ id }) => id === byId('land-link').value); }

  #open() {
    this.#site = this.#on.site();
    if (!this.#site) return notify('The site is not loaded yet.');
    byId('land-message').textContent = '';
    byId('land-link').replaceChildren();
    this.#drawLinks();
    this.#dialog.showModal();
    byId('land-cancel').focus();
    return this.#ask();
  }

  // The plan for the wind of the chosen aircraft, which does not change while the user reads it.
  async #ask() {
    const [site, link] = [this.#site, this.#link()];
    const wind = link ? landingWind(link) : null;
    this.#plan = null;
    byId('land-checked').checked = false;
    this.#draw();
    let plan;
    try {
      const answer = await api.getApproach(site.properties.id, wind);
      const { properties: p } = wind ? siteWithPlan(site, answer, wind) : site;
      plan = { ...answer, p, wind };
    } catch (error) {
      plan = { refusal: error.message };
    }
    if (site !== this.#site || link?.id !== this.#link()?.id) return;
    this.#plan = plan;
    this.#draw();
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
    const plan = this.#plan;
    const verdict = !plan ? null : plan.refusal ? 'rejected' : plan.p.verdict;
    byId('land-title').textContent = `Land at ${this.#on.nameOf(this.#site.properties.id)}?`;
    byId('land-verdict').className = verdict ? `outcome ${verdict}` : 'faint';
    byId('land-verdict').textContent = verdict ? `${verdictSign[verdict]} ${plan.refusal ?? verdict}` : 'Planning for the present wind …';
    byId('land-rows').replaceChildren(...(plan?.collection ? landingRows(plan.p, plan.collection) : []).map(([name, value]) =>
      el('tr', {}, el('th', { scope: 'row' }, name), el('td', {}, value))));
    byId('land-warnings').replaceChildren(...this.#warnings().map((text) => el('li', {}, text)));
    byId('land-checked-row').hidden = verdict !== 'unverified';
    this.#allow();
  }

  #warnings() {
    const link = this.#link();
    if (!link) return ['This aircraft is not heard any more.'];
    return this.#plan?.collection ? landingWarnings(this.#plan.p, link, groundAge_s(this.#site.properties)) : [];
  }

  #allow() {
    const plan = this.#plan;
    const isUsable = plan?.collection && (plan.p.verdict === 'landable' || (plan.p.verdict === 'unverified' && byId('land-checked').checked));
    byId('land-yes').disabled = !this.#link() || !isUsable;
  }

  async #send() {
    const { p, wind } = this.#plan;
    byId('land-yes').disabled = true;
    byId('land-message').textContent = 'Sending …';
    try {
      await api.landAt(byId('land-link').value, p.id, wind);
      this.#dialog.close();
      this.#on.sent();
    } catch (error) {
      byId('land-message').textContent = refusalText(error);
      this.#allow();
    }
  }
}

// on: {site(): the stored feature that is selected, nameOf(site id), sent()}
export const createLandHere = (on) => new LandHere(on);
