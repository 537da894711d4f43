// The link with a stand-in that speaks and refuses as PX4 does, by its documentation and sources. No PX4 was flown.

import assert from 'node:assert/strict';
import test from 'node:test';

import { EngineFailure } from '../../server/mavlink/guidance/engine_failure.js';
import { areSame } from '../../server/mavlink/mission/mission_items.js';
import { approachAnswer, Rig } from './mission_rig.js';
import { report } from './report.js';
import { storedByPx4 } from './standin/px4.js';
import { Random } from './standin/random.js';

const subject = 'PX4, by the stand-in';
const rates_hz = { HEARTBEAT: 1, SYSTEM_TIME: 1, ATTITUDE: 4, GLOBAL_POSITION_INT: 4, GPS_RAW_INT: 0, VFR_HUD: 4, WIND: 0, WIND_COV: 1,
  SYS_STATUS: 0, RPM: 0, MISSION_CURRENT: 1, HOME_POSITION: 0, CAMERA_FEEDBACK: 0 };
const faults = { loss_ratio: 0.2, duplicate_ratio: 0.1, reorder_ratio: 0.1, delay_s: 0.05 };

// At home height, with a final of 4.6 degrees.
function px4Rig({ seed = 1, parameters = {}, options = {}, ...more } = {}) {
  return new Rig({ seed, options: { firmware: 'px4', rates_hz, wind: { speed_mps: 4, from_deg: 250 },
    parameters: { FW_LND_AIRSPD: 16, RTL_AUTOLAND: 0, ...parameters }, ...options }, ...more });
}

const want = (rig) => rig.landings.take({ id: 'c1', kind: 'mission', site_id: 's1' });

test('modes, wind and position are those of PX4', async () => {
  const rig = px4Rig();
  await rig.step(60);
  const { autopilot, mode, wind, position } = rig.link.state(rig.plane.utc_us);
  assert.deepEqual([autopilot, mode], ['px4', 'AUTO.MISSION']);
  assert.equal(wind.source, 'autopilot');
  // From 250 degrees it blows to 70.
  assert.ok(wind.east_mps > 2.5 && wind.north_mps > 0.5, JSON.stringify(wind));
  assert.ok(Math.abs(position.altitude_m - rig.plane.truth.altitude_m) < 2);
  for (const [name, told] of [['LOITER', 'AUTO.LOITER'], ['RTL', 'AUTO.RTL'], ['FBWA', 'STABILIZED'], ['MANUAL', 'MANUAL']]) {
    rig.plane.pilotMode(name);
    await rig.step(2);
    assert.equal(rig.link.state(rig.plane.utc_us).mode, told);
  }
});

test('a landing is written, read back equal, started and flown to the ground', async () => {
  const misses_m = [];
  for (let seed = 1; seed <= 6; ++seed) {
    const heading_deg = 60 * seed;
    const rig = px4Rig({ seed, service: { approach: async () => approachAnswer(rig.plane, { heading_deg, isRight: seed % 2 === 0 }) } });
    await rig.step(15);
    want(rig);
    await rig.step(20);
    assert.deepEqual(rig.told.get('c1'), { state: 'done', detail: 'flown' });
    assert.equal(rig.mission.state, 'current');
    assert.equal(rig.mission.kind, 'landing');
    assert.match(rig.mission.warning, /PX4 have not been flown/);
    assert.equal(rig.plane.control.mode, 'AUTO');
    while (!rig.plane.touchdown && rig.plane.time_s < 600) await rig.step(5);
    const { east_m, north_m } = rig.plane.touchdown;
    const heading_rad = (heading_deg * Math.PI) / 180;
    assert.ok(Math.abs(east_m * Math.cos(heading_rad) - north_m * Math.sin(heading_rad)) < 15, 'beside the final');
    misses_m.push(east_m * Math.sin(heading_rad) + north_m * Math.cos(heading_rad));
  }
  report(subject, 'landings written, started and flown (with ArduPlane\'s flare)', `6 of 6, ${Math.min(...misses_m).toFixed(0)} to ${Math.max(...misses_m).toFixed(0)} m beyond the touchdown`);
});

test('the item that is flown stays the current one while the mission is written', async () => {
  const rig = px4Rig();
  await rig.step(60);
  const flown = rig.plane.control.mission.index;
  assert.ok(flown > 0);
  want(rig);
  const seen = new Set();
  await rig.step(6, () => seen.add(rig.plane.control.mission.index));
  assert.ok([...seen].every((index) => index >= flown), `${flown}: ${[...seen]}`);
});

