// What the aircraft believes of itself: truth with noise, and a wind estimate that settles in flight.

import { SlowNoise } from './random.js';
import { clamp, wrapped } from './frame.js';

const radians = (degrees) => (degrees * Math.PI) / 180;
// Straight flight shows this share of the wind; the rest comes with turns.
const straightShare = 0.85;
const fullTurn_rad = Math.PI / 2;
const flyingAirspeed_mps = 8;

export class Sensors {
  #options;
  #random;
  #noise;
  #bias;
  #turned_rad = 0;
  #lastHeading_rad;
  #wind = { east_mps: 0, north_mps: 0 };

  constructor(options, random) {
    this.#options = options;
    this.#random = random;
    const slow = (sd) => new SlowNoise(random, sd, 20);
    this.#noise = {
      east: slow(options.position_sd_m), north: slow(options.position_sd_m), up: slow(options.altitude_sd_m),
    };
    this.#bias = {
      ratio: 1 + random.gauss(options.wind_bias_ratio), angle_rad: radians(random.gauss(options.wind_bias_deg)),
    };
  }

  // Towards where the air moves, as the autopilot believes.
  get wind() { return this.#wind; }

  restart() {
    this.#turned_rad = 0;
    this.#wind = { east_mps: 0, north_mps: 0 };
  }

  step(duration_s, body, meanWind) {
    for (const noise of Object.values(this.#noise)) noise.step(duration_s);
    const isFlying = !body.isOnGround && body.airspeed_mps > flyingAirspeed_mps;
    if (isFlying) {
      this.#turned_rad += Math.abs(wrapped(body.heading_rad - (this.#lastHeading_rad ?? body.heading_rad)));
    }
    this.#lastHeading_rad = body.heading_rad;
    const seen = straightShare + (1 - straightShare) * clamp(this.#turned_rad / fullTurn_rad, 0, 1);
    const cosine = Math.cos(this.#bias.angle_rad);
    const sine = Math.sin(this.#bias.angle_rad);
    const scale = isFlying ? seen * this.#bias.ratio : 0.15;
    const rate = Math.min(1, duration_s / this.#options.wind_settle_s);
    const { east_mps, north_mps } = meanWind;
    this.#wind.east_mps += rate * (scale * (east_mps * cosine + north_mps * sine) - this.#wind.east_mps);
    this.#wind.north_mps += rate * (scale * (north_mps * cosine - east_mps * sine) - this.#wind.north_mps);
  }

  // Where the aircraft believes to be.
  place(body) {
    return {
      east_m: body.east_m + this.#noise.east.value,
      north_m: body.north_m + this.#noise.north.value,
      altitude_m: body.altitude_m + this.#options.altitude_bias_m + this.#noise.up.value,
    };
  }

  read(body) {
    const { velocity_sd_mps, attitude_sd_deg, airspeed_sd_mps } = this.#options;
    const random = this.#random;
    const { east_mps, north_mps } = body.velocity;
    const attitude = () => radians(random.gauss(attitude_sd_deg));
    return {
      ...this.place(body),
      east_mps: east_mps + random.gauss(velocity_sd_mps),
      north_mps: north_mps + random.gauss(velocity_sd_mps),
      climb_mps: body.climb_mps + random.gauss(velocity_sd_mps),
      roll_rad: body.bank_rad + attitude(),
      pitch_rad: body.pitch_rad + attitude(),
      yaw_rad: wrapped(body.heading_rad + attitude()),
      airspeed_mps: Math.max(0, body.indicated_mps + random.gauss(airspeed_sd_mps)),
    };
  }
}
