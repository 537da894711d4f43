// A planned route on the map: solid green where a site is in reach without power, dashed red where none is.
/* global L */

import { el } from './dom.js';
import { discMarker } from './overlays.js';
import { clock, newAltitudesOf, spansOf } from './route_request.js';
import { margin } from './units.js';

const kTouch = 30;  // px, width of the line for fingers
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

function fixLayers(fix, samples) {
  if (!fix.route) return [discMarker(latLng(fix.place), 'route-look', '◎', { title: 'Ground to photograph first', alt: 'Ground to photograph first' })];
  const altitudes = newAltitudesOf(fix.route, samples).map((point) =>
    signMarker(point, 'route-sign', el('span', { class: 'route-altitude' }, `${point.altitude_m.toFixed(0)} m`), { zIndexOffset: 1350 }));
  return [...casedLine(fix.route, 'route-fix'), ...altitudes];
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

  function drawAnswer(answer, fix, onMoment) {
    for (const { isCovered, places } of spansOf(answer)) {
      for (const line of casedLine(places, isCovered ? 'route-covered' : 'route-gap')) group.addLayer(line);
    }
    group.addLayer(touchLine(onMoment));
    answer.gaps.forEach((gap, i) => group.addLayer(gapSign(gap, i, samples)));
    if (answer.point_of_no_return) group.addLayer(pointOfNoReturn(answer.point_of_no_return));
    if (fix) for (const layer of fixLayers(fix, samples)) group.addLayer(layer);
  }

  function drawPoints(points) {
    if (points.length > 1) for (const line of casedLine(points, 'route-unchecked')) group.addLayer(line);
    if (points.length > kMostNumbers) return;
    points.forEach((point, i) => group.addLayer(discMarker(latLng(point), 'draft', i + 1, { interactive: false, keyboard: false })));
  }

  return {
    // points: of a route that was not checked yet. answer: of the server, or null. fix: of the answer, that is shown.
    // onMoment(index of a sample) is called when the user points at the line.
    draw({ points = [], answer = null, fix = null, isOld = false } = {}, onMoment = () => {}) {
      group.clearLayers();
      now.clearLayers();
      samples = answer?.samples ?? [];
      map.getContainer().classList.toggle('route-old', isOld);
      if (answer) drawAnswer(answer, fix, onMoment);
      else drawPoints(points);
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
