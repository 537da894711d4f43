// How much specific excess power the engine gives at a throttle demand, an airspeed and a load factor,
// learned in flight by least squares of the power balance
//
//   e = v (a throttle + b throttle^2) - c v^3 - d load^2 / v + f
//
// with bounded memory. The answer is a lower bound: what is not known well is not expected.

import { LeastSquares } from './least_squares.js';

export const referenceAirspeed_mps = 20;
// Small planes before anything is learned, in m/s at the reference airspeed: glide ratios of 5 to 25,
// thrust up to one and a half times the weight, nearly in proportion to the throttle.
export const priorMeans_mps = [18, 0, 6, 0.3, 0];
export const priorSds_mps = [18, 4, 7, 0.3, 0.5];

export const featuresOf = ({ throttle, airspeed_mps, load }) => {
  const speed = airspeed_mps / referenceAirspeed_mps;
  return [speed * throttle, speed * throttle * throttle, -(speed ** 3), -(load ** 2) / speed, 1];
};

const defaultPowerModelOptions = {
  // Gusts last so long: samples that are closer count as one.
  correlation_s: 4,
  memory_s: 600,
  minNoise_mps: 0.7,
  // Standard deviations between estimate and bound.
  numSds: 2,
};

export class PowerModel {
  #options;
  #fit;
  #variance_mps2;
  seconds = 0;

  constructor(options = {}) {
    this.#options = { ...defaultPowerModelOptions, ...options };
    this.#fit = new LeastSquares({ means: priorMeans_mps, sds: priorSds_mps, memory_s: this.#options.memory_s });
    this.#variance_mps2 = this.#options.minNoise_mps ** 2;
  }

  // state: throttle, airspeed_mps, load.
  learn(state, power_mps, duration_s) {
    const { correlation_s, minNoise_mps } = this.#options;
    const features = featuresOf(state);
    const residual_mps = power_mps - this.#fit.estimate(features);
    if (this.seconds > correlation_s) {
      const rate = Math.min(1, duration_s / 60);
      this.#variance_mps2 += rate * (residual_mps ** 2 - this.#variance_mps2);
    }
    const variance_mps2 = Math.max(minNoise_mps ** 2, this.#variance_mps2);
    this.#fit.learn(features, power_mps, variance_mps2 / Math.min(1, duration_s / correlation_s), duration_s);
    this.seconds += duration_s;
  }

  // The power that is given at least: more throttle never gives less, nor does a lower airspeed.
  bound_mps({ throttle, airspeed_mps, load }, highest_mps, numSds = this.#options.numSds) {
    let most_mps = -Infinity;
    for (let lower = throttle; lower >= 0; lower -= 0.1) {
      for (let faster_mps = airspeed_mps; faster_mps <= Math.max(airspeed_mps, highest_mps); faster_mps += 2) {
        const features = featuresOf({ throttle: lower, airspeed_mps: faster_mps, load });
        most_mps = Math.max(most_mps, this.#fit.estimate(features) - numSds * Math.sqrt(this.#fit.variance(features)));
      }
    }
    return most_mps;
  }
}
