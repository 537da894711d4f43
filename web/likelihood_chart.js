// How well each height of a place explains its photographs, as a small chart; the stored height is marked.

import { svg } from './dom.js';
import { bestHeight_m, likelihoodText, niceStep } from './proof_shape.js';
import { isKnown } from './units.js';

const kWidth = 268;
const kHeight = 150;
const kBox = { left: 38, right: kWidth - 14, top: 8, bottom: kHeight - 36 };
const kLeastBand = 3;  // so that a small deviation is seen

const ticks = (from, to, most) => {
  const step = niceStep(to - from, most);
  const first = Math.ceil(from / step - 1e-9);
  return Array.from({ length: Math.floor(to / step + 1e-9) - first + 1 }, (_, i) => Number(((first + i) * step).toFixed(6)));
};

const scale = ([from, to], [start, end]) => (value) => start + (value - from) / (to - from) * (end - start);
const line = (x1, y1, x2, y2, name) => svg('line', { x1, y1, x2, y2, class: name });
const text = (x, y, anchor, content) => svg('text', { x, y, 'text-anchor': anchor }, content);

function storedMark(x, { height_m, height_sd_m }) {
  if (!isKnown(height_m)) return [];
  const half = Math.max(kLeastBand, isKnown(height_sd_m) ? x(height_m + height_sd_m) - x(height_m) : 0);
  const [left, right] = [x(height_m) - half, x(height_m) + half].map((at) => Math.min(kBox.right, Math.max(kBox.left, at)));
  return [svg('rect', { x: left, y: kBox.top, width: right - left, height: kBox.bottom - kBox.top, class: 'stored-band' }),
    line(x(height_m), kBox.top, x(height_m), kBox.bottom, 'stored-line')];
}

// stored: {height_m, height_sd_m} of the map.
export function likelihoodChart(likelihood, stored) {
  const { height_m, log_likelihood } = likelihood;
  const heights = isKnown(stored.height_m) ? [...height_m, stored.height_m] : height_m;
  const ends = [Math.min(...heights), Math.max(...heights)];
  const least = Math.min(...log_likelihood, -1);
  const x = scale(ends, [kBox.left, kBox.right]);
  const y = scale([least, 0], [kBox.bottom, kBox.top]);
  const best = bestHeight_m(likelihood);
  return svg('svg', { viewBox: `0 0 ${kWidth} ${kHeight}`, class: 'likelihood', role: 'img', 'aria-label': likelihoodText(likelihood, stored) },
    ...ticks(least, 0, 3).flatMap((value) => [line(kBox.left, y(value), kBox.right, y(value), 'grid'), text(kBox.left - 5, y(value) + 4, 'end', String(value).replace('-', '−'))]),
    ...ticks(...ends, 5).flatMap((value) => [line(x(value), kBox.bottom, x(value), kBox.bottom + 4, 'grid'), text(x(value), kBox.bottom + 16, 'middle', String(value))]),
    ...storedMark(x, stored),
    svg('polyline', { points: height_m.map((height, i) => `${x(height).toFixed(1)},${y(log_likelihood[i]).toFixed(1)}`).join(' '), class: 'curve' }),
    svg('circle', { cx: x(best), cy: y(0), r: 4, class: 'best' }),
    text((kBox.left + kBox.right) / 2, kHeight - 4, 'middle', 'height (m)'));
}
