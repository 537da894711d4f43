// Height and airspeed by total energy: throttle for its sum, flight path for its balance, as
// ArduPlane's TECS. It does not know that an engine stands.

import { clamp } from './frame.js';

const gravity_mps2 = 9.81;
const radians = (degrees) => (degrees * Math.PI) / 180;
// Share of the balance's rate error that goes into the path.
const balanceDamping = 1.0;
const balanceSumGain_per_s = 0.4;
const maxBalanceSum_mps = 4;
const throttleTime_s = 3;
const throttleDamping = 0.5;
const powerFilter_s = 0.5;
const sumGain_per_s = 0.15;
const maxSum_mps = 4;

export class EnergyControl {
  #parameters;
  #height_m;
  #heightRate_mps = 0;
  #isTooSlow = false;
  #path_rad = 0;
  #power_mps = 0;
  #sum_mps = 0;
  #balanceSum_mps = 0;

  constructor(parameters) { this.#parameters = parameters; }

  reset(altitude_m, path_rad) {
    this.#path_rad = path_rad;
    this.#height_m = altitude_m;
    this.#heightRate_mps = 0;
    this.#isTooSlow = false;
    this.#sum_mps = 0;
    this.#balanceSum_mps = 0;
  }

  get isTooSlow() { return this.#isTooSlow; }

  // target: altitude_m, airspeed_mps, minPath_rad, maxThrottle. measured: altitude_m, climb_mps,
  // airspeed_mps, acceleration_mps2, drag_ratio, levelDrag_ratio(airspeed_mps),
  // max_thrust_ratio. Gives path_rad and throttle.
  step(duration_s, target, measured) {
    this.#follow(duration_s, target.altitude_m, measured.altitude_m);
    const { AIRSPEED_MIN, AIRSPEED_MAX, TECS_SINK_MAX, TECS_CLMB_MAX } = this.#parameters;
    const wanted_mps = clamp(target.airspeed_mps, AIRSPEED_MIN, AIRSPEED_MAX);
    const kinetic_m = (airspeed_mps) => airspeed_mps ** 2 / (2 * gravity_mps2);
    const missingHeight_m = this.#height_m - measured.altitude_m;
    const missingSpeed_m = kinetic_m(wanted_mps) - kinetic_m(measured.airspeed_mps);
    const missing_m = missingHeight_m + missingSpeed_m;
    const throttle = clamp(this.#throttleFor(duration_s, missing_m, wanted_mps, measured), 0, target.maxThrottle ?? 1);
    this.#watchSpeed(measured, throttle, missingHeight_m);
    const path_rad = this.#isTooSlow
      ? this.#pathForSpeed(measured)
      : this.#pathForBalance(duration_s, { missingHeight_m, missingSpeed_m, target }, measured);
    return { throttle: this.#isTooSlow ? target.maxThrottle ?? 1 : throttle, path_rad: this.#limited(duration_s, path_rad, target, measured) };
  }

  // The demanded height runs to the target at no more than the rates of the parameters.
  #follow(duration_s, target_m, now_m) {
    this.#height_m ??= now_m;
    const { TECS_CLMB_MAX, TECS_SINK_MAX } = this.#parameters;
    const change_m = clamp(target_m - this.#height_m, -TECS_SINK_MAX * duration_s, TECS_CLMB_MAX * duration_s);
    this.#height_m += change_m;
    const rate_mps = duration_s > 0 ? change_m / duration_s : 0;
    this.#heightRate_mps += (rate_mps - this.#heightRate_mps) * Math.min(1, duration_s);
  }

  // From that of the level cruise; what is missing for long is summed up.
  #throttleFor(duration_s, missing_m, wanted_mps, measured) {
    const { TECS_SINK_MAX, TECS_CLMB_MAX } = this.#parameters;
    const rate_mps = clamp(missing_m / throttleTime_s, -TECS_SINK_MAX, 2 * TECS_CLMB_MAX) + this.#heightRate_mps;
    const now_mps = measured.climb_mps + (measured.airspeed_mps * measured.acceleration_mps2) / gravity_mps2;
    this.#power_mps += (now_mps - this.#power_mps) * Math.min(1, duration_s / powerFilter_s);
    this.#sum_mps = clamp(this.#sum_mps + sumGain_per_s * (missing_m / throttleTime_s) * duration_s, -maxSum_mps, maxSum_mps);
    const demand_mps = rate_mps + throttleDamping * (rate_mps - this.#power_mps) + this.#sum_mps;
    return (measured.levelDrag_ratio(wanted_mps) + demand_mps / wanted_mps) / measured.max_thrust_ratio;
  }

  // Underspeed: the path holds the lowest airspeed until the engine has power to spare.
  #watchSpeed({ airspeed_mps }, throttle, missingHeight_m) {
    if (airspeed_mps < this.#parameters.AIRSPEED_MIN * 0.9) this.#isTooSlow = true;
    else if (throttle < 0.95 || missingHeight_m < 0) this.#isTooSlow = false;
  }

  #pathForSpeed({ airspeed_mps, acceleration_mps2, drag_ratio }) {
    const missing_mps = this.#parameters.AIRSPEED_MIN - airspeed_mps;
    return -Math.asin(clamp(drag_ratio, 0, 0.5)) - 0.12 * missing_mps + 0.02 * acceleration_mps2;
  }

  #pathForBalance(duration_s, { missingHeight_m, missingSpeed_m, target }, measured) {
    const { TECS_SPDWEIGHT, TECS_TIME_CONST } = this.#parameters;
    const speedWeight = target.speedWeight ?? TECS_SPDWEIGHT;
    const heightWeight = 2 - speedWeight;
    const speed_mps = Math.max(5, measured.airspeed_mps);
    const balance_m = heightWeight * missingHeight_m - speedWeight * missingSpeed_m;
    const wanted_mps = heightWeight * this.#heightRate_mps + balance_m / (target.timeConstant_s ?? TECS_TIME_CONST);
    const kineticRate_mps = (measured.airspeed_mps * measured.acceleration_mps2) / gravity_mps2;
    const now_mps = heightWeight * measured.climb_mps - speedWeight * kineticRate_mps;
    const error_mps = wanted_mps - now_mps;
    this.#balanceSum_mps = clamp(this.#balanceSum_mps + balanceSumGain_per_s * error_mps * duration_s,
      -maxBalanceSum_mps, maxBalanceSum_mps);
    return (wanted_mps + balanceDamping * error_mps + this.#balanceSum_mps) / speed_mps / Math.max(1, heightWeight);
  }

  #limited(duration_s, path_rad, target, { airspeed_mps }) {
    const { PTCH_LIM_MAX_DEG, PTCH_LIM_MIN_DEG } = this.#parameters;
    const low_rad = Math.max(radians(PTCH_LIM_MIN_DEG), target.minPath_rad ?? -2);
    const change_rad = (7 / Math.max(5, airspeed_mps)) * duration_s;
    const wanted_rad = clamp(path_rad, low_rad, target.maxPath_rad ?? radians(PTCH_LIM_MAX_DEG));
    this.#path_rad += clamp(wanted_rad - this.#path_rad, -change_rad, change_rad);
    return this.#path_rad;
  }
}
