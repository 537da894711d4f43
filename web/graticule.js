// Lines of latitude and longitude at a round spacing. They replace map tiles, which need a network.
/* global L */

const style = { weight: 1, interactive: false, className: 'graticule', pane: 'graticule' };

export const Graticule = L.LayerGroup.extend({
  onAdd(map) {
    (map.getPane('graticule') ?? map.createPane('graticule')).style.zIndex = 190;  // below the ground
    L.LayerGroup.prototype.onAdd.call(this, map);
    map.on('moveend', this.redraw, this);
    this.redraw();
  },
  onRemove(map) {
    map.off('moveend', this.redraw, this);
    L.LayerGroup.prototype.onRemove.call(this, map);
  },
  redraw() {
    this.clearLayers();
    const bounds = this._map.getBounds().pad(0.2);
    const wanted = (bounds.getEast() - bounds.getWest()) / 8;
    const power = 10 ** Math.floor(Math.log10(wanted));
    const step = [1, 2, 5, 10].map((n) => n * power).find((n) => n >= wanted);
    const [south, west] = [bounds.getSouth(), bounds.getWest()];
    const [north, east] = [bounds.getNorth(), bounds.getEast()];
    for (let lon = Math.ceil(west / step) * step; lon < east; lon += step) {
      this.addLayer(L.polyline([[south, lon], [north, lon]], style));
    }
    for (let lat = Math.ceil(south / step) * step; lat < north; lat += step) {
      this.addLayer(L.polyline([[lat, west], [lat, east]], style));
    }
  },
});
