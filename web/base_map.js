// The user's own base map below the photograph, if the server has one. It can be switched off.

import { getBaseMap } from './api.js';
import { byId } from './dom.js';
import { offers } from './offers.js';

const key = 'freelsd.base-map';

// A server without a base map is asked once, and the switch stays hidden.
export async function showBaseMap(ground) {
  if (!(await offers()).baseMap) return;
  const layer = await getBaseMap();
  if (!layer) return;
  const toggle = byId('show-base');
  const draw = () => ground.draw('base', toggle.checked ? { name: 'base map', ...layer } : null);
  toggle.checked = localStorage.getItem(key) !== 'off';
  toggle.addEventListener('change', () => {
    localStorage.setItem(key, toggle.checked ? 'on' : 'off');
    draw();
  });
  toggle.closest('label').hidden = false;
  dispatchEvent(new Event('freelsd-layers'));
  draw();
}
