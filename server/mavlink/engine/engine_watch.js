// Detects that the engine no longer does what the throttle demands.
//
// Specific excess power e = climb + airspeed * acceleration / g, in m/s: the climb rate that would
// be left at constant airspeed. The acceleration is that over ground along the heading: a gust
// changes the airspeed at once, but hardly the speed over ground.
// While the engine runs, the e of throttle demand, airspeed and bank is learned (power_model.js). There are two
// signs of a failure: the power has dropped within seconds (power_drop.js), or energy is missing: against the
// lower bound of e, in metres of height, summed up. The second one is also there before much is learned, and
// for an engine that fails slowly or at idle. RPM and current, where the autopilot sends them, confirm a
// failure sooner; they never raise an alarm on their own.

import { PowerDrop } from './power_drop.js';
import { PowerModel } from './power_model.js';

const gravity_mps2 = 9.81;

const defaultEngineOptions = {
  // Ground velocity and climb are compared over this time.
  window_s: 0.8,
  // The engine is given this long to follow the throttle.
  spoolUp_s: 1.0,
  // Below this demand a stopped engine looks like an idle one.
  minThrottle_ratio: 0.1,
  // Sinking air and turbulence take this much without a failure.
  tolerance_mps: 2.0,
  // The same if every sign of the engine has gone: a good glider sinks no faster than that.
  toleranceConfirmed_mps: 0.2,
  // How many standard deviations below its estimate the power is expected.
  numSds: 2,
  numSdsConfirmed: 0.5,
  // More for a hard turn, times (1 / cos^2 bank - 1).
  turnTolerance_mps: 1.0,
  // Missing height that is a failure; the smaller one if RPM or current has also gone.
  missingHeight_m: 12.0,
  missingHeightConfirmed_m: 0.8,
  // RPM or current below this share of what the same throttle gave has gone.
  goneShare_ratio: 0.25,
  // Not in flight below these.
  minAirspeed_mps: 8.0,
  minHeight_m: 5.0,
  // RPM and current of a demand count as learned after so many seconds.
  minLearned_s: 3.0,
  // Power counts as learned after so many seconds.
  minPowerLearned_s: 30.0,
  // Up to the usual airspeed, this demand should hold height, and full throttle should climb so fast.
  levelThrottle_ratio: 0.7,
  fullPower_mps: 1.0,
  // Less doubt at full throttle.
  toleranceFull_mps: 1.0,
  // The engine is believed again after it has delivered for this long.
  recovery_s: 5.0,
};

const numBins = 10;
const binOf = (throttle) => Math.min(numBins - 1, Math.floor(throttle * numBins));
const learnRate = 0.05;

// What each throttle demand gave.
class ThrottleMap {
  #bins = Array.from({ length: numBins }, () => ({ seconds: 0, mean: 0 }));

  learn(throttle, value, duration_s) {
    const bin = this.#bins[binOf(throttle)];
    bin.seconds += duration_s;
    // A true mean first, a slow one later.
    const rate = Math.max(learnRate * duration_s, duration_s / bin.seconds);
    bin.mean += Math.min(1, rate) * (value - bin.mean);
  }

  // More throttle gives at least what less of it gave.
  expected(throttle, minSeconds) {
    const known = this.#bins.slice(0, binOf(throttle) + 1).filter((b) => b.seconds >= minSeconds);
    return known.length ? Math.max(...known.map((b) => b.mean)) : undefined;
  }
}

export class EngineWatch {
  #options;
  #history = [];
  #throttles = [];
  #power = new PowerModel();
  #drop = new PowerDrop();
  #highest_mps = 0;
  #signs = { rpm: new ThrottleMap(), current_a: new ThrottleMap() };
  #now = {};
  #missing_m = 0;
  #well_s = 0;
  #demandedSince_s;
  state = 'unknown';
  since_s;
  reason;

  constructor(options = {}) {
    this.#options = { ...defaultEngineOptions, ...options };
  }

