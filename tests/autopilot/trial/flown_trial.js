// One flight of the trial: the stand-in flies a route over the mosaic, its engine stops, and the
// link guides it down. Simulated time waits while the service answers; the answer comes as much
// later as it took.

import { EngineFailure } from '../../../server/mavlink/guidance/engine_failure.js';
import { defaultGuidanceOptions } from '../../../server/mavlink/guidance/guidance.js';
import { Landings } from '../../../server/mavlink/mission/landings.js';
import { Link } from '../../../server/mavlink/link.js';
import { Outgoing } from '../../../server/mavlink/outgoing.js';
import { queryOf } from '../../../server/mavlink/guidance/recall_query.js';
import { Random } from '../standin/random.js';
import { defaultTrialOptions, planeOver, startRoute } from './trial_plane.js';

const step_s = 0.02;
const tick_s = 0.1;
const track_s = 0.1;
const minFlight_s = 20;
const maxFlight_s = 150;
const longest_s = 240;
const afterTouchdown_s = 12;

// The surveys' flights are no longer in the service, only their sites.
const withoutFlight = ({ flight, ...query }) => query;
const sleepless = () => new Promise((resolve) => { setImmediate(resolve); });

export class FlownTrial {
  #random;
  #ground;
  #service;
  #survey;
  #plane;
  #link;
  #landings;
  #failure;
  #options;
  #waiting = [];
  #asked = new Set();
  #log = [];
  #track = [];
  #ways = [];
  #firstTarget_s;
  #detected_s;
  #stopped_s;
  #final;

