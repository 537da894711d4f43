// The flying body: a point mass with a drag polar, thrust, bank and flight path.

import { clamp, wrapped } from './frame.js';

const gravity_mps2 = 9.81;
const radians = (degrees) => (degrees * Math.PI) / 180;
// Sideslip from a gust decays in this time.
const slip_s = 0.5;
const stallPath_rad = radians(-25);

const equivalentShare = (altitude_m) => (1 - 2.25577e-5 * altitude_m) ** 2.128;

export class Body {
  #options;
  #wind = { east_mps: 0, north_mps: 0, up_mps: 0 };
  #slip_mps = 0;
  #thrust_ratio = 0;
  #throttle = 0;
  east_m = 0;
  north_m = 0;
  altitude_m = 0;
  airspeed_mps = 0;
  heading_rad = 0;
  bank_rad = 0;
  path_rad = 0;
  // Of the airspeed along the heading.
  acceleration_mps2 = 0;
  isOnGround = true;
  isEngineStopped = false;
  isBroken = false;

  constructor(options) { this.#options = options; }

  // The airspeed that the wing and the sensor feel: equivalent airspeed in the standard atmosphere.
  // airspeed_mps is the true one.
  get indicated_mps() { return this.airspeed_mps * equivalentShare(this.altitude_m); }

  get throttle() { return this.#throttle; }
  // Of full power; 0 with a stopped engine.
  get power_ratio() { return this.#thrust_ratio / this.#options.max_thrust_ratio; }
  get climb_mps() {
    return this.isOnGround ? 0 : this.airspeed_mps * Math.sin(this.path_rad) + this.#wind.up_mps;
  }

  get velocity() {
    const air_mps = this.airspeed_mps * Math.cos(this.path_rad);
    const sine = Math.sin(this.heading_rad);
    const cosine = Math.cos(this.heading_rad);
    // On the ground the wheels take the wind.
    const wind = this.isOnGround ? { east_mps: 0, north_mps: 0 } : this.#wind;
    return {
      east_mps: air_mps * sine + this.#slip_mps * cosine + wind.east_mps,
      north_mps: air_mps * cosine - this.#slip_mps * sine + wind.north_mps,
    };
  }

  // Drag by weight; load: lift by weight.
  drag_ratio(load = 1, airspeed_mps = this.indicated_mps) {
    const { max_glide_ratio, best_glide_airspeed_mps } = this.#options;
    const share = Math.max(1, airspeed_mps) / best_glide_airspeed_mps;
    return (share ** 2 + (load / share) ** 2) / (2 * max_glide_ratio);
  }

  get load() { return Math.cos(this.path_rad) / Math.max(0.2, Math.cos(this.bank_rad)); }

  get pitch_rad() {
    if (this.isOnGround) return 0;
    const attack_deg = -4.1 + 5.6 * (10 / Math.max(5, this.indicated_mps)) ** 2 * this.load;
    return this.path_rad + radians(attack_deg);
  }

  // demand: bank_rad, path_rad, throttle (0 to 1).
  step(duration_s, demand, wind) {
    this.#followThrottle(duration_s, demand.throttle);
    if (this.isOnGround) this.#roll(duration_s, demand);
    else this.#fly(duration_s, demand, wind);
    const { east_mps, north_mps } = this.velocity;
    this.east_m += east_mps * duration_s;
    this.north_m += north_mps * duration_s;
    this.altitude_m += this.climb_mps * duration_s;
    this.#wind = wind;
  }

  // Puts it into the air, or somewhere else.
  place(state, wind = this.#wind) {
    Object.assign(this, state);
    this.#wind = wind;
    this.#slip_mps = 0;
  }

  touchDown(altitude_m) {
    const { east_mps, north_mps } = this.velocity;
    this.heading_rad = Math.atan2(east_mps, north_mps);
    this.airspeed_mps = Math.hypot(east_mps, north_mps);
    Object.assign(this, { isOnGround: true, altitude_m, path_rad: 0, bank_rad: 0 });
    this.#slip_mps = 0;
  }

  #followThrottle(duration_s, throttle) {
    const { max_throttle_rate_per_s: rate, thrust_lag_s, max_thrust_ratio } = this.#options;
    this.#throttle += clamp(throttle - this.#throttle, -rate * duration_s, rate * duration_s);
    const demanded = this.isEngineStopped || this.isBroken ? 0 : this.#throttle * max_thrust_ratio;
    const lag_s = this.isEngineStopped ? 0.05 : thrust_lag_s;
    this.#thrust_ratio += (demanded - this.#thrust_ratio) * Math.min(1, duration_s / lag_s);
  }

  #fly(duration_s, demand, wind) {
    const options = this.#options;
    const rate = radians(options.max_bank_rate_deg_s);
    const bankRate = clamp((demand.bank_rad - this.bank_rad) / options.bank_lag_s, -rate, rate);
    this.bank_rad += bankRate * duration_s;
    const isStalled = this.indicated_mps < options.stall_airspeed_mps * Math.sqrt(this.load);
    const path_rad = isStalled ? Math.min(demand.path_rad, stallPath_rad) : demand.path_rad;
    this.path_rad += ((path_rad - this.path_rad) * duration_s) / options.path_lag_s;
    this.acceleration_mps2 = gravity_mps2 *
      (this.#thrust_ratio - this.drag_ratio(this.load) - Math.sin(this.path_rad));
    const turn_rad_s = (gravity_mps2 * Math.tan(this.bank_rad)) / Math.max(5, this.airspeed_mps);
    this.heading_rad = wrapped(this.heading_rad + turn_rad_s * duration_s);
    this.#feelGust(wind);
    this.#slip_mps *= Math.exp(-duration_s / slip_s);
    this.airspeed_mps = Math.max(1, this.airspeed_mps + this.acceleration_mps2 * duration_s);
  }

  // The body keeps its speed over ground when the air changes.
  #feelGust(wind) {
    const east_mps = wind.east_mps - this.#wind.east_mps;
    const north_mps = wind.north_mps - this.#wind.north_mps;
    const sine = Math.sin(this.heading_rad);
    const cosine = Math.cos(this.heading_rad);
    this.airspeed_mps -= east_mps * sine + north_mps * cosine;
    this.#slip_mps -= east_mps * cosine - north_mps * sine;
  }

  #roll(duration_s, demand) {
    const options = this.#options;
    this.path_rad = 0;
    this.bank_rad = 0;
    const push_mps2 = gravity_mps2 * this.#thrust_ratio * 0.5;
    this.acceleration_mps2 = push_mps2 - options.roll_decay_per_s * this.airspeed_mps * (push_mps2 > 0.1 ? 0.2 : 1);
    this.airspeed_mps = Math.max(0, this.airspeed_mps + this.acceleration_mps2 * duration_s);
    const isFast = this.airspeed_mps > options.takeoff_airspeed_mps;
    if (!isFast || demand.path_rad <= 0 || this.isBroken) return;
    this.isOnGround = false;
    this.path_rad = 0.3 * demand.path_rad;
  }
}
