// "Copy as curl": every panel shows how to get the same by hand. A token is never copied.

import { token } from './api.js';
import { byId, el, notify } from './dom.js';

const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;

export function curlOf(path, extra = '') {
  const header = token() ? ' -H "Authorization: Bearer $FREELSD_TOKEN"' : '';
  return `curl -sS${header}${extra ? ` ${extra}` : ''} ${quoted(location.origin + path)}`;
}

async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    notify('Copied');
  } catch {
    // Without https there is no clipboard: show it, selected.
    byId('copy-text').value = text;
    byId('copy-dialog').showModal();
    byId('copy-text').select();
  }
}

// what: for the ear, "the list of sites"; command(): the line, made when it is asked for.
export function curlButton(what, command) {
  return el('button', {
    type: 'button',
    class: 'quiet curl',
    title: `Copy the curl command for ${what}`,
    'aria-label': `Copy the curl command for ${what}`,
    onclick: () => copy(command()),
  }, 'curl');
}
