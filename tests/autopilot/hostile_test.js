// What a hostile or broken link may send. Needs no recording.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test from 'node:test';

import { lock } from '../../server/mavlink/lock.js';
import { Link } from '../../server/mavlink/link.js';
import { idOf, messageOf, packetBytes } from '../../server/mavlink/messages.js';
import { Sessions } from '../../server/mavlink/sessions.js';
import { Signing } from '../../server/mavlink/signing.js';
import { Spool } from '../../server/mavlink/spool.js';
import { Uplink } from '../../server/mavlink/uplink.js';
import { ChangeStore } from '../../server/mavlink/mission/change_store.js';
import { report } from './report.js';

const home = '127.0.0.1 14550';
const start_us = Date.UTC(2026, 5, 1) * 1000;

let sequence = 0;
const bytesOf = (name, fields, { systemId = 1, componentId = 1, version = 2, isSigned = false } = {}) =>
  packetBytes(messageOf(name, fields), { systemId, componentId, version, isSigned, sequence: sequence++ });

const heartbeat = (more = {}) => bytesOf('HEARTBEAT', {
  type: 1, autopilot: 3, baseMode: 128, customMode: 10, systemStatus: 4, mavlinkVersion: 3 }, more);
const time = (boot_ms, more) => bytesOf('SYSTEM_TIME', {
  timeUnixUsec: BigInt(start_us + boot_ms * 1000), timeBootMs: boot_ms }, more);
const position = (boot_ms, fields = {}, more = {}) => bytesOf('GLOBAL_POSITION_INT', {
  timeBootMs: boot_ms, lat: 474000000, lon: 85000000, alt: 500000, relativeAlt: 70000, vx: 0, vy: 1800,
  vz: 0, hdg: 9000, ...fields }, more);

function newLink(options = {}) {
  const lines = [];
  const link = new Link({ emit: (line) => lines.push(line), ...options });
  return { link, lines, take: (bytes, from = home) => link.take(bytes, from, true, start_us) };
}

function temporaryFolder(t) {
  const folder = mkdtempSync(join(tmpdir(), 'freelsd-hostile-'));
  t.after(() => rmSync(folder, { recursive: true, force: true }));
  return folder;
}

for (const version of [1, 2]) {
  test(`MAVLink ${version} is decoded`, () => {
    const { take, lines } = newLink();
    for (const bytes of [heartbeat({ version }), time(1000, { version }), position(1200, {}, { version })]) take(bytes);
    assert.equal(lines.length, 1);
    assert.equal(lines[0].timestamp_us, start_us + 1_200_000);
    assert.deepEqual(lines[0].position, { latitude_deg: 47.4, longitude_deg: 8.5, altitude_m: 500 });
  });
}

test('another system, peer or component is not believed', () => {
  const { take, link, lines } = newLink();
  take(heartbeat());
  take(time(1000));
  take(position(1200, {}, { systemId: 2 }));
  take(position(1200, {}, { componentId: 154 }));
  take(position(1200), '127.0.0.1 9999');
  take(position(1200), '10.0.0.7 14550');
  assert.equal(lines.length, 0);
  assert.deepEqual(link.state().packets.refused, { other_system: 1, other_component: 1, other_peer: 2 });
});

test('a ground station does not become the autopilot', () => {
  const { take, link } = newLink();
  take(bytesOf('HEARTBEAT', { type: 6, autopilot: 8, baseMode: 0, customMode: 0, systemStatus: 4, mavlinkVersion: 3 },
    { systemId: 255, componentId: 190 }));
  assert.equal(link.state().system_id, undefined);
});

test('absurd positions are not believed, and a true jump is after 5 s', () => {
  const { take, link, lines } = newLink();
  take(heartbeat());
  take(time(1000));
  take(position(1200));
  for (const fields of [{ lat: 0, lon: 0 }, { lat: 950000000 }, { alt: 90000000 }, { lat: 484000000 }]) {
    take(position(1400, fields));
    take(position(1600));
  }
  const places = lines.filter((line) => line.position).map((line) => line.position.latitude_deg);
  assert.ok(places.every((latitude_deg) => latitude_deg === 47.4));
  assert.equal(link.state().packets.refused.absurd_position, 3);
  assert.equal(link.state().packets.refused.position_jump, 1);
  for (let boot_ms = 2000; boot_ms <= 7200; boot_ms += 200) take(position(boot_ms, { lat: 484000000 }));
  assert.equal(lines.at(-1).position.latitude_deg, 48.4);
});

