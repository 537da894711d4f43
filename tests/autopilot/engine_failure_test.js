// Guidance on a link, against the stand-in aircraft and a made-up answer of recall, without sockets.

import assert from 'node:assert/strict';
import test from 'node:test';

import { EngineFailure } from '../../server/mavlink/guidance/engine_failure.js';
import { FlatFrame } from '../../server/mavlink/flat_frame.js';
import { Landings } from '../../server/mavlink/mission/landings.js';
import { Link } from '../../server/mavlink/link.js';
import { Outgoing } from '../../server/mavlink/outgoing.js';
import { parseCommandLine } from '../../server/mavlink/command_line.js';
import { Standin } from './standin/aircraft.js';
import { smallAircraft } from './trial/trial_plane.js';

const final_m = 71;
const finalHeight_m = 10;
const ratio = 7;
const doSetMode = 176;
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

class Chain {
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

test('an engine that fails is followed by targets, a mission and a landing at the told place', async () => {
  const chain = new Chain();
  await chain.failEngine();
  await chain.land();
  const targets = chain.targets();
  assert.ok(targets[0].time_s - chain.engaged_s <= 2);
  for (const { altitude_m, fields } of targets) assert.ok(fields._param7 <= altitude_m + 1.5, 'no target is above the aircraft');
  const { touchdown } = chain.plane;
  const { east_m, north_m } = new FlatFrame(chain.site.touchdown).toLocal(touchdown);
  assert.ok(Math.hypot(east_m, north_m) < 12, `${east_m}, ${north_m}`);
  assert.equal(touchdown.mode, 'AUTO');
});

test('nothing is sent on the final', async () => {
  const chain = new Chain();
  await chain.failEngine();
  await chain.land();
  const last = chain.sent.findIndex(({ name, fields }) => name === 'COMMAND_LONG' && fields.command === doSetMode);
  assert.ok(last > 0);
  assert.deepEqual(chain.sent.slice(last + 1).map(({ name }) => name), []);
});

test('without the service the last way is flown on from memory', async () => {
  const chain = new Chain();
  await chain.failEngine();
  await chain.fly(5);
  chain.isServiceThere = false;
  await chain.land();
  assert.ok(chain.log.some(({ text }) => /does not answer/.test(text)));
  const { east_m, north_m } = new FlatFrame(chain.site.touchdown).toLocal(chain.plane.touchdown);
  assert.ok(Math.hypot(east_m, north_m) < 12, `${east_m}, ${north_m}`);
});

test('a service that is away from the start: the answer from before the failure is flown', async () => {
  const chain = new Chain();
  await chain.fly(15);
  chain.isServiceThere = false;
  chain.plane.stopEngine();
  await chain.fly(15, () => chain.targets().length > 0 && chain.failure.guidance.isEngaged);
  assert.ok(chain.failure.guidance.way);
});

test('an old answer is flown only where the aircraft is still on its way; without one the reason is told', async () => {
  const failed = async (chain, away_s) => {
    chain.isServiceThere = false;
    await chain.fly(away_s);
    chain.engine = { state: 'failed', reason: 'test' };
    chain.plane.stopEngine();
    chain.engaged_s = chain.plane.time_s;
    await chain.fly(5);
    return chain.failure.guidance.state();
  };
  const onWay = new Chain();
  await onWay.fly(15);
  const { phase, text } = await failed(onWay, 12);
  assert.equal(phase, 'glide');
  assert.ok(onWay.log.some((line) => /to site ahead: on its way of 1\d s ago/.test(line.text)), text);
  assert.ok(onWay.targets().length > 0);
  // One circles away from the way, one has never had an answer.
  const beside = new Chain({ mode: 'LOITER' });
  await beside.fly(15);
  const never = new Chain();
  for (const [chain, away_s] of [[beside, 25], [never, 15]]) {
    const waiting = await failed(chain, away_s);
    assert.equal(waiting.phase, 'waiting');
    assert.equal(waiting.text, 'the service does not answer, and no way is known from here: nothing is sent');
    assert.equal(chain.targets().length, 0);
    chain.isServiceThere = true;
    await chain.fly(3);
    assert.ok(chain.failure.guidance.way);
  }
});

test('a person who changes the mode ends guidance, and is not overruled', async () => {
  const chain = new Chain();
  await chain.failEngine();
  await chain.fly(8);
  chain.plane.pilotMode('FBWA');
  const changed_s = chain.plane.time_s;
  await chain.fly(10);
  assert.equal(chain.failure.guidance.isEngaged, false);
  assert.equal(chain.plane.control.mode, 'FBWA');
  assert.ok(chain.targets().every(({ time_s }) => time_s < changed_s + 1.5));
  assert.ok(chain.targets().filter(({ time_s }) => time_s >= changed_s).every(({ fields }) => fields._param2 === 0));
});

test('a watch that begins anew does not call back guidance that a person ended', async () => {
  const chain = new Chain();
  await chain.failEngine();
  await chain.fly(3);
  chain.plane.pilotMode('RTL');
  await chain.fly(3);
  assert.equal(chain.failure.guidance.isEngaged, false);
  chain.engine = { state: 'unknown' };
  await chain.fly(1);
  chain.engine = { state: 'failed', reason: 'again' };
  await chain.fly(2);
  assert.equal(chain.failure.guidance.isEngaged, false);
  // After it has run, a failure is another one.
  chain.engine = { state: 'running' };
  await chain.fly(1);
  chain.engine = { state: 'failed', reason: 'another' };
  await chain.fly(1);
  assert.equal(chain.failure.guidance.isEngaged, true);
});

test('a failure that a person has declared before it was noticed does not call guidance back after Release or another mode', async () => {
  for (const mode of [undefined, 'CIRCLE', 'LOITER']) {
    const chain = new Chain();
    chain.engine = { state: 'running' };
    await chain.fly(15);
    chain.failure.take({ id: '1', kind: 'engine_failure', confirmed_by: 'Ada' }, chain.plane.utc_us);
    chain.engaged_s = chain.plane.time_s;
    await chain.fly(3);
    chain.engine = { state: 'failed', reason: 'noticed later' };
    await chain.fly(3);
    if (mode) chain.plane.pilotMode(mode);
    else chain.failure.take({ id: '2', kind: 'release' }, chain.plane.utc_us);
    const ended_s = chain.plane.time_s;
    await chain.fly(5);
    assert.equal(chain.failure.guidance.isEngaged, false);
    assert.ok(chain.targets().every(({ time_s }) => time_s < ended_s + 1.5));
    assert.equal(chain.plane.control.mode, mode ?? 'GUIDED');
  }
});

test('a landing mission that guidance has not written when it ends is never written', async () => {
  for (const how of ['commands are lost', 'released at once']) {
    const chain = new Chain();
    await chain.fly(35);
    const before = structuredClone(chain.plane.mission);
    chain.engine = { state: 'running' };
    await chain.fly(1);
    if (how === 'commands are lost') chain.plane.take = () => {};
    chain.engine = { state: 'failed', reason: 'false alarm' };
    await chain.fly(5, () => chain.failure.guidance.isEngaged);
    await chain.fly(0.2);
    if (how === 'released at once') {
      chain.failure.take({ id: '1', kind: 'release' }, 0);
      chain.plane.pilotMode('AUTO');
    }
    await chain.fly(6);
    delete chain.plane.take;
    chain.engine = { state: 'running' };
    assert.equal(chain.failure.guidance.isEngaged, false);
    await chain.fly(60);
    assert.equal(chain.landings.state().state, 'current');
    chain.plane.pilotMode('LOITER');
    await chain.fly(12);
    assert.deepEqual(chain.plane.mission, before, how);
    assert.ok(!chain.sent.some(({ name }) => name === 'MISSION_COUNT' || name === 'MISSION_SET_CURRENT'), how);
    assert.match(chain.failure.guidance.state().text, /^guidance ended/);
  }
});

test('the final is flown by the link\'s own landing mission: another ground station\'s is replaced, a refused one is written again', async () => {
  for (const how of ['replaced', 'refused']) {
    const chain = new Chain();
    const { missions } = chain.landings;
    const prepare = missions.prepare.bind(missions);
    let numPrepared = 0;
    missions.prepare = (site) => (++numPrepared === 1 && how === 'refused' ? Promise.reject(new Error('no answer')) : prepare(site));
    await chain.failEngine();
    await chain.fly(8);
    const far = chain.plane.mission[0];
    if (how === 'replaced') chain.plane.loadMission(Array.from({ length: 7 }, () => ({ ...far, x: far.x - 200000, z: 450 })));
    await chain.land();
    const { touchdown } = chain.plane;
    const { east_m, north_m } = new FlatFrame(chain.site.touchdown).toLocal(touchdown);
    assert.ok(Math.hypot(east_m, north_m) < 12, `${how}: ${east_m}, ${north_m}`);
    assert.equal(touchdown.mode, 'AUTO');
    assert.equal(numPrepared, 2);
    const last = chain.sent.findIndex(({ name, fields }) => name === 'COMMAND_LONG' && fields.command === doSetMode);
    assert.equal(chain.sent.length, last + 1, 'nothing is sent on the final');
  }
});

test('while it is not known whose mission it is, the final does not begin', async () => {
  const chain = new Chain();
  await chain.failEngine();
  await chain.fly(8);
  const { state } = chain.landings;
  chain.landings.state = () => ({ ...state.call(chain.landings), state: 'unknown' });
  await chain.land();
  assert.equal(chain.plane.touchdown.mode, 'GUIDED');
  assert.ok(!chain.sent.some(({ name, fields }) => name === 'COMMAND_LONG' && fields.command === doSetMode));
});

// lost: of the messages of the aircraft, while it is set.
function chainWithLoss() {
  const chain = new Chain();
  const { onSend } = chain.plane;
  chain.plane.onSend = (bytes, name) => { if (name !== chain.lost) onSend(bytes, name); };
  return chain;
}

test('without positions or airspeeds the engine is unknown, and nothing is told of an old airspeed', async () => {
  for (const lost of ['GLOBAL_POSITION_INT', 'VFR_HUD']) {
    const chain = chainWithLoss();
    await chain.fly(200);
    assert.equal(chain.state().engine.state, 'running');
    assert.ok(chain.state().position.age_s < 0.5);
    chain.lost = lost;
    await chain.fly(3.5);
    chain.plane.stopEngine();
    await chain.fly(3.5);
    const { engine, position, airspeed_mps, ground_speed_mps } = chain.state();
    assert.equal(engine.state, 'unknown', lost);
    assert.ok(lost === 'VFR_HUD' ? airspeed_mps === undefined && ground_speed_mps > 5 : position.age_s > 6, lost);
    assert.ok(chain.landings.vehicle.isFlying);
    chain.lost = undefined;
    await chain.fly(0.5);
    assert.notEqual(chain.state().engine.state, 'unknown');
  }
});

test('guidance sends no targets from an old place, says so once, and goes on when the place is known again', async () => {
  const chain = chainWithLoss();
  await chain.failEngine();
  await chain.fly(4);
  chain.lost = 'GLOBAL_POSITION_INT';
  await chain.fly(3.5);
  const before = chain.targets().length;
  const askedBefore = chain.numAsked;
  await chain.fly(3);
  assert.equal(chain.targets().length, before);
  assert.equal(chain.numAsked, askedBefore);
  assert.equal(chain.log.filter(({ text }) => /no position for 3 s: nothing is sent/.test(text)).length, 1);
  assert.equal(chain.failure.guidance.isEngaged, true);
  chain.lost = undefined;
  await chain.fly(2);
  assert.ok(chain.targets().length > before);
  chain.lost = 'GLOBAL_POSITION_INT';
  await chain.fly(5);
  chain.plane.pilotMode('FBWA');
  await chain.fly(2);
  assert.equal(chain.failure.guidance.isEngaged, false, 'a mode of the pilot ends it also then');
});

test('an aircraft that is flown by hand is not taken over, but a person may declare the failure', async () => {
  const chain = new Chain({ mode: 'FBWA' });
  chain.plane.pilotSticks({ throttle: 0.35 });
  await chain.fly(15);
  chain.plane.pilotSticks({ throttle: 0.9 });
  chain.plane.stopEngine();
  await chain.fly(8);
  assert.equal(chain.targets().length, 0);
  chain.failure.take({ id: '1', kind: 'engine_failure', confirmed_by: 'a pilot' }, chain.plane.utc_us);
  chain.engaged_s = chain.plane.time_s;
  await chain.fly(4);
  assert.equal(chain.told[0][1], 'done');
  assert.equal(chain.plane.control.mode, 'GUIDED');
  chain.failure.take({ id: '2', kind: 'release' }, chain.plane.utc_us);
  const released_s = chain.plane.time_s;
  await chain.fly(5);
  assert.ok(chain.targets().every(({ time_s }) => time_s <= released_s));
});

test('without the option nothing is sent before a person declares the failure', async () => {
  const chain = new Chain({ isAutomatic: false });
  await chain.fly(15);
  chain.plane.stopEngine();
  await chain.fly(10);
  assert.equal(chain.state().engine.state, 'failed');
  assert.equal(chain.sent.filter(({ name }) => name.startsWith('COMMAND')).length, 0);
});

test('on its own word only over serial or signed', () => {
  const parsed = (...more) => parseCommandLine(['--url', 'http://127.0.0.1:1', '--on-engine-failure', 'land', ...more]);
  assert.throws(() => parsed('--connect', 'udp:14550'), /serial/);
  assert.equal(parsed('--connect', 'serial:/dev/ttyS1').isAutomatic, true);
  assert.equal(parsed('--connect', 'udp:14550', '--signing-key', 'key').isAutomatic, true);
  assert.throws(() => parsed('--connect', 'serial:/dev/ttyS1', '--silent'), /silent/);
});
