// Landing missions against the stand-in, without faults.

import assert from 'node:assert/strict';
import test from 'node:test';

import { ardupilotItems, landingOfApproach, landingOfRecall, landPointBehind_m, px4Items } from '../../server/mavlink/mission/landing_items.js';
import { isMixture, isSameItem } from '../../server/mavlink/mission/mission_items.js';
import { allowed, NotAllowed, Outgoing } from '../../server/mavlink/outgoing.js';
import { messageClasses } from '../../server/mavlink/messages.js';
import { Random } from './standin/random.js';
import { approachAnswer, Rig, siteAnswer } from './mission_rig.js';
import { report } from './report.js';

const subject = 'missions';

const land = (rig, id = 'c1', more = {}) => rig.landings.take({ id, kind: 'mission', site_id: 's1', confirmed_by: 'Ada', ...more });

test('a site becomes a mission that is read back equal, and is flown', async () => {
  const rig = new Rig();
  const before = structuredClone(rig.plane.mission);
  await rig.step(5);
  assert.deepEqual(rig.mission, { state: 'current', kind: 'other', current_item: rig.plane.control.mission.index, num_items: before.length });
  land(rig);
  await rig.step(20);
  assert.equal(rig.mission.state, 'current');
  assert.equal(rig.mission.kind, 'landing');
  assert.equal(rig.mission.site, 's1');
  assert.equal(rig.told.get('c1').state, 'done');
  const landingAt = before.findIndex((one) => one.command === 189);
  assert.deepEqual(rig.plane.mission.slice(1, landingAt), before.slice(1, landingAt), 'what is flown stays in place');
  assert.deepEqual(rig.plane.mission.slice(landingAt).map((one) => one.command), [189, 31, 21]);
  assert.equal(rig.plane.control.mission.index, landingAt + 1, 'the circle is flown');
});

test('the flown final is the checked one, and the aircraft touches down near the touchdown', async () => {
  const misses_m = [];
  const heights_m = [];
  for (let seed = 1; seed <= 12; ++seed) {
    const random = new Random(seed);
    const heading_deg = random.between(0, 360);
    // Into the wind, as sites are planned; the stand-in lands at 16 m/s and more in a headwind.
    const wind = { speed_mps: random.between(0, 5), from_deg: heading_deg + random.between(-25, 25), gradient_height_m: 0 };
    const rig = new Rig({ seed, options: { wind, ground: () => 431.7 } });
    const headwind_mps = wind.speed_mps * Math.cos(((wind.from_deg - heading_deg) * Math.PI) / 180);
    const answer = approachAnswer(rig.plane, { heading_deg, isRight: seed % 2 === 0, final_m: 230, height_m: 16, radius_m: 75 });
    answer.features[0].properties.ground_speed_mps = 16.3 - 0.5 * headwind_mps;
    rig.service.approach = async () => answer;
    await rig.step(12);
    land(rig);
    while (!rig.plane.touchdown && rig.plane.time_s < 500) {
      const { truth } = rig.plane;
      const back_m = -(truth.east_m * Math.sin((heading_deg * Math.PI) / 180) + truth.north_m * Math.cos((heading_deg * Math.PI) / 180));
      if (rig.plane.control.mission.isLanding && back_m < 150 && back_m > 75) heights_m.push(truth.height_m - (16 * back_m) / 230);
      await rig.step(0.5);
    }
    const { east_m, north_m } = rig.plane.touchdown;
    misses_m.push(east_m * Math.sin((heading_deg * Math.PI) / 180) + north_m * Math.cos((heading_deg * Math.PI) / 180));
  }
  const worst_m = Math.max(...heights_m.map(Math.abs));
  report(subject, 'final flown against the checked one, 12 landings', `at most ${worst_m.toFixed(1)} m of height, 75 to 150 m before the touchdown`);
  report(subject, 'touchdown beyond the site\'s, 12 landings with engine', `${Math.min(...misses_m).toFixed(0)} to ${Math.max(...misses_m).toFixed(0)} m`);
  assert.ok(worst_m < 2.5, `${worst_m}`);
  assert.ok(misses_m.every((miss_m) => Math.abs(miss_m) < 25), misses_m.map((m) => m.toFixed(1)).join(' '));
});

