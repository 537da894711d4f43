// Wind from ground velocity, heading and airspeed, by least squares over turns.
//
// Model: ground velocity = p * air velocity + q * (air velocity turned right by 90 degrees) + wind.
// The air velocity is the horizontal airspeed along the heading. p takes up the scale of the
// airspeed sensor and the difference between indicated and true airspeed; q takes up sideslip and
// the error of the compass. Without an airspeed, p is the unknown airspeed itself.
// Only turns tell p and q from the wind: on a straight line the uncertainty stays large.

const window_s = 150;
// Samples closer together than gusts last are not independent. How long they last is measured from
// what the solution leaves, between these.
const minCorrelation_s = 3;
const maxCorrelation_s = 30;
const minNoise_mps = 0.3;
const airspeedScaleSd = 0.15;
const sideslipSd = 0.05;
const typicalAirspeed_mps = 18;
const airspeedSd_mps = 10;
const windSd_mps = 10;
const minAirspeed_mps = 7;
const numUnknowns = 4;

// Solves the symmetric system a x = b and inverts a, by Gauss-Jordan elimination with pivots.
function solved(a, b) {
  const n = b.length;
  const rows = a.map((row, i) => [...row, b[i], ...row.map((_, j) => (i === j ? 1 : 0))]);
  for (let i = 0; i < n; ++i) {
    let pivot = i;
    for (let r = i + 1; r < n; ++r) if (Math.abs(rows[r][i]) > Math.abs(rows[pivot][i])) pivot = r;
    [rows[i], rows[pivot]] = [rows[pivot], rows[i]];
    const scale = rows[i][i];
    rows[i] = rows[i].map((value) => value / scale);
    for (let r = 0; r < n; ++r) {
      if (r === i) continue;
      const factor = rows[r][i];
      rows[r] = rows[r].map((value, c) => value - factor * rows[i][c]);
    }
  }
  return { x: rows.map((row) => row[n]), inverse: rows.map((row) => row.slice(n + 1)) };
}

export class DriftWind {
  #samples = [];

  restart() { this.#samples = []; }

  // heading_rad: clockwise from true north. airspeed_mps may be absent; climb_mps is upwards.
  add({ time_s, east_mps, north_mps, heading_rad, airspeed_mps, climb_mps = 0 }) {
    const numbers = [time_s, east_mps, north_mps, heading_rad, airspeed_mps ?? 0, climb_mps];
    if (!numbers.every(Number.isFinite)) return;
    if (airspeed_mps !== undefined && airspeed_mps < minAirspeed_mps) return;
    const last = this.#samples.at(-1);
    if (last && time_s <= last.time_s) return;
    const level_mps = airspeed_mps === undefined
      ? undefined : Math.sqrt(Math.max(airspeed_mps ** 2 - climb_mps ** 2, 0));
    this.#samples.push({ time_s, east_mps, north_mps, heading_rad, level_mps });
    while (this.#samples[0].time_s < time_s - window_s) this.#samples.shift();
  }

  // { east_mps, north_mps: where the air moves, sd_mps: the larger of both } or nothing.
  estimate() {
    const isMeasured = this.#samples.every((sample) => sample.level_mps !== undefined);
    const samples = this.#samples;
    if (samples.length < 10) return undefined;
    const { rows, values } = equationsOf(samples, isMeasured);
    const prior = isMeasured
      ? { mean: [1, 0], sd: [airspeedScaleSd, sideslipSd] }
      : { mean: [typicalAirspeed_mps, 0],
          sd: [airspeedSd_mps, sideslipSd * typicalAirspeed_mps] };
    // The noise is not known before the first solution.
    let noise_mps = 1;
    let gust_s = minCorrelation_s;
    let solution;
    for (let round = 0; round < 3; ++round) {
      solution = fit(rows, values, prior, noise_mps, independentShare(samples, gust_s));
      const residuals = residualsOf(rows, values, solution.x);
      noise_mps = Math.max(minNoise_mps, spreadOf(residuals));
      gust_s = correlation_s(samples, residuals);
    }
    const [, , east_mps, north_mps] = solution.x;
    const sd_mps = Math.sqrt(Math.max(solution.inverse[2][2], solution.inverse[3][3]));
    return { east_mps, north_mps, sd_mps };
  }
}

const durationOf = (samples) => samples.at(-1).time_s - samples[0].time_s;

function independentShare(samples, correlation_s) {
  const duration_s = durationOf(samples);
  return Math.min(1, (duration_s / correlation_s + 1) / samples.length);
}

function equationsOf(samples, isMeasured) {
  const rows = [];
  const values = [];
  for (const { east_mps, north_mps, heading_rad, level_mps } of samples) {
    const speed = isMeasured ? level_mps : 1;
    const east = speed * Math.sin(heading_rad);
    const north = speed * Math.cos(heading_rad);
    rows.push([east, north, 1, 0], [north, -east, 0, 1]);
    values.push(east_mps, north_mps);
  }
  return { rows, values };
}

function fit(rows, values, prior, noise_mps, share) {
  const weight = share / noise_mps ** 2;
  const a = Array.from({ length: numUnknowns }, () => Array(numUnknowns).fill(0));
  const b = Array(numUnknowns).fill(0);
  rows.forEach((row, k) => {
    for (let i = 0; i < numUnknowns; ++i) {
      b[i] += weight * row[i] * values[k];
      for (let j = 0; j < numUnknowns; ++j) a[i][j] += weight * row[i] * row[j];
    }
  });
  const means = [...prior.mean, 0, 0];
  [...prior.sd, windSd_mps, windSd_mps].forEach((sd, i) => {
    a[i][i] += 1 / sd ** 2;
    b[i] += means[i] / sd ** 2;
  });
  return solved(a, b);
}

const residualsOf = (rows, values, x) =>
  rows.map((row, k) => values[k] - row.reduce((total, value, i) => total + value * x[i], 0));

const spreadOf = (residuals) =>
  Math.sqrt(residuals.reduce((sum, one) => sum + one * one, 0) / Math.max(1, residuals.length - numUnknowns));

// The sum of the autocorrelation up to its first zero, east and north together.
function correlation_s(samples, residuals) {
  const step_s = durationOf(samples) / (samples.length - 1);
  const covariance = (lag) => {
    let sum = 0;
    for (let k = 2 * lag; k < residuals.length; ++k) sum += residuals[k] * residuals[k - 2 * lag];
    return sum;
  };
  const variance = covariance(0);
  let numCorrelated = 1;
  for (let lag = 1; lag * step_s < maxCorrelation_s && lag < samples.length; ++lag) {
    const one = covariance(lag) / variance;
    if (!(one > 0)) break;
    numCorrelated += 2 * one;
  }
  return Math.min(maxCorrelation_s, Math.max(minCorrelation_s, numCorrelated * step_s));
}
