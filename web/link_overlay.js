// Aircraft on the map, where their autopilots say that they are.
/* global L */

import { el } from './dom.js';
import { heardText, linkName, modeText } from './link_shape.js';

export function createLinkOverlay(map) {
  const group = L.layerGroup().addTo(map);

  // Where the aircraft is guided to.
  function drawTarget({ id, position, target, isStale }) {
    if (!target) return;
    const place = [target.latitude_deg, target.longitude_deg];
    const className = `link-target${isStale ? ' stale' : ''}`;
    L.polyline([[position.latitude_deg, position.longitude_deg], place], { className, interactive: false }).addTo(group);
    L.circleMarker(place, { radius: 12, className, interactive: false }).addTo(group)
      .bindTooltip(`${id} to ${target.name}`, { permanent: true, direction: 'right', className: 'link-target-name', offset: [12, 0] });
  }

  return {
    // isStale: it may be elsewhere by now. target: the stored touchdown of the site that it is guided to, if any; the landing itself is planned for the wind.
    draw(links) {
      group.clearLayers();
      for (const link of links.filter(({ position }) => position)) {
        const text = `${linkName(link)}: ${modeText(link)}, ${heardText(link)}`;
        const label = el('span', {}, `${link.isStale ? '? ' : ''}${link.id}`);
        L.marker([link.position.latitude_deg, link.position.longitude_deg], {
          icon: L.divIcon({ className: `link-sign${link.isStale ? ' stale' : ''}`, html: label, iconSize: [18, 18], iconAnchor: [9, 9] }),
          title: text, alt: text, interactive: false, keyboard: false, zIndexOffset: 1500,
        }).addTo(group);
        drawTarget(link);
      }
    },
  };
}
