// Guidance on a link, against the stand-in aircraft and a made-up answer of recall, without sockets.

import assert from 'node:assert/strict';
import test from 'node:test';

import { FlatFrame } from '../../server/mavlink/flat_frame.js';
import { parseCommandLine } from '../../server/mavlink/command_line.js';
import { Chain } from './engine_failure_rig.js';

const doSetMode = 176;

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

test('an autopilot that begins a mission anew in AUTO (MIS_RESTART) flies the LAND; then nothing is sent', async () => {
  for (const isTold of [true, false]) {
    const chain = new Chain();
    // The circle lies aside: whoever flies it does not come back to the final.
    const recall = chain.recall.bind(chain);
    chain.recall = async () => {
      const answer = await recall();
      const { approach } = answer.sites[0];
      approach.loiter_center = { ...approach.start, latitude_deg: approach.start.latitude_deg + 0.003 };
      return answer;
    };
    if (isTold) chain.plane.parameters.MIS_RESTART = 1;
    await chain.failEngine();
    chain.plane.parameters.MIS_RESTART = 1;
    await chain.fly(60, () => chain.failure.guidance.isOnFinal);
    const begun_s = chain.plane.time_s;
    await chain.land();
    const { touchdown } = chain.plane;
    const { east_m, north_m } = new FlatFrame(chain.site.touchdown).toLocal(touchdown);
    assert.ok(touchdown.isFlared && Math.hypot(east_m, north_m) < (isTold ? 12 : 25), `${east_m}, ${north_m}`);
    const late = chain.sent.filter(({ time_s }) => time_s > begun_s).map(({ name }) => name);
    assert.deepEqual(late, isTold ? [] : ['MISSION_SET_CURRENT']);
  }
});

// lost: of the messages of the aircraft, while it is set.
function chainWithLoss() {
  const chain = new Chain();
  const { onSend } = chain.plane;
  chain.plane.onSend = (bytes, name) => { if (name !== chain.lost) onSend(bytes, name); };
  return chain;
}

test('a mission that cannot be read for a weak radio is flown on the final, one that others may have written is not', async () => {
  const flyFinal = async (doubt) => {
    const chain = chainWithLoss();
    await chain.failEngine();
    await chain.fly(8);
    assert.equal(chain.landings.state().state, 'current');
    chain.lost = 'MISSION_COUNT';
    doubt(chain);
    await chain.fly(10);
    assert.equal(chain.landings.state().state, 'unknown');
    await chain.land();
    return chain.plane.touchdown.mode;
  };
  assert.equal(await flyFinal(({ landings }) => landings.missions.doubt('the autopilot was silent')), 'AUTO');
  assert.equal(await flyFinal(({ landings, plane }) =>
    landings.missions.hear('STATUSTEXT', { text: 'Flight plan received' }, plane.time_s)), 'GUIDED');
});

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
