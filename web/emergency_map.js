// The map of the emergency view: the aircraft, the ground in reach, the sites of the cards.
/* global L */

import { byId } from './dom.js';
import { boxOf, createBase } from './map.js';
import { createObstacleOverlay, obstacleKey } from './obstacle_overlay.js';
import { createObstacleSource } from './obstacle_source.js';
import { createBearings, discMarker } from './overlays.js';
import { createReachOverlay, reachKey } from './reach_overlay.js';
import { siteLetter } from './units.js';

class EmergencyMap {
  #map = null; // made when the dialog first opens: a hidden map has no size
  #reach; #obstacles; #bearings; #sites;
  #isMoved = false;
  #source = createObstacleSource(() => this.#drawObstacles());
  #shown = { reach: null, from: null, sites: [] };

  open() {
    this.#isMoved = false;
    if (this.#map) return;
    const element = byId('em-map');
    this.#map = createBase(element);
    this.#reach = createReachOverlay(this.#map);
    this.#obstacles = createObstacleOverlay(this.#map);
    this.#bearings = createBearings(this.#map);
    this.#sites = L.featureGroup().addTo(this.#map);
    for (const type of ['pointerdown', 'wheel', 'keydown']) {
      element.addEventListener(type, () => { this.#isMoved = true; }, { passive: true });
    }
    this.#map.on('moveend', () => this.#source.look(boxOf(this.#map)));
    this.#draw();
  }

  // changes: some of {reach: GeoJSON or null, reachText, from: place, sites: of the cards}
  show(changes) {
    Object.assign(this.#shown, changes);
    if (this.#map) this.#draw();
  }

  #draw() {
    const { reach, from, sites } = this.#shown;
    this.#reach.draw(reach, sites);
    this.#drawKey();
    if (!from) return;
    this.#bearings.draw(from, sites);
    this.#sites.clearLayers();
    sites.forEach(({ touchdown: { latitude_deg, longitude_deg }, verdict, reachable }, i) => this.#sites.addLayer(discMarker(
      [latitude_deg, longitude_deg], `verdict-${reachable === false ? 'rejected' : verdict}`, siteLetter(i), { interactive: false, keyboard: false, zIndexOffset: 1000 - i })));
    this.#fit([from, ...sites.map(({ touchdown }) => touchdown)]);
    this.#source.look(boxOf(this.#map));
  }

  #drawObstacles() {
    this.#obstacles.draw(this.#source.features);
    this.#drawKey();
  }

  #drawKey() {
    byId('em-key').replaceChildren(...reachKey(this.#shown.reach, this.#shown.sites), ...obstacleKey(this.#source.features));
    byId('em-reach').textContent = [this.#shown.reachText, this.#source.note].filter(Boolean).join('. ');
  }

  // The aircraft and its sites matter; the rim of the reach may lie outside.
  #fit(places) {
    if (this.#isMoved) return;
    const bounds = L.latLngBounds(places.map(({ latitude_deg, longitude_deg }) => [latitude_deg, longitude_deg]));
    this.#map.fitBounds(places.length > 1 ? bounds : this.#reach.bounds().extend(bounds), {
      paddingTopLeft: [40, 40], paddingBottomRight: [110, 40], maxZoom: 18, animate: false });
  }
}

export const createEmergencyMap = () => new EmergencyMap();
