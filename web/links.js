// Links to autopilots: their state, their decisions, and the commands "Engine failed" and "Release".

import * as api from './api.js';
import { confirmed } from './confirm.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el, notify } from './dom.js';
import { createLandHere } from './land_here.js';
import { alarmsOf, commandText, heardText, linkName, linkRows, refusalText } from './link_shape.js';
import { offers } from './offers.js';
import { clockOf } from './units.js';
import { isVisible, showView } from './views.js';

const kPeriod_ms = 1000;
const kPeriodWithoutLinks_ms = 5000;

function table(rows) {
  return el('table', { class: 'numbers' }, el('tbody', {}, rows.map(([name, value, isAlarm]) =>
    el('tr', {}, el('th', { scope: 'row' }, name), el('td', { class: isAlarm ? 'bad' : null }, value)))));
}

const logItem = ({ at, kind, text }) => el('li', {}, el('time', { datetime: at }, clockOf(at)), ` ${text}`, el('small', {}, ` ${kind}`));

class Links {
  #map;
  #on;
  #links = [];
  #isLost = false;
  #drawn = '';
  #timer = 0;
  #landHere;

  constructor(map, on) {
    this.#map = map;
    this.#on = on;
    this.#landHere = createLandHere({ ...on, sent: () => { this.open(); this.#loop(); } });
    byId('links-curl').append(curlButton('the links', () => curlOf(api.paths.links)));
    byId('open-links').addEventListener('click', () => this.open());
    addEventListener('freelsd-view', () => this.#draw());
    this.#loop();
  }

  open() {
    showView('links');
    byId('links-title').focus();
    this.#draw();
  }

  // After another site was selected.
  drawSite() { this.#landHere.draw(); }

  async #loop() {
    clearTimeout(this.#timer);
    await this.#look();
    this.#timer = setTimeout(() => this.#loop(), this.#links.length ? kPeriod_ms : kPeriodWithoutLinks_ms);
  }

  async #look() {
    try {
      if (!(await offers()).links) return;
      this.#links = await api.getLinks();
      this.#isLost = false;
    } catch {
      // Old values would look like new ones.
      this.#isLost = true;
    }
    this.#draw();
  }

  #draw() {
    byId('open-links').hidden = this.#links.length === 0;
    byId('num-links').textContent = this.#links.length;
    this.#drawAlarms();
    this.#map.drawLinks(this.#links.map((link) => ({ ...link, isStale: this.#isLost || !link.is_connected })));
    if (isVisible('links')) this.#drawCards();
    this.#landHere.takeLinks(this.#isLost ? [] : this.#links.filter((link) => link.is_connected));
  }

  // Only a change is announced.
  #drawAlarms() {
    const texts = this.#links.flatMap(alarmsOf);
    const drawn = JSON.stringify(texts);
    if (drawn === this.#drawn) return;
    this.#drawn = drawn;
    byId('link-alarms').replaceChildren(...texts.map((text) => el('p', {}, `! ${text}`)));
  }

  #drawCards() {
    const focused = document.activeElement?.dataset?.command;
    byId('no-links').hidden = this.#links.length > 0;
    byId('links-lost').hidden = !this.#isLost;
    byId('links').replaceChildren(...this.#links.map((link) => this.#card(link)));
    if (focused) byId('links').querySelector(`[data-command="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
  }

  #card(link) {
    const { nameOf } = this.#on;
    const button = (name, className, call) => el('button', {
      type: 'button', class: `wide ${className}`, 'data-command': `${link.id} ${name}`, disabled: !link.is_connected, onclick: call,
    }, name);
    return el('li', { class: 'link-card', 'data-link': link.id },
      el('div', { class: 'head' }, el('h3', {}, linkName(link)),
        el('span', { class: `chip ${link.is_connected ? 'link-heard' : 'link-silent'}` }, heardText(link))),
      table(linkRows(link, nameOf)),
      el('div', { class: 'row' },
        link.position ? el('button', { type: 'button', class: 'wide', 'data-command': `${link.id} show`, onclick: () => this.#map.panTo(link.position) }, 'Show on the map') : null,
        button('Engine failed', 'danger', () => this.#declare(link)),
        button('Release', '', () => this.#release(link))),
      this.#list('Commands', [...(link.commands ?? [])].reverse().map((command) => el('li', {}, commandText(command, nameOf)))),
      this.#list('Decisions', [...(link.log ?? [])].reverse().map(logItem)));
  }

  #list(title, items) {
    return items.length === 0 ? null : el('div', {}, el('h4', {}, title), el('ul', { class: 'plain link-log', tabindex: 0, 'aria-label': title }, items));
  }

  async #command(send) {
    try {
      await send();
      notify('Sent. The link answers within a second.');
    } catch (error) {
      notify(refusalText(error));
    }
    this.#loop();
  }

  async #declare(link) {
    const question = `Engine failed on ${linkName(link)}? The link then guides this aircraft to the best site in reach and takes control from the mission.`;
    if (await confirmed(question, 'Engine failed')) await this.#command(() => api.declareEngineFailure(link.id));
  }

  async #release(link) {
    const question = `Release ${linkName(link)}? The link stops guiding it. The autopilot keeps its mode and its mission.`;
    if (await confirmed(question, 'Release')) await this.#command(() => api.releaseLink(link.id));
  }
}

// on: {nameOf(site id), site(): the stored feature that is selected}
export const createLinks = (map, on) => new Links(map, on);
