// Plots the final over the highest terrain in its corridor and marks the lowest margin.

import { cssColor, el } from './dom.js';
import { fixed, isKnown } from './units.js';
import uPlot from './vendor/uPlot.esm.js';

// Required clearance at a height above touchdown: the safety margin, but at most half the height.
const wantedAt = (height_m, margin_m) => Math.min(margin_m, height_m / 2);

// {distance_m, clearance_m, wanted_m, spare_m, terrain_m} of the lowest margin: the seen point outside the
// touchdown disc with the least clearance above the required one. null if no such point was seen.
export function limitOf(profile, aircraft) {
  const touchdown_m = profile.path_m.at(-1);
  let limit = null;
  profile.distance_m.forEach((distance_m, i) => {
    const clearance_m = profile.clearance_m[i];
    if (!isKnown(clearance_m) || distance_m < (aircraft?.touchdown_uncertainty_m ?? 0)) return;
    const wanted_m = wantedAt(profile.path_m[i] - touchdown_m, aircraft?.safety_margin_m ?? 0);
    const spare_m = clearance_m - wanted_m;
    if (limit && limit.spare_m <= spare_m) return;
    limit = { distance_m, clearance_m, wanted_m, spare_m, terrain_m: profile.terrain_m[i] };
  });
  return limit;
}

export function limitText(limit, profile) {
  const numUnseen = profile.terrain_m.filter((terrain) => !isKnown(terrain)).length;
  const unseen = numUnseen === 0 ? '' :
    ` ${Math.round(100 * numUnseen / profile.terrain_m.length)} % of the final is unseen.`;
  if (!limit) return `No ground under the final was seen.${unseen}`;
  return `Lowest margin ${fixed(limit.distance_m, 0, 'm')} before touchdown: ` +
    `clearance ${fixed(limit.clearance_m, 1, 'm')}, required ${fixed(limit.wanted_m, 1, 'm')}.${unseen}`;
}

// Bands over the whole height where the ground is unseen.
function drawUnseen(plot, distance, terrain) {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.fillStyle = cssColor('--unseen-wash');
  for (let i = 0; i + 1 < distance.length; ++i) {
    if (isKnown(terrain[i]) && isKnown(terrain[i + 1])) continue;
    const from = plot.valToPos(distance[i], 'x', true);
    const to = plot.valToPos(distance[i + 1], 'x', true);
    ctx.fillRect(Math.min(from, to), bbox.top, Math.abs(to - from) + 1, bbox.height);
  }
  ctx.restore();
}

function drawLimit(plot, limit) {
  if (!limit) return;
  const { ctx } = plot;
  const x = plot.valToPos(limit.distance_m, 'x', true);
  const top = plot.valToPos(limit.terrain_m + limit.clearance_m, 'y', true);
  const bottom = plot.valToPos(limit.terrain_m, 'y', true);
  ctx.save();
  ctx.strokeStyle = ctx.fillStyle = cssColor('--ink');
  ctx.lineWidth = 2 * devicePixelRatio;
  ctx.beginPath();
  ctx.moveTo(x, top);
  ctx.lineTo(x, bottom);
  ctx.stroke();
  ctx.beginPath();
  ctx.arc(x, bottom, 4 * devicePixelRatio, 0, 2 * Math.PI);
  ctx.fill();
  ctx.restore();
}

// A vertical line at the point of no return, with its name beside it on the side towards the touchdown.
function drawNoReturn(plot, distance_m) {
  const { ctx, bbox } = plot;
  const x = plot.valToPos(distance_m, 'x', true);
  const isRight = x < bbox.left + bbox.width / 2;
  ctx.save();
  ctx.strokeStyle = ctx.fillStyle = cssColor('--no-return');
  ctx.lineWidth = 2 * devicePixelRatio;
  ctx.setLineDash([6 * devicePixelRatio, 3 * devicePixelRatio]);
  ctx.beginPath();
  ctx.moveTo(x, bbox.top);
  ctx.lineTo(x, bbox.top + bbox.height);
  ctx.stroke();
  ctx.font = `700 ${13 * devicePixelRatio}px system-ui, sans-serif`;
  ctx.textAlign = isRight ? 'left' : 'right';
  ctx.fillText('no return', x + (isRight ? 5 : -5) * devicePixelRatio, bbox.top + 14 * devicePixelRatio);
  ctx.restore();
}

const legendItem = (className, text) =>
  el('span', { class: 'swatch' }, el('i', { class: `line ${className}` }), text);

export const axis = (label, extra = {}) => ({
  label,
  labelSize: 20,
  labelFont: '600 13px system-ui, sans-serif',
  font: '13px system-ui, sans-serif',
  stroke: cssColor('--faint'),
  grid: { stroke: cssColor('--line'), width: 1 },
  ticks: { stroke: cssColor('--line'), width: 1 },
  ...extra,
});

const plots = new WeakMap();  // by element

// noReturn_m: distance of the point of no return before the touchdown, or nothing.
export function drawProfile(element, profile, aircraft, noReturn_m) {
  plots.get(element)?.destroy();
  plots.delete(element);
  element.replaceChildren();
  if (!profile) return;
  const limit = limitOf(profile, aircraft);
  const hasNoReturn = isKnown(noReturn_m) && noReturn_m <= profile.distance_m[0];
  const touchdown_m = profile.path_m.at(-1);
  const margin_m = aircraft?.safety_margin_m ?? 0;
  // uPlot requires ascending x. The aircraft comes from the left: the axis is reversed.
  const ascending = (values) => [...values].reverse();
  const distance = ascending(profile.distance_m);
  const terrain = ascending(profile.terrain_m);
  const path = ascending(profile.path_m);
  const lowest = path.map((z) => z - wantedAt(z - touchdown_m, margin_m));
  plots.set(element, new uPlot(
    {
      width: Math.max(element.clientWidth, 260),
      height: 200,
      legend: { show: false },
      cursor: { y: false, points: { show: false } },
      scales: { x: { time: false, dir: -1 } },
      axes: [axis('distance to touchdown (m)', { size: 34 }), axis('altitude (m)', { size: 52 })],
      series: [
        {},
        { stroke: cssColor('--path'), width: 3, points: { show: false } },
        { stroke: cssColor('--path'), width: 1.5, dash: [5, 5], points: { show: false } },
        { stroke: cssColor('--terrain'), width: 2, fill: cssColor('--terrain-wash'), points: { show: false } },
      ],
      hooks: {
        drawClear: [(u) => drawUnseen(u, distance, terrain)],
        draw: [(u) => drawLimit(u, limit), (u) => { if (hasNoReturn) drawNoReturn(u, noReturn_m); }],
      },
    },
    [distance, path, lowest, terrain],
    element,
  ));
  element.append(
    el('div', { class: 'legend-line' }, legendItem('path', 'final'), legendItem('wanted', 'terrain limit'),
      legendItem('terrain', 'highest terrain'), legendItem('unseen', 'unseen'),
      hasNoReturn ? legendItem('no-return', 'point of no return') : null),
    el('p', { class: 'limit' }, limitText(limit, profile)));
}
