// A stand-in aircraft, the link and guidance, with a made-up answer of recall, in stepped time.

import assert from 'node:assert/strict';

import { EngineFailure } from '../../server/mavlink/guidance/engine_failure.js';
import { FlatFrame } from '../../server/mavlink/flat_frame.js';
import { Landings } from '../../server/mavlink/mission/landings.js';
import { Link } from '../../server/mavlink/link.js';
import { Outgoing } from '../../server/mavlink/outgoing.js';
import { Standin } from './standin/aircraft.js';
import { smallAircraft } from './trial/trial_plane.js';

const final_m = 71;
const finalHeight_m = 10;
const ratio = 7;
const turns = () => new Promise((resolve) => { setImmediate(resolve); });

// Straight ahead from where the aircraft is, and from there the final, to flat ground.
function siteAhead({ position, velocity }, ground_m) {
  const frame = new FlatFrame(position);
  const speed = Math.hypot(velocity.east_mps, velocity.north_mps);
  const glide_m = (position.altitude_m - ground_m - finalHeight_m) * ratio;
  const place = (along_m, altitude_m) => ({
    ...frame.toGlobal({ east_m: (along_m * velocity.east_mps) / speed, north_m: (along_m * velocity.north_mps) / speed }), altitude_m });
  const start = place(glide_m, ground_m + finalHeight_m);
  const touchdown = place(glide_m + final_m, ground_m);
  const centre = place(glide_m, ground_m + finalHeight_m);
  return {
    site_id: 'ahead', verdict: 'landable', arrival_margin_m: 0, altitude_datum: 'amsl', touchdown,
    ground_speed_mps: 10, aircraft: { landing_airspeed_mps: 10, glide_ratio: ratio },
    approach: { start, loiter_center: centre, loiter_radius_m: 20, loiter_direction: 'left', height_m: finalHeight_m,
      heading_deg: (Math.atan2(velocity.east_mps, velocity.north_mps) * 180) / Math.PI },
    times_s: [0, glide_m / 2, glide_m, glide_m + final_m].map((along_m) => along_m / 10),
    path: { type: 'LineString', coordinates: [place(0, position.altitude_m),
      place(glide_m / 2, (position.altitude_m + start.altitude_m) / 2), start, touchdown]
      .map(({ latitude_deg, longitude_deg, altitude_m }) => [longitude_deg, latitude_deg, altitude_m]) },
  };
}

export class Chain {
  log = [];
  sent = [];
  told = [];
  numAsked = 0;
  isServiceThere = true;

  constructor({ isAutomatic = true, mode = 'AUTO' } = {}) {
    this.plane = new Standin({ seed: 4, wind: { speed_mps: 0 }, aircraft: { ...smallAircraft.aircraft, max_glide_ratio: 7.1 },
      parameters: smallAircraft.parameters });
    this.link = new Link({ emit: () => {}, steady_us: () => this.plane.time_s * 1e6,
      onMessage: (name, fields) => this.landings.hear(name, fields, this.plane.time_s) });
    const outgoing = new Outgoing({ systemId: () => 1, send: (bytes) => this.plane.take(bytes) });
    const send = outgoing.send.bind(outgoing);
    outgoing.send = (name, fields) => {
      this.sent.push({ time_s: this.plane.time_s, mode: this.plane.control.mode, altitude_m: this.plane.truth.altitude_m, name, fields });
      send(name, fields);
    };
    const log = (text, kind) => this.log.push({ time_s: this.plane.time_s, text, kind });
    this.landings = new Landings({ service: {}, out: outgoing, address: () => this.link.pin, linkState: () => this.link.state(),
      log: (kind, text) => log(text, kind), told: () => {} });
    this.failure = new EngineFailure({ recall: () => this.recall(), outgoing, landings: this.landings, address: () => this.link.pin,
      state: () => this.state(), log, told: (...told) => this.told.push(told), isAutomatic });
    this.plane.onSend = (bytes) => this.link.take(bytes, '127.0.0.1 5760', true, this.plane.utc_us);
    this.plane.loadMission([this.#wayPoint(0, 0), this.#wayPoint(0, 0), this.#wayPoint(2600, 3100)]);
    this.plane.startInFlight({ height_m: 90, heading_deg: 40, airspeed_mps: 15, mode });
  }

  #wayPoint(east_m, north_m) {
    const { latitude_deg, longitude_deg } = this.plane.frame.toGlobal({ east_m, north_m });
    return { frame: 0, command: 16, param1: 0, param2: 0, param3: 0, param4: 0,
      x: Math.round(latitude_deg * 1e7), y: Math.round(longitude_deg * 1e7), z: 520 };
  }

  // engine: instead of what the link tells.
  state() {
    return { ...this.link.state(this.plane.utc_us), mission: this.landings.state(), ...(this.engine && { engine: this.engine }) };
  }

  async recall() {
    ++this.numAsked;
    if (!this.isServiceThere) throw new Error('refused');
    this.site = this.failure.guidance.isEngaged ? this.site ?? siteAhead(this.state(), 430) : siteAhead(this.state(), 430);
    return { sites: [this.site], warnings: [] };
  }

  async fly(duration_s, isOver = () => false) {
    const end_s = this.plane.time_s + duration_s;
    while (this.plane.time_s < end_s && !isOver()) {
      this.plane.step(0.1);
      this.landings.step(this.plane.time_s);
      this.failure.step(this.plane.time_s, this.plane.utc_us);
      await turns();
    }
  }

  async failEngine() {
    await this.fly(15);
    this.site = undefined;
    this.plane.stopEngine();
    await this.fly(10, () => this.failure.guidance.isEngaged);
    assert.ok(this.failure.guidance.isEngaged, 'the failure is told');
    this.engaged_s = this.plane.time_s;
  }

  targets() { return this.sent.filter(({ name, time_s }) => name === 'COMMAND_INT' && time_s >= this.engaged_s); }
  land() { return this.fly(200, () => this.plane.touchdown !== undefined); }
}
