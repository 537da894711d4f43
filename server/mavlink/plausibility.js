// Refuses positions and attitudes that no small plane can have.

import { distance_m } from './flat_frame.js';

// An aircraft flies 50 m and more in this time: what was heard before it is not known any more.
export const longestGap_s = 3;
export const isPlaceKnown = ({ position }) => position !== undefined && !(position.age_s > longestGap_s);

const minAltitude_m = -500;
const maxAltitude_m = 12_000;
// Ground speed of a small plane in a storm.
const maxSpeed_mps = 150;
const slack_m = 50;
// A jump is believed when the aircraft stays there: its navigation was wrong before.
const jumpIsTrueAfter_s = 5;

const apart_m = (a, b) => Math.hypot(distance_m(a, b), a.altitude_m - b.altitude_m);

function isPlace({ latitude_deg, longitude_deg, altitude_m }) {
  // Before the first fix autopilots send 0, 0 or what their filter drifts to from there.
  const isNowhere = Math.abs(latitude_deg) < 0.01 && Math.abs(longitude_deg) < 0.01;
  return !isNowhere && Math.abs(latitude_deg) <= 90 && Math.abs(longitude_deg) <= 180 &&
    altitude_m >= minAltitude_m && altitude_m <= maxAltitude_m;
}

const follows = (next, last) =>
  apart_m(next, last) <= slack_m + maxSpeed_mps * Math.abs(next.time_s - last.time_s);

export class PositionGate {
  #last;
  #jumpStart;
  #jumpLast;

  // Why the position is refused; nothing if it is believed. place: latitude_deg, longitude_deg,
  // altitude_m, time_s.
  refusal(place) {
    if (!isPlace(place)) return 'absurd_position';
    if (!this.#last || follows(place, this.#last)) return this.#believe(place);
    if (!this.#jumpLast || !follows(place, this.#jumpLast)) this.#jumpStart = place;
    this.#jumpLast = place;
    if (place.time_s - this.#jumpStart.time_s >= jumpIsTrueAfter_s) return this.#believe(place);
    return 'position_jump';
  }

  restart() { this.#last = undefined; }

  #believe(place) {
    this.#last = place;
    this.#jumpStart = undefined;
    this.#jumpLast = undefined;
    return undefined;
  }
}

export const isAttitude = ({ roll, pitch, yaw }) =>
  [roll, pitch, yaw].every(Number.isFinite) && Math.abs(roll) <= 3.2 &&
  Math.abs(pitch) <= 1.6 && Math.abs(yaw) <= 6.4;
