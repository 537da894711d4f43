// Bank for a leg, a circle or a course, by the velocity over ground.

import { bearing, clamp, distance, wrapped } from './frame.js';

const gravity_mps2 = 9.81;
const radians = (degrees) => (degrees * Math.PI) / 180;
const damping = 0.75;
const courseGain_per_s = 0.9;
// How soon a circle is met: of the angle between the way to the centre and the tangent.
const circleGain = 2.5;

const courseOf = ({ east_mps, north_mps }) => Math.atan2(east_mps, north_mps);
const speedOf = ({ east_mps, north_mps }) => Math.max(3, Math.hypot(east_mps, north_mps));
const bankFor = (acceleration_mps2) => Math.atan(acceleration_mps2 / gravity_mps2);

// Lateral error: right of the leg is positive. share: 0 at the start, 1 at the end.
export function onLeg(place, from, to) {
  const length_m = Math.max(0.1, distance(from, to));
  const east = (to.east_m - from.east_m) / length_m;
  const north = (to.north_m - from.north_m) / length_m;
  const x = place.east_m - from.east_m;
  const y = place.north_m - from.north_m;
  return { along_m: x * east + y * north, right_m: x * north - y * east, length_m,
    share: (x * east + y * north) / length_m };
}

// A point on the leg some way ahead is aimed at (L1 guidance, Park et al. 2004).
export function bankForLeg(place, velocity, from, to, period_s) {
  const speed_mps = speedOf(velocity);
  const ahead_m = (damping * period_s * speed_mps) / Math.PI;
  if (distance(from, to) < 1) return bankForPoint(place, velocity, to, ahead_m);
  const { right_m } = onLeg(place, from, to);
  const intercept_rad = Math.asin(clamp(right_m / ahead_m, -0.8, 0.8));
  const aim_rad = bearing(from, to) - intercept_rad;
  return bankForAim(velocity, aim_rad, ahead_m);
}

function bankForPoint(place, velocity, to, ahead_m) {
  return bankForAim(velocity, bearing(place, to), Math.max(10, Math.min(ahead_m, distance(place, to))));
}

function bankForAim(velocity, aim_rad, ahead_m) {
  const error_rad = clamp(wrapped(aim_rad - courseOf(velocity)), -Math.PI / 2, Math.PI / 2);
  return bankFor((4 * damping ** 2 * speedOf(velocity) ** 2 * Math.sin(error_rad)) / ahead_m);
}

// direction: 1 clockwise, -1 counter-clockwise.
export function bankForCircle(place, velocity, centre, radius_m, direction) {
  const distance_m = distance(place, centre);
  const outside = (distance_m - radius_m) / radius_m;
  const tangent_rad = Math.PI / 2 - Math.atan(circleGain * outside);
  const course_rad = bearing(place, centre) - direction * tangent_rad;
  const error_rad = wrapped(course_rad - courseOf(velocity));
  const speed_mps = speedOf(velocity);
  const isNear = Math.abs(outside) < 0.5 && Math.abs(error_rad) < radians(60);
  const steady_mps2 = isNear ? (direction * speed_mps ** 2) / radius_m : 0;
  return bankFor(steady_mps2 + speed_mps * courseGain_per_s * error_rad);
}

// At low airspeed the wing does not carry more than level flight needs.
export function bankLimit_rad(airspeed_mps, { AIRSPEED_MIN, ROLL_LIMIT_DEG }) {
  const load = Math.max(1, airspeed_mps / AIRSPEED_MIN);
  const byWing_rad = Math.max(radians(25), Math.acos(clamp(1 / load ** 2, 0, 1)));
  return Math.min(radians(ROLL_LIMIT_DEG), byWing_rad);
}