test('items of ArduPlane: altitudes above mean sea level, whole radius, abort altitude above home', () => {
  const rig = new Rig();
  const landing = landingOfApproach('s1', approachAnswer(rig.plane, { isRight: false }), 16);
  const [start, circle, final] = ardupilotItems(landing, { home_altitude_m: 430 });
  assert.deepEqual([start, circle, final].map((one) => one.frame), [0, 0, 0]);
  assert.equal(circle.param2, -42);
  assert.equal(circle.param4, 1);
  assert.ok(Math.abs(circle.z - 443.7) < 0.01);
  assert.equal(final.param1, 14);
  assert.ok(Math.abs(final.z - 431.7) < 0.01);
  const back_m = landPointBehind_m(landing, { LAND_FLARE_SEC: 2, LAND_FLARE_ALT: 3, LAND_FLARE_AIM: 50, TECS_LAND_SINK: 0.25 });
  assert.ok(back_m > 5 && back_m < 40, `${back_m}`);
  assert.equal(landPointBehind_m(landing, { LAND_FLARE_SEC: 2 }), 0);
});

test('items of PX4: leaves the circle towards the final, no yaw', () => {
  const rig = new Rig();
  const [start, circle, final] = px4Items(landingOfApproach('s1', approachAnswer(rig.plane)));
  assert.deepEqual([start.frame, start.x, start.y, start.z], [2, 0, 0, 0]);
  assert.deepEqual([circle.param1, circle.param2, circle.param4], [1, 41.3, 1]);
  assert.ok(Number.isNaN(final.param4));
  assert.ok(isSameItem(final, { ...final, frame: 5, param4: 0 }));
});

test('the same landing from an answer of recall', () => {
  const rig = new Rig();
  const ours = landingOfApproach('s1', approachAnswer(rig.plane), 16);
  const fromRecall = landingOfRecall({ site_id: 's1', verdict: 'landable', altitude_datum: 'amsl', touchdown: ours.touchdown,
    aircraft: { landing_airspeed_mps: 16 }, ground_speed_mps: 13,
    approach: { heading_deg: 90, height_m: 12, loiter_radius_m: 41.3, loiter_direction: 'right', start: ours.start, loiter_center: ours.centre } });
  for (const [i, one] of ardupilotItems(fromRecall).entries()) assert.ok(isSameItem(one, ardupilotItems(ours)[i]));
});

test('a start is not told as flown while it is not known which item is flown', async () => {
  const rig = new Rig();
  const { onSend } = rig.plane;
  rig.plane.onSend = (bytes, name) => { if (name !== 'MISSION_CURRENT') onSend(bytes, name); };
  await rig.step(5);
  land(rig);
  await rig.step(30);
  assert.equal(rig.plane.control.mode, 'AUTO');
  assert.deepEqual([rig.mission.kind, rig.told.get('c1').state], ['landing', 'failed']);
  assert.match(rig.told.get('c1').detail, /not flown as far as is known: mode AUTO, item unknown/);
});

test('what must not be landed at: rejected, superseded, of another altitude reference, without approach', async () => {
  const cases = {
    rejected: [{ ...siteAnswer, properties: { ...siteAnswer.properties, verdict: 'rejected' } }],
    superseded: [{ properties: { ...siteAnswer.properties, superseded_by: 's2' } }],
    'not above mean sea level': [siteAnswer, { altitude_datum: 'ellipsoid' }],
    'is rejected': [siteAnswer, { verdict: 'rejected' }],
    'no approach': [siteAnswer, { features: [] }],
    'does not descend': [siteAnswer, {}, { height_m: 0 }],
  };
  for (const [why, [site, more = {}, geometry = {}]] of Object.entries(cases)) {
    const rig = new Rig();
    rig.service.site = async () => site;
    rig.service.approach = async () => ({ ...approachAnswer(rig.plane, geometry), ...more });
    const before = structuredClone(rig.plane.mission);
    await rig.step(4);
    land(rig);
    await rig.step(6);
    assert.equal(rig.told.get('c1').state, 'failed');
    assert.match(rig.told.get('c1').detail, new RegExp(why.replace('is rejected', 'rejected')));
    assert.deepEqual(rig.plane.mission, before);
  }
});

test('a landing airspeed that differs is warned of, and no parameter is written', async () => {
  const rig = new Rig({ options: { parameters: { TECS_LAND_ARSPD: 12 } } });
  await rig.step(8);
  const before = { ...rig.plane.parameters };
  land(rig);
  await rig.step(15);
  assert.match(rig.mission.warning, /lands at 12.0 m\/s, the site was planned for 16.0/);
  assert.deepEqual({ ...rig.plane.parameters, MIS_TOTAL: 0 }, { ...before, MIS_TOTAL: 0 });
});