test('with a key only fresh packets of that key are believed, also after a restart', (t) => {
  const path = join(temporaryFolder(t), 'signatures.json');
  const key = Buffer.alloc(32, 7);
  let now_ms = Date.UTC(2026, 5, 1);
  const sign = (bytes, withKey = key) => {
    const sender = new Signing(withKey, join(temporaryFolder(t), 'none.json'));
    now_ms += 1;
    return sender.signed(bytes, { linkId: 3, now_ms });
  };
  const signing = new Signing(key, path);
  const { take, link, lines } = newLink({ signing });
  const isSigned = { isSigned: true };
  const recorded = [sign(heartbeat(isSigned)), sign(time(1000, isSigned)), sign(position(1200, {}, isSigned))];
  recorded.forEach((bytes) => take(bytes));
  assert.equal(lines.length, 1);
  recorded.forEach((bytes) => take(bytes));
  take(position(1400));
  take(sign(position(1400, {}, isSigned), Buffer.alloc(32, 8)));
  const changed = sign(position(1400, {}, isSigned));
  changed[20] ^= 1;
  take(changed);
  assert.equal(lines.length, 1);
  const { refused, damaged } = { ...link.state().packets };
  assert.deepEqual(refused, { replayed: 3, unsigned: 1, wrong_signature: 1 });
  assert.ok(damaged >= 1);
  signing.save();
  const later = newLink({ signing: new Signing(key, path) });
  recorded.forEach((bytes) => later.take(bytes));
  assert.equal(later.link.state().packets.refused.replayed, 3);
});

test('10 000 packets a second, valid and not, leave most of the processor free', () => {
  const { take, lines, link } = newLink();
  take(heartbeat());
  take(time(1000));
  const junk = Buffer.alloc(1400, 0xfd);
  const halfTrue = Buffer.concat(Array.from({ length: 100 }, () => Buffer.from([0xfd, 9, 0, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0])));
  const valid = position(1200);
  const other = position(1200, {}, { systemId: 9 });
  const floods = { 'the same valid packet': valid, 'another system': other, 'start bytes only': junk, 'false headers': halfTrue };
  for (const [what, bytes] of Object.entries(floods)) {
    const begun = process.cpuUsage();
    for (let i = 0; i < 10_000; ++i) take(bytes);
    // Processor time: other programs on the machine do not count.
    const { user, system } = process.cpuUsage(begun);
    const spent_ms = (user + system) / 1000;
    report('flood', `10 000 datagrams, ${what}`, `${spent_ms.toFixed(0)} ms of processor`);
    assert.ok(spent_ms < 800, `${what}: ${spent_ms} ms`);
  }
  assert.equal(lines.length, 1);
  take(position(1400));
  assert.equal(lines.length, 2);
  assert.ok(link.state().packets.accepted > 10_000);
});

test('the spool is bounded, drops the oldest and says how many', (t) => {
  const spool = new Spool(temporaryFolder(t), { maxBytes: 2 * 1024 * 1024 });
  const line = { session: 's', line: { text: 'x'.repeat(1000) } };
  for (let i = 0; i < 4000; ++i) {
    spool.append({ ...line, i });
    if (i % 10 === 9) spool.flush();
  }
  assert.ok(spool.numBytes <= 2.1 * 1024 * 1024);
  assert.equal(spool.numLost + spool.numWaiting, 4000);
  assert.equal(spool.next(2000).values[0].i, spool.numLost);
});

test('a spool opened again has what was not delivered, and survives half a line', (t) => {
  const folder = temporaryFolder(t);
  const first = new Spool(folder);
  for (let i = 0; i < 100; ++i) first.append({ i });
  first.flush();
  const batch = first.next(200);
  first.delivered(batch.mark);
  first.sync();
  const second = new Spool(folder);
  assert.equal(second.numWaiting, 100 - batch.values.length);
  second.append({ i: 100 });
  second.flush();
  const seen = [];
  for (let next = second.next(1e6); next; next = second.next(1e6)) {
    seen.push(...next.values.map(({ i }) => i));
    second.delivered(next.mark);
  }
  assert.deepEqual(seen, Array.from({ length: 101 - batch.values.length }, (_, k) => k + batch.values.length));
});

