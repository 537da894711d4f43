// Flies an aircraft whose engine has failed to a site: by targets to the start of the final, then
// by a landing mission, on which nothing is sent. No sockets: what it asks and sends is handed in.

import { GlideShare } from './glide_share.js';
import { choose, defaultChoiceOptions, hasWay } from './guidance_choice.js';
import { FinalGate } from './guidance_final.js';
import { ModeWatch } from './guidance_modes.js';
import { defaultTargetOptions, glideAirspeed_mps, kinetic_m, targetOn } from './guidance_target.js';
import { queryOf, WindHold } from './recall_query.js';
import { isSameFinal, ToldWay } from './told_way.js';
import { isPlaceKnown, longestGap_s } from '../plausibility.js';

export const defaultGuidanceOptions = {
  recallPeriod_s: 1,
  // Before a failure: the answer that is there if the service cannot be reached then.
  watchPeriod_s: 5,
  targetPeriod_s: 0.5,
  // An answer is for where the aircraft was; on a worse link it is of no use.
  maxAnswerAge_s: 3,
  // A way is searched ahead of the last place on it, as far as the aircraft gets in this time.
  search_s: 6,
  // Another site at the earliest after so long.
  minStay_s: 10,
  // The way is flown so much lower: turns and airspeed that is left end above it.
  aimLow_m: 1.5,
  // Autopilots come down within so much of the told touchdown in 9 of 10 landings without an engine
  // (decision 0044). The ground is judged for all of it.
  touchdownUncertainty_m: 14,
  choice: defaultChoiceOptions,
  target: defaultTargetOptions,
};

// What is left of airspeed that becomes height.
const kineticShare = 0.9;
const lastLook_s = 2;
// A way is flown without another answer, if it was told for where the aircraft was so shortly before.
const recentAnswer_s = 10;
// A new answer is waited for: if there is a recent one, or the service was away; and if there is none.
const patienceOfAny_s = 1;
const patienceOfNone_s = 3;
// A landing mission that was refused or replaced is written again after so long.
const prepareAgain_s = 3;

export class Guidance {
  #recall;
  #autopilot;
  #mission;
  #log;
  #options;
  #wind = new WindHold();
  #modes;
  #gate;
  #glide;
  #answer;
  #isAsking = false;
  #asked_s = -Infinity;
  #sent_s = -Infinity;
  #isReachable = true;
  #isEngaged = false;
  #way;
  #progress;
  #prepared;
  #told_m;
  #taken_s = -Infinity;
  #since;
  #text;
  #phase;
  // Why nothing is sent yet, as told.
  #waitsFor;
  #wasPlaceKnown = true;

  // recall(query): answer of /v1/emergency. autopilot: goTo(target, mayChangeMode), setSpeed(mps),
  // beginFinal(). mission: prepare(site), a promise of the landing mission in the autopilot;
  // abandon(why): it is not wanted any more; hasLanding(site): it is there; isBusy.
  // log(text, kind): one decision.
  constructor({ recall, autopilot, mission, log, options = {} }) {
    this.#recall = recall;
    this.#autopilot = autopilot;
    this.#mission = mission;
    this.#log = log;
    this.#options = { ...defaultGuidanceOptions, ...options };
  }

