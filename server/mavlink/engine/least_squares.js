// Linear least squares that goes on: a prior, samples one by one, and bounded memory.

const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);

// Inverse of a symmetric positive definite matrix, by elimination without exchange of rows.
function inverseOf(matrix) {
  const size = matrix.length;
  const rows = matrix.map((row, i) => [...row, ...row.map((_, j) => Number(i === j))]);
  for (let i = 0; i < size; ++i) {
    const pivot = rows[i][i];
    for (let j = 0; j < 2 * size; ++j) rows[i][j] /= pivot;
    for (let k = 0; k < size; ++k) {
      if (k === i) continue;
      const factor = rows[k][i];
      for (let j = 0; j < 2 * size; ++j) rows[k][j] -= factor * rows[i][j];
    }
  }
  return rows.map((row) => row.slice(size));
}

export class LeastSquares {
  #memory_s;
  #priorInformation;
  #priorVector;
  #information;
  #vector;
  #coefficients;
  #covariance;

  // means, sds: of the coefficients before anything is learned; they never fade.
  constructor({ means, sds, memory_s }) {
    this.#memory_s = memory_s;
    this.#priorInformation = sds.map((sd, i) => sds.map((_, j) => (i === j ? 1 / sd ** 2 : 0)));
    this.#priorVector = means.map((mean, i) => mean / sds[i] ** 2);
    this.#information = this.#priorInformation.map((row) => [...row]);
    this.#vector = [...this.#priorVector];
  }

  get coefficients() {
    this.#solve();
    return this.#coefficients;
  }

  learn(features, value, variance, duration_s) {
    const kept = Math.exp(-duration_s / this.#memory_s);
    for (let i = 0; i < features.length; ++i) {
      const prior = this.#priorVector[i];
      this.#vector[i] = kept * (this.#vector[i] - prior) + prior + (features[i] * value) / variance;
      for (let j = 0; j < features.length; ++j) {
        const base = this.#priorInformation[i][j];
        this.#information[i][j] = kept * (this.#information[i][j] - base) + base + (features[i] * features[j]) / variance;
      }
    }
    this.#coefficients = undefined;
  }

  estimate(features) { return dot(this.coefficients, features); }

  variance(features) {
    this.#solve();
    return Math.max(0, dot(features, this.#covariance.map((row) => dot(row, features))));
  }

  #solve() {
    if (this.#coefficients) return;
    this.#covariance = inverseOf(this.#information);
    this.#coefficients = this.#covariance.map((row) => dot(row, this.#vector));
  }
}
