// What the map shows over its background, one function for each kind of overlay.
/* global L */

import { outerRings } from './antimeridian.js';
import { gradeColor } from './colors.js';
import { byId, el, svg } from './dom.js';
import { noReturnOf } from './go_around.js';
import { courseTo, isKnown, verdictSign } from './units.js';

const kWideMap = 600;  // px; there a popup leaves the wind barb free, and the open layer box
const kMarker = 44;  // px, a touch target for gloves; the disc in it is smaller

// A light line below the dark one keeps it legible on any layer.
function casedLine(places, kind, suffix) {
  return [
    L.polyline(places, { className: `casing ${kind}-casing`, interactive: false }),
    L.polyline(places, { className: kind + suffix, interactive: false }),
  ];
}

const latLngs = (line) => line.coordinates.map(([lon, lat]) => [lat, lon]);

export function discMarker(place, className, text, options = {}) {
  const disc = document.createElement('span');
  disc.textContent = text;
  return L.marker(place, {
    icon: L.divIcon({ className: `disc-marker ${className}`, html: disc, iconSize: [kMarker, kMarker] }),
    ...options,
  });
}

// What the server looks at now: a dashed outline, dark on bright ground and bright on dark ground.
export function createArea(map) {
  map.createPane('area').style.zIndex = 305;
  const group = L.featureGroup().addTo(map);
  let drawn = 'null';
  return {
    // area: GeoJSON, or null.
    draw(area) {
      const wanted = JSON.stringify(area);
      if (wanted === drawn) return;
      drawn = wanted;
      group.clearLayers();
      if (!area) return;
      for (const className of ['area-casing', 'area']) {
        L.geoJSON(area, { interactive: false, pane: 'area', style: { className, fill: false }, pointToLayer: (_, at) => L.circleMarker(at, { pane: 'area' }) })
          .addTo(group);
      }
    },
  };
}

export function createRegions(map) {
  const group = L.featureGroup().addTo(map);
  return {
    draw(collection) {
      group.clearLayers();
      L.geoJSON(collection, { style: { className: 'region-casing' }, interactive: false }).addTo(group);
      L.geoJSON(collection, {
        bubblingMouseEvents: true,
        style: ({ properties }) => ({
          color: gradeColor(properties.grade),
          fillColor: gradeColor(properties.grade),
          className: `region${properties.is_fixed ? '' : ' growing'}`,
        }),
      }).addTo(group);
    },
    bounds: () => group.getBounds(),
  };
}

// onSite(id) is called when the user selects a marker.
export function createSites(map, onSite) {
  const group = L.featureGroup().addTo(map);

  function markerOf({ properties: p, geometry }, isChosen) {
    const [lon, lat] = geometry.coordinates;
    return discMarker([lat, lon], `verdict-${p.verdict}${isChosen ? ' chosen' : ''}`, p.rank, {
      alt: `Site ${p.rank}, ${p.verdict}`,
      title: `${verdictSign[p.verdict]} ${p.verdict}: ${p.summary}`,
      zIndexOffset: isChosen ? 1000 : -p.rank,
    }).on('click', () => onSite(p.id)).on('keypress', (event) => {
      if (event.originalEvent.key === 'Enter') onSite(p.id);
    });
  }

  return {
    draw(collection, chosenId) {
      group.clearLayers();
      for (const feature of collection.features.filter(({ geometry }) => geometry)) {
        group.addLayer(markerOf(feature, feature.properties.id === chosenId));
      }
    },
    bounds: () => group.getBounds(),
  };
}

