// Whether the power of the engine has gone within the last seconds: a likelihood ratio.
//
// With a running engine the excess power follows throttle, airspeed and bank as learned, with the noise of
// power_noise.js. Without it the thrust is missing since one of the last moments. Evidence is the
// logarithm of how much better the second explains the innovations, at the likeliest of these moments.
// Beside it stands the absence: the same evidence from the power itself, since it began to be missing.
//
// An autopilot opens the throttle when the air sinks, so throttle and gusts of the same moment go
// together, and power would seem to fall with the throttle. Thus the throttle of a second ago tells the
// thrust; what it has changed since has a coefficient of its own. All is learned from innovations,
// and only seconds later, so that a failure is not learned.

import { LeastSquares } from './least_squares.js';
import { featuresOf, priorMeans_mps, priorSds_mps, referenceAirspeed_mps } from './power_model.js';
import { defaultPowerNoise, Innovations, numResiduals, PowerNoise } from './power_noise.js';

const gravity_mps2 = 9.81;

export const defaultPowerDropOptions = {
  // Evidence that is a drop: e^12 is 160 000. Evidence from which nothing is learned for a while.
  limit: 12,
  // The same for thrust that is missing all the time, and if RPM or current has also gone.
  limitAbsence: 8,
  limitConfirmed: 3,
  doubt: 3,
  // The drop may have begun so long ago.
  onsets_s: 4,
  // Before this nothing is concluded.
  minLearned_s: 30,
  // From the throttle demand to the thrust, and how long ago the throttle is not yet an answer to the gust.
  thrustLag_s: 0.2,
  answer_s: 1.0,
  // Below this demand a stopped engine looks like an idle one.
  minThrottle_ratio: 0.1,
  // The thrust that is missing, as a share of the one that is expected; in gusts too little is expected.
  leastShare: 0.7,
  mostShare: 2,
  // Standard deviations that are not of the noise: of the thrust, and per (1 / cos^2 bank - 1). What the throttle
  // changes within answer_s is not counted on at all.
  thrust_ratio: 0.1,
  turn_mps: 1.0,
  // So much less demand than answer_s ago: then the search begins anew.
  fall_ratio: 0.03,
  // No sample says more than so many standard deviations.
  maxDeviation: 3,
  smooth_s: 1.0,
  learnAfter_s: 3,
  learnAfterDoubt_s: 12,
  memory_s: 600,
  // Samples that are nearer are passed over.
  minStep_s: 0.19,
  maxStep_s: 2,
  // Evidence that the thrust is back.
  recovery: 5,
};

const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
const between = (a, b, share) => a + share * (b - a);
const wrapped = (angle_rad) => Math.atan2(Math.sin(angle_rad), Math.cos(angle_rad));

// Demands of the throttle, the oldest first.
class ThrottleHistory {
  #heard = [];

