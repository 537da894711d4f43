// What disturbs the measured excess power: vertical gusts, which last for some seconds, and the error of
// the measured energy height, which is new with each sample:
//
//   power = gust + (error - error before) / duration
//
// How strong both are is learned. The filter (Kalman's, of this model) leaves what could not be foreseen.

export const defaultPowerNoise = {
  // Gusts last for about so long; only their strength is learned.
  gusts_s: 4,
  // Before anything is learned.
  gust_mps: 0.6,
  error_m: 0.14,
};
const memory_s = 60;
// No gusts are never believed in.
const minGust_mps = 0.2;
const minError_m = 0.01;
// Residuals so many samples apart show the gusts; those of one sample show the error too.
const lags = [2, 3, 4];
export const numResiduals = 5;

const square = (value) => value * value;

export class PowerNoise {
  #gusts_s;
  #gust_mps2;
  #error_m2;
  #products;
  #uncertainty;

  constructor({ gusts_s, gust_mps, error_m } = defaultPowerNoise) {
    this.#gusts_s = gusts_s;
    this.#gust_mps2 = square(gust_mps);
    this.#error_m2 = square(error_m);
    this.restart();
  }

  get gust_mps2() { return this.#gust_mps2; }

  // Nothing is known of the present gust.
  restart() { this.#uncertainty = { gust: this.#gust_mps2, error: this.#error_m2, both: 0 }; }

  // residuals_mps: the newest last.
  learn(residuals_mps, duration_s) {
    const kept = Math.exp(-duration_s / this.#gusts_s);
    this.#products ??= [this.#gust_mps2 + (2 * this.#error_m2) / square(duration_s), ...lags.map((lag) => this.#gust_mps2 * kept ** lag)];
    const rate = duration_s / memory_s;
    [0, ...lags].forEach((lag, i) => {
      const product = residuals_mps.at(-1) * residuals_mps.at(-1 - lag);
      this.#products[i] += rate * (product - this.#products[i]);
    });
    const [all_mps2, ...later] = this.#products;
    const gust_mps2 = later.reduce((sum, one, i) => sum + one / kept ** lags[i], 0) / lags.length;
    this.#gust_mps2 = Math.max(square(minGust_mps), gust_mps2);
    this.#error_m2 = Math.max(square(minError_m), (square(duration_s) * (all_mps2 - this.#gust_mps2)) / 2);
  }

  // The filter of the next sample, and the variance of what it leaves.
  next(duration_s) {
    const before = this.#uncertainty;
    const kept = Math.exp(-duration_s / this.#gusts_s);
    const rate_per_s = 1 / duration_s;
    const gust = kept * kept * before.gust + this.#gust_mps2 * (1 - kept * kept);
    const shared = gust - rate_per_s * kept * before.both;
    const variance_mps2 = shared - rate_per_s * kept * before.both +
      square(rate_per_s) * (before.error + this.#error_m2);
    const gustGain = shared / variance_mps2;
    const errorGain_s = (rate_per_s * this.#error_m2) / variance_mps2;
    this.#uncertainty = { gust: gust - square(gustGain) * variance_mps2, both: -gustGain * errorGain_s * variance_mps2,
      error: this.#error_m2 - square(errorGain_s) * variance_mps2 };
    return { kept, rate_per_s, gustGain, errorGain_s, variance_mps2 };
  }
}

// One series through the filter; it is linear, so features and signatures go through it as the power does.
export class Innovations {
  #gust_mps = 0;
  #error_m = 0;

  next({ kept, rate_per_s, gustGain, errorGain_s }, value) {
    const foreseen = kept * this.#gust_mps - rate_per_s * this.#error_m;
    const left = value - foreseen;
    this.#gust_mps = kept * this.#gust_mps + gustGain * left;
    this.#error_m = errorGain_s * left;
    return left;
  }
}
