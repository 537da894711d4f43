// The picture of one layer of the chosen site on the map, its legend and its opacity.

import * as api from './api.js';
import { gradeColor, safetyColor } from './colors.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el } from './dom.js';
import { words } from './units.js';

const unitText = { deg: '°', class: '' };

function swatch(color, text) {
  return el('span', { class: 'swatch' }, el('i', { style: { background: color } }), text);
}

const safetyLegend = (names) => names.map((name) => swatch(safetyColor[name], name));

export function createLayers(map) {
  const select = byId('layer');
  const opacity = byId('opacity');
  const legend = byId('legend');
  let site = null;
  let layers = [];
  let loading = new AbortController();
  let drawnName;
  let pictureUrl = null;
  let legendUrl = null;

  function drawLegend(layer) {
    URL.revokeObjectURL(legendUrl);
    legendUrl = null;
    legend.replaceChildren();
    if (layer?.name === 'hazard') legend.append(...safetyLegend(['free', 'hazard', 'unseen']));
    const note = layer && !['hazard', 'distance'].includes(layer.name) ? 'not seen' : 'outside the map';
    if (layer) legend.append(el('span', { class: 'swatch' }, el('i', { class: 'hatch' }), note));
    legend.append(el('span', { class: 'swatch', title: 'Outlines of regions; dashed while they still grow' },
      el('i', { class: 'ramp', style: { background: `linear-gradient(90deg, ${[0, 0.25, 0.5, 0.75, 1].map(gradeColor)})` } }),
      'region, grade 0 to 1'), el('span', { class: 'swatch' }, el('i', { class: 'track-line' }), 'flown'));
  }

  // The scale is the server's own picture, so that it cannot differ from the layer.
  async function drawScale(layer, signal) {
    if (!layer || layer.name === 'hazard') return;
    const blob = await api.getBlob(api.paths.legend(site, layer.name), signal);
    legendUrl = URL.createObjectURL(blob);
    legend.prepend(el('img', { src: legendUrl, alt: `Scale of ${layer.name} in ${layer.unit}` }));
  }

  async function draw() {
    loading.abort();
    loading = new AbortController();
    const { signal } = loading;
    const layer = layers.find((l) => l.name === select.value);
    byId('layer-box').hidden = layers.length === 0;
    byId('layer-name').textContent = select.selectedOptions[0]?.text ?? '';
    drawLegend(layer);
    byId('layer-curl').replaceChildren(...(layer ? [curlButton(`the layer ${layer.name}`,
      () => curlOf(api.paths.layerPicture(site, layer.name), `-o ${layer.name}.png`))] : []));
    // A picture never stands beside the name or the legend of another layer.
    if (drawnName !== layer?.name) map.drawLayer(null);
    drawnName = layer?.name;
    if (!layer) return;
    try {
      const blob = await api.getBlob(api.paths.layerPicture(site, layer.name), signal);
      const former = pictureUrl;
      pictureUrl = URL.createObjectURL(blob);
      map.drawLayer(pictureUrl, layer, Number(opacity.value));
      URL.revokeObjectURL(former);
      await drawScale(layer, signal);
    } catch (error) {
      if (error.name === 'AbortError') return;
      map.drawLayer(null);
      legend.replaceChildren(el('span', { class: 'bad' }, `This layer did not come: ${error.message}`));
    }
  }

  // On a phone the map is small: the legend opens when it is asked for.
  byId('layer-box').open = innerWidth > 760;
  select.addEventListener('change', draw);
  opacity.addEventListener('input', () => map.setOpacity(Number(opacity.value)));

  return {
    // The layers of another site; what was chosen stays chosen.
    show(siteId, list) {
      site = siteId;
      layers = list;
      const wanted = select.value || 'hazard';
      select.replaceChildren(...list.map(({ name, unit }) => {
        const shown = unitText[unit] ?? unit;
        return new Option(words(name) + (shown ? ` (${shown})` : ''), name);
      }), new Option('no layer', ''));
      select.value = list.some((layer) => layer.name === wanted) ? wanted : list[0]?.name ?? '';
      return draw();
    },
    all: () => layers,
  };
}
