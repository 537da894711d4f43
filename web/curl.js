// Copies texts. "Copy as curl": the request behind a panel as a command, which never contains the token.

import { token } from './api.js';
import { byId, el, notify } from './dom.js';

export const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;

export function curlOf(path, extra = '') {
  const header = token() ? ' -H "Authorization: Bearer $FREELSD_TOKEN"' : '';
  return `curl -sS${header}${extra ? ` ${extra}` : ''} ${quoted(location.origin + path)}`;
}

export async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    notify('Copied');
  } catch {
    // Browsers offer no clipboard without HTTPS: the dialog shows the command selected.
    byId('copy-text').value = text;
    byId('copy-dialog').showModal();
    byId('copy-text').select();
  }
}

// what: for the accessible name, such as "the list of sites". command(): returns the command at the time of the click.
export function curlButton(what, command) {
  return el('button', {
    type: 'button',
    class: 'quiet curl',
    title: `Copy the curl command for ${what}`,
    'aria-label': `Copy the curl command for ${what}`,
    onclick: () => copy(command()),
  }, 'curl');
}
