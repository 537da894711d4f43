// East and north in metres about a place, by the radii of WGS84 there. Good for some kilometres.

import { nearTo, wrapped } from './antimeridian.js';

// Of latitude, on a sphere: where a few metres in a kilometre do not matter.
export const metresPerDegree = 111_195;

const semiMajorAxis_m = 6378137;
const eccentricity2 = 6.69437999014e-3;
const radians = (degrees) => (degrees * Math.PI) / 180;

export class FlatFrame {
  #origin;
  #east_m_per_deg;
  #north_m_per_deg;

  constructor(origin) {
    this.#origin = origin;
    const latitude_rad = radians(origin.latitude_deg);
    const flattened = 1 - eccentricity2 * Math.sin(latitude_rad) ** 2;
    const altitude_m = origin.altitude_m ?? 0;
    const prime_m = semiMajorAxis_m / Math.sqrt(flattened) + altitude_m;
    const meridian_m = (semiMajorAxis_m * (1 - eccentricity2)) / flattened ** 1.5 + altitude_m;
    this.#east_m_per_deg = radians(prime_m) * Math.cos(latitude_rad);
    this.#north_m_per_deg = radians(meridian_m);
  }

  toLocal({ latitude_deg, longitude_deg }) {
    return {
      east_m: (nearTo(longitude_deg, this.#origin.longitude_deg) - this.#origin.longitude_deg) * this.#east_m_per_deg,
      north_m: (latitude_deg - this.#origin.latitude_deg) * this.#north_m_per_deg,
    };
  }

  toGlobal({ east_m, north_m }) {
    return {
      latitude_deg: this.#origin.latitude_deg + north_m / this.#north_m_per_deg,
      longitude_deg: wrapped(this.#origin.longitude_deg + east_m / this.#east_m_per_deg),
    };
  }
}

// Across the ground, from anywhere to anywhere near it.
export function distance_m(a, b) {
  const north_m = (b.latitude_deg - a.latitude_deg) * metresPerDegree;
  const east_deg = wrapped(b.longitude_deg - a.longitude_deg);
  return Math.hypot(north_m, east_deg * metresPerDegree * Math.cos(radians(a.latitude_deg)));
}
