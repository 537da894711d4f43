#!/usr/bin/env node
// Flights of the trial through the program itself: freelsd-mavlink.js as a process, signed, over UDP,
// in real time. Prints how each ended.
//
//   live_trial.js --url URL --ground PATH [--flights N] [--seed N]

import { spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';

import { FlatFrame } from '../../../server/mavlink/flat_frame.js';
import { Random } from '../standin/random.js';
import { serveUdp } from '../standin/udp.js';
import { surveysOf } from './surveys.js';
import { defaultTrialOptions, planeOver, startRoute } from './trial_plane.js';
import { TrueGround } from './true_ground.js';

const program = fileURLToPath(new URL('../../../server/mavlink/freelsd-mavlink.js', import.meta.url));
const sleep = (duration_ms) => new Promise((resolve) => { setTimeout(resolve, duration_ms); });
const firstPort = 24600;
const longest_s = 240;

const { values } = parseArgs({ options: {
  url: { type: 'string' }, ground: { type: 'string' }, flights: { type: 'string', default: '1' },
  seed: { type: 'string', default: '1' },
} });
const ground = new TrueGround(values.ground);
const sites = await (await fetch(new URL('v1/emergency/export?f=geojson', values.url))).json();
const surveys = surveysOf(sites, ground);

async function fly(seed, port) {
  const folder = mkdtempSync(join(tmpdir(), 'freelsd-live-'));
  const key = Buffer.alloc(32, seed);
  writeFileSync(join(folder, 'key'), key.toString('hex'));
  const random = new Random(seed);
  const survey = surveys[Math.floor(random.uniform() * surveys.length)];
  const plane = planeOver(survey, { ground, random, seed, ...defaultTrialOptions }, { signingKey: key });
  startRoute(plane, random);
  const link = spawn(process.execPath, [program, '--connect', `udp:${port}`, '--url', values.url,
    '--signing-key', join(folder, 'key'), '--on-engine-failure', 'land', '--aircraft', 'small', '--spool', join(folder, 'spool'),
    '--status', join(folder, 'status.json')], { stdio: ['ignore', 'ignore', 'inherit'] });
  const served = await serveUdp(plane, { toPort: port });
  const state = () => { try { return JSON.parse(readFileSync(join(folder, 'status.json'), 'utf8')).links[0]; } catch { return undefined; } };
  await sleep(30_000 + 20_000 * random.uniform());
  plane.stopEngine();
  const stopped_s = plane.time_s;
  while (!plane.touchdown && plane.time_s < stopped_s + longest_s) await sleep(200);
  await sleep(3000);
  const { guidance, log = [] } = state() ?? {};
  const ended = new Promise((resolve) => { link.once('exit', resolve); });
  link.kill();
  await ended;
  served.close();
  rmSync(folder, { recursive: true, force: true });
  return { plane, guidance, log, stopped_s };
}

for (let i = 0; i < Number(values.flights); ++i) {
  const seed = Number(values.seed) + i;
  const { plane, guidance, log, stopped_s } = await fly(seed, firstPort + i);
  const { touchdown } = plane;
  const land = plane.mission.at(-1);
  const place = touchdown && new FlatFrame({ latitude_deg: land.x / 1e7, longitude_deg: land.y / 1e7 }).toLocal(touchdown);
  console.log(`flight ${seed}: down after ${(touchdown?.time_s - stopped_s).toFixed(0)} s in ${touchdown?.mode}, ` +
    `guidance ${guidance?.phase} to ${guidance?.site_id}, ` +
    `${place ? Math.hypot(place.east_m, place.north_m).toFixed(0) : '-'} m from the last item of its mission, ${log.length} decisions`);
}