// The picture of a layer, in a pane of the ground.
export function createPicture(map) {
  let overlay = null;
  return {
    // url: of a picture in memory; null removes the layer.
    draw(url, layer, opacity) {
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
  };
}

// Points along the direction of flight, in the middle of the final.
function flightArrow({ coordinates: [from, to] }, heading_deg, suffix) {
  const arrow = svg('svg', { viewBox: '-12 -12 24 24', width: 28, height: 28, role: 'img', 'aria-label': 'Direction of flight' },
    svg('path', { d: 'M0 -10L8 8L0 4L-8 8Z', transform: `rotate(${heading_deg})` }));
  return L.marker([(from[1] + to[1]) / 2, (from[0] + to[0]) / 2], {
    icon: L.divIcon({ className: `flight-arrow${suffix}`, html: arrow, iconSize: [28, 28] }), interactive: false, keyboard: false,
  });
}

// The point of the final from which a go-around last clears everything known. distance_m: before the touchdown.
function pointOfNoReturn({ coordinates }, distance_m) {
  const [start, end] = [coordinates[0], coordinates.at(-1)];
  const { distance_m: length_m } = courseTo({ longitude_deg: start[0], latitude_deg: start[1] },
    { longitude_deg: end[0], latitude_deg: end[1] });
  const share = Math.min(1, distance_m / length_m);
  const at = [end[1] + share * (start[1] - end[1]), end[0] + share * (start[0] - end[0])];
  const sign = el('span', {}, el('b', {}, 'R'));
  return L.marker(at, {
    icon: L.divIcon({ className: 'no-return', html: sign, iconSize: [24, 24] }), title: 'Point of no return',
    alt: 'Point of no return', interactive: false, keyboard: false,
  });
}

// Lengths of the final that a climb is drawn over. It may be known to the end of the map, but its beginning is what
// the pilot flies, and a long line would hide the final.
const kDrawnFinals = 2;

function drawnClimb({ coordinates }, final) {
  const place = ([longitude_deg, latitude_deg]) => ({ longitude_deg, latitude_deg });
  const length_m = (line) => courseTo(place(line[0]), place(line.at(-1))).distance_m;
  const [from, to] = [coordinates[0], coordinates.at(-1)];
  const share = Math.min(1, kDrawnFinals * length_m(final.coordinates) / length_m(coordinates));
  return { coordinates: [from, from.map((value, i) => value + share * (to[i] - value))] };
}

// An arrow head at the end of the drawn climb.
function climbArrow({ coordinates }, suffix) {
  const [from, to] = coordinates.slice(-2).map(([longitude_deg, latitude_deg]) => ({ longitude_deg, latitude_deg }));
  const head = svg('svg', { viewBox: '-12 -12 24 24', width: 24, height: 24, 'aria-hidden': 'true' },
    svg('path', { d: 'M0 -9L8 7H-8Z', transform: `rotate(${courseTo(from, to).bearing_deg.toFixed(1)})` }));
  return L.marker([to.latitude_deg, to.longitude_deg], {
    icon: L.divIcon({ className: `climb-arrow${suffix}`, html: head, iconSize: [24, 24] }), interactive: false, keyboard: false,
  });
}

// Final, loiter circle, touchdown disc, ground roll and direction of flight. A replanned path differs in colour, a rejected one is dotted.
export function createApproach(map) {
  const group = L.layerGroup().addTo(map);
  return {
    // Where its small signs stand: the direction of flight, the point of no return.
    signs: () => group.getLayers().filter((layer) => /flight-arrow|no-return/.test(layer.options.icon?.options.className))
      .map((layer) => layer.getLatLng()),
    // collection: GeoJSON of the server; null removes the approach.
    draw(collection, { touchdownRadius_m, isReplanned } = {}) {
      group.clearLayers();
      if (!collection) return;
      const suffix = (isReplanned ? ' replanned' : '') + (collection.verdict === 'rejected' ? ' refused-path' : '');
      // The go-around lies below the final, whose line it continues.
      const final = collection.features.find(({ properties }) => properties.kind === 'approach')?.geometry;
      const goesBelow = ({ properties }) => (properties.kind === 'go_around' ? 0 : 1);
      for (const { properties, geometry } of collection.features.toSorted((a, b) => goesBelow(a) - goesBelow(b))) {
        if (properties.kind === 'touchdown') {
          const [lon, lat] = geometry.coordinates;
          group.addLayer(L.circle([lat, lon], {
            radius: touchdownRadius_m ?? 1, className: 'touchdown', interactive: false,
          }));
        } else if (properties.kind === 'ground_roll') {
          const rings = outerRings(geometry).map((ring) => latLngs({ coordinates: ring }));
          group.addLayer(L.polygon(rings.map((ring) => [ring]), { className: `ground-roll${suffix}`, interactive: false }));
        } else {
          if (properties.kind === 'approach') group.addLayer(flightArrow(geometry, properties.heading_deg, suffix));
          const drawn = properties.kind === 'go_around' && final ? drawnClimb(geometry, final) : geometry;
          if (properties.kind === 'go_around') group.addLayer(climbArrow(drawn, suffix));
          casedLine(latLngs(drawn), properties.kind.replace('_', '-'), suffix).forEach((line) => group.addLayer(line));
        }
      }
      const noReturn_m = noReturnOf(collection);
      if (final && isKnown(noReturn_m)) group.addLayer(pointOfNoReturn(final, noReturn_m));
    },
    bounds() {
      const bounds = L.latLngBounds([]);
      group.eachLayer((layer) => bounds.extend(layer.getBounds?.() ?? layer.getLatLng()));
      return bounds;
    },
  };
}

// Rejected touchdowns and obstacles.
export function createMarks(map) {
  const group = L.layerGroup().addTo(map);
  return {
    // marks: [{place: {latitude_deg, longitude_deg}, sign, className, title}]
    draw(marks) {
      group.clearLayers();
      for (const { place, sign, className, title } of marks) {
        group.addLayer(discMarker([place.latitude_deg, place.longitude_deg], className, sign, { title, alt: title, zIndexOffset: 1500 }));
      }
    },
  };
}

// The wind barb in a corner of the map.
export function createBarb(map) {
  const control = L.control({ position: 'topleft' });
  control.onAdd = () => L.DomUtil.create('div', 'map-barb');
  control.addTo(map);
  return {
    // node: null if the wind is unknown. isTried: a trial wind, not the stored one.
    draw(node, isTried) {
      const box = control.getContainer();
      box.replaceChildren(...(node ? [node] : []));
      box.classList.toggle('tried', isTried);
    },
  };
}

// The popup at a clicked place. Opened by keyboard it takes the focus, and the map gets it back.
export function createAnswer(map) {
  const group = L.layerGroup().addTo(map);
  const element = map.getContainer();
  function leftPadding_px() {
    const box = byId('layer-box');
    if (map.getSize().x <= kWideMap) return 12;
    return box.open && !box.hidden && map.getSize().x > 2.3 * box.offsetWidth ? box.offsetWidth + 24 : 2 * kMarker;
  }
  // What the user unfolds makes the popup grow upwards.
  function keepInView(popup) {
    const above_px = element.getBoundingClientRect().top + 12 - popup.getElement().getBoundingClientRect().top;
    if (above_px > 0) map.panBy([0, -above_px], { animate: false });
  }

  return {
    // content: a DOM node. latlng: null removes the popup.
    draw(latlng, content) {
      group.clearLayers();
      if (!latlng) return;
      element.style.setProperty('--answer-height', `${Math.max(160, element.clientHeight - 90)}px`);
      const popup = L.popup({
        maxWidth: 300, minWidth: 230, className: 'answer-popup',
        autoPanPaddingTopLeft: [leftPadding_px(), 16], autoPanPaddingBottomRight: [map.getSize().x > kWideMap ? kMarker + 28 : 12, 16],
      }).setLatLng(latlng).setContent(content);
      group.addLayer(popup);
      content.addEventListener('toggle', () => keepInView(popup), true);
      content.tabIndex = -1;
      if (document.activeElement === element) content.focus({ preventScroll: true });
    },
    // Returns whether a popup was open.
    close() {
      const isOpen = group.getLayers().some((popup) => popup.isOpen());
      const hadFocus = document.activeElement?.closest('.leaflet-popup');
      group.clearLayers();
      if (hadFocus) element.focus({ preventScroll: true });
      return isOpen;
    },
  };
}

// Lines from the aircraft to the emergency sites.
export function createBearings(map) {
  const group = L.layerGroup().addTo(map);
  return {
    // from: {latitude_deg, longitude_deg}; sites: with a touchdown each, and a path where one was
    // planned. Without a path the straight line to the touchdown is drawn.
    draw(from, sites) {
      group.clearLayers();
      const here = [from.latitude_deg, from.longitude_deg];
      for (const { touchdown, path } of sites) {
        const line = path?.coordinates.map(([longitude, latitude]) => [latitude, longitude])
          ?? [here, [touchdown.latitude_deg, touchdown.longitude_deg]];
        casedLine(line, 'bearing', '').forEach((layer) => group.addLayer(layer));
      }
      group.addLayer(discMarker(here, 'here', '✈', { title: 'Your position', alt: 'Your position' }));
    },
  };
}
