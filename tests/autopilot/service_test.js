// The program itself between a recording and a real service.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import dgram from 'node:dgram';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import net from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test from 'node:test';
import { fileURLToPath } from 'node:url';

import { replay } from './replay.js';
import { report } from './report.js';
import { readTlog, recording, skipReason } from './tlog.js';
import { throughLink } from './truth.js';

const root = fileURLToPath(new URL('../..', import.meta.url));
const server = process.env.FREELSD_SERVER ?? join(root, 'build/release/server/freelsd-server');
const program = join(root, 'server/mavlink/freelsd-mavlink.js');
const path = recording('arduplane_landing.tlog');
const skip = !path ? skipReason
  : !existsSync(server) ? 'no freelsd-server: build it or set FREELSD_SERVER' : false;

const sleep = (duration_ms) => new Promise((resolve) => { setTimeout(resolve, duration_ms); });

async function until(what, condition, limit_ms = 30_000) {
  for (const end_ms = Date.now() + limit_ms; Date.now() < end_ms; await sleep(100)) {
    const value = await Promise.resolve().then(condition).catch(() => undefined);
    if (value) return value;
  }
  throw new Error(`waited in vain for: ${what}`);
}

function freePort(make) {
  return new Promise((resolve) => {
    const socket = make();
    const done = () => {
      const { port } = socket.address();
      socket.close(() => resolve(port));
    };
    if (socket.listen) socket.listen(0, '127.0.0.1', done);
    else socket.bind(0, '127.0.0.1', done);
  });
}

const ended = (child) => new Promise((resolve) => { child.once('exit', resolve); });

async function setUp(t) {
  const folder = mkdtempSync(join(tmpdir(), 'freelsd-link-'));
  const setup = {
    folder,
    url: `http://127.0.0.1:${await freePort(() => net.createServer())}`,
    udpPort: await freePort(() => dgram.createSocket('udp4')),
    children: [],
    startServer: () => start(setup, server, ['--data', join(folder, 'data'), '--listen', setup.url.slice(7)]),
    startLink: (...more) => start(setup, process.execPath, [program, '--connect', `udp:${setup.udpPort}`, '--url', setup.url,
      '--spool', join(folder, 'spool'), '--status', join(folder, 'status.json'), ...more]),
    state: () => JSON.parse(readFileSync(join(folder, 'status.json'), 'utf8')).links[0],
    get: async (where) => (await fetch(`${setup.url}${where}`)).json(),
  };
  t.after(async () => {
    for (const child of setup.children) {
      if (child.exitCode !== null || child.signalCode) continue;
      child.kill('SIGKILL');
      await ended(child);
    }
    rmSync(folder, { recursive: true, force: true });
  });
  return setup;
}

function start(setup, command, args) {
  const child = spawn(command, args, { stdio: 'ignore' });
  setup.children.push(child);
  return child;
}

const isReady = (setup) => until('the service', async () => (await fetch(`${setup.url}/healthz`)).ok);

async function trackOf(setup) {
  const { flights } = await setup.get('/v1/flights');
  assert.equal(flights.length, 1);
  const { features } = await setup.get(`/v1/flights/${flights[0].id}/track`);
  return features[0];
}

const expected = () => throughLink(readTlog(path)).lines.filter((line) => line.position)
  .sort((a, b) => a.timestamp_us - b.timestamp_us)
  .map(({ position }) => [position.longitude_deg, position.latitude_deg, position.altitude_m]);

const delivered = (setup) => until('the spool to be empty', () => {
  const { spool, samples } = setup.state();
  return spool.waiting === 0 && samples.waiting_for_utc === 0;
});

test('positions in the service are those of the recording', { skip, timeout: 120_000 }, async (t) => {
  const setup = await setUp(t);
  setup.startServer();
  await isReady(setup);
  setup.startLink();
  await until('the link', () => setup.state());
  const heard = await replay(readTlog(path), { port: setup.udpPort, speed: 2 });
  await sleep(1500);
  await delivered(setup);
  const track = await trackOf(setup);
  assert.deepEqual(track.geometry.coordinates, expected());
  assert.equal(track.properties.altitude_datum, 'amsl');
  assert.ok(heard.length > 0, 'the link sends its heartbeat');
  const { service, packets } = setup.state();
  assert.equal(service.rejected, 0);
  report('service', 'track equal to the recording', `${expected().length} positions, ${packets.accepted} packets, 20 times real time`);
});

test('a service killed twice in the middle, and started after the link, loses nothing', { skip, timeout: 120_000 }, async (t) => {
  const setup = await setUp(t);
  setup.startLink();
  await until('the link', () => setup.state());
  const records = readTlog(path);
  let running;
  await replay(records, {
    port: setup.udpPort,
    speed: 2,
    onRecord: async (index) => {
      if (index === 3000 || index === 9000) running = setup.startServer();
      if (index === 7000 || index === 12000) running.kill('SIGKILL');
    },
  });
  await sleep(1500);
  assert.ok(setup.state().spool.waiting > 0);
  setup.startServer();
  await isReady(setup);
  const begun_ms = Date.now();
  await delivered(setup);
  const track = await trackOf(setup);
  assert.deepEqual(track.geometry.coordinates, expected());
  assert.equal(setup.state().spool.lost, 0);
  report('service', 'killed twice and started late: positions lost', `0 of ${expected().length}; caught up in ${((Date.now() - begun_ms) / 1000).toFixed(1)} s`);
});

test('the link killed and started again in the middle goes on in the same flight', { skip, timeout: 120_000 }, async (t) => {
  const setup = await setUp(t);
  setup.startServer();
  await isReady(setup);
  let link = setup.startLink();
  await until('the link', () => setup.state());
  await replay(readTlog(path), {
    port: setup.udpPort,
    speed: 2,
    onRecord: async (index) => {
      if (index === 6000) link.kill('SIGKILL');
      if (index !== 6200) return;
      if (link.signalCode === null) await ended(link);
      rmSync(join(setup.folder, 'status.json'));
      link = setup.startLink();
      await until('the link', () => setup.state());
    },
  });
  await sleep(1500);
  await delivered(setup);
  const track = await trackOf(setup);
  const share = track.geometry.coordinates.length / expected().length;
  // What was sent while nobody listened is gone, and what the socket still held; on a busy machine
  // this is seconds, and the recording runs 20 times faster.
  assert.ok(share > 0.8);
  report('service', 'link killed in the middle', `one flight, ${(100 * share).toFixed(0)} % of the positions`);
});
