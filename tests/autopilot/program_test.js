// The program itself over real sockets: between a stand-in and a small service of this file, also
// under a flood of forged packets.

import assert from 'node:assert/strict';
import dgram from 'node:dgram';
import { createServer } from 'node:http';
import { mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import test from 'node:test';

import { readKey, Signing } from '../../server/mavlink/signing.js';
import { approachAnswer, siteAnswer } from './mission_rig.js';
import { ended, setUp, sleep, until as waitFor } from './processes.js';
import { report } from './report.js';
import { Standin } from './standin/aircraft.js';
import { distance } from './standin/frame.js';
import { landing, survey } from './standin/missions.js';
import { serveUdp } from './standin/udp.js';
import { Sender } from './standin/wire.js';

// Of a machine that does much else.
const patience_ms = 120_000;
const until = (what, condition) => waitFor(what, condition, patience_ms);
const flood_s = 5;
const packetsPerSecond = 10_000;

// Answers as freelsd-server does: links, sites, approaches, flights and telemetry.
async function smallService(t, setup, plane) {
  const service = { reports: [], commands: [] };
  const answers = [
    [/^PUT \/v1\/links\//, (body) => {
      service.reports.push(body);
      const told = new Set((body.commands ?? []).map(({ id }) => id));
      return { commands: service.commands.filter(({ id }) => !told.has(id)) };
    }],
    [/^GET \/v1\/sites\/s1\/approach/, () => approachAnswer(plane, { final_m: 200, height_m: 14, radius_m: 75 })],
    [/^GET \/v1\/sites\/s1$/, () => siteAnswer],
    [/^GET \/v1\/flights\?/, () => ({ flights: [] })],
    [/^POST \/v1\/flights$/, () => ({ id: 'f1' })],
    [/^POST \/v1\/flights\/f1\/telemetry/, () => ({ accepted: 1, rejected: [] })],
    [/^GET \/v1\/emergency/, () => ({ sites: [] })],
  ];
  const server = createServer(async (request, response) => {
    let text = '';
    for await (const part of request) text += part;
    const answer = answers.find(([pattern]) => pattern.test(`${request.method} ${request.url}`));
    response.writeHead(answer ? 200 : 404, { 'Content-Type': 'application/json' });
    const isJson = request.headers['content-type'] === 'application/json' && text;
    response.end(JSON.stringify(answer ? answer[1](isJson ? JSON.parse(text) : undefined) : { title: 'not found' }));
  });
  await new Promise((resolve) => { server.listen(Number(new URL(setup.url).port), '127.0.0.1', resolve); });
  t.after(() => { server.closeAllConnections(); server.close(); });
  service.last = () => service.reports.at(-1);
  service.command = (id) => service.last()?.commands?.find((one) => one.id === id);
  return service;
}

async function flying(t, { signingKey, linkArgs = [] } = {}) {
  const setup = await setUp(t);
  const plane = new Standin({ start_us: Date.now() * 1000 }, { signingKey: signingKey?.(setup) });
  plane.loadMission([...survey(plane, { width_m: 240, spacing_m: 80 }), ...landing(plane)]);
  plane.startInFlight({ height_m: 120, mode: 'AUTO' });
  const service = await smallService(t, setup, plane);
  const served = await serveUdp(plane, { toPort: setup.udpPort, speed: 1 });
  t.after(() => served.close());
  const link = setup.startLink(...linkArgs.map((one) => one.replace('FOLDER', setup.folder)));
  await until('the mission', () => service.last()?.mission?.num_items === plane.mission.length);
  return { setup, plane, service, link };
}

test('a command of the service becomes a mission that the autopilot flies', { timeout: 400_000 }, async (t) => {
  const { plane, service } = await flying(t);
  const begun_ms = Date.now();
  service.commands.push({ id: 'c1', kind: 'mission', site_id: 's1', issued_at: new Date().toISOString(), confirmed_by: 'Ada' });
  await until('the command', () => service.command('c1')?.state === 'done');
  report('program', 'from the command to the flown mission, over UDP', `${((Date.now() - begun_ms) / 1000).toFixed(1)} s`);
  const { mission, log } = service.last();
  assert.deepEqual({ state: mission.state, kind: mission.kind, site: mission.site }, { state: 'current', kind: 'landing', site: 's1' });
  assert.ok(log.some(({ kind, text }) => kind === 'mission' && /wanted by Ada/.test(text)));
  assert.equal(plane.mission.at(-1).command, 21);
  assert.equal(plane.control.mode, 'AUTO');
  await until('the circle', () => service.last().mission.current_item > plane.mission.findIndex((one) => one.command === 189));
});

test('a fault that nobody catches is told once and does not end the program', { timeout: 400_000 }, async (t) => {
  const setup = await setUp(t);
  const faulty = join(setup.folder, 'faulty.cjs');
  const status = JSON.stringify(join(setup.folder, 'status.json'));
  // Once it runs.
  writeFileSync(faulty, `setInterval(() => { if (require('node:fs').existsSync(${status})) Promise.reject(new Error('nobody waits')); }, 200);\n`);
  process.env.NODE_OPTIONS = `--require ${faulty}`;
  t.after(() => { delete process.env.NODE_OPTIONS; });
  const link = setup.startLink();
  const faults = () => setup.state().log.filter(({ text }) => text === 'fault: nobody waits');
  await until('the fault', () => faults().length > 0);
  await sleep(1500);
  assert.deepEqual([faults().length, link.exitCode], [1, null]);
});

