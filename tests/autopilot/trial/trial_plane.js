// The aircraft of the trial, and the route that it flies over a survey before its engine stops.

import { Standin } from '../standin/aircraft.js';
import { LocalFrame } from '../standin/frame.js';

const routeHalf_m = 300;
const routeHeights_m = [60, 160];
const numPoints = 12;
const cruise_mps = 15;
const belowLowest_m = 20;

// The aircraft of the profile "small", as its owner measured it: 10 m/s at the best glide.
export const smallAircraft = {
  aircraft: { best_glide_airspeed_mps: 10, stall_airspeed_mps: 7, max_thrust_ratio: 0.6, roll_decay_per_s: 0.67 },
  parameters: {
    AIRSPEED_CRUISE: cruise_mps, AIRSPEED_MIN: 8.5, AIRSPEED_MAX: 20, WP_RADIUS: 30, WP_LOITER_RAD: 40,
    TECS_LAND_ARSPD: 10, LAND_FLARE_ALT: 2, LAND_FLARE_SEC: 1.5,
  },
};

// altimeter: "survey" has the error of the survey, "true" has none. glideRatios: the profile tells 7.
export const defaultTrialOptions = {
  altimeter: 'survey', maxWind_mps: 6, glideRatios: [7.35, 8.4], gust_mps: 0.5,
};

// Home is in the middle of the survey, below the lowest ground.
export function planeOver(survey, { ground, random, seed, altimeter, maxWind_mps, glideRatios, gust_mps }, keys) {
  const home = { ...survey.centre, altitude_m: ground.lowest_m - belowLowest_m };
  const frame = new LocalFrame(home);
  return new Standin({
    seed, home, ground: (east_m, north_m) => ground.altitude_m(frame.toGlobal({ east_m, north_m })),
    wind: { speed_mps: random.between(0, maxWind_mps), from_deg: random.between(0, 360), gust_sd_mps: gust_mps,
      vertical_gust_sd_mps: gust_mps / 2 },
    sensors: { altitude_bias_m: altimeter === 'survey' ? survey.height_error_m : 0 },
    aircraft: { ...smallAircraft.aircraft, max_glide_ratio: random.between(...glideRatios) },
    parameters: smallAircraft.parameters,
  }, keys);
}

export function startRoute(plane, random) {
  const coordinate = () => random.between(-routeHalf_m, routeHalf_m);
  const points = Array.from({ length: numPoints }, () => ({ east_m: coordinate(), north_m: coordinate() }));
  const highest_m = Math.max(...points.map((point) => plane.ground(point.east_m, point.north_m)));
  const altitude_m = highest_m + random.between(...routeHeights_m);
  const items = points.map((point) => {
    const { latitude_deg, longitude_deg } = plane.frame.toGlobal(point);
    return { frame: 0, command: 16, param1: 0, param2: 0, param3: 0, param4: 0,
      x: Math.round(latitude_deg * 1e7), y: Math.round(longitude_deg * 1e7), z: altitude_m };
  });
  plane.loadMission([items[0], ...items]);
  const [first] = points;
  plane.startInFlight({ ...first, height_m: altitude_m - plane.ground(first.east_m, first.north_m),
    heading_deg: random.between(0, 360), airspeed_mps: cruise_mps, mode: 'AUTO' });
}
