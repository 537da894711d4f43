// The map with all its overlays.
/* global L */

import { createCursor } from './cursor.js';
import { byId } from './dom.js';
import { Graticule } from './graticule.js';
import { createGround } from './ground.js';
import { createLinkOverlay } from './link_overlay.js';
import { createMeasure } from './measure.js';
import { createDraftOverlay, createObstacleOverlay } from './obstacle_overlay.js';
import {
  createAnswer, createApproach, createArea, createBarb, createBearings, createMarks, createPicture, createRegions, createSites,
} from './overlays.js';
import { createNextLookOverlay } from './next_look_overlay.js';
import { createReachOverlay } from './reach_overlay.js';
import { createRouteOverlay } from './route_overlay.js';
import { createTrack } from './track.js';

// A map without overlays.
export function createBase(element) {
  const isCalm = matchMedia('(prefers-reduced-motion: reduce)').matches;
  const map = L.map(element, {
    maxZoom: 24, zoomSnap: 0.25, attributionControl: false, zoomControl: false,
    zoomAnimation: !isCalm, fadeAnimation: !isCalm, markerZoomAnimation: !isCalm,
  });
  map.setView([0, 0], 2);
  L.control.zoom({ position: 'topright' }).addTo(map);
  L.control.scale({ imperial: false, position: 'bottomright', maxWidth: 140 }).addTo(map);
  new Graticule().addTo(map);
  new ResizeObserver(() => map.invalidateSize({ animate: false })).observe(element);
  return map;
}

// The part of a map in view, in degrees.
export function boxOf(map) {
  const bounds = map.getBounds();
  return { west: bounds.getWest(), south: bounds.getSouth(), east: bounds.getEast(), north: bounds.getNorth() };
}

// Keeps bounds beside the open layer box, or above the closed one, if the map is wide enough for both.
function fitTo(map, bounds) {
  if (!bounds.isValid()) return;
  const box = byId('layer-box');
  const left = box.open && !box.hidden && map.getSize().x > 2 * box.offsetWidth ? box.offsetWidth + 40 : 28;
  map.fitBounds(bounds, { paddingTopLeft: [left, 28], paddingBottomRight: [28, left > 28 ? 28 : 64], maxZoom: 20 });
}

// on: {site(id), place(latlng), obstacle(id), ground(): tiles began to load, arrived or failed}
export function createMap(element, on) {
  const map = createBase(element);
  const barb = createBarb(map);
  const ground = createGround(map, () => on.ground());
  const picture = createPicture(map);
  const reach = createReachOverlay(map);
  const track = createTrack(map);
  const area = createArea(map);
  const regions = createRegions(map);
  const approach = createApproach(map);
  const route = createRouteOverlay(map);
  const nextLook = createNextLookOverlay(map);
  const sites = createSites(map, on.site);
  const marks = createMarks(map);
  const looks = createMarks(map);
  const obstacles = createObstacleOverlay(map, ({ properties }) => on.obstacle(properties.id));
  const draft = createDraftOverlay(map);
  const answer = createAnswer(map);
  const bearings = createBearings(map);
  const measure = createMeasure(map);
  const links = createLinkOverlay(map);
  // Once the user has moved the map, it no longer follows the track.
  let isMoved = false;
  for (const type of ['pointerdown', 'wheel', 'keydown']) {
    element.addEventListener(type, () => { isMoved = true; }, { passive: true });
  }
  const place = (latlng) => {
    if (!measure.take(latlng)) on.place(latlng);
  };
  map.on('click', (event) => place(event.latlng));
  createCursor(map, { place, moved: (latlng) => measure.follow(latlng), key: (event, latlng) => measure.key(event, latlng) });
  const fit = () => {
    const bounds = L.latLngBounds([]).extend(regions.bounds()).extend(sites.bounds()).extend(track.bounds());
    fitTo(map, bounds.isValid() ? bounds : ground.bounds());
  };
  // The path of the site, which a landing that is planned elsewhere replaces while it is shown: [collection, options].
  let path = [null, {}];
  let landing = null;
  const drawPath = () => {
    approach.draw(...(landing ?? path));
    reach.keepClear(approach.signs());
  };
  const fitPath = () => {
    const bounds = approach.bounds();
    fitTo(map, bounds.isValid() ? bounds.pad(0.1) : bounds);
  };

  return {
    drawTrack(collection, options) {
      track.draw(collection, options);
      if (!collection) isMoved = false;
    },
    drawRegions: regions.draw,
    drawSites(collection, chosenId) {
      sites.draw(collection, chosenId);
      reach.nameSites(collection);
    },
    drawLayer: picture.draw,
    setOpacity: picture.setOpacity,
    ground,
    route,
    nextLook,
    drawArea: area.draw,
    drawApproach(collection, options) {
      path = [collection, options];
      drawPath();
    },
    // collection: GeoJSON; null shows the path of the site again.
    drawLanding(collection, options) {
      if (!collection && !landing) return;
      landing = collection ? [collection, options] : null;
      drawPath();
      if (landing) fitPath();
    },
    drawMarks: marks.draw,
    drawWind: barb.draw,
    drawAnswer: answer.draw,
    closeAnswer: answer.close,
    drawBearings: bearings.draw,
    drawReach: reach.draw,
    drawLinks: links.draw,
    drawNewLook: (shown) => looks.draw(shown.map((mark) => ({ ...mark, className: 'new-look' }))),
    drawObstacles: obstacles.draw,
    drawDraft(points, ...rest) {
      if (points) measure.end();
      draft.draw(points, ...rest);
    },
    endMeasure: () => measure.end(),
    onMove: (listener) => map.on('moveend', listener),
    box: () => boxOf(map),
    centerPoint: () => map.getCenter(),
    // feature: GeoJSON
    panToFeature: (feature) => map.panTo(L.geoJSON(feature).getBounds().getCenter()),
    fitFeatures: (features) => fitTo(map, L.geoJSON(features).getBounds()),
    fit,
    fitUnlessMoved() { if (!isMoved) fit(); },
    fitApproach: fitPath,
    panTo: ({ latitude_deg, longitude_deg }) => map.panTo([latitude_deg, longitude_deg]),
    center() {
      const { lat, lng } = map.getCenter();
      return { latitude_deg: lat, longitude_deg: lng };
    },
  };
}
