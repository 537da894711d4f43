// How much specific excess power the engine gives at a throttle demand, an airspeed and a load factor,
// learned in flight by least squares of the power balance
//
//   e = v (a throttle + b throttle^2) - c v^3 - d load^2 / v + f
//
// with bounded memory. The answer is a lower bound: what is not known well is not expected.

const numFeatures = 5;
const referenceAirspeed_mps = 20;
// Small planes before anything is learned, in m/s at the reference airspeed: glide ratios of 5 to 25,
// thrust up to one and a half times the weight, nearly in proportion to the throttle.
const priorMeans_mps = [18, 0, 6, 0.3, 0];
const priorSds_mps = [18, 4, 7, 0.3, 0.5];

const featuresOf = ({ throttle, airspeed_mps, load }) => {
  const speed = airspeed_mps / referenceAirspeed_mps;
  return [speed * throttle, speed * throttle * throttle, -(speed ** 3), -(load ** 2) / speed, 1];
};

const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);

// Inverse of a symmetric positive definite matrix, by elimination without exchange of rows.
function inverseOf(matrix) {
  const rows = matrix.map((row, i) => [...row, ...row.map((_, j) => Number(i === j))]);
  for (let i = 0; i < numFeatures; ++i) {
    const pivot = rows[i][i];
    for (let j = 0; j < 2 * numFeatures; ++j) rows[i][j] /= pivot;
    for (let k = 0; k < numFeatures; ++k) {
      if (k === i) continue;
      const factor = rows[k][i];
      for (let j = 0; j < 2 * numFeatures; ++j) rows[k][j] -= factor * rows[i][j];
    }
  }
  return rows.map((row) => row.slice(numFeatures));
}

// The signs of drag are in the features.
const priorInformation = () => priorSds_mps.map((sd, i) => priorSds_mps.map((_, j) => (i === j ? 1 / sd ** 2 : 0)));
const priorVector = () => priorMeans_mps.map((mean, i) => mean / priorSds_mps[i] ** 2);

export const defaultPowerModelOptions = {
  // Gusts last so long: samples that are closer count as one.
  correlation_s: 4,
  memory_s: 600,
  minNoise_mps: 0.7,
  // Standard deviations between estimate and bound.
  numSds: 2,
};

export class PowerModel {
  #options;
  #prior = priorInformation();
  #information = priorInformation();
  #vector = priorVector();
  #coefficients;
  #covariance;
  #variance_mps2;
  seconds = 0;

  constructor(options = {}) {
    this.#options = { ...defaultPowerModelOptions, ...options };
    this.#variance_mps2 = this.#options.minNoise_mps ** 2;
  }

  // state: throttle, airspeed_mps, load.
  learn(state, power_mps, duration_s) {
    const { correlation_s, memory_s, minNoise_mps } = this.#options;
    const features = featuresOf(state);
    const residual_mps = power_mps - this.#estimate(features);
    if (this.seconds > correlation_s) {
      const rate = Math.min(1, duration_s / 60);
      this.#variance_mps2 += rate * (residual_mps ** 2 - this.#variance_mps2);
    }
    const variance_mps2 = Math.max(minNoise_mps ** 2, this.#variance_mps2);
    const weight = Math.min(1, duration_s / correlation_s) / variance_mps2;
    const kept = Math.exp(-duration_s / memory_s);
    const prior = priorVector();
    for (let i = 0; i < numFeatures; ++i) {
      this.#vector[i] = kept * (this.#vector[i] - prior[i]) + prior[i] + weight * features[i] * power_mps;
      for (let j = 0; j < numFeatures; ++j) {
        const learned = this.#information[i][j] - this.#prior[i][j];
        this.#information[i][j] = kept * learned + this.#prior[i][j] + weight * features[i] * features[j];
      }
    }
    this.#coefficients = undefined;
    this.seconds += duration_s;
  }

  // The power that is given at least: more throttle never gives less, nor does a lower airspeed.
  bound_mps({ throttle, airspeed_mps, load }, highest_mps, numSds = this.#options.numSds) {
    let most_mps = -Infinity;
    for (let lower = throttle; lower >= 0; lower -= 0.1) {
      for (let faster_mps = airspeed_mps; faster_mps <= Math.max(airspeed_mps, highest_mps); faster_mps += 2) {
        const features = featuresOf({ throttle: lower, airspeed_mps: faster_mps, load });
        most_mps = Math.max(most_mps, this.#estimate(features) - numSds * this.#sd_mps(features));
      }
    }
    return most_mps;
  }

  #solve() {
    if (this.#coefficients) return;
    this.#covariance = inverseOf(this.#information);
    this.#coefficients = this.#covariance.map((row) => dot(row, this.#vector));
  }

  #estimate(features) {
    this.#solve();
    return dot(this.#coefficients, features);
  }

  #sd_mps(features) {
    this.#solve();
    return Math.sqrt(Math.max(0, dot(features, this.#covariance.map((row) => dot(row, features)))));
  }
}
