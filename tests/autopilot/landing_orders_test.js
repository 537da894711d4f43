// "Land here", and what comes after it: another site, Release, a mode of the pilot's, an engine failure.

import assert from 'node:assert/strict';
import test from 'node:test';

import { EngineFailure } from '../../server/mavlink/guidance/engine_failure.js';
import { approachAnswer, Rig } from './mission_rig.js';

const land = (rig, id = 'c1', site_id = 's1') => rig.landings.take({ id, kind: 'mission', site_id, confirmed_by: 'Ada' });
const release = (rig) => rig.landings.take({ id: 'r', kind: 'release' });

// The service plans for so long, in the rig's time.
function plansIn(rig, seconds) {
  const waiting = [];
  rig.service.approach = (site) => new Promise((resolve) => {
    waiting.push({ until_s: rig.plane.time_s + (seconds[site] ?? seconds), resolve });
  });
  return () => waiting.filter(({ until_s }) => rig.plane.time_s >= until_s).forEach(({ resolve }) => resolve(approachAnswer(rig.plane)));
}

const starts = (rig) => rig.outgoing.counts.COMMAND_INT ?? 0;

test('of two sites the one that was wanted last is landed at, also if it was planned sooner', async () => {
  const rig = new Rig();
  const tick = plansIn(rig, { A: 6, B: 0.5 });
  await rig.step(12);
  land(rig, 'c1', 'A');
  await rig.step(1, tick);
  land(rig, 'c2', 'B');
  assert.deepEqual(rig.told.get('c1'), { state: 'failed', detail: 'another landing was wanted' });
  await rig.step(40, tick);
  assert.equal(rig.mission.site, 'B');
  assert.equal(rig.told.get('c2').state, 'done');
});

test('Release while the service plans, and while the mission is written: nothing is started', async () => {
  for (const plan_s of [4, 0]) {
    const rig = new Rig({ mode: 'LOITER' });
    const tick = plansIn(rig, plan_s);
    await rig.step(12);
    const before = structuredClone(rig.plane.mission);
    land(rig);
    do await rig.step(0.1, tick); while (plan_s === 0 && !rig.plane.isReceivingItems);
    release(rig);
    assert.deepEqual(rig.told.get('c1'), { state: 'failed', detail: 'released' });
    await rig.step(30, tick);
    assert.deepEqual([rig.plane.control.mode, starts(rig), rig.mission.state], ['LOITER', 0, 'current']);
    if (plan_s > 0) assert.deepEqual(rig.plane.mission, before);
    assert.equal(rig.told.get('c1').detail, 'released');
  }
});

test('a mission that was not known before is not known after Release', async () => {
  const rig = new Rig({ mode: 'LOITER' });
  await rig.step(12);
  // The radio is dead while the autopilot starts anew.
  rig.up.send = () => {};
  rig.plane.restart(3);
  await rig.step(25);
  assert.equal(rig.mission.state, 'unknown');
  land(rig);
  await rig.step(1);
  release(rig);
  assert.equal(rig.mission.state, 'unknown');
  delete rig.up.send;
  await rig.step(35);
  assert.equal(rig.mission.state, 'current');
});

test('Release before the autopilot is seen in the landing is told, and nothing is repeated', async () => {
  const rig = new Rig({ mode: 'LOITER' });
  await rig.step(12);
  rig.plane.control.land = () => true;
  land(rig);
  await rig.step(20, () => { if (starts(rig) === 1 && !rig.told.has('c1')) release(rig); });
  assert.deepEqual(rig.told.get('c1'), { state: 'failed', detail: 'in the autopilot, but released' });
  assert.equal(starts(rig), 1);
});

test('a mode that the pilot takes while the service plans is kept, also if it is the former one again', async () => {
  for (const modes of [['LOITER'], ['FBWA', 'AUTO']]) {
    const rig = new Rig();
    const tick = plansIn(rig, 6);
    await rig.step(12);
    land(rig);
    for (const mode of modes) {
      await rig.step(1.5, tick);
      rig.plane.pilotMode(mode);
    }
    await rig.step(30, tick);
    assert.deepEqual([rig.plane.control.mode, starts(rig)], [modes.at(-1), 0]);
    assert.match(rig.told.get('c1').detail, /not started, because the mode was changed/);
  }
});

