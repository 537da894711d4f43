// Local east, north in metres about home, by the radii of WGS84 there.

const semiMajorAxis_m = 6378137;
const eccentricity2 = 6.69437999014e-3;
const radians = (degrees) => (degrees * Math.PI) / 180;

export class LocalFrame {
  #home;
  #east_m_per_deg;
  #north_m_per_deg;

  constructor(home) {
    this.#home = home;
    const sine = Math.sin(radians(home.latitude_deg));
    const root = Math.sqrt(1 - eccentricity2 * sine * sine);
    const prime_m = semiMajorAxis_m / root;
    const meridian_m = (semiMajorAxis_m * (1 - eccentricity2)) / root ** 3;
    this.#north_m_per_deg = radians(meridian_m + home.altitude_m);
    this.#east_m_per_deg = radians(prime_m + home.altitude_m) * Math.cos(radians(home.latitude_deg));
  }

  toLocal({ latitude_deg, longitude_deg }) {
    return {
      east_m: (longitude_deg - this.#home.longitude_deg) * this.#east_m_per_deg,
      north_m: (latitude_deg - this.#home.latitude_deg) * this.#north_m_per_deg,
    };
  }

  toGlobal({ east_m, north_m }) {
    return {
      latitude_deg: this.#home.latitude_deg + north_m / this.#north_m_per_deg,
      longitude_deg: this.#home.longitude_deg + east_m / this.#east_m_per_deg,
    };
  }
}

export const wrapped = (angle_rad) => Math.atan2(Math.sin(angle_rad), Math.cos(angle_rad));
export const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
// Clockwise from north.
export const bearing = (from, to) => Math.atan2(to.east_m - from.east_m, to.north_m - from.north_m);
export const distance = (from, to) => Math.hypot(to.east_m - from.east_m, to.north_m - from.north_m);
export const offset = (from, bearing_rad, distance_m) => ({
  ...from,
  east_m: from.east_m + distance_m * Math.sin(bearing_rad),
  north_m: from.north_m + distance_m * Math.cos(bearing_rad),
});