test('a person who takes another mode ends our part', async () => {
  const rig = new Rig();
  await rig.step(4);
  land(rig);
  await rig.step(12);
  assert.equal(rig.told.get('c1').state, 'done');
  rig.plane.pilotMode('FBWA');
  await rig.step(3);
  assert.ok(rig.log.some(({ text }) => /mode FLY_BY_WIRE_A: the link's part/.test(text)));
  await rig.step(60);
  assert.equal(rig.plane.control.mode, 'FBWA');
  assert.equal(rig.outgoing.counts.COMMAND_INT, 1);
});

test('a mode that is changed during the upload is kept: the mission is there, but not started', async () => {
  const rig = new Rig({ faults: { delay_s: 0.4 } });
  await rig.step(30);
  land(rig);
  await rig.step(3);
  rig.plane.pilotMode('LOITER');
  await rig.step(40);
  assert.equal(rig.mission.kind, 'landing');
  assert.match(rig.told.get('c1').detail, /not started, because the mode was changed/);
  assert.equal(rig.plane.control.mode, 'LOITER');
});

test('on the ground the mission is written, and nothing is started', async () => {
  const rig = new Rig();
  rig.plane.body.place({ altitude_m: 430, airspeed_mps: 0, isOnGround: true });
  rig.plane.control.isArmed = false;
  await rig.step(5);
  land(rig);
  await rig.step(15);
  assert.match(rig.told.get('c1').detail, /it does not fly/);
  assert.equal(rig.outgoing.counts.COMMAND_INT, undefined);
});

test('guidance: a landing mission alone, with LAND as its current item', async () => {
  const rig = new Rig({ mode: 'GUIDED' });
  await rig.step(5);
  const { touchdown, start, centre } = landingOfApproach('s1', approachAnswer(rig.plane), 16);
  const site = { site_id: 's9', verdict: 'landable', altitude_datum: 'amsl', touchdown, aircraft: { landing_airspeed_mps: 16 },
    approach: { heading_deg: 90, height_m: 12, loiter_radius_m: 41.3, loiter_direction: 'right', start, loiter_center: centre } };
  const begun_s = rig.plane.time_s;
  let ready_s;
  rig.landings.missions.prepare(site).then(() => { ready_s = rig.plane.time_s; });
  await rig.step(10);
  report(subject, 'landing mission for guidance, delay 50 ms each way', `in the autopilot after ${(ready_s - begun_s).toFixed(1)} s`);
  assert.deepEqual(rig.plane.mission.map((one) => one.command), [16, 189, 31, 21]);
  rig.plane.control.setMode('AUTO');
  assert.equal(rig.plane.control.mission.index, 3);
});

test('a landing sequence that is flown is not replaced under the aircraft', async () => {
  const rig = new Rig();
  await rig.step(4);
  land(rig);
  await rig.step(20);
  assert.equal(rig.told.get('c1').state, 'done');
  const before = structuredClone(rig.plane.mission);
  rig.service.approach = async () => approachAnswer(rig.plane, { heading_deg: 200 });
  land(rig, 'c2');
  await rig.step(15);
  assert.match(rig.told.get('c2').detail, /take another mode first/);
  assert.deepEqual(rig.plane.mission, before);
  assert.deepEqual([rig.mission.kind, rig.mission.site], ['landing', 's1']);
  rig.plane.pilotMode('LOITER');
  await rig.step(2);
  land(rig, 'c3');
  await rig.step(20);
  assert.equal(rig.told.get('c3').state, 'done');
  assert.equal(rig.plane.control.mode, 'AUTO');
});

test('guidance writes only after the autopilot has left its mission', async () => {
  const rig = new Rig();
  await rig.step(5);
  rig.plane.control.setCurrent(8);
  await rig.step(3);
  const { touchdown, start, centre } = landingOfApproach('s1', approachAnswer(rig.plane), 16);
  let isReady = false;
  rig.landings.missions.prepare({ site_id: 's9', verdict: 'landable', altitude_datum: 'amsl', touchdown,
    approach: { heading_deg: 90, height_m: 12, loiter_radius_m: 41.3, loiter_direction: 'right', start, loiter_center: centre },
  }).then(() => { isReady = true; });
  await rig.step(5);
  assert.equal(rig.plane.control.mode, 'AUTO');
  assert.ok(!isReady);
  rig.plane.control.setMode('GUIDED');
  await rig.step(6);
  assert.ok(isReady);
  assert.equal(rig.plane.control.mode, 'GUIDED');
});

test('rally points of the best sites in reach, and only verified ones', async () => {
  const rig = new Rig({ recall: async () => ({ sites: [
    { reachable: true, verdict: 'landable', altitude_datum: 'amsl', touchdown: { latitude_deg: 47.4, longitude_deg: 8.55, altitude_m: 440.3 } },
    { reachable: true, verdict: 'unverified', altitude_datum: 'amsl', touchdown: { latitude_deg: 47.41, longitude_deg: 8.55, altitude_m: 440 } },
  ] }) });
  await rig.step(20);
  assert.equal(rig.plane.rally.length, 1);
  assert.deepEqual([rig.plane.rally[0].frame, rig.plane.rally[0].z], [3, 111]);
  assert.equal(rig.mission.rally.num_points, 1);
  const sent = rig.outgoing.counts.MISSION_COUNT;
  await rig.step(70);
  assert.equal(rig.outgoing.counts.MISSION_COUNT, sent, 'not written again');
});

test('a mission of somebody else is read again every 30 s, and is a new one only if it differs', async () => {
  const rig = new Rig();
  await rig.step(5);
  const { items } = rig.landings.vehicle;
  const read = rig.outgoing.counts.MISSION_REQUEST_INT;
  await rig.step(35);
  assert.ok(rig.outgoing.counts.MISSION_REQUEST_INT > read);
  assert.equal(rig.landings.vehicle.items, items);
  rig.plane.mission[3].z += 50;
  await rig.step(35);
  assert.equal(rig.landings.vehicle.items[3].z, rig.plane.mission[3].z);
  assert.deepEqual([rig.mission.state, rig.mission.kind, rig.mission.alarm], ['current', 'other', undefined]);
});

test('a mission of somebody else that cannot be read after a restart is unknown, alarms, and is read later', async () => {
  const rig = new Rig();
  await rig.step(5);
  rig.up.send = () => {};
  rig.plane.restart(3);
  await rig.step(25);
  assert.ok(rig.link.state(rig.plane.utc_us).is_connected);
  assert.equal(rig.mission.state, 'unknown');
  assert.match(rig.mission.alarm, /not known which mission/);
  assert.equal(rig.landings.vehicle.items, undefined);
  delete rig.up.send;
  await rig.step(35);
  assert.deepEqual([rig.mission.state, rig.mission.alarm], ['current', undefined]);
});

test('on the final of somebody else\'s landing nothing is read', async () => {
  const rig = new Rig();
  await rig.step(5);
  const landAt = rig.plane.mission.findIndex((one) => one.command === 21);
  rig.plane.control.setCurrent(landAt);
  await rig.step(2);
  const sent = rig.outgoing.counts.MISSION_REQUEST_LIST;
  await rig.step(40);
  assert.equal(rig.plane.control.mission.index, landAt);
  assert.equal(rig.outgoing.counts.MISSION_REQUEST_LIST, sent);
});

test('nothing else can be sent: no arming, take-off, parameter, servo or any other message', () => {
  const sent = [];
  const outgoing = new Outgoing({ send: (bytes) => sent.push(bytes), systemId: () => 1 });
  const names = Object.values(messageClasses).map((one) => one.MSG_NAME);
  for (const name of names) {
    if (name in allowed) continue;
    assert.throws(() => outgoing.send(name, {}), NotAllowed, name);
  }
  const commands = [];
  for (let id = 0; id < 65536; ++id) {
    for (const name of ['COMMAND_INT', 'COMMAND_LONG']) {
      if (allowed[name]({ command: id, _param1: 0, _param2: 0 }) || allowed[name]({ command: id, _param1: 1, _param2: 10 })) commands.push(id);
    }
  }
  assert.deepEqual([...new Set(commands)], [176, 178, 189, 192]);
  // Neither MANUAL nor any other mode than GUIDED and AUTO.
  for (const mode of [0, 1, 2, 4, 5, 11, 13, 21]) assert.ok(!allowed.COMMAND_LONG({ command: 176, _param1: 1, _param2: mode }));
  // 1 marks the item that is flown; 2 and 3 are guided targets and changes of altitude.
  for (const current of [2, 3]) assert.throws(() => outgoing.send('MISSION_ITEM_INT', { current }), NotAllowed);
  assert.throws(() => outgoing.send('MISSION_COUNT', { count: 0 }), NotAllowed);
  assert.equal(sent.length, 0);
  report(subject, 'messages that may be sent', `${Object.keys(allowed).length} of ${names.length}: ${Object.keys(allowed).join(', ')}`);
});

test('a mixture is told from somebody else\'s mission', () => {
  const one = (z) => ({ frame: 0, command: 16, param1: 0, param2: 0, param3: 0, param4: 0, x: 1, y: 1, z });
  const [a, b] = [[one(1), one(2), one(3)], [one(1), one(5)]];
  assert.ok(isMixture([one(1), one(5), one(3)], [a, b]));
  assert.ok(isMixture([one(1)], [a, b]));
  assert.ok(!isMixture([one(1), one(7)], [a, b]));
  assert.ok(!isMixture([one(1), one(2), one(3), one(4)], [a, b]));
});
