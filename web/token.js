// The dialog that asks the user for an access token.

import { setToken, token } from './api.js';
import { byId } from './dom.js';

let then = () => {};

// Calls next() after the user has entered a token.
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
