// The map: the flight's track, regions by grade, sites by rank, the chosen site's layer, approach and circle.
/* global L */

import { gradeColor } from './colors.js';
import { Graticule } from './graticule.js';
import { createTrack } from './track.js';
import { verdictSign } from './units.js';

const kMarker = 44;  // px, for gloves; the disc drawn in it is smaller

// Two lines on each other: a light one below keeps the dark one legible on any layer.
function casedLine(places, kind, suffix) {
  return [
    L.polyline(places, { className: `casing ${kind}-casing`, interactive: false }),
    L.polyline(places, { className: kind + suffix, interactive: false }),
  ];
}

const latLngs = (line) => line.coordinates.map(([lon, lat]) => [lat, lon]);

function discMarker(place, className, text, options = {}) {
  const disc = document.createElement('span');
  disc.textContent = text;
  return L.marker(place, {
    icon: L.divIcon({ className: `disc-marker ${className}`, html: disc, iconSize: [kMarker, kMarker] }),
    ...options,
  });
}

// on: {site(id), place(latlng)}
export function createMap(element, on) {
  const isCalm = matchMedia('(prefers-reduced-motion: reduce)').matches;
  const map = L.map(element, {
    maxZoom: 23, zoomSnap: 0.25, attributionControl: false, zoomControl: false,
    zoomAnimation: !isCalm, fadeAnimation: !isCalm, markerZoomAnimation: !isCalm,
  });
  map.setView([0, 0], 2);
  L.control.zoom({ position: 'topright' }).addTo(map);
  L.control.scale({ imperial: false, position: 'bottomright', maxWidth: 140 }).addTo(map);
  const barb = L.control({ position: 'topleft' });
  barb.onAdd = () => L.DomUtil.create('div', 'map-barb');
  barb.addTo(map);
  map.createPane('layers').style.zIndex = 250;
  new Graticule().addTo(map);
  const track = createTrack(map);
  const regions = L.layerGroup().addTo(map);
  const path = L.layerGroup().addTo(map);
  const sites = L.layerGroup().addTo(map);
  const marks = L.layerGroup().addTo(map);
  const asked = L.layerGroup().addTo(map);
  let overlay = null;
  let bearings = [];
  // By a person: from then on the map stays where it is.
  let isMoved = false;

  for (const type of ['pointerdown', 'wheel', 'keydown']) {
    element.addEventListener(type, () => { isMoved = true; }, { passive: true });
  }
  map.on('click', (event) => on.place(event.latlng));
  new ResizeObserver(() => map.invalidateSize({ animate: false })).observe(element);

  // Room is left for what lies over the map's lower edge.
  const fitTo = (bounds) => {
    if (bounds.isValid()) {
      map.fitBounds(bounds, { paddingTopLeft: [28, 28], paddingBottomRight: [28, 64], maxZoom: 20 });
    }
  };

  return {
    drawTrack(collection) {
      track.draw(collection);
      if (!collection) isMoved = false;
    },

    drawRegions(collection) {
      regions.clearLayers();
      L.geoJSON(collection, { style: { className: 'region-casing' }, interactive: false }).addTo(regions);
      L.geoJSON(collection, {
        bubblingMouseEvents: true,
        style: ({ properties }) => ({
          color: gradeColor(properties.grade),
          fillColor: gradeColor(properties.grade),
          className: `region${properties.is_fixed ? '' : ' growing'}`,
        }),
      }).addTo(regions);
    },

    drawSites(collection, chosenId) {
      sites.clearLayers();
      for (const { properties: p, geometry } of collection.features) {
        if (!geometry) continue;
        const [lon, lat] = geometry.coordinates;
        discMarker([lat, lon], `verdict-${p.verdict}${p.id === chosenId ? ' chosen' : ''}`, p.rank, {
          alt: `Site ${p.rank}, ${p.verdict}`,
          title: `${verdictSign[p.verdict]} ${p.verdict}: ${p.summary}`,
          zIndexOffset: p.id === chosenId ? 1000 : -p.rank,
        }).on('click', () => on.site(p.id)).on('keypress', (event) => {
          if (event.originalEvent.key === 'Enter') on.site(p.id);
        }).addTo(sites);
      }
    },

    fit() {
      const group = L.featureGroup([...regions.getLayers(), ...sites.getLayers()]);
      fitTo(group.getBounds().extend(track.bounds()));
    },

    fitUnlessMoved() { if (!isMoved) this.fit(); },

    // url: of a picture that is already here; null takes the layer away.
    drawLayer(url, layer, opacity) {
      overlay?.remove();
      overlay = null;
      if (!url) return;
      const [west, south, east, north] = layer.bounds;
      overlay = L.imageOverlay(url, [[south, west], [north, east]], {
        opacity, pane: 'layers', className: 'site-layer', alt: `Layer ${layer.name}`,
      }).addTo(map);
      overlay.getElement().dataset.layer = layer.name;
    },

    setOpacity(opacity) { overlay?.setOpacity(opacity); },

    // A path for another wind (isReplanned) looks other than the stored one; a rejected one is dotted.
    drawApproach(collection, { touchdownRadius_m, isReplanned } = {}) {
      path.clearLayers();
      if (!collection) return;
      const suffix = (isReplanned ? ' replanned' : '') + (collection.verdict === 'rejected' ? ' refused-path' : '');
      for (const { properties, geometry } of collection.features) {
        if (properties.kind === 'touchdown') {
          const [lon, lat] = geometry.coordinates;
          L.circle([lat, lon], {
            radius: touchdownRadius_m ?? 1, className: 'touchdown', interactive: false,
          }).addTo(path);
        } else {
          casedLine(latLngs(geometry), properties.kind, suffix).forEach((line) => line.addTo(path));
        }
      }
    },

    fitApproach() {
      const bounds = L.latLngBounds([]);
      path.eachLayer((layer) => bounds.extend(layer.getBounds()));
      fitTo(bounds.isValid() ? bounds.pad(0.1) : bounds);
    },

    // marks: [{place: {latitude_deg, longitude_deg}, sign, className, title}]
    drawMarks(list) {
      marks.clearLayers();
      for (const { place, sign, className, title } of list) {
        discMarker([place.latitude_deg, place.longitude_deg], className, sign, { title, alt: title })
          .addTo(marks);
      }
    },

    // A wind barb over the map, null where no wind is known; isTried: another than the stored one.
    drawWind(node, isTried) {
      const box = barb.getContainer();
      box.replaceChildren(...(node ? [node] : []));
      box.classList.toggle('tried', isTried);
    },

    panTo: ({ latitude_deg, longitude_deg }) => map.panTo([latitude_deg, longitude_deg]),

    center: () => {
      const { lat, lng } = map.getCenter();
      return { latitude_deg: lat, longitude_deg: lng };
    },

    // A popup with what is known of a place; content is a DOM node.
    drawAnswer(latlng, content) {
      asked.clearLayers();
      if (!latlng) return;
      L.popup({
        maxWidth: 300, minWidth: 230, maxHeight: Math.max(160, element.clientHeight - 90),
        autoPanPaddingTopLeft: [16, 16], autoPanPaddingBottomRight: [kMarker + 28, 16],
      })
        .setLatLng(latlng).setContent(content).addTo(asked);
    },

    // Whether there was one.
    closeAnswer() {
      const isOpen = asked.getLayers().some((popup) => popup.isOpen());
      asked.clearLayers();
      return isOpen;
    },

    // Lines from here to the sites in reach, for emergencies.
    drawBearings(from, sitesInReach) {
      bearings.forEach((layer) => layer.remove());
      bearings = [];
      if (!from) return;
      const here = [from.latitude_deg, from.longitude_deg];
      for (const { touchdown } of sitesInReach) {
        bearings.push(L.polyline([here, [touchdown.latitude_deg, touchdown.longitude_deg]],
          { className: 'bearing', interactive: false }).addTo(map));
      }
      bearings.push(discMarker(here, 'here', '✈', { title: 'You', alt: 'You' }).addTo(map));
    },
  };
}