  // sign: 'rpm' or 'current_a'.
  hearSign(sign, value, time_s) {
    if (Number.isFinite(value) && value >= 0) this.#now[sign] = { value, time_s };
  }

  hearThrottle(throttle_ratio, time_s) {
    if (!Number.isFinite(throttle_ratio)) return;
    this.#throttles.push({ time_s, throttle: Math.min(1, Math.max(0, throttle_ratio)) });
    this.#drop.hearThrottle(this.#throttles.at(-1).throttle, time_s);
    const oldest_s = time_s - this.#options.spoolUp_s;
    while (this.#throttles[0].time_s < oldest_s) this.#throttles.shift();
  }

  // At each position. airspeed_mps: the best known. True if the state has changed.
  step({ time_s, east_mps, north_mps, climb_mps, heading_rad, bank_rad, airspeed_mps, isArmed, height_m }) {
    const before = this.state;
    const options = this.#options;
    this.#history.push({ time_s, east_mps, north_mps, heading_rad });
    while (this.#history.length > 2 && this.#history[1].time_s <= time_s - options.window_s) {
      this.#history.shift();
    }
    const isFlying = isArmed && airspeed_mps >= options.minAirspeed_mps &&
      !(height_m < options.minHeight_m);
    if (!isArmed) this.#land();
    if (isFlying) this.#drop.step({ time_s, east_mps, north_mps, climb_mps, heading_rad, bank_rad, airspeed_mps }, this.state === 'failed');
    else this.#drop.restart();
    const start = this.#history[0];
    const duration_s = time_s - start.time_s;
    const isFresh = duration_s > 0.3 && duration_s < 3;
    if (!isFlying || !isFresh || this.#throttles.length === 0) return this.state !== before;
    // Along the heading half way through a turn, to which the turn's own acceleration is square.
    const turned_rad = Math.atan2(Math.sin(heading_rad - start.heading_rad), Math.cos(heading_rad - start.heading_rad));
    const middle_rad = start.heading_rad + turned_rad / 2;
    const forward_mps2 = ((east_mps - start.east_mps) * Math.sin(middle_rad) +
      (north_mps - start.north_mps) * Math.cos(middle_rad)) / duration_s;
    const power_mps = climb_mps + (airspeed_mps * forward_mps2) / gravity_mps2;
    const step_s = Math.min(1, time_s - this.#history.at(-2).time_s);
    this.#judge({ power_mps, bank_rad, airspeed_mps, time_s, step_s });
    return this.state !== before;
  }

  #judge({ power_mps, bank_rad, airspeed_mps, time_s, step_s }) {
    const options = this.#options;
    // The least demand of the last second: the engine has had its time to follow.
    const throttle = Math.min(...this.#throttles.map((one) => one.throttle));
    const load = 1 / Math.max(0.4, Math.cos(bank_rad));
    const isDemanded = throttle >= options.minThrottle_ratio;
    this.#demandedSince_s = isDemanded ? this.#demandedSince_s ?? time_s : undefined;
    const gone = this.#goneSigns(throttle, time_s);
    const expected_mps = this.#expectedPower({ throttle, airspeed_mps, load }, gone);
    const tolerance_mps = gone ? options.toleranceConfirmed_mps : this.#tolerance_mps(throttle);
    const allowed_mps = tolerance_mps + options.turnTolerance_mps * (load ** 2 - 1);
    const below_mps = expected_mps === undefined || !isDemanded
      ? -options.tolerance_mps : expected_mps - power_mps - allowed_mps;
    // Without an engine only rising air lifts.
    const deficit_mps = power_mps > 0 && !gone ? Math.min(below_mps, -power_mps) : below_mps;
    this.#missing_m = Math.max(0, this.#missing_m + deficit_mps * step_s);
    const limit_m = gone ? options.missingHeightConfirmed_m : options.missingHeight_m;
    if (this.#missing_m > limit_m || this.#drop.isDrop(gone)) this.#fail(time_s, gone);
    else if (this.state === 'failed') this.#recover(deficit_mps, isDemanded, gone, step_s);
    else if (isDemanded && expected_mps !== undefined) this.state = 'running';
    const isSteady = this.#throttles.every((one) => Math.abs(one.throttle - throttle) < 0.1);
    if (this.state !== 'failed' && this.#missing_m === 0 && isSteady) {
      this.#learn({ throttle, airspeed_mps, load }, power_mps, time_s, step_s);
    }
    // A long failure is not undone by a short burst, and not paid back for minutes either.
    this.#missing_m = Math.min(this.#missing_m, 2 * options.missingHeight_m);
  }

  // 0 at the demand that holds height, 1 at full throttle; negative below.
  #shareOfFull(throttle) {
    const { levelThrottle_ratio } = this.#options;
    return Math.min(1, (throttle - levelThrottle_ratio) / (0.95 - levelThrottle_ratio));
  }

  #tolerance_mps(throttle) {
    const { tolerance_mps, toleranceFull_mps } = this.#options;
    return tolerance_mps + Math.max(0, this.#shareOfFull(throttle)) * (toleranceFull_mps - tolerance_mps);
  }

  #expectedPower(state, gone) {
    const options = this.#options;
    const isLearned = this.#power.seconds >= options.minPowerLearned_s;
    const numSds = gone ? options.numSdsConfirmed : options.numSds;
    const learned_mps = isLearned ? this.#power.bound_mps(state, this.#highest_mps, numSds) : undefined;
    const share = this.#shareOfFull(state.throttle);
    const isUsual = !isLearned || state.airspeed_mps <= this.#highest_mps + 1;
    if (share < 0 || !isUsual) return learned_mps;
    return Math.max(learned_mps ?? 0, share * options.fullPower_mps);
  }

  #learn(state, power_mps, time_s, step_s) {
    const throttles = this.#throttles.map((one) => one.throttle);
    const throttle = throttles.reduce((sum, one) => sum + one, 0) / throttles.length;
    this.#power.learn({ ...state, throttle }, power_mps, step_s);
    // The highest airspeed that lasts.
    this.#highest_mps += (state.airspeed_mps > this.#highest_mps ? 0.1 : 0.005) * step_s *
      (state.airspeed_mps - this.#highest_mps);
    for (const [sign, map] of Object.entries(this.#signs)) {
      const now = this.#now[sign];
      if (now && time_s - now.time_s < 2) map.learn(throttle, now.value, step_s);
    }
  }

  // What says that the engine stands, if nothing says that it runs: "rpm and current_a".
  #goneSigns(throttle, time_s) {
    if (this.#demandedSince_s === undefined) return undefined;
    const names = [];
    for (const [sign, map] of Object.entries(this.#signs)) {
      const now = this.#now[sign];
      const usual = map.expected(throttle, this.#options.minLearned_s);
      if (!now || !usual || time_s - now.time_s > 2) continue;
      // Measured before the engine could follow.
      if (now.time_s < this.#demandedSince_s) return undefined;
      if (now.value >= this.#options.goneShare_ratio * usual) return undefined;
      names.push(sign);
    }
    return names.length ? names.join(' and ') : undefined;
  }

  #fail(time_s, gone) {
    this.#well_s = 0;
    if (this.state === 'failed') return;
    this.state = 'failed';
    this.since_s = time_s;
    this.reason = gone ? `climb and speed do not follow the throttle, and ${gone} has gone`
      : 'climb and speed do not follow the throttle';
  }

  #recover(deficit_mps, isDemanded, gone, step_s) {
    const isWell = isDemanded && deficit_mps <= 0 && !gone;
    this.#well_s = isWell ? this.#well_s + step_s : 0;
    if (this.#well_s >= this.#options.recovery_s && this.#drop.hasRecovered) this.#clear('running');
  }

  #land() {
    if (this.state !== 'unknown') this.#clear('unknown');
    this.#missing_m = 0;
  }

  #clear(state) {
    this.state = state;
    this.since_s = undefined;
    this.reason = undefined;
    this.#well_s = 0;
    this.#drop.restart();
  }
}
