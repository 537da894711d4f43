// What the operator must know, above all damage of the databases: below the header until it is acknowledged.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el, notify } from './dom.js';

const kPeriod_ms = 30000;
let drawn = '';

async function acknowledge(id) {
  try {
    await api.acknowledgeNotice(id);
  } catch (error) {
    notify(`The notice is not acknowledged: ${error.message}`);
  }
  await look();
}

function noticeBox({ id, text, raised_at }) {
  return el('article', { class: 'strip-notice', 'data-notice': id },
    el('b', { class: 'strip-sign', 'aria-hidden': 'true' }, '!'),
    el('p', {}, el('strong', {}, `Storage, ${new Date(raised_at).toLocaleString()}:`), ` ${text}.`),
    el('div', { class: 'strip-buttons' },
      el('button', { type: 'button', onclick: () => acknowledge(id) }, 'Acknowledge'),
      curlButton('the notices', () => curlOf(api.paths.notices))));
}

async function look() {
  // Without a token, or without the server, another part of the page says so.
  const notices = await api.listNotices().catch(() => null);
  if (!notices) return;
  const open = notices.filter(({ acknowledged_at }) => !acknowledged_at);
  const now = JSON.stringify(open);
  if (now === drawn) return;
  drawn = now;
  byId('notices').replaceChildren(...open.map(noticeBox));
}

look();
setInterval(look, kPeriod_ms);