test('PX4: wind says where the air moves, and a camera is heard', () => {
  const { take, link, lines } = newLink();
  take(heartbeat());
  take(time(1000));
  take(position(1200));
  take(bytesOf('WIND_COV', { timeUsec: 0n, windX: 3, windY: -4, windZ: 0, varHoriz: 0, varVert: 0, windAlt: 0, horizAccuracy: 0, vertAccuracy: 0 }));
  assert.deepEqual(lines.at(-1).wind, { east_mps: -4, north_mps: 3, source: 'autopilot' });
  take(bytesOf('CAMERA_TRIGGER', { timeUsec: 1_500_000n, seq: 7 }));
  assert.deepEqual(link.state().camera, { num_triggers: 1, last: { timestamp_us: start_us + 1_500_000, kind: 'CAMERA_TRIGGER', index: 7 } });
  assert.equal(idOf.WIND, 168);
});

const feedback = (more) => bytesOf('CAMERA_FEEDBACK', { timeUsec: 1_500_000n, targetSystem: 1, camIdx: 0, imgIdx: 3, lat: 474000100, lng: 85000100,
  altMsl: 500, altRel: 70, roll: 3, pitch: -2, yaw: 90, focLen: 0, flags: 0, completedCaptures: 0, ...more });

test('a trigger waits for UTC, comes once, and a pose far from the aircraft is not believed', () => {
  const triggers = [];
  const { take, link } = newLink({ onTrigger: (trigger) => triggers.push(trigger) });
  take(heartbeat());
  take(position(1200));
  take(feedback());
  assert.equal(triggers.length, 0);
  take(time(1600));
  link.tick(start_us);
  take(feedback());
  assert.equal(triggers.length, 1);
  const { timestamp_us, kind, index, attitude } = triggers[0];
  assert.deepEqual({ timestamp_us, kind, index, attitude }, { timestamp_us: start_us + 1_500_000, kind: 'CAMERA_FEEDBACK', index: 3,
    attitude: { roll_deg: 3, pitch_deg: -2, yaw_deg: 90 } });
  take(feedback({ imgIdx: 4, timeUsec: 2_500_000n, lat: 484000000 }));
  take(feedback({ imgIdx: 5, timeUsec: 0n }));
  assert.equal(triggers.length, 2);
  assert.deepEqual([triggers[1].index, triggers[1].position, triggers[1].attitude], [4, undefined, undefined]);
  assert.equal(link.state().camera.num_triggers, 4);
});

const captured = (fields, more) => bytesOf('CAMERA_IMAGE_CAPTURED', { timeBootMs: 1400, timeUtc: 0n, cameraId: 0, lat: 474000000, lon: 85000000,
  alt: 500000, relativeAlt: 70000, q: [1, 0, 0, 0], imageIndex: 1, captureResult: 1, fileUrl: '', ...fields }, more);

test("a camera has another boot than the autopilot, and its UTC counts only near the link's own", () => {
  const triggers = [];
  const { take, link } = newLink({ onTrigger: (trigger) => triggers.push(trigger) });
  const camera = { componentId: 100 };
  take(heartbeat());
  const utc = (boot_ms) => BigInt(start_us + boot_ms * 1000);
  take(captured({ timeUtc: utc(0) }, camera));
  take(time(1000));
  take(position(1200));
  take(captured({}, camera));
  take(bytesOf('CAMERA_TRIGGER', { timeUsec: 1_400_000n, seq: 1 }, camera));
  for (const boot_ms of [-3_600_000, -2000, 5000, 86_400_000]) take(captured({ timeUtc: utc(boot_ms) }, camera));
  take(captured({ timeBootMs: 60_000 }));
  assert.deepEqual(triggers, []);
  assert.equal(link.state().packets.refused.trigger_time, 8);
  take(captured({ timeUtc: utc(-1000), imageIndex: 2 }, camera));
  take(captured({ imageIndex: 3 }));
  assert.deepEqual(triggers.map(({ timestamp_us, index }) => [timestamp_us - start_us, index]), [[-1e6, 2], [1_400_000, 3]]);
});

