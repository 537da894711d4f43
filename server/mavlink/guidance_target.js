// Where an aircraft without power is sent next. Pure.
//
// An autopilot that holds a height without an engine pays with airspeed until it stalls. So a
// target never lies above the aircraft. Above the told way, the autopilot is asked for the way's
// height: what it has too much of becomes airspeed and drag. Below the way, or too slow, it is
// asked for its own height: then its energy balance trades height for the airspeed of the glide.

const gravity_mps2 = 9.81;

export const defaultTargetOptions = {
  // The autopilot aims at a point so far ahead on the way, in seconds, and at least in metres.
  ahead_s: 2.5,
  minAhead_m: 18,
  // Circled if the program falls silent. It is as small as an autopilot takes it, because an
  // autopilot inside the circle would fly away from the target.
  radius_m: 5,
  // The height is that of the way so much later: half the time between targets, and the link's.
  lead_s: 0.4,
  // Height is given away for airspeed up to this share of the glide airspeed. More of it only
  // shortly before the final, where a longer way can no longer lose the height.
  maxAirspeed_ratio: 1.1,
  maxLastAirspeed_ratio: 1.25,
  last_s: 6,
};

// Height that the airspeed is worth, above the glide airspeed.
export const kinetic_m = (airspeed_mps, glide_mps) =>
  (airspeed_mps ** 2 - glide_mps ** 2) / (2 * gravity_mps2);

export const glideAirspeed_mps = ({ aircraft }) =>
  aircraft.glide_airspeed_mps ?? aircraft.landing_airspeed_mps;

// progress: ToldWay.nearest(). state: { position, airspeed_mps, ground_speed_mps }.
export function targetOn(way, progress, state, options = defaultTargetOptions) {
  const ahead_m = Math.max(options.minAhead_m, options.ahead_s * state.ground_speed_mps);
  const aim = way.at(progress.along_m + ahead_m);
  return {
    latitude_deg: aim.latitude_deg, longitude_deg: aim.longitude_deg,
    altitude_m: height_m(way, progress, state, options), radius_m: options.radius_m,
  };
}

// The autopilot's balance counts airspeed above the glide as height. So the demand lies lower by
// what the airspeed is worth: it follows the way's height at any airspeed up to the limit.
function height_m(way, progress, state, options) {
  const glide_mps = glideAirspeed_mps(way.site);
  const now_m = state.position.altitude_m;
  const soon = way.at(progress.along_m + options.lead_s * state.ground_speed_mps);
  const isLast = way.timeToFinal_s(progress.along_m) < options.last_s;
  const ratio = isLast ? options.maxLastAirspeed_ratio : options.maxAirspeed_ratio;
  const faster_m = Math.max(0, kinetic_m(state.airspeed_mps ?? glide_mps, glide_mps));
  const lowest_m = now_m - kinetic_m(ratio * glide_mps, glide_mps);
  return Math.max(lowest_m, Math.min(soon.altitude_m, now_m) - faster_m);
}