  hear(throttle, time_s) {
    this.#heard.push({ throttle, time_s });
    while (this.#heard.length > 2 && this.#heard[1].time_s < time_s - 3) this.#heard.shift();
  }

  at(time_s) {
    const after = this.#heard.findIndex((one) => one.time_s >= time_s);
    if (after < 0) return this.#heard.at(-1)?.throttle;
    if (after === 0) return this.#heard[0].throttle;
    const [a, b] = [this.#heard[after - 1], this.#heard[after]];
    return between(a.throttle, b.throttle, (time_s - a.time_s) / (b.time_s - a.time_s));
  }
}

// The drop as it would look since one moment.
export class Onset {
  #signature = new Innovations();
  #likeness = 0;
  #size = 0;

  constructor(time_s) { this.time_s = time_s; }

  add(filter, thrust_mps, innovation_mps, variance_mps2) {
    const expected_mps = this.#signature.next(filter, thrust_mps);
    this.#likeness -= (innovation_mps * expected_mps) / variance_mps2;
    this.#size += expected_mps ** 2 / variance_mps2;
  }

  evidence(leastShare, mostShare) {
    const share = clamp(this.#likeness / this.#size || 0, leastShare, mostShare);
    return share * this.#likeness - (share ** 2 * this.#size) / 2;
  }
}

export class PowerDrop {
  #options;
  #fit;
  #noise = new PowerNoise();
  #throttles = new ThrottleHistory();
  #last;
  #airspeed_mps;
  #innovations;
  #residuals_mps;
  #onsets;
  #waiting;
  #learned_s = 0;
  #absence = 0;
  #recovery = 0;
  #evidence = 0;

  constructor(options = {}) {
    this.#options = { ...defaultPowerDropOptions, ...options };
    // The last one: of what the throttle has changed.
    this.#fit = new LeastSquares({ means: [...priorMeans_mps, 0], sds: [...priorSds_mps, 10], memory_s: this.#options.memory_s });
    this.restart();
  }

  isDrop(isConfirmed) {
    const { limit, limitAbsence, limitConfirmed } = this.#options;
    if (isConfirmed) return Math.max(this.#evidence, this.#absence) > limitConfirmed;
    return this.#evidence > limit || this.#absence > limitAbsence;
  }

  // Nothing speaks against it while too little is learned.
  get hasRecovered() { return this.#recovery > this.#options.recovery || !this.#isLearned; }
  get #isLearned() { return this.#learned_s >= this.#options.minLearned_s; }

  // What was learned stays.
  restart() {
    this.#last = undefined;
    this.#airspeed_mps = undefined;
    this.#innovations = { power: new Innovations(), features: [...priorMeans_mps, 0].map(() => new Innovations()) };
    this.#residuals_mps = [];
    this.#onsets = [];
    this.#waiting = [];
    this.#noise.restart();
    this.#absence = 0;
    this.#recovery = 0;
    this.#evidence = 0;
  }

  hearThrottle(throttle_ratio, time_s) { this.#throttles.hear(throttle_ratio, time_s); }

  // At each position in flight. hasFailed: it is known already, so nothing is learned.
  step(motion, hasFailed) {
    const { minStep_s, maxStep_s } = this.#options;
    const before = this.#last;
    const duration_s = before && motion.time_s - before.time_s;
    if (duration_s < minStep_s) return;
    if (duration_s > maxStep_s) this.restart();
    this.#last = motion;
    if (!(duration_s <= maxStep_s)) return;
    const sample = this.#sampleOf(before, motion);
    if (sample) this.#take(sample, hasFailed);
  }

  #sampleOf(before, motion) {
    const { thrustLag_s, answer_s, smooth_s } = this.#options;
    const duration_s = motion.time_s - before.time_s;
    const middle_s = motion.time_s - duration_s / 2 - thrustLag_s;
    const throttle = this.#throttles.at(middle_s);
    if (throttle === undefined) return undefined;
    const earlier = this.#throttles.at(middle_s - answer_s);
    const airspeed_mps = between(before.airspeed_mps, motion.airspeed_mps, 0.5);
    this.#airspeed_mps ??= airspeed_mps;
    this.#airspeed_mps = between(this.#airspeed_mps, airspeed_mps, Math.min(1, duration_s / smooth_s));
    const load = 1 / Math.max(0.4, Math.cos(between(before.bank_rad, motion.bank_rad, 0.5)));
    const features = [...featuresOf({ throttle: earlier, airspeed_mps: this.#airspeed_mps, load }),
      (this.#airspeed_mps / referenceAirspeed_mps) * (throttle - earlier)];
    const power_mps = between(before.climb_mps, motion.climb_mps, 0.5) +
      (airspeed_mps * forward_mps2(before, motion, duration_s)) / gravity_mps2;
    return { time_s: motion.time_s, duration_s, throttle, earlier, load, features, power_mps };
  }

  #take(sample, hasFailed) {
    const { time_s, duration_s, load, features, power_mps } = sample;
    const options = this.#options;
    const [first, second] = this.#fit.coefficients;
    const thrust_mps = Math.max(0, first * features[0] + second * features[1]);
    const filter = this.#noise.next(duration_s);
    const power = this.#innovations.power.next(filter, power_mps);
    const row = features.map((one, i) => this.#innovations.features[i].next(filter, one));
    this.#residuals_mps = [...this.#residuals_mps, power_mps - this.#fit.estimate(features)].slice(-numResiduals);
    if (this.#residuals_mps.length < numResiduals) return;
    const absence = this.#absenceIn(sample, thrust_mps);
    if (hasFailed) {
      this.#watchRecovery(absence);
      return;
    }
    this.#recovery = 0;
    const isShown = this.#isLearned && sample.throttle >= options.minThrottle_ratio;
    this.#absence = isShown ? Math.max(0, this.#absence + absence) : 0;
    const variance_mps2 = filter.variance_mps2 + this.#fit.variance(row) + (options.turn_mps * (load ** 2 - 1)) ** 2 +
      (row.at(-1) * Math.max(0, first)) ** 2 + (options.thrust_ratio * thrust_mps) ** 2;
    // A demand that has fallen explains less power by itself.
    if (sample.throttle < sample.earlier - options.fall_ratio) this.#onsets = [];
    if (this.#isLearned) this.#weigh(sample, { filter, thrust_mps, innovation_mps: power - this.#fit.estimate(row), variance_mps2 });
    this.#waiting.push({ time_s, duration_s, row, power, variance_mps2: filter.variance_mps2, residuals_mps: this.#residuals_mps });
    this.#learn(time_s);
  }

  #weigh({ time_s, throttle }, { filter, thrust_mps, innovation_mps, variance_mps2 }) {
    const { onsets_s, maxDeviation, leastShare, mostShare, minThrottle_ratio } = this.#options;
    const most_mps = maxDeviation * Math.sqrt(variance_mps2);
    const believed_mps = clamp(innovation_mps, -most_mps, most_mps);
    this.#onsets.push(new Onset(time_s));
    while (this.#onsets[0].time_s <= time_s - onsets_s) this.#onsets.shift();
    this.#onsets.forEach((one) => one.add(filter, thrust_mps, believed_mps, variance_mps2));
    const evidences = this.#onsets.map((one) => one.evidence(leastShare, mostShare));
    this.#evidence = throttle < minThrottle_ratio ? 0 : Math.max(0, ...evidences);
  }

  // From the innovations: they are independent of each other.
  #learn(time_s) {
    const { doubt, learnAfter_s, learnAfterDoubt_s } = this.#options;
    const until_s = time_s - (Math.max(this.#evidence, this.#absence) > doubt ? learnAfterDoubt_s : learnAfter_s);
    while (this.#waiting.length && this.#waiting[0].time_s < until_s) {
      const { row, power, variance_mps2, duration_s, residuals_mps } = this.#waiting.shift();
      this.#fit.learn(row, power, variance_mps2, duration_s);
      this.#noise.learn(residuals_mps, duration_s);
      this.#learned_s += duration_s;
    }
  }

  // Evidence of one sample that the thrust is missing, from the power itself; over seconds, a gust is one sample.
  #absenceIn({ duration_s, features }, thrust_mps) {
    const { thrust_ratio } = this.#options;
    const variance_mps2 = this.#noise.gust_mps2 + this.#fit.variance(features) + (thrust_ratio * thrust_mps) ** 2;
    const missing_mps = -this.#residuals_mps.at(-1) - thrust_mps / 2;
    return ((thrust_mps * missing_mps) / variance_mps2) * (duration_s / defaultPowerNoise.gusts_s);
  }

  #watchRecovery(absence) {
    this.#recovery = Math.max(0, this.#recovery - absence);
    this.#absence = 0;
    this.#evidence = 0;
    this.#onsets = [];
    this.#waiting = [];
  }
}

// Over ground, along the heading half way through a turn, to which the turn's own acceleration is square.
function forward_mps2(before, motion, duration_s) {
  const middle_rad = before.heading_rad + wrapped(motion.heading_rad - before.heading_rad) / 2;
  return ((motion.east_mps - before.east_mps) * Math.sin(middle_rad) +
    (motion.north_mps - before.north_mps) * Math.cos(middle_rad)) / duration_s;
}
