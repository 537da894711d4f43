// Asks for the token of a server that wants one.

import { setToken, token } from './api.js';
import { byId } from './dom.js';

let then = () => {};

// next() is called when there is a token to try.
export function askToken(next) {
  then = next;
  const dialog = byId('token-dialog');
  if (dialog.open) return;
  byId('token-refused').hidden = !token();
  dialog.showModal();
}

byId('token-form').addEventListener('submit', () => {
  setToken(byId('token-value').value.trim(), byId('token-keep').checked);
  byId('token-value').value = '';
  then();
});