test('an engine failure that is declared after it ends it', async () => {
  const rig = new Rig();
  const tick = plansIn(rig, 3);
  const linkState = () => ({ ...rig.link.state(rig.plane.utc_us), mission: rig.mission });
  const failure = new EngineFailure({ recall: async () => ({ sites: [] }), outgoing: rig.outgoing, landings: rig.landings,
    address: () => rig.link.pin, state: linkState, log: () => {}, told: (id, state, detail) => rig.told.set(id, { state, detail }) });
  await rig.step(12);
  land(rig);
  await rig.step(1, tick);
  failure.take({ id: 'c2', kind: 'engine_failure', confirmed_by: 'Ada' }, rig.plane.utc_us);
  await rig.step(30, tick);
  assert.equal(rig.told.get('c1').detail, 'an engine failure came after it');
  assert.equal(rig.told.get('c2').state, 'done');
  assert.deepEqual([starts(rig), rig.mission.kind], [0, 'other']);
});

test('with a lost acknowledgement, a pilot who takes the former mode back is not overruled', async () => {
  const rig = new Rig({ mode: 'LOITER' });
  await rig.step(12);
  const { onSend } = rig.plane;
  rig.plane.onSend = (bytes, name) => { if (name !== 'COMMAND_ACK') onSend(bytes, name); };
  // A first landing, from another mode.
  land(rig);
  await rig.step(15);
  assert.deepEqual(rig.told.get('c1'), { state: 'done', detail: 'flown' });
  rig.plane.pilotMode('CRUISE');
  await rig.step(3);
  for (const mode of ['CRUISE', 'LOITER']) {
    rig.plane.pilotMode(mode);
    await rig.step(3);
    rig.plane.control.mission.select(1);
    await rig.step(2);
    const before = starts(rig);
    land(rig, mode);
    let since_s;
    await rig.step(30, () => {
      if (rig.plane.control.mode === 'AUTO') since_s ??= rig.plane.time_s;
      if (since_s !== undefined && rig.plane.time_s > since_s + 1.1 && rig.plane.time_s < since_s + 1.3) rig.plane.pilotMode(mode);
    });
    assert.deepEqual([mode, rig.plane.control.mode, starts(rig) - before], [mode, mode, 1]);
  }
});

// MISSION_ITEM_INT, at its place in a packet of MAVLink 2.
const isItem = (bytes) => bytes[7] === 73;

test('half a mission that a second command has found is replaced by the former one, and is never told as current', async () => {
  for (const how of ['the radio is dead', 'the second landing is refused']) {
    const rig = new Rig();
    await rig.step(12);
    const before = structuredClone(rig.plane.mission);
    const send = rig.up.send.bind(rig.up);
    let numItems = 0;
    rig.up.send = (bytes, time_s) => {
      if (isItem(bytes)) ++numItems;
      if (numItems < before.length - 2) send(bytes, time_s);
    };
    land(rig, 'c1', 'A');
    await rig.step(10);
    assert.notDeepEqual(rig.plane.mission, before);
    if (how === 'the second landing is refused') {
      delete rig.up.send;
      // As if its own landing sequence were flown.
      rig.plane.control.mission.select(before.findIndex((one) => one.command === 189) + 1);
    }
    land(rig, 'c2', 'B');
    await rig.step(55, () => { if (how === 'the radio is dead') assert.notEqual(rig.mission.state, 'current'); });
    delete rig.up.send;
    await rig.step(30);
    assert.equal(rig.mission.state, 'current', how);
    if (rig.mission.kind === 'other') assert.deepEqual(rig.plane.mission.slice(1), before.slice(1), how);
    else assert.equal(rig.mission.site, 'B');
    assert.ok(rig.told.get('c2').state);
  }
});

test('the alarm of a mission that another ground station has changed ends with Release or disarming', async () => {
  for (const how of ['release', 'disarm']) {
    const rig = new Rig({ mode: 'LOITER' });
    await rig.step(12);
    land(rig);
    await rig.step(15);
    rig.plane.pilotMode('LOITER');
    await rig.step(3);
    const { mission } = rig.plane;
    rig.plane.loadMission([...mission.slice(0, 5), ...mission.slice(1, 5)]);
    await rig.step(40);
    assert.match(rig.mission.alarm, /another ground station has changed the mission/);
    if (how === 'release') release(rig);
    else rig.plane.control.isArmed = false;
    await rig.step(2);
    assert.deepEqual([rig.mission.state, rig.mission.kind, rig.mission.alarm], ['current', 'other', undefined]);
    await rig.step(40);
    assert.equal(rig.mission.alarm, undefined);
  }
});