test('a trigger begins no flight, whatever its time is', (t) => {
  const sessions = new Sessions(join(temporaryFolder(t), 'session.json'));
  assert.equal(sessions.find(start_us, 1), undefined);
  const name = sessions.at(start_us, 1);
  for (const hours of [-24, -1, 1, 24]) assert.equal(sessions.find(start_us + hours * 3600e6, 1), undefined);
  assert.equal(sessions.find(start_us, 2), undefined);
  // Such triggers, each near the last one, lead nowhere.
  for (let minutes = 0; minutes <= 60; minutes += 10) sessions.find(start_us + minutes * 60e6, 1);
  assert.equal(sessions.find(start_us - 2e6, 1), name);
  assert.equal(sessions.at(start_us + 1e6, 1), name);
  assert.equal(sessions.name, name);
});

test('a time of the autopilot that is no date is not believed', (t) => {
  const sessions = new Sessions(join(temporaryFolder(t), 'session.json'));
  const { take, link } = newLink({ emit: (line) => sessions.at(line.timestamp_us, 1) });
  take(heartbeat());
  for (let boot_ms = 1000; boot_ms <= 4000; boot_ms += 1000) {
    take(bytesOf('SYSTEM_TIME', { timeUnixUsec: 0xffff_ffff_ffff_ffffn, timeBootMs: boot_ms }));
    take(position(boot_ms + 200));
  }
  assert.notEqual(link.state().clock.source, 'autopilot');
  take(time(5000));
  take(position(5200));
  assert.match(sessions.name, /2026-06-01/);
});

test('files of state that a power cut has emptied or cut are set aside and told, and the program runs without them', (t) => {
  const opened = {
    'session.json': (path, log) => new Sessions(path, log),
    'flights.json': (path, log) => new Uplink({ path, log }),
    'signatures.json': (path, log) => new Signing(Buffer.alloc(32, 7), path, log),
    'mission.json': (path, log) => new ChangeStore(path, log),
    'read.json': (path, log) => new Spool(join(path, '..'), { log }),
  };
  for (const [name, open] of Object.entries(opened)) {
    for (const text of ['', '{"name": "MAV', 'null']) {
      const log = [];
      const path = join(temporaryFolder(t), name);
      writeFileSync(path, text);
      open(path, (line) => log.push(line));
      assert.match(log.join(), /set aside/, name);
      assert.ok(!existsSync(path));
      assert.equal(readFileSync(`${path}.broken`, 'utf8'), text);
    }
  }
});

test('a disk that refuses does not end a change of the mission: the former one is kept in memory', () => {
  const log = [];
  // No folder can be made there.
  const store = new ChangeStore('/proc/none/mission.json', (text) => log.push(text));
  store.save({ old: [1], wanted: [2] });
  assert.deepEqual(store.load(), { old: [1], wanted: [2] });
  assert.match(log[0], /not safe from a crash/);
  store.clear();
  assert.equal(store.load(), undefined);
});

test('a spool is held only by the very program that has locked it, also if another one has its number now', async (t) => {
  const folder = temporaryFolder(t);
  const other = spawn(process.execPath, ['-e', 'setInterval(() => {}, 1000)', 'freelsd-mavlink', '--spool', '/elsewhere'], { stdio: 'ignore' });
  t.after(() => other.kill());
  const pidPath = join(folder, 'pid');
  lock(folder);
  lock(folder);
  const own = readFileSync(pidPath, 'utf8');
  for (const held of [String(other.pid), own.replace(/^\d+/, other.pid)]) {
    writeFileSync(pidPath, held);
    lock(folder);
  }
  const script = `import(${JSON.stringify(new URL('../../server/mavlink/lock.js', import.meta.url))}).then(({ lock }) => { lock(${JSON.stringify(folder)}); setInterval(() => {}, 1000); })`;
  rmSync(pidPath);
  const holder = spawn(process.execPath, ['-e', script], { stdio: 'ignore' });
  t.after(() => holder.kill());
  while (!existsSync(pidPath) || readFileSync(pidPath, 'utf8') === '') await new Promise((resolve) => { setTimeout(resolve, 50); });
  assert.throws(() => lock(folder), /uses it/);
});
