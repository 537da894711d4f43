// A planned route on the map: solid green where a site is in reach without power, dashed red where none is.
/* global L */

import { el, svg } from './dom.js';
import { discMarker } from './overlays.js';
import { clock, changedPart, spansOf } from './route_request.js';
import { margin } from './units.js';

const kTouch = 30;  // px, width of the line for fingers
const kArrows = [0, 1 / 3, 2 / 3];  // shares of the time
const kMostNumbers = 40;  // points; a survey has hundreds, whose numbers would hide the route

const latLng = ({ latitude_deg, longitude_deg }) => [latitude_deg, longitude_deg];

function casedLine(places, kind) {
  const line = places.map(latLng);
  return [`route-casing ${kind}-casing`, kind].map((className) => L.polyline(line, { className, interactive: false }));
}

const signMarker = (place, className, node, options = {}) => L.marker(latLng(place), {
  icon: L.divIcon({ className, html: node, iconSize: [0, 0] }), interactive: false, keyboard: false, ...options,
});

function pointOfNoReturn(sample) {
  const sign = el('span', { class: 'route-no-return' }, el('i', {}, el('b', {}, 'R')), el('em', {}, `no return ${clock(sample.time_s)}`));
  return signMarker(sample, 'route-sign', sign, { title: 'Point of no return of the route', alt: 'Point of no return of the route', zIndexOffset: 1400 });
}

function gapSign({ from_s, to_s }, index, samples) {
  const middle_s = (from_s + to_s) / 2;
  const middle = samples.reduce((best, sample) => (Math.abs(sample.time_s - middle_s) < Math.abs(best.time_s - middle_s) ? sample : best));
  return signMarker(middle, 'route-sign', el('span', { class: 'route-gap-sign' }, `✕ gap ${index + 1}`), { zIndexOffset: 1300 });
}

// Which way the route is flown.
function arrowAt(sample) {
  const head = svg('svg', { viewBox: '-12 -12 24 24', width: 24, height: 24, 'aria-hidden': 'true' },
    svg('path', { d: 'M0 -9L8 7L0 3L-8 7Z', transform: `rotate(${sample.heading_deg.toFixed(1)})` }));
  return L.marker(latLng(sample), { icon: L.divIcon({ className: 'route-arrow', html: head, iconSize: [24, 24] }), interactive: false, keyboard: false });
}

function fixLayers(fix, samples) {
  if (!fix.route) return [discMarker(latLng(fix.place), 'route-look', '◎', { title: 'Ground to photograph first', alt: 'Ground to photograph first' })];
  const { points, highest } = changedPart(fix.route, samples);
  const altitude = highest && el('span', { class: 'route-altitude' }, `▲ ${highest.altitude_m.toFixed(0)} m`);
  return [...casedLine(points, highest ? 'route-fix' : 'route-fix-aside'), ...(highest ? [signMarker(highest, 'route-sign', altitude, { zIndexOffset: 1350 })] : [])];
}

export function createRouteOverlay(map) {
  map.createPane('route-touch').style.zIndex = 430;
  const group = L.featureGroup().addTo(map);
  const now = L.layerGroup().addTo(map);
  let samples = [];

  function nearestTo(latlng) {
    const at = map.latLngToLayerPoint(latlng);
    let best = { index: 0, distance_px: Infinity };
    samples.forEach((sample, index) => {
      const distance_px = at.distanceTo(map.latLngToLayerPoint(latLng(sample)));
      if (distance_px < best.distance_px) best = { index, distance_px };
    });
    return best.index;
  }

  // The line takes clicks, so that it can be asked; a click beside it is a click on the map.
  function touchLine(onMoment) {
    return L.polyline(samples.map(latLng), { className: 'route-touch', pane: 'route-touch', weight: kTouch, opacity: 0, bubblingMouseEvents: false })
      .on('mousemove click', (event) => onMoment(nearestTo(event.latlng)));
  }

  // A changed route lies below the present one, as a wide band, because a climb changes nothing that is seen from above.
  function drawAnswer(answer, fix, onMoment) {
    if (fix) for (const layer of fixLayers(fix, samples)) group.addLayer(layer);
    for (const { isCovered, places } of spansOf(answer)) {
      for (const line of casedLine(places, isCovered ? 'route-covered' : 'route-gap')) group.addLayer(line);
    }
    group.addLayer(touchLine(onMoment));
    for (const share of kArrows) group.addLayer(arrowAt(samples[Math.floor(share * samples.length)]));
    answer.gaps.forEach((gap, i) => group.addLayer(gapSign(gap, i, samples)));
    if (answer.point_of_no_return) group.addLayer(pointOfNoReturn(answer.point_of_no_return));
  }

  function drawPoints(points, isDrawing) {
    if (points.length > 1) for (const line of casedLine(points, 'route-unchecked')) group.addLayer(line);
    if (isDrawing || points.length > kMostNumbers) return;
    points.forEach((point, i) => group.addLayer(discMarker(latLng(point), 'draft', i + 1, { interactive: false, keyboard: false })));
  }

  return {
    // points: of a route that was not checked yet; isDrawing: the draft shows their numbers. answer: of the server, or null. fix: of the answer, that is shown.
    // onMoment(index of a sample) is called when the user points at the line.
    draw({ points = [], isDrawing = false, answer = null, fix = null, isOld = false } = {}, onMoment = () => {}) {
      group.clearLayers();
      now.clearLayers();
      samples = answer?.samples ?? [];
      map.getContainer().classList.toggle('route-old', isOld);
      if (answer) drawAnswer(answer, fix, onMoment);
      else drawPoints(points, isDrawing);
    },
    // index: of the sample that the panel tells about, or null.
    mark(index) {
      now.clearLayers();
      const sample = samples[index];
      if (!sample) return;
      const text = el('span', { class: `route-moment${sample.covered ? '' : ' is-gap'}` }, el('i'),
        el('b', {}, `${clock(sample.time_s)} · ${margin(sample.arrival_margin_m)}`));
      now.addLayer(signMarker(sample, 'route-sign', text, { zIndexOffset: 1900 }));
    },
  };
}

const swatch = (name, text) => el('span', { class: 'swatch' }, el('i', { class: `key-${name}` }), text);

// The legend of what is drawn.
export const routeKey = (answer) => (answer
  ? [swatch('route-covered', 'site in reach'), answer.gaps.length ? swatch('route-gap', 'no site in reach') : null].filter(Boolean) : []);
