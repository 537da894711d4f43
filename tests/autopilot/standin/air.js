// The moving air: a mean wind that is weaker near the ground, and gusts.

import { SlowNoise } from './random.js';

export class Air {
  #options;
  #gusts;

  constructor(options, random) {
    this.#options = options;
    const horizontal = () => new SlowNoise(random, options.gust_sd_mps, options.gust_time_s);
    this.#gusts = {
      east: horizontal(), north: horizontal(),
      up: new SlowNoise(random, options.vertical_gust_sd_mps, options.gust_time_s),
    };
  }

  // Where the air moves towards.
  mean(height_m) {
    const { speed_mps, from_deg, gradient_height_m } = this.#options;
    const share = gradient_height_m > 0
      ? Math.sqrt(Math.min(1, Math.max(0, height_m) / gradient_height_m)) : 1;
    const from_rad = (from_deg * Math.PI) / 180;
    return {
      east_mps: -share * speed_mps * Math.sin(from_rad),
      north_mps: -share * speed_mps * Math.cos(from_rad),
    };
  }

  step(duration_s, height_m) {
    const { east_mps, north_mps } = this.mean(height_m);
    const { east, north, up } = this.#gusts;
    // A vertical gust cannot pass through the ground.
    const upShare = Math.min(1, Math.max(0, height_m) / 30);
    return {
      east_mps: east_mps + east.step(duration_s),
      north_mps: north_mps + north.step(duration_s),
      up_mps: upShare * up.step(duration_s),
    };
  }
}
