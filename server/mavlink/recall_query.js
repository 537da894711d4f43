// What emergency recall is asked: from the present state, in a wind that is held. Pure.

// Sites are planned for the wind. An estimate that wanders would move their finals all the time.
const held_mps = 1.5;

export class WindHold {
  #wind;

  // onChange(sentence): called when another wind is taken.
  take(wind, onChange = () => {}) {
    if (!wind) return this.#wind;
    const held = this.#wind;
    if (held && Math.hypot(wind.east_mps - held.east_mps, wind.north_mps - held.north_mps) < held_mps) return held;
    if (held) onChange(`the wind is now ${Math.hypot(wind.east_mps, wind.north_mps).toFixed(1)} m/s: ways are planned for it`);
    this.#wind = { east_mps: wind.east_mps, north_mps: wind.north_mps };
    return this.#wind;
  }
}

const rounded = (value, digits) => Number(value.toFixed(digits));

// more_m: height that surplus airspeed is worth.
export function queryOf({ position, velocity, flight }, wind, more_m = 0) {
  const course_deg = (Math.atan2(velocity.east_mps, velocity.north_mps) * 180) / Math.PI;
  const query = {
    latitude_deg: rounded(position.latitude_deg, 7),
    longitude_deg: rounded(position.longitude_deg, 7),
    altitude_m: rounded(position.altitude_m + more_m, 2),
    altitude_datum: position.altitude_datum,
    heading_deg: rounded(course_deg, 1),
    limit: 5,
  };
  if (wind) Object.assign(query, { wind_east_mps: rounded(wind.east_mps, 2), wind_north_mps: rounded(wind.north_mps, 2) });
  if (flight?.id) query.flight = flight.id;
  return query;
}
