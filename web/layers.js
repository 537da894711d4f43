// The layer box: shows one layer of the selected site on the map, with legend and opacity.

import * as api from './api.js';
import { gradeColor, safetyColor } from './colors.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el } from './dom.js';
import { showLayerBox } from './key.js';
import { words } from './units.js';

const unitText = { deg: '°', class: '' };

function swatch(color, text) {
  return el('span', { class: 'swatch' }, el('i', { style: { background: color } }), text);
}

const safetyLegend = (names) => names.map((name) => swatch(safetyColor[name], name));

// The parts of the legend that need no request. layer: undefined if none is shown.
function legendNodes(layer) {
  const note = layer && !['hazard', 'distance'].includes(layer.name) ? 'unseen' : 'outside map';
  return [
    ...(layer?.name === 'hazard' ? safetyLegend(['free', 'hazard', 'unseen']) : []),
    layer ? el('span', { class: 'swatch' }, el('i', { class: 'hatch' }), note) : null,
    el('span', { class: 'swatch', title: 'Region outline. Dashed: outline incomplete.' },
      el('i', { class: 'ramp', style: { background: `linear-gradient(90deg, ${[0, 0.25, 0.5, 0.75, 1].map(gradeColor)})` } }),
      'region grade, 0 to 1'),
    el('span', { class: 'swatch' }, el('i', { class: 'track-line' }), 'track'),
  ].filter(Boolean);
}

function optionOf({ name, unit }) {
  const shown = unitText[unit] ?? unit;
  return new Option(words(name) + (shown ? ` (${shown})` : ''), name);
}

class Layers {
  #map;
  #select = byId('layer');
  #legend = byId('legend');
  #site = null;
  #layers = [];
  #loading = new AbortController();
  #drawnName;
  #pictureUrl = null;
  #legendUrl = null;

  constructor(map) {
    this.#map = map;
    // On a phone the open box would cover the small map.
    byId('layer-box').open = innerWidth > 760;
    this.#select.addEventListener('change', () => this.#draw());
    byId('opacity').addEventListener('input', () => map.setOpacity(Number(byId('opacity').value)));
  }

  // Shows the layers of another site. The selected layer stays selected.
  show(siteId, list) {
    this.#site = siteId;
    this.#layers = list;
    const wanted = this.#select.value || 'hazard';
    this.#select.replaceChildren(...list.map(optionOf), new Option('none', ''));
    this.#select.value = list.some((layer) => layer.name === wanted) ? wanted : list[0]?.name ?? '';
    return this.#draw();
  }

  async #draw() {
    this.#loading.abort();
    this.#loading = new AbortController();
    const { signal } = this.#loading;
    const layer = this.#layers.find((l) => l.name === this.#select.value);
    this.#drawBox(layer);
    // A picture must never stand beside the name or the legend of another layer.
    if (this.#drawnName !== layer?.name) this.#map.drawLayer(null);
    this.#drawnName = layer?.name;
    if (!layer) return;
    try {
      await this.#drawPicture(layer, signal);
      await this.#drawScale(layer, signal);
    } catch (error) {
      if (error.name === 'AbortError') return;
      this.#map.drawLayer(null);
      this.#legend.replaceChildren(el('span', { class: 'bad' }, `Layer not loaded: ${error.message}`));
    }
  }

  #drawBox(layer) {
    showLayerBox();
    byId('layer-name').textContent = this.#select.selectedOptions[0]?.text ?? '';
    URL.revokeObjectURL(this.#legendUrl);
    this.#legendUrl = null;
    this.#legend.replaceChildren(...legendNodes(layer));
    byId('layer-curl').replaceChildren(...(layer ? [curlButton(`the layer ${layer.name}`,
      () => curlOf(api.paths.layerPicture(this.#site, layer.name), `-o ${layer.name}.png`))] : []));
  }

  async #drawPicture(layer, signal) {
    const blob = await api.getBlob(api.paths.layerPicture(this.#site, layer.name), signal);
    const former = this.#pictureUrl;
    this.#pictureUrl = URL.createObjectURL(blob);
    this.#map.drawLayer(this.#pictureUrl, layer, Number(byId('opacity').value));
    URL.revokeObjectURL(former);
  }

  // The server draws the scale: it always matches the layer.
  async #drawScale(layer, signal) {
    if (layer.name === 'hazard') return;
    const blob = await api.getBlob(api.paths.legend(this.#site, layer.name), signal);
    this.#legendUrl = URL.createObjectURL(blob);
    this.#legend.prepend(el('img', { src: this.#legendUrl, alt: `Scale of ${layer.name} in ${layer.unit}` }));
  }
}

export const createLayers = (map) => new Layers(map);