test('PX4 as it was written to before: a land start with a place is refused', () => {
  const withPlace = { frame: 0, command: 189, param1: 0, param2: 0, param3: 0, param4: 0, x: 473977000, y: 85456000, z: 440 };
  assert.equal(storedByPx4(withPlace).result, 3);
  assert.equal(storedByPx4({ ...withPlace, frame: 2, x: 0, y: 0, z: 0 }).result, 0);
});

test('a final that is too steep for the autopilot is not written', async () => {
  const rig = px4Rig({ service: { approach: async () => approachAnswer(rig.plane, { height_m: 20 }) } });
  const old = structuredClone(rig.plane.mission);
  await rig.step(15);
  want(rig);
  await rig.step(20);
  assert.equal(rig.told.get('c1').state, 'failed');
  assert.match(rig.told.get('c1').detail, /7\.6 degrees.*FW_LND_ANG/);
  assert.ok(areSame(rig.plane.mission, old));
  assert.equal(rig.mission.alarm, undefined);
});

test('a mission that PX4 accepts but does not fly is not told as flown', async () => {
  const rig = px4Rig({ mode: 'LOITER', service: { approach: async () => approachAnswer(rig.plane, { height_m: 20 }) } });
  await rig.step(15);
  // The parameter is lower than what was read.
  rig.plane.parameters.FW_LND_ANG = 12;
  rig.startProgram();
  await rig.step(15);
  rig.plane.parameters.FW_LND_ANG = 5;
  want(rig);
  await rig.step(40);
  assert.equal(rig.told.get('c1').state, 'failed');
  assert.match(rig.told.get('c1').detail, /not flown/);
});

test('uploads over a bad radio, cut for 3 s and for 60 s: the old or the new mission, and the link knows which', { timeout: 600_000 }, async () => {
  const numUploads = Number(process.env.FREELSD_UPLOADS ?? 9) >= 200 ? 60 : 9;
  const ends = { new: 0, old: 0 };
  for (let seed = 1; seed <= numUploads; ++seed) {
    const random = new Random(seed * 17);
    const rig = px4Rig({ seed, faults });
    const old = structuredClone(rig.plane.mission);
    await rig.step(20);
    want(rig);
    const cut_s = [0, 3, 60][seed % 3];
    let act_s = Infinity;
    const watch = () => {
      if (rig.outgoing.counts.MISSION_COUNT) act_s = Math.min(act_s, rig.plane.time_s + random.between(0.1, 2));
      if (rig.plane.time_s >= act_s && cut_s) {
        [rig.up, rig.down].forEach((one) => one.cut(rig.plane.time_s, cut_s));
        act_s = Infinity;
        rig.outgoing.counts.MISSION_COUNT = 0;
      }
      const isOld = areSame(rig.plane.mission, old);
      const isNew = rig.stored && areSame(rig.plane.mission, rig.stored.wanted.map((one) => storedByPx4(one).item));
      assert.ok(isOld || isNew || !rig.stored, 'a broken upload leaves the old mission');
      const { state, kind } = rig.mission;
      if (state === 'current' && rig.link.state(rig.plane.utc_us).is_connected) assert.equal(kind === 'landing', !isOld);
    };
    await rig.step(130, watch);
    while (rig.landings.isBusy && rig.plane.time_s < 600) await rig.step(5, watch);
    // On the final nothing is sent, so a doubt stays.
    const isDoubtOnFinal = rig.plane.control.mission.isLanding && rig.mission.alarm;
    assert.ok(rig.mission.state === 'current' || isDoubtOnFinal, `seed ${seed}: ${JSON.stringify(rig.mission)}`);
    const isNew = !areSame(rig.plane.mission, old);
    assert.equal(rig.mission.kind === 'landing', isNew, `seed ${seed}`);
    ++ends[isNew ? 'new' : 'old'];
  }
  report(subject, 'uploads, 20 % loss, 10 % duplicates, 10 % reordered, cut for 0, 3 or 60 s', `${numUploads}: ${ends.new} new, ${ends.old} old, none mixed, none told wrongly`);
});

test('a failure is told, but PX4 is not guided', async () => {
  const rig = px4Rig();
  await rig.step(20);
  const told = [];
  const failure = new EngineFailure({ recall: async () => ({ sites: [] }), outgoing: rig.outgoing, landings: rig.landings, address: () => rig.link.pin,
    state: () => ({ ...rig.link.state(rig.plane.utc_us), mission: rig.mission }), log: () => {}, told: (...one) => told.push(one), isAutomatic: false });
  failure.take({ id: '1', kind: 'engine_failure', confirmed_by: 'a pilot' }, rig.plane.utc_us);
  assert.deepEqual(told, [['1', 'failed', 'px4 is not guided: only ArduPlane is']]);
});
