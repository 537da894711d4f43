// What emergency recall is asked: from the present state, in a wind that is held. Pure.

// Sites are planned for the wind. An estimate that wanders would move their finals all the time.
const held_mps = 1.5;
// A wind in the query is one of now. The service knows how old the flight's wind is: it takes an older one from there.
const maxWindAge_s = 600;

const isOld = (wind) => !(wind.age_s <= maxWindAge_s);

export class WindHold {
  #wind;

  // onChange(sentence): called when another wind is taken.
  take(wind, onChange = () => {}) {
    if (!wind) return undefined;
    if (isOld(wind)) return wind;
    const held = this.#wind;
    if (held && Math.hypot(wind.east_mps - held.east_mps, wind.north_mps - held.north_mps) < held_mps) {
      held.age_s = wind.age_s;
      return held;
    }
    if (held) onChange(`the wind is now ${Math.hypot(wind.east_mps, wind.north_mps).toFixed(1)} m/s: ways are planned for it`);
    this.#wind = { east_mps: wind.east_mps, north_mps: wind.north_mps, age_s: wind.age_s };
    return this.#wind;
  }
}

// As the service has it by default.
const clearance_m = 10;

const rounded = (value, digits) => Number(value.toFixed(digits));

// airspeed_m: height that surplus airspeed is worth. better_m: height that will not be lost,
// because the aircraft glides better than told. lower_m: how far the way is flown below the told one;
// the position has it already. The aircraft is not there, so terrain must stay as much lower.
// touchdownUncertainty_m: so far from the told touchdown the autopilot comes down.
export function queryOf({ position, velocity, flight }, wind,
  { airspeed_m = 0, better_m = 0, lower_m = 0, touchdownUncertainty_m = 0 } = {}) {
  const course_deg = (Math.atan2(velocity.east_mps, velocity.north_mps) * 180) / Math.PI;
  const query = {
    latitude_deg: rounded(position.latitude_deg, 7),
    longitude_deg: rounded(position.longitude_deg, 7),
    altitude_m: rounded(position.altitude_m + airspeed_m + better_m, 2),
    altitude_datum: position.altitude_datum,
    heading_deg: rounded(course_deg, 1),
    limit: 10,
  };
  if (wind && !isOld(wind)) Object.assign(query, { wind_east_mps: rounded(wind.east_mps, 2), wind_north_mps: rounded(wind.north_mps, 2) });
  const missing_m = Math.max(0, airspeed_m + better_m + lower_m);
  if (missing_m > 0) query.terrain_clearance_m = rounded(clearance_m + missing_m, 1);
  if (touchdownUncertainty_m > 0) query.touchdown_uncertainty_m = touchdownUncertainty_m;
  if (flight?.id) query.flight = flight.id;
  return query;
}
