// Aircraft on the map, where their autopilots say that they are.
/* global L */

import { el } from './dom.js';
import { heardText, linkName, modeText } from './link_shape.js';

export function createLinkOverlay(map) {
  const group = L.layerGroup().addTo(map);
  return {
    // isStale: it may be elsewhere by now.
    draw(links) {
      group.clearLayers();
      for (const link of links.filter(({ position }) => position)) {
        const text = `${linkName(link)}: ${modeText(link)}, ${heardText(link)}`;
        const label = el('span', {}, `${link.isStale ? '? ' : ''}${link.id}`);
        L.marker([link.position.latitude_deg, link.position.longitude_deg], {
          icon: L.divIcon({ className: `link-sign${link.isStale ? ' stale' : ''}`, html: label, iconSize: [18, 18], iconAnchor: [9, 9] }),
          title: text, alt: text, interactive: false, keyboard: false, zIndexOffset: 1500,
        }).addTo(group);
      }
    },
  };
}