  // service: emergency(query). surveys: as of surveys.js; the flight is over one of them. altimeter:
  // "survey" has the error of that survey, "true" has none.
  constructor({ ground, service, surveys, seed, ...options }) {
    this.#ground = ground;
    this.#service = service;
    this.#options = { ...defaultTrialOptions, ...options, seed };
    this.#random = new Random(seed);
    this.#survey = surveys[Math.floor(this.#random.uniform() * surveys.length)];
    this.#plane = planeOver(this.#survey, { ground, random: this.#random, ...this.#options });
    this.#link = new Link({
      emit: () => {}, steady_us: () => this.#plane.time_s * 1e6, onEvent: (text) => this.#note('link', text),
      onMessage: (name, fields) => this.#landings.hear(name, fields, this.#plane.time_s),
    });
    this.#connect();
    this.#plane.onSend = (bytes) => this.#link.take(bytes, '127.0.0.1 5760', true, this.#plane.utc_us);
  }

  // As freelsd-mavlink.js does, without sockets.
  #connect() {
    const outgoing = new Outgoing({ send: (bytes) => this.#plane.take(bytes), systemId: () => this.#link.pin.systemId });
    const send = outgoing.send.bind(outgoing);
    outgoing.send = (name, fields) => {
      if (name === 'COMMAND_INT') this.#firstTarget_s ??= this.#plane.time_s;
      if (this.#final && name !== 'HEARTBEAT') ++this.#final.num_sent;
      send(name, fields);
    };
    const common = {
      address: () => this.#link.pin, told: () => {}, log: (text, kind) => this.#note(kind, text),
    };
    this.#landings = new Landings({
      ...common, out: outgoing, linkState: () => this.#link.state(this.#plane.utc_us),
      log: (kind, text) => this.#note(kind, text), service: {},
    });
    this.#failure = new EngineFailure({
      ...common, recall: (query) => this.#ask(query), outgoing, landings: this.#landings,
      state: () => this.#state(), isAutomatic: true,
    });
  }

  get #guidance() { return this.#failure.guidance; }

  #note(kind, text) { this.#log.push({ time_s: this.#plane.time_s, kind, text }); }

  // Answers arrive in simulated time.
  #ask(query) {
    const begun_ms = performance.now();
    const asked_s = this.#plane.time_s;
    return new Promise((resolve, reject) => {
      const later = (done) => {
        this.#asked.delete(asked);
        this.#waiting.push({ due_s: asked_s + (performance.now() - begun_ms) / 1000, done });
      };
      const asked = this.#service.emergency(withoutFlight(query)).then(
        (answer) => later(() => resolve(answer)), (error) => later(() => reject(error)));
      this.#asked.add(asked);
    });
  }

  async #step() {
    this.#plane.step(step_s);
    const due = this.#waiting.filter((one) => one.due_s <= this.#plane.time_s);
    if (due.length) {
      this.#waiting = this.#waiting.filter((one) => !due.includes(one));
      due.forEach((one) => one.done());
      await sleepless();
    }
    while (this.#asked.size > 0) await Promise.all(this.#asked);
  }

  #state() {
    return { ...this.#link.state(this.#plane.utc_us), mission: this.#landings.state(), flight: { id: this.#survey.flight_id } };
  }

  async #pass(duration_s, isOver = () => false) {
    const end_s = this.#plane.time_s + duration_s - step_s / 2;
    while (this.#plane.time_s < end_s && !isOver()) {
      for (let t = 0; t < tick_s - step_s / 2; t += step_s) await this.#step();
      this.#tick();
    }
  }

  #tick() {
    const now_s = this.#plane.time_s;
    const truth = this.#plane.truth;
    if (this.#stopped_s !== undefined) {
      this.#track.push([now_s, truth.latitude_deg, truth.longitude_deg, truth.altitude_m,
        truth.airspeed_mps, truth.bank_deg, truth.throttle]);
    }
    this.#landings.step(now_s);
    this.#failure.step(now_s, this.#plane.utc_us);
    if (this.#guidance.isEngaged) this.#detected_s ??= now_s;
    this.#watchWay(truth);
  }

  #watchWay(truth) {
    const { way } = this.#guidance;
    if (way && way !== this.#ways.at(-1)?.way) this.#ways.push({ time_s: this.#plane.time_s, way });
    const phase = this.#guidance.state()?.phase;
    if (phase === 'final' && !this.#final) {
      this.#final = { time_s: this.#plane.time_s, ...this.#guidance.state(), airspeed_mps: truth.airspeed_mps, num_sent: 0 };
    }
  }

  // Route, then the engine stops where a site is in reach. Gives the report of the flight; nothing
  // if no such moment came.
  async fly() {
    startRoute(this.#plane, this.#random);
    await this.#pass(minFlight_s + this.#random.between(0, 30));
    const told = await this.#waitForSite();
    if (!told) return undefined;
    this.#stopped_s = this.#plane.time_s;
    this.#plane.stopEngine();
    await this.#pass(longest_s, () => this.#plane.touchdown !== undefined);
    await this.#pass(afterTouchdown_s);
    return this.#report(told);
  }

  async #waitForSite() {
    const end_s = this.#plane.time_s + maxFlight_s;
    while (this.#plane.time_s < end_s) {
      const state = this.#state();
      const answer = await this.#service.emergency(withoutFlight(queryOf(state, state.wind, { touchdownUncertainty_m: defaultGuidanceOptions.touchdownUncertainty_m }))).catch(() => undefined);
      if (answer?.sites.length) return answer;
      await this.#pass(2);
    }
    return undefined;
  }

  #report(told) {
    const way = this.#guidance.way;
    const { touchdown } = this.#plane;
    const { wind } = this.#plane.options;
    return {
      id: String(this.#options.seed), wind_mps: wind.speed_mps, wind_from_deg: wind.from_deg,
      glide_ratio: this.#plane.options.aircraft.max_glide_ratio,
      num_told: told.sites.length, told_landable: told.sites.some((site) => site.verdict === 'landable'),
      detection_s: this.#detected_s - this.#stopped_s, first_target_s: this.#firstTarget_s - this.#detected_s,
      flight_s: (touchdown?.time_s ?? NaN) - this.#stopped_s,
      survey: this.#survey, site_flight_id: way?.site.flight_id,
      touchdown: way && way.site.touchdown, touchdown_uncertainty_m: way?.site.aircraft.touchdown_uncertainty_m, heading_deg: way?.site.approach.heading_deg,
      ground_speed_mps: way?.site.ground_speed_mps, verdict: way?.site.verdict,
      failure_probability: way?.site.failure_probability, told_margin_m: this.#guidance.state()?.told_margin_m,
      final: this.#final, num_ways: this.#ways.length, sites: [...new Set(this.#ways.map((one) => one.way.site.site_id))],
      contact: touchdown && { latitude_deg: touchdown.latitude_deg, longitude_deg: touchdown.longitude_deg },
      sink_mps: touchdown?.sink_mps, touchdown_airspeed_mps: touchdown?.airspeed_mps, is_flared: touchdown?.isFlared,
      points: this.#track, log: this.#log,
      paths: this.#ways.map((one) => ({ time_s: one.time_s, path: one.way.site.path.coordinates })),
    };
  }
}
