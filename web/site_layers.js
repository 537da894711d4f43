// The layers of one site as pictures, for the layer box: for flights and servers without a map of the whole flight.

import * as api from './api.js';
import { marksUnseen } from './colors.js';

// map.drawLayer(url or null, layer, opacity) draws a picture.
export function createSiteLayers(map, site, list) {
  let url = null;
  return {
    of: site,
    list,
    opacity: 1,
    async show(layer, opacity, signal) {
      const blob = await api.getBlob(api.paths.layerPicture(site, layer.name), signal);
      const former = url;
      url = URL.createObjectURL(blob);
      map.drawLayer(url, layer, opacity);
      URL.revokeObjectURL(former);
    },
    hide() {
      map.drawLayer(null);
      URL.revokeObjectURL(url);
      url = null;
    },
    setOpacity: map.setOpacity,
    // Colours that no legend of the server has: {isBlank: a place without colour shows the ground below, hatchesUnseen: unseen cells are hatched}
    note: ({ name }) => ({ text: marksUnseen(name) ? 'outside map' : 'unseen', isBlank: false }),
    legend: ({ name }, signal) => api.getBlob(api.paths.legend(site, name), signal),
    picturePath: ({ name }) => api.paths.layerPicture(site, name),
    pictureEnding: 'png',
  };
}
