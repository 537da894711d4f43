// The map: regions by grade, sites by rank, the chosen site's layer and approach.
/* global L */

import { gradeColor, verdictColor } from './colors.js';

// Lines of latitude and longitude at a round spacing: there is no other background without network.
const Graticule = L.LayerGroup.extend({
  onAdd(map) {
    L.LayerGroup.prototype.onAdd.call(this, map);
    map.on('moveend', this.redraw, this);
    this.redraw();
  },
  redraw() {
    const map = this._map;
    this.clearLayers();
    const bounds = map.getBounds().pad(0.2);
    const wanted = (bounds.getEast() - bounds.getWest()) / 8;
    const power = 10 ** Math.floor(Math.log10(wanted));
    const step = [1, 2, 5, 10].map((n) => n * power).find((n) => n >= wanted);
    const style = { color: '#8a949e', weight: 0.5, interactive: false };
    for (let lon = Math.ceil(bounds.getWest() / step) * step; lon < bounds.getEast(); lon += step) {
      this.addLayer(L.polyline([[bounds.getSouth(), lon], [bounds.getNorth(), lon]], style));
    }
    for (let lat = Math.ceil(bounds.getSouth() / step) * step; lat < bounds.getNorth(); lat += step) {
      this.addLayer(L.polyline([[lat, bounds.getWest()], [lat, bounds.getEast()]], style));
    }
  },
});

export function createMap(element, onSite) {
  const map = L.map(element, { maxZoom: 23, zoomSnap: 0.25, attributionControl: false });
  map.setView([0, 0], 2);
  L.control.scale({ imperial: false }).addTo(map);
  new Graticule().addTo(map);
  const regions = L.layerGroup().addTo(map);
  const sites = L.layerGroup().addTo(map);
  const chosen = L.layerGroup().addTo(map);
  let overlay = null;

  return {
    drawRegions(collection) {
      regions.clearLayers();
      L.geoJSON(collection, {
        style: (feature) => ({
          color: '#333',
          weight: 1,
          dashArray: feature.properties.is_fixed ? null : '4 4',
          fillColor: gradeColor(feature.properties.grade),
          fillOpacity: 0.35,
          className: 'region',
        }),
        onEachFeature: (feature, layer) => {
          const p = feature.properties;
          layer.bindTooltip(`Region ${p.id}: grade ${p.grade.toFixed(2)}, grass ` +
            `${p.num_grass_observations} of ${p.num_observations}, ${Math.round(p.area_m2)} m²`);
        },
      }).addTo(regions);
    },

    drawSites(collection) {
      sites.clearLayers();
      for (const feature of collection.features) {
        const [lon, lat] = feature.geometry.coordinates;
        const icon = L.divIcon({
          className: 'rank-marker',
          html: String(feature.properties.rank),
          iconSize: [26, 26],
        });
        const marker = L.marker([lat, lon], {
          icon,
          title: feature.properties.summary,
          alt: `Site of rank ${feature.properties.rank}`,
        });
        marker.on('click', () => onSite(feature.properties.id));
        marker.on('add', () => {
          marker.getElement()?.style.setProperty(
            '--verdict', verdictColor[feature.properties.verdict]);
        });
        marker.addTo(sites);
      }
    },

    // [west, south, east, north] of everything drawn; the view moves there.
    fit() {
      const group = L.featureGroup([...regions.getLayers(), ...sites.getLayers()]);
      const bounds = group.getBounds();
      if (bounds.isValid()) map.fitBounds(bounds.pad(0.15));
    },

    drawLayer(url, layer, opacity) {
      overlay?.remove();
      overlay = null;
      if (!layer) return;
      const [west, south, east, north] = layer.bounds;
      overlay = L.imageOverlay(url, [[south, west], [north, east]], {
        opacity,
        className: 'site-layer',
        alt: `${layer.name} layer`,
      }).addTo(map);
      overlay.bringToBack?.();
    },

    setOpacity(opacity) {
      overlay?.setOpacity(opacity);
    },

    drawApproach(collection) {
      chosen.clearLayers();
      if (!collection) return;
      L.geoJSON(collection, {
        style: (feature) => ({
          color: feature.properties.kind === 'loiter' ? '#7a0177' : '#d7191c',
          weight: 3,
          fill: false,
          dashArray: feature.properties.kind === 'loiter' ? '6 6' : null,
          className: feature.properties.kind,
        }),
        pointToLayer: (feature, place) =>
          L.circleMarker(place, { radius: 6, color: '#d7191c', fillOpacity: 1, className: 'touchdown' }),
      }).addTo(chosen);
      const bounds = L.featureGroup(chosen.getLayers()).getBounds();
      if (bounds.isValid()) map.fitBounds(bounds.pad(0.2));
    },
  };
}
