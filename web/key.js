// The legend of what is drawn over the map beside the layer, in the layer box.

import { byId, el } from './dom.js';

const parts = new Map();

// The box is visible while it has a layer or a legend.
export function showLayerBox() {
  const hasLayer = byId('layer').options.length > 1;
  const hasGround = document.querySelector('.ground-row > :not([hidden])') !== null;
  byId('layer-box').hidden = !hasLayer && !hasGround && byId('key').childElementCount === 0;
  byId('layer-box').classList.toggle('only-key', !hasLayer);
}

// nodes: swatches; text: a line below them, or nothing. An unchanged part is not drawn again.
export function setKey(name, nodes, text = '') {
  const content = nodes.map((node) => node.outerHTML).join('') + text;
  if (parts.get(name)?.content === content) return;
  parts.set(name, { content, nodes, text });
  byId('key').replaceChildren(...[...parts.values()].flatMap((part) =>
    [...part.nodes, ...(part.text ? [el('span', { class: 'key-text' }, part.text)] : [])]));
  showLayerBox();
}
