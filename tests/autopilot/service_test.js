// The program itself between a recording and a real service.

import assert from 'node:assert/strict';
import { rmSync } from 'node:fs';
import { join } from 'node:path';
import test from 'node:test';

import { ended, isReady, path, setUp, skip, sleep, until } from './processes.js';
import { replay } from './replay.js';
import { report } from './report.js';
import { readTlog } from './tlog.js';
import { throughLink } from './truth.js';

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
