// What the operator must know of the stores, until somebody has acknowledged it: below the header, and above an emergency's sites.

import * as api from './api.js';
import { byId, el, notify } from './dom.js';
import { sentence } from './emergency_text.js';
import { offers } from './offers.js';

const kPeriod_ms = 30000;

class Notices {
  #open = [];
  #timer = 0;

  constructor() { this.look(); }

  async look() {
    clearTimeout(this.#timer);
    try {
      const notices = (await offers()).notices ? await api.getNotices() : [];
      this.#open = notices.filter(({ acknowledged_at }) => !acknowledged_at);
      this.#draw();
    } catch {
      // The page says elsewhere that the server cannot be reached.
    }
    this.#timer = setTimeout(() => this.look(), kPeriod_ms);
  }

  // An answer's warnings repeat the notices, which stand above.
  without(warnings) { return warnings.filter((warning) => !this.#open.some(({ text }) => text === warning)); }

  #draw() {
    byId('notices').replaceChildren(...this.#open.map((notice) => el('div', { class: 'store-notice' },
      el('p', {}, `! ${sentence(notice.text)}`),
      el('button', { type: 'button', onclick: () => this.#acknowledge(notice.id) }, 'Acknowledge'))));
    byId('em-notices').replaceChildren(...this.#open.map(({ text }) => el('p', {}, `! ${sentence(text)}`)));
  }

  async #acknowledge(id) {
    await api.acknowledgeNotice(id).catch((error) => notify(`Not acknowledged: ${error.message}`));
    await this.look();
  }
}

export const createNotices = () => new Notices();