  get isEngaged() { return this.#isEngaged; }
  get isOnFinal() { return this.#isEngaged && this.#phase === 'final'; }
  get way() { return this.#way; }
  // Another ground station may have written since it was prepared.
  get hasLanding() {
    const isPrepared = this.#isEngaged && this.#prepared?.isReady === true;
    return isPrepared && this.#mission.hasLanding(this.#way.site.site_id);
  }

  // reason: why the engine counts as failed. now_us: UTC.
  engage(state, reason, now_us) {
    if (this.#isEngaged) return;
    this.#isEngaged = true;
    this.#modes = new ModeWatch(state);
    this.#gate = new FinalGate();
    this.#glide = new GlideShare();
    this.#way = undefined;
    this.#prepared = undefined;
    this.#waitsFor = undefined;
    this.#wasPlaceKnown = true;
    this.#phase = undefined;
    this.#since = new Date(now_us / 1000).toISOString();
    this.#asked_s = -Infinity;
    this.#decide(`engine failure: ${reason}`, 'engine');
  }

  release(reason) {
    if (!this.#isEngaged) return;
    this.#isEngaged = false;
    this.#phase = 'ended';
    this.#prepared = undefined;
    this.#mission.abandon('guidance has ended');
    this.#decide(`guidance ended: ${reason}`, 'guidance');
  }

  // Several times a second. now_s: a clock that never steps.
  step(heard, now_s) {
    if (!heard.position || !heard.velocity) return;
    const lower_m = this.#isEngaged && this.#way ? this.#options.aimLow_m : 0;
    const altitude_m = heard.position.altitude_m + lower_m;
    const state = { ...heard, position: { ...heard.position, altitude_m } };
    const period_s = this.#isEngaged ? this.#options.recallPeriod_s : this.#options.watchPeriod_s;
    const isWanted = isPlaceKnown(heard) && (this.#isEngaged ? this.#phase !== 'final' : state.is_armed);
    if (isWanted && !this.#isAsking && now_s - this.#asked_s >= period_s) this.#ask(state, now_s);
    if (!this.#isEngaged) return;
    const interference = this.#modes.interference(state, now_s);
    if (interference) this.release(interference);
    else if (this.#phase === 'final') this.#watchFinal(state);
    else if (!this.#hasPlace(heard)) return;
    else if (this.#way) this.#fly(state, now_s);
    else this.#begin(state, now_s);
  }

  // Without a place the autopilot circles the last target.
  #hasPlace(heard) {
    const isKnown = isPlaceKnown(heard);
    if (isKnown === this.#wasPlaceKnown) return isKnown;
    this.#wasPlaceKnown = isKnown;
    this.#phase ??= 'waiting';
    this.#decide(isKnown ? 'the place is known again' : `no position for ${longestGap_s} s: nothing is sent`, 'guidance');
    return isKnown;
  }

  state() {
    if (!this.#phase) return undefined;
    const way = this.#way;
    return {
      phase: this.#phase,
      site_id: way?.site.site_id,
      arrival_margin_m: way && this.#progress?.height_m + way.surplus_m,
      told_margin_m: this.#told_m,
      eta_s: way && this.#progress && way.timeToTouchdown_s(this.#progress.along_m),
      since: this.#since,
      text: this.#text,
    };
  }

  #decide(text, kind) {
    this.#text = text;
    this.#log(text, kind);
  }

  async #ask(state, now_s) {
    this.#isAsking = true;
    this.#asked_s = now_s;
    const wind = this.#wind.take(state.wind, (text) => this.#isEngaged && this.#decide(text, 'wind'));
    try {
      const answer = await this.#answerFor(state, wind);
      this.#answer = { answer, asked_s: now_s, isNew: true };
      this.#tellReachable(true);
    } catch (error) {
      this.#tellReachable(false, error.message);
    } finally {
      this.#isAsking = false;
    }
  }

  // A field that is too small for the autopilot's scatter is still better than none.
  async #answerFor(state, wind) {
    const isOnWay = this.#isEngaged && this.#way !== undefined;
    const ask = (touchdownUncertainty_m) => this.#recall(queryOf(state, wind, {
      airspeed_m: this.#surplus_m(state), better_m: this.#better_m(state),
      lower_m: isOnWay ? this.#options.aimLow_m : 0, touchdownUncertainty_m }));
    if (isOnWay) return ask(this.#way.site.aircraft.touchdown_uncertainty_m);
    const answer = await ask(this.#options.touchdownUncertainty_m);
    return answer.sites.length > 0 ? answer : ask();
  }

  // Only a way that is flown counts on airspeed and on a better glide: a site is chosen without.
  #surplus_m(state) {
    if (!this.#way || !this.#isEngaged || state.airspeed_mps === undefined) return 0;
    return kineticShare * kinetic_m(state.airspeed_mps, glideAirspeed_mps(this.#way.site));
  }

  // Height that the way may be planned higher, because less of it will be lost.
  #better_m(state) {
    if (!this.#way || !this.#isEngaged) return 0;
    const left_m = state.position.altitude_m - this.#way.site.approach.start.altitude_m;
    return Math.max(0, left_m) * (1 / this.#glide.share - 1);
  }

  #nearest(state, from_m, to_m) {
    const nearest = this.#way.nearest(state.position, from_m, to_m);
    const energy_m = nearest.height_m + this.#surplus_m(state);
    const { altitude_m } = this.#way.at(nearest.along_m);
    this.#glide.add(this.#way, altitude_m, energy_m);
    const left_m = Math.max(0, altitude_m - this.#way.finalStartAltitude_m);
    return { ...nearest, energy_m: energy_m + (1 - this.#glide.share) * left_m };
  }

  #tellReachable(isReachable, why) {
    if (isReachable === this.#isReachable) return;
    this.#isReachable = isReachable;
    if (!this.#isEngaged) return;
    if (isReachable) this.#decide('the service answers again', 'service');
    else if (this.#way) this.#decide(`the service does not answer (${why}): the last way is flown on`, 'service');
  }

  // An answer from before is better than none, when the service is away.
  #begin(state, now_s) {
    const given = this.#answer;
    const isRecent = given !== undefined && now_s - given.asked_s <= recentAnswer_s;
    const patience_s = isRecent || !this.#isReachable ? patienceOfAny_s : patienceOfNone_s;
    if (this.#isAsking && now_s - this.#asked_s < patience_s) return;
    const sites = (given?.answer.sites ?? []).filter((site) => isRecent || this.#isOn(site, state));
    const chosen = choose({ answer: { sites }, flightId: state.flight?.id }, this.#options.choice);
    if (given) given.isNew = false;
    if (!chosen) {
      this.#wait(isRecent ? 'no site is in reach' : 'the service does not answer, and no way is known from here');
      return;
    }
    const old = `on its way of ${(now_s - given.asked_s).toFixed(0)} s ago`;
    this.#take(isRecent ? chosen : { ...chosen, reason: old }, state, now_s);
    this.#fly(state, now_s);
  }

  #wait(why) {
    this.#phase = 'waiting';
    if (this.#waitsFor === why) return;
    this.#waitsFor = why;
    this.#decide(`${why}: nothing is sent`, 'guidance');
  }

  // An aircraft that is still on a way of an old answer, and not below it.
  #isOn(site, { position }) {
    if (!hasWay(site)) return false;
    const { away_m, height_m } = new ToldWay(site).nearest(position);
    const { maxAside_m, maxLow_m } = this.#options.choice;
    return away_m <= maxAside_m && height_m >= -maxLow_m;
  }

  #take({ site, reason }, state, now_s) {
    const isOther = site.site_id !== this.#way?.site.site_id;
    const isOtherFinal = isOther || !isSameFinal(site, this.#way.site);
    this.#way = new ToldWay(site);
    this.#progress = this.#nearest(state, 0, 60);
    if (this.#progress.away_m > 60) this.#progress = this.#nearest(state);
    const { numCircles } = this.#way;
    const what = `${this.#way.length_m.toFixed(0)} m, ${numCircles} ${numCircles === 1 ? 'circle' : 'circles'}`;
    if (isOtherFinal) this.#prepare(site, now_s);
    if (!isOther) {
      this.#decide(`new way to ${site.site_id}: ${reason}; ${what}`, 'guidance');
      return;
    }
    this.#told_m = site.arrival_margin_m;
    this.#taken_s = now_s;
    this.#decide(`to site ${site.site_id}: ${reason}; margin ${this.#told_m.toFixed(1)} m, ${what}${this.#scatterOf(site)}`,
      'guidance');
    this.#sent_s = now_s - this.#options.targetPeriod_s;
  }

  #scatterOf({ aircraft }) {
    const free_m = aircraft.touchdown_uncertainty_m;
    const wanted_m = this.#options.touchdownUncertainty_m;
    return free_m < wanted_m ? `; planned for a touchdown within ${free_m} m, autopilots need ${wanted_m} m` : '';
  }

  #prepare(site, now_s) {
    const problemBefore = this.#prepared?.problem;
    const prepared = { isReady: false, begun_s: now_s, problem: undefined };
    this.#prepared = prepared;
    this.#mission.prepare(site).then(() => {
      prepared.isReady = true;
      if (this.#prepared === prepared) this.#decide('the landing mission is in the autopilot', 'mission');
    }, (error) => {
      prepared.problem = error.message;
      const isNew = this.#prepared === prepared && error.message !== problemBefore;
      if (isNew) this.#decide(`no landing mission: ${error.message}`, 'mission');
    });
  }

  // Once more, if it could not be written, or if somebody else has written since.
  #prepareAgain(mission, now_s) {
    const { isReady, problem, begun_s } = this.#prepared;
    const isReplaced = isReady && mission?.state === 'current' && !this.hasLanding;
    const isDue = now_s - begun_s >= prepareAgain_s && !this.#mission.isBusy;
    if (isDue && (isReplaced || problem !== undefined)) this.#prepare(this.#way.site, now_s);
  }

  #fly(state, now_s) {
    const reach_m = this.#options.search_s * state.ground_speed_mps + 10;
    const from_m = this.#progress.along_m - 5;
    this.#progress = this.#nearest(state, from_m, from_m + reach_m);
    this.#reconsider(state, now_s);
    this.#addCircle();
    this.#prepareAgain(state.mission, now_s);
    if (this.#gate.isOpen(this.#way, this.#progress, state) && this.hasLanding) {
      this.#beginFinal(state, now_s);
      return;
    }
    this.#phase = this.#progress.along_m < this.#way.arrival_m ? 'glide' : 'circle';
    if (now_s - this.#sent_s < this.#options.targetPeriod_s - 0.02) return;
    this.#sent_s = now_s;
    const target = targetOn(this.#way, this.#progress, state, this.#options.target);
    target.altitude_m -= this.#options.aimLow_m;
    this.#autopilot.goTo(target, this.#modes.mayChange);
    this.#modes.sendsGuided(now_s);
    if (this.#modes.isGuided) this.#autopilot.setSpeed(glideAirspeed_mps(this.#way.site));
  }

  #reconsider(state, now_s) {
    const given = this.#answer;
    if (!given?.isNew || now_s - given.asked_s > this.#options.maxAnswerAge_s) return;
    given.isNew = false;
    const chosen = choose(
      { way: this.#way, progress: this.#progress, answer: given.answer, flightId: state.flight?.id,
        mayChangeSite: now_s - this.#taken_s > this.#options.minStay_s },
      this.#options.choice);
    if (chosen) this.#take(chosen, state, now_s);
  }

  // Where no told way loses the surplus: once more around, if the aircraft then arrives nearer to
  // the height of the final.
  #addCircle() {
    const way = this.#way;
    if (way.timeToFinal_s(this.#progress.along_m) > lastLook_s) return;
    const surplus_m = this.#progress.energy_m + way.surplus_m;
    if (surplus_m < this.#options.choice.maxSurplus_m) return;
    const longer = way.withCircle(way.site.aircraft.glide_ratio, glideAirspeed_mps(way.site));
    const left_m = this.#progress.energy_m + longer.surplus_m;
    if (left_m < -this.#options.choice.maxLow_m) return;
    this.#way = longer;
    this.#decide(`one more circle: ${surplus_m.toFixed(0)} m above the start of the final`, 'guidance');
  }

  #beginFinal(state, now_s) {
    this.#phase = 'final';
    this.#autopilot.beginFinal();
    this.#modes.sendsMission(now_s);
    const margin_m = this.#progress.height_m + this.#way.surplus_m;
    this.#decide(`final to ${this.#way.site.site_id}: ${margin_m.toFixed(1)} m above its start; ` +
      'nothing more is sent', 'guidance');
  }

  // The command itself may be lost.
  #watchFinal(state) {
    if (state.is_armed === false) this.release('landed and disarmed');
    else if (this.#modes.isMissionLate) this.#autopilot.beginFinal();
  }
}
