// The layer box: shows one layer on the map, of the flight's map or else of the selected site, with legend and opacity.

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

// The parts of the legend that need no request. layer: undefined if none is shown. note: of the source.
function legendNodes(layer, note) {
  return [
    ...(layer?.name === 'hazard' ? safetyLegend(note?.hatchesUnseen ? ['free', 'hazard'] : ['free', 'hazard', 'unseen']) : []),
    note?.hatchesUnseen ? el('span', { class: 'swatch' }, el('i', { class: 'unseen-hatch' }), 'unseen') : null,
    note ? el('span', { class: 'swatch' }, el('i', { class: note.isBlank ? 'blank' : 'hatch' }),
      note.isBlank ? `no colour: ${note.text}` : note.text) : null,
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

const isSameList = (a, b) => JSON.stringify(a.map(({ name, unit }) => [name, unit])) === JSON.stringify(b.map(({ name, unit }) => [name, unit]));

class Layers {
  #select = byId('layer');
  #opacity = byId('opacity');
  #legend = byId('legend');
  #source = null;  // see site_layers.js
  #isOpacityChosen = false;
  #loading = new AbortController();
  #drawnName;
  #legendUrl = null;

  constructor() {
    // On a phone the open box would cover the small map.
    byId('layer-box').open = innerWidth > 760;
    this.#select.addEventListener('change', () => this.#draw());
    this.#opacity.addEventListener('input', () => {
      this.#isOpacityChosen = true;
      this.#source?.setOpacity(Number(this.#opacity.value));
    });
  }

  // Shows the layers of another source, or of the same one after it changed. The selected layer stays selected.
  show(source) {
    const list = source?.list ?? [];
    const isSame = this.#source !== null && this.#source.of === source?.of;
    if (!isSame) {
      this.#source?.hide();
      this.#drawnName = undefined;
    }
    if (source && source.opacity !== this.#source?.opacity && !this.#isOpacityChosen) {
      this.#opacity.value = source.opacity;
      source.setOpacity(source.opacity);
    }
    if (!isSame || !isSameList(this.#source.list, list)) {
      const wanted = this.#select.value || (isSame ? '' : 'hazard');
      this.#select.replaceChildren(...list.map(optionOf), new Option('none', ''));
      this.#select.value = list.some((layer) => layer.name === wanted) || isSame ? wanted : list[0]?.name ?? '';
    }
    this.#source = source;
    return this.#draw();
  }

  // What of the tiles on the map is not complete: see Ground.state.
  setNote({ isLoading, numMissing }) {
    byId('layer-note').textContent = numMissing > 0 ? `${numMissing} tiles not loaded` : isLoading ? 'loading …' : '';
  }

  async #draw() {
    this.#loading.abort();
    this.#loading = new AbortController();
    const { signal } = this.#loading;
    const layer = this.#source?.list.find((l) => l.name === this.#select.value);
    const isOther = this.#drawnName !== layer?.name;
    this.#drawBox(layer, isOther);
    // A picture must never stand beside the name or the legend of another layer.
    if (isOther) this.#source?.hide();
    this.#drawnName = layer?.name;
    if (!layer) return;
    try {
      await this.#source.show(layer, Number(this.#opacity.value), signal);
      await this.#drawScale(layer, signal);
    } catch (error) {
      if (error.name === 'AbortError') return;
      this.#source.hide();
      this.#legend.replaceChildren(el('span', { class: 'bad' }, `Layer not loaded: ${error.message}`));
    }
  }

  #drawBox(layer, isOther) {
    showLayerBox();
    byId('layer-name').textContent = this.#select.selectedOptions[0]?.text ?? '';
    const scale = isOther ? null : this.#legend.querySelector('img');
    this.#legend.replaceChildren(...(scale ? [scale] : []), ...legendNodes(layer, layer ? this.#source.note(layer) : null));
    const source = this.#source;
    byId('layer-curl').replaceChildren(...(layer ? [curlButton(`the layer ${layer.name}`,
      () => curlOf(source.picturePath(layer), `-o ${layer.name}.${source.pictureEnding}`))] : []));
  }

  // The server draws the scale: it always matches the layer.
  async #drawScale(layer, signal) {
    const blob = layer.name === 'hazard' ? null : await this.#source.legend(layer, signal);
    const former = this.#legendUrl;
    this.#legendUrl = blob && URL.createObjectURL(blob);
    this.#legend.querySelector('img')?.remove();
    if (blob) this.#legend.prepend(el('img', { src: this.#legendUrl, alt: `Scale of ${layer.name} in ${layer.unit}` }));
    URL.revokeObjectURL(former);
  }
}

export const createLayers = () => new Layers();
