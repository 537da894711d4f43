// The user's own base map below the photograph, if the server has one. It can be switched off.

import { getBaseMap } from './api.js';
import { byId } from './dom.js';
import { showLayerBox } from './key.js';
import { offers } from './offers.js';

const key = 'freelsd.base-map';

// look() asks the server until it has answered, once. Without a base map the switch stays hidden.
export function createBaseMap(ground) {
  const toggle = byId('show-base');
  let layer;
  let isAsking = false;
  const draw = () => ground.draw('base', toggle.checked ? { name: 'base map', ...layer } : null);
  toggle.checked = localStorage.getItem(key) !== 'off';
  toggle.addEventListener('change', () => {
    localStorage.setItem(key, toggle.checked ? 'on' : 'off');
    draw();
  });

  async function ask() {
    layer = (await offers()).baseMap ? await getBaseMap() : null;
    if (!layer) return;
    toggle.closest('label').hidden = false;
    showLayerBox();
    draw();
  }

  return {
    look() {
      if (layer !== undefined || isAsking) return;
      isAsking = true;
      ask().catch(() => {}).finally(() => { isAsking = false; });
    },
  };
}
