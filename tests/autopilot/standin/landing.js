// The final of a LAND item: a straight slope to the flare, as ArduPlane's glide slope landing.

import { clamp } from './frame.js';
import { onLeg } from './navigation.js';

const radians = (degrees) => (degrees * Math.PI) / 180;
// The sink grows when the throttle is cut; from a recording. Without power there is nothing to cut.
const cutSink = 1.6;
const hasPower_ratio = 0.02;

export class Landing {
  #parameters;
  isFlaring = false;
  slope;
  flareHeight_m;

  constructor(parameters) { this.#parameters = parameters; }

  // from, to: ends of the final with altitude_m. Gives the target for the energy control.
  step(place, from, to, { groundSpeed_mps, sink_mps, headwind_mps, power_ratio }) {
    const leg = onLeg(place, from, to);
    const fall_m = from.altitude_m - to.altitude_m;
    const final = this.#slopeOf(fall_m, leg.length_m, groundSpeed_mps);
    const height_m = place.altitude_m - to.altitude_m;
    this.#watch(height_m, sink_mps, leg.share, power_ratio);
    const altitude_m = from.altitude_m - final.slope * leg.along_m;
    if (!this.isFlaring) {
      return { altitude_m: clamp(altitude_m, to.altitude_m - 30, from.altitude_m),
        airspeed_mps: this.#airspeed_mps(headwind_mps), speedWeight: 1, timeConstant_s: this.#parameters.TECS_LAND_TCONST, slope: final.slope };
    }
    return this.#flare(height_m, groundSpeed_mps);
  }

  // Runs from the start of the final to the flare point, which is before the LAND point.
  #slopeOf(fall_m, length_m, groundSpeed_mps) {
    const { LAND_FLARE_SEC, LAND_FLARE_ALT, LAND_FLARE_AIM, TECS_LAND_SINK } = this.#parameters;
    const flareEffect = LAND_FLARE_AIM / 100;
    const sink_mps = (fall_m * groundSpeed_mps) / length_m;
    const aim_m = clamp(LAND_FLARE_SEC * sink_mps, 0.1, 2 * LAND_FLARE_ALT);
    const flareSink_mps = Math.max(0.1, flareEffect * TECS_LAND_SINK + (1 - flareEffect) * sink_mps);
    const flare_m = Math.min(length_m / 2, (groundSpeed_mps * aim_m) / flareSink_mps);
    this.slope ??= (fall_m - aim_m) / (length_m - flare_m);
    return { slope: (fall_m - aim_m) / (length_m - flare_m) };
  }

  #watch(height_m, sink_mps, share, power_ratio) {
    const { LAND_FLARE_ALT, LAND_FLARE_SEC } = this.#parameters;
    const isLow = height_m <= LAND_FLARE_ALT || (share > 0.5 && height_m <= sink_mps * LAND_FLARE_SEC);
    if (this.isFlaring || !(isLow || share >= 1)) return;
    this.isFlaring = true;
    this.flareHeight_m = Math.max(0.5, height_m);
    this.flareSink_mps = Math.max(0.3, (power_ratio > hasPower_ratio ? cutSink : 1) * sink_mps);
  }

  #flare(height_m, groundSpeed_mps) {
    const { TECS_LAND_SINK } = this.#parameters;
    const share = clamp(height_m / this.flareHeight_m, 0, 1) ** 0.2;
    const sink_mps = TECS_LAND_SINK + (this.flareSink_mps - TECS_LAND_SINK) * share;
    return { path_rad: -Math.asin(clamp(sink_mps / Math.max(5, groundSpeed_mps), 0, 0.3)), maxThrottle: 0,
      maxBank_rad: radians(5) };
  }

  #airspeed_mps(headwind_mps) {
    const { TECS_LAND_ARSPD, AIRSPEED_MIN, AIRSPEED_CRUISE, LAND_WIND_COMP } = this.#parameters;
    const base_mps = TECS_LAND_ARSPD > 0 ? TECS_LAND_ARSPD : (AIRSPEED_MIN + AIRSPEED_CRUISE) / 2;
    return Math.min(AIRSPEED_CRUISE, base_mps + (Math.max(0, headwind_mps) * LAND_WIND_COMP) / 100);
  }
}