test('exit status 78, after which nobody starts it again, is only for wrong options', { timeout: 60_000 }, async (t) => {
  const setup = await setUp(t);
  const statusOf = (...args) => ended(setup.startLink(...args));
  assert.equal(await statusOf('--url', 'ftp://nowhere'), 78);
  assert.equal(await statusOf('--signing-key', join(setup.folder, 'none')), 78);
  // A folder that cannot be made is of the machine.
  writeFileSync(join(setup.folder, 'file'), '');
  assert.equal(await statusOf('--spool', join(setup.folder, 'file', 'spool')), 1);
  mkdirSync(join(setup.folder, 'spool'), { recursive: true });
  writeFileSync(join(setup.folder, 'spool', 'session.json'), '');
  const link = setup.startLink();
  await until('the state', () => setup.state());
  assert.equal(link.exitCode, null);
});

// Each as often as the others.
function forged(plane, signing) {
  const other = new Sender({ systemId: 9, componentId: 1 });
  const same = new Sender({ systemId: 1, componentId: 1 }, signing);
  const nowhere = { timeBootMs: 1, lat: 484000000, lon: 95000000, alt: 900000, relativeAlt: 0, vx: 0, vy: 0, vz: 0, hdg: 0 };
  const count = { targetSystem: 1, targetComponent: 191, count: 2, missionType: 0 };
  return [
    () => other.bytes('HEARTBEAT', { type: 1, autopilot: 3, baseMode: 0, customMode: 0, systemStatus: 3, mavlinkVersion: 3 }),
    () => same.bytes('GLOBAL_POSITION_INT', nowhere),
    () => same.bytes('HEARTBEAT', { type: 1, autopilot: 3, baseMode: 0, customMode: 0, systemStatus: 3, mavlinkVersion: 3 }),
    () => same.bytes('MISSION_COUNT', count),
    () => same.bytes('MISSION_ACK', { targetSystem: 1, targetComponent: 191, type: 0, missionType: 0 }),
    () => same.bytes('MISSION_REQUEST', { targetSystem: 1, targetComponent: 191, seq: 1, missionType: 0 }),
    () => Buffer.alloc(300, 0xfd),
    () => same.bytes('COMMAND_ACK', { command: 189, result: 0 }),
  ];
}

async function flood(port, makers, duration_s) {
  const socket = dgram.createSocket('udp4');
  const packets = Array.from({ length: 800 }, (_, i) => makers[i % makers.length]());
  const begun_ms = performance.now();
  let numSent = 0;
  while (performance.now() - begun_ms < 1000 * duration_s) {
    const due = Math.floor(((performance.now() - begun_ms) * packetsPerSecond) / 1000);
    while (numSent < due) {
      const bytes = packets[numSent++ % packets.length];
      if (numSent === due) await new Promise((resolve) => { socket.send(bytes, port, '127.0.0.1', resolve); });
      else socket.send(bytes, port, '127.0.0.1');
    }
    await sleep(1);
  }
  socket.close();
  return numSent;
}

const keyText = 'the right key';
const cases = {
  'from another socket': {},
  'unsigned and wrongly signed, link with a key': {
    signingKey: (setup) => {
      const path = join(setup.folder, 'key');
      writeFileSync(path, keyText);
      return readKey(path);
    },
    linkArgs: ['--signing-key', 'FOLDER/key'],
    forge: (i) => (i % 2 ? new Signing(Buffer.alloc(32, 3), '') : undefined),
  },
};

for (const [label, { signingKey, linkArgs, forge }] of Object.entries(cases)) {
  test(`10 000 forged packets a second ${label}: nothing is believed, nothing stalls`, { timeout: 400_000 }, async (t) => {
    const { setup, plane, service } = await flying(t, { signingKey, linkArgs });
    const before = service.last();
    const makers = [0, 1].flatMap((i) => forged(plane, forge?.(i)));
    const flooding = flood(setup.udpPort, makers, flood_s);
    await sleep(1000);
    service.commands.push({ id: 'c1', kind: 'mission', site_id: 's1', issued_at: new Date().toISOString() });
    const ages_s = [];
    const away_m = [];
    let isOver = false;
    flooding.then(() => { isOver = true; });
    while (!isOver) {
      await sleep(200);
      const state = service.last();
      ages_s.push(state.age_s);
      away_m.push(distance(plane.frame.toLocal(state.position), plane.truth));
      assert.ok(state.is_armed && state.mode === 'AUTO' && state.system_id === 1);
    }
    const numSent = await flooding;
    await until('the command', () => service.command('c1')?.state === 'done');
    const after = service.last();
    assert.equal(after.mission.kind, 'landing');
    assert.equal(plane.mission.at(-1).command, 21);
    const { refused } = after.packets;
    const numRefused = Object.values(refused).reduce((sum, one) => sum + one, 0);
    const numAccepted = after.packets.accepted - before.packets.accepted;
    report('hostile, real socket', `${numSent} forged packets in ${flood_s} s, ${label}`,
      `${numRefused} refused, 0 believed; own packets heard meanwhile: ${numAccepted}; state at most ${Math.max(...ages_s).toFixed(1)} s old; ` +
      `place at most ${Math.max(...away_m).toFixed(0)} m from the truth of that moment; mission written meanwhile`);
    // Reports come once a second.
    assert.ok(Math.max(...away_m) < 150);
    assert.ok(Math.max(...ages_s) < 3, `${Math.max(...ages_s)}`);
    assert.ok(numRefused > 1000);
  });
}
