// The arrival margin along a route: a strip chart with a slider below it.

import { cssColor, el } from './dom.js';
import { axis } from './profile.js';
import { clock } from './route_request.js';
import { isKnown } from './units.js';
import uPlot from './vendor/uPlot.esm.js';

const kHeight = 170;  // px
const kAxis = 52;  // px, width of the axis of margins
const kSteps_s = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200];
const kHatch = 8;  // px
const kLeastTop_m = 40;

// Margins far below zero say no more than "far": the lower end of the scale is at most as far from zero as the upper.
export function rangeOf(margins_m) {
  const known = margins_m.filter(isKnown);
  const most = known.reduce((a, b) => Math.max(a, b), kLeastTop_m);
  const least = known.reduce((a, b) => Math.min(a, b), 0);
  return [Math.max(1.1 * least, -1.1 * most) - 0.05 * most, 1.1 * most];
}

// Margins where a site is in reach, and where none is. The second includes its neighbours, so that the line has no hole.
export function seriesOf(samples) {
  const isBesideGap = (i) => [i - 1, i, i + 1].some((k) => samples[k]?.covered === false);
  const marginsWhere = (isWanted) => samples.map((sample, i) => (isWanted(sample, i) ? sample.arrival_margin_m : null));
  return [marginsWhere(({ covered }) => covered), marginsWhere((_, i) => isBesideGap(i))];
}

// Gaps over the whole height, hatched.
function drawGaps({ ctx, bbox, valToPos }, gaps) {
  ctx.save();
  ctx.fillStyle = cssColor('--gap-wash');
  ctx.strokeStyle = cssColor('--gap-hatch');
  for (const { from_s, to_s } of gaps) {
    const left = valToPos(from_s, 'x', true);
    const width = Math.max(2, valToPos(to_s, 'x', true) - left);
    ctx.save();
    ctx.beginPath();
    ctx.rect(left, bbox.top, width, bbox.height);
    ctx.clip();
    ctx.fill();
    ctx.beginPath();
    for (let x = left - bbox.height; x < left + width; x += kHatch * devicePixelRatio) {
      ctx.moveTo(x, bbox.top + bbox.height);
      ctx.lineTo(x + bbox.height, bbox.top);
    }
    ctx.stroke();
    ctx.restore();
  }
  ctx.restore();
}

function drawLevel({ ctx, bbox, valToPos }, noReturn_s) {
  const line = (from, to, color, dash) => {
    ctx.strokeStyle = cssColor(color);
    ctx.setLineDash(dash.map((length) => length * devicePixelRatio));
    ctx.beginPath();
    ctx.moveTo(...from);
    ctx.lineTo(...to);
    ctx.stroke();
  };
  ctx.save();
  ctx.lineWidth = 2 * devicePixelRatio;
  const zero = valToPos(0, 'y', true);
  line([bbox.left, zero], [bbox.left + bbox.width, zero], '--ink', []);
  if (isKnown(noReturn_s)) {
    const x = valToPos(noReturn_s, 'x', true);
    line([x, bbox.top], [x, bbox.top + bbox.height], '--no-return', [6, 3]);
  }
  ctx.restore();
}

const legendItem = (className, text) => el('span', { class: 'swatch' }, el('i', { class: `line ${className}` }), text);

// onMoment(index of a sample) is called when the user points at the chart or moves the slider.
export function createRouteChart(element, onMoment) {
  const slider = el('input', { type: 'range', id: 'route-time', min: 0, step: 1, 'aria-label': 'Time along the route',
    oninput: () => onMoment(Number(slider.value)) });
  const line = el('i', { class: 'route-now' });
  let plot = null;
  let answer = null;
  let marked = null;

  function mark(index, text = '') {
    marked = index;
    const sample = answer?.samples[index];
    line.hidden = !sample;
    if (!sample) return;
    line.style.left = `${100 * sample.time_s / answer.time_s}%`;
    slider.value = index;
    slider.setAttribute('aria-valuetext', text);
  }

  function draw(drawn) {
    plot?.destroy();
    plot = null;
    answer = drawn;
    element.replaceChildren();
    if (!answer?.samples.length) return;
    const [covered, uncovered] = seriesOf(answer.samples);
    const noReturn_s = answer.point_of_no_return?.time_s;
    const look = { width: 3, points: { show: false } };
    plot = new uPlot({
      width: Math.max(element.clientWidth, 260), height: kHeight, legend: { show: false }, cursor: { x: false, y: false, points: { show: false } },
      scales: { x: { time: false, range: () => [0, answer.time_s] }, y: { range: () => rangeOf([...covered, ...uncovered]) } },
      axes: [axis(undefined, { size: 30, labelSize: 0, incrs: kSteps_s, values: (_, ticks) => ticks.map(clock) }), axis('margin (m)', { size: kAxis })],
      series: [{}, { ...look, stroke: cssColor('--reach') }, { ...look, stroke: cssColor('--bad'), dash: [6, 4] }],
      hooks: {
        drawClear: [(u) => drawGaps(u, answer.gaps)], draw: [(u) => drawLevel(u, noReturn_s)],
        setCursor: [(u) => { if (isKnown(u.cursor.idx) && u.cursor.left >= 0) onMoment(u.cursor.idx); }],
      },
    }, [answer.samples.map(({ time_s }) => time_s), covered, uncovered], element);
    plot.over.append(line);
    slider.max = answer.samples.length - 1;
    element.append(el('div', { class: 'route-slider' }, slider),
      el('div', { class: 'legend-line' }, legendItem('in-reach', 'site in reach'),
        answer.gaps.length ? legendItem('no-reach dashed', 'no site in reach') : null,
        isKnown(noReturn_s) ? legendItem('no-return', 'point of no return') : null));
    mark(marked);
  }

  addEventListener('freelsd-theme', () => { if (answer) draw(answer); });
  return { draw, mark };
}
