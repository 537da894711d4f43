// The history of a region, plotted as in the paper: views, grade and area by frame.

import { getHistory, paths } from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, cssColor, el } from './dom.js';
import { axis } from './profile.js';
import { area, windText } from './units.js';
import uPlot from './vendor/uPlot.esm.js';

let plots = [];

function drawPlot(parent, title, x, series, scale) {
  const box = el('figure', { class: 'plot' }, el('figcaption', {}, title,
    ...series.map(({ name, color, dash }) => el('span', { class: 'swatch' },
      el('i', { class: `line${dash ? ' dashed' : ''}`, style: { color: cssColor(color) } }), name))));
  parent.append(box);
  plots.push(new uPlot(
    {
      width: Math.max(box.clientWidth, 260),
      height: 150,
      legend: { show: false },
      cursor: { y: false, points: { show: false } },
      scales: { x: { time: false }, y: scale ? { range: scale } : {} },
      axes: [axis('frame', { size: 34 }), axis(undefined, { size: 66, labelSize: 0, label: undefined })],
      series: [{}, ...series.map(({ color, dash }) => ({
        stroke: cssColor(color), width: 2.5, dash: dash ? [6, 4] : undefined, spanGaps: false, points: { show: false },
      }))],
    },
    [x, ...series.map(({ values }) => values)],
    box,
  ));
}

function facts(p) {
  return el('p', {}, `Grade ${p.grade.toFixed(2)}. Grass in ${p.num_grass_observations} of ${p.num_observations} views. ` +
    `Area ${area(p.area_m2)}, outline ${p.is_fixed ? 'complete' : 'incomplete'}. Wind ${windText(p.wind)}.`);
}

// properties: of the region. site: properties of its site, undefined before its evaluation.
export async function drawHistory(flight, properties, site, onSite) {
  const id = properties.id;
  byId('region-title').textContent = `Region ${id}`;
  byId('region-curl').replaceChildren(curlButton('this history', () => curlOf(paths.history(flight, id))));
  byId('region-facts').replaceChildren(facts(properties), site
    ? el('button', { type: 'button', class: 'wide', onclick: () => onSite(site.id) }, `Site ${site.rank}: ${site.verdict}`)
    : el('p', { class: 'faint' }, 'No site: this region is not evaluated yet.'));
  const parent = byId('region-plots');
  const history = await getHistory(flight, id);
  plots.forEach((plot) => plot.destroy());
  plots = [];
  parent.replaceChildren();
  if (history.length === 0) {
    parent.append(el('p', { class: 'faint' }, 'No history stored for this region.'));
    return;
  }
  const x = history.map((_, i) => i + 1);
  const column = (name) => history.map((entry) => entry[name] ?? null);
  drawPlot(parent, 'Views', x, [
    { name: 'all', color: '--faint', dash: true, values: column('num_observations') },
    { name: 'with grass', color: '--accent', values: column('num_grass_observations') }]);
  drawPlot(parent, 'Grade', x, [
    { name: 'grass ratio', color: '--faint', dash: true, values: column('grass_ratio') },
    { name: 'grade', color: '--accent', values: column('grade') }], [0, 1.05]);
  drawPlot(parent, 'Area, m²', x, [{ name: 'area', color: '--accent', values: column('area_m2') }]);
}
