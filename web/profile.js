// Clearance plot: path and highest terrain in the corridor against distance to touchdown.

import uPlot from './vendor/uPlot.esm.js';

let plot = null;

export function drawProfile(element, profile) {
  plot?.destroy();
  plot = null;
  element.replaceChildren();
  if (!profile) return;
  // uPlot wants ascending x; the aircraft comes from the left, so the axis runs backwards.
  const distance = [...profile.distance_m].reverse();
  const path = [...profile.path_m].reverse();
  const terrain = [...profile.terrain_m].reverse();
  plot = new uPlot(
    {
      width: Math.max(element.clientWidth, 280),
      height: 190,
      scales: { x: { time: false, dir: -1 } },
      axes: [{ label: 'distance to touchdown (m)' }, { label: 'altitude (m)' }],
      series: [
        { label: 'distance' },
        { label: 'path', stroke: '#d7191c', width: 2 },
        { label: 'terrain', stroke: '#5b4a1f', width: 1.5, fill: 'rgba(120,100,40,0.3)' },
      ],
    },
    [distance, path, terrain],
    element,
  );
}
