// Finds the region at a place.

import { outerRings } from './antimeridian.js';

// Even-odd rule on the outer ring.
function isInside(ring, { lat, lng }) {
  let inside = false;
  for (let i = 0, j = ring.length - 1; i < ring.length; j = i++) {
    const [xi, yi] = ring[i];
    const [xj, yj] = ring[j];
    if ((yi > lat) !== (yj > lat) && lng < (xj - xi) * (lat - yi) / (yj - yi) + xi) inside = !inside;
  }
  return inside;
}

// The smallest region at a place: a small region may lie within a large one.
export function findRegion(collection, latlng) {
  const here = collection.features.filter(({ geometry }) =>
    geometry && outerRings(geometry).some((ring) => isInside(ring, latlng)));
  here.sort((a, b) => a.properties.area_m2 - b.properties.area_m2);
  return here[0] ?? null;
}
