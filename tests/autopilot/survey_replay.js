#!/usr/bin/env node
// Flies a rendered survey (freelsd-render) through the link: MAVLink traffic of its poses and a folder
// of its photographs, which come late. The sites must be those of the same flight sent directly.
//
//   FREELSD_SERVER=… survey_replay.js FOLDER [--speed 4] [--late SECONDS]
//
// Prints the sites of four flights over the same photographs, and how far apart they are: through the
// link; sent frame by frame with the frames and telemetry that the service has of that; the same with the
// rendered poses; and these as a batch, whose wind is that of the frames.

import { execFileSync, spawn } from 'node:child_process';
import { copyFileSync, mkdirSync, mkdtempSync, readFileSync, renameSync, rmSync, utimesSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import dgram from 'node:dgram';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';

import { Service } from '../../server/mavlink/service.js';
import { quaternionOf } from './quaternion.js';
import { Random } from './standin/random.js';
import { allZero, Sender } from './standin/wire.js';

const { values, positionals: [folder] } = parseArgs({ allowPositionals: true, options: {
  speed: { type: 'string', default: '4' }, late: { type: 'string', default: '2' }, port: { type: 'string', default: '18300' },
  verbose: { type: 'boolean', default: false } } });
const speed = Number(values.speed);
const late_s = Number(values.late);
const port = Number(values.port);
const program = fileURLToPath(new URL('../../server/mavlink/freelsd-mavlink.js', import.meta.url));
const work = mkdtempSync(join(tmpdir(), 'freelsd-survey-'));
const url = `http://127.0.0.1:${port}`;
const service = new Service(url);
const sleep = (duration_ms) => new Promise((resolve) => { setTimeout(resolve, duration_ms); });
const radians = (degrees) => (degrees * Math.PI) / 180;
const step_s = 0.2;
const lead_s = 10;

const frames = readFileSync(join(folder, 'poses.csv'), 'utf8').trim().split('\n').slice(1).map((line) => {
  const [image, ...numbers] = line.split(',');
  const [latitude_deg, longitude_deg, altitude_m, time_us, roll_deg, pitch_deg, yaw_deg, wind_east_mps, wind_north_mps] = numbers.map(Number);
  return { image, latitude_deg, longitude_deg, altitude_m, time_s: time_us / 1e6, roll_deg, pitch_deg, yaw_deg, wind_east_mps, wind_north_mps };
});

// Between two frames, as straight as can be; outside, that of the end.
function poseAt(time_s) {
  const after = frames.find((frame) => frame.time_s >= time_s) ?? frames.at(-1);
  const before = frames[Math.max(0, frames.indexOf(after) - 1)];
  const share = Math.min(1, Math.max(0, after === before ? 0 : (time_s - before.time_s) / (after.time_s - before.time_s)));
  const mixed = {};
  for (const key of Object.keys(after)) {
    const step = key === 'yaw_deg' ? ((after[key] - before[key] + 540) % 360) - 180 : after[key] - before[key];
    mixed[key] = key === 'image' ? after.image : before[key] + share * step;
  }
  return mixed;
}

const socket = dgram.createSocket('udp4');
const sender = new Sender({ systemId: 1, componentId: 1 });
const begin_s = frames[0].time_s - lead_s;
const boot_s = begin_s - 60;
const send = (name, fields) => socket.send(sender.bytes(name, { ...allZero(name), ...fields }, Date.now()), port + 1, '127.0.0.1');

function sendPose(time_s) {
  const pose = poseAt(time_s);
  const timeBootMs = Math.round(1000 * (time_s - boot_s));
  send('ATTITUDE', { timeBootMs, roll: radians(pose.roll_deg), pitch: radians(pose.pitch_deg), yaw: radians(pose.yaw_deg) });
  send('GLOBAL_POSITION_INT', { timeBootMs, lat: Math.round(pose.latitude_deg * 1e7), lon: Math.round(pose.longitude_deg * 1e7),
    alt: Math.round(pose.altitude_m * 1000), relativeAlt: 100_000 });
  send('WIND_COV', { windX: pose.wind_north_mps, windY: pose.wind_east_mps });
}

function trigger(frame, index) {
  sendPose(frame.time_s);
  send('CAMERA_FEEDBACK', { timeUsec: BigInt(Math.round(1e6 * (frame.time_s - boot_s))), imgIdx: index + 1,
    lat: Math.round(frame.latitude_deg * 1e7), lng: Math.round(frame.longitude_deg * 1e7), altMsl: frame.altitude_m,
    roll: frame.roll_deg, pitch: frame.pitch_deg, yaw: frame.yaw_deg });
}

function drop({ image, time_s }) {
  const path = join(work, 'pictures', image);
  copyFileSync(join(folder, image), `${path}.part`);
  utimesSync(`${path}.part`, time_s + 0.2, time_s + 0.2);
  renameSync(`${path}.part`, path);
}

async function fly() {
  const random = new Random(1);
  const drops = [];
  const end_s = frames.at(-1).time_s + lead_s;
  const begun_ms = performance.now();
  let next = 0;
  for (let time_s = begin_s, tick = 0; time_s < end_s; time_s = begin_s + ++tick * step_s) {
    while (performance.now() - begun_ms < (1000 * tick * step_s) / speed) await sleep(5);
    if (tick % 5 === 0) {
      send('HEARTBEAT', { type: 1, autopilot: 3, baseMode: 217, customMode: 10, systemStatus: 4, mavlinkVersion: 3 });
      send('SYSTEM_TIME', { timeUnixUsec: BigInt(Math.round(1e6 * time_s)), timeBootMs: Math.round(1000 * (time_s - boot_s)) });
    }
    for (; next < frames.length && frames[next].time_s <= time_s; ++next) {
      const frame = frames[next];
      trigger(frame, next);
      drops.push(sleep(1000 * late_s * random.uniform()).then(() => drop(frame)));
    }
    sendPose(time_s);
  }
  await Promise.all(drops);
}

const state = () => JSON.parse(readFileSync(join(work, 'status.json'), 'utf8')).links[0];
const get = async (path) => (await fetch(`${url}${path}`)).json();
const post = async (path, body) => (await fetch(`${url}${path}`, { method: 'POST', body })).json();

async function awaited(job) {
  for (;;) {
    const { state: how, detail } = await get(`/v1/jobs/${job}`);
    if (how === 'done') return;
    if (how !== 'queued' && how !== 'running') throw new Error(`job ${job}: ${how} ${JSON.stringify(detail)}`);
    await sleep(500);
  }
}

async function sitesOf(flight) {
  await awaited((await post(`/v1/flights/${flight}/finish`)).id);
  const { features } = await get(`/v1/flights/${flight}/sites`);
  const { wind, warnings, origin, options, aircraft } = await get(`/v1/flights/${flight}`);
  if (values.verbose) console.log(JSON.stringify({ wind, warnings, origin, options, aircraft }), features.map(({ properties: p }) => `${p.id} ${p.verdict} ${p.summary}`).join('\n'));
  return features.map(({ geometry: { coordinates }, properties: p }) => ({
    id: p.id.slice(flight.length + 1), verdict: p.verdict, place: coordinates, heading_deg: p.approach?.heading_deg,
    failure_probability: p.failure_probability }));
}

function stored(query, flight) {
  const code = 'import sqlite3, sys, json\n' +
    'rows = sqlite3.connect(f"file:{sys.argv[1]}?mode=ro", uri=True).execute(sys.argv[2], (sys.argv[3],))\n' +
    'print(json.dumps([list(row) for row in rows]))';
  return JSON.parse(execFileSync('python3', ['-c', code, join(work, 'data/freelsd.db'), query, flight], { maxBuffer: 1 << 28 }));
}

const storedFrames = (flight) =>
  stored('select id, sha256, meta_json from frames where flight_id = ? order by sequence', flight);

function storedTelemetry(flight) {
  const kinds = [
    ([latitude_deg, longitude_deg, altitude_m]) => ({ position: { latitude_deg, longitude_deg, altitude_m }, altitude_datum: 'amsl' }),
    (quaternion_wxyz) => ({ attitude: { quaternion_wxyz } }),
    ([east_mps, north_mps]) => ({ wind: { east_mps, north_mps, source: 'autopilot' } }),
  ];
  return stored('select kind, timestamp_us, value_0, value_1, value_2, value_3 from telemetry where flight_id = ? order by timestamp_us', flight)
    .map(([kind, timestamp_us, ...numbers]) => ({ timestamp_us, ...kinds[kind](numbers) }));
}

function shown(sites) {
  const count = (verdict) => sites.filter((site) => site.verdict === verdict).length;
  return `${sites.length} sites: ${count('landable')} landable, ${count('unverified')} unverified, ${count('rejected')} rejected`;
}

function distance_m([longitude, latitude], [otherLongitude, otherLatitude]) {
  return Math.hypot(latitude - otherLatitude, (longitude - otherLongitude) * Math.cos(radians(latitude))) * 111_195;
}

function compare(label, sites, others) {
  const rest = [...others];
  const apart_m = [];
  let numSameVerdict = 0;
  for (const site of sites) {
    const nearest = rest.sort((a, b) => distance_m(site.place, a.place) - distance_m(site.place, b.place))[0];
    if (!nearest) break;
    apart_m.push(distance_m(site.place, nearest.place));
    if (nearest.verdict === site.verdict) ++numSameVerdict;
    rest.shift();
  }
  apart_m.sort((a, b) => a - b);
  console.log(`${label}: ${shown(others)}; nearest site of the link's flight ${apart_m.at(0)?.toFixed(2)} / ${apart_m[apart_m.length >> 1]?.toFixed(2)} / ` +
    `${apart_m.at(-1)?.toFixed(2)} m away (least / median / most), same verdict ${numSameVerdict} of ${sites.length}, ` +
    `identical ${JSON.stringify(sites) === JSON.stringify(others)}`);
}

// As a client gives it.
function givenMeta({ ned_from_body_wxyz: quaternion_wxyz, ...meta }) {
  return { ...meta, attitude: { quaternion_wxyz } };
}

function renderedMeta(_, image) {
  const { time_s, latitude_deg, longitude_deg, altitude_m, roll_deg, pitch_deg, yaw_deg } = frames.find((frame) => frame.image === image);
  return { timestamp_us: Math.round(1e6 * time_s), position: { latitude_deg, longitude_deg, altitude_m }, altitude_datum: 'amsl',
    attitude: { roll_deg, pitch_deg, yaw_deg } };
}

// How far the stored poses are from the rendered ones at most: MAVLink rounds them.
function showRounding(flight, digestOf) {
  let place_m = 0;
  let attitude_deg = 0;
  for (const [, sha256, text] of storedFrames(flight)) {
    const { position: a, ned_from_body_wxyz: q } = JSON.parse(text);
    const { position: b, attitude } = renderedMeta(undefined, digestOf.get(sha256));
    const flat_m = distance_m([a.longitude_deg, a.latitude_deg], [b.longitude_deg, b.latitude_deg]);
    place_m = Math.max(place_m, Math.hypot(flat_m, a.altitude_m - b.altitude_m));
    const same = quaternionOf(attitude).reduce((sum, part, i) => sum + part * q[i], 0);
    attitude_deg = Math.max(attitude_deg, (2 * Math.acos(Math.min(1, Math.abs(same))) * 180) / Math.PI);
  }
  console.log(`poses of the frames against the rendered ones: at most ${(100 * place_m).toFixed(2)} cm and ${attitude_deg.toFixed(5)} deg`);
}

// The telemetry and the frames that the service has of a flight, for another flight.
async function directly(request, linkFlight, digestOf, metaOf) {
  const { id } = await post('/v1/flights', JSON.stringify({ ...request, name: 'frame by frame' }));
  const lines = storedTelemetry(linkFlight);
  while (lines.length) await service.sendTelemetry(id, lines.splice(0, 1000));
  for (const [frame, sha256, meta] of storedFrames(linkFlight)) {
    const image = digestOf.get(sha256);
    await service.putFrame(id, frame, readFileSync(join(folder, image)), metaOf(JSON.parse(meta), image));
  }
  return id;
}

async function asBatch(request) {
  const { id } = await post('/v1/flights', JSON.stringify({ ...request, name: 'batch' }));
  const body = new FormData();
  body.append('poses', new Blob([readFileSync(join(folder, 'poses.csv'))]), 'poses.csv');
  for (const { image } of frames) body.append('images', new Blob([readFileSync(join(folder, image))], { type: 'image/jpeg' }), image);
  await awaited((await post(`/v1/flights/${id}/batch`, body)).id);
  return id;
}

async function run(children) {
  mkdirSync(join(work, 'pictures'));
  const request = JSON.parse(readFileSync(join(folder, 'flight.json'), 'utf8'));
  writeFileSync(join(work, 'request.json'), JSON.stringify(request));
  children.push(spawn(process.env.FREELSD_SERVER, ['--data', join(work, 'data'), '--listen', `127.0.0.1:${port}`], { stdio: 'ignore' }));
  while (!await fetch(`${url}/readyz`).then(({ ok }) => ok, () => false)) await sleep(100);
  children.push(spawn(process.execPath, [program, '--connect', `udp:${port + 1}`, '--url', url, '--spool', join(work, 'spool'),
    '--status', join(work, 'status.json'), '--flight-request', join(work, 'request.json'), '--pictures', join(work, 'pictures'),
    '--picture-clock-error', '1'], { stdio: ['ignore', 'ignore', 'inherit'] }));
  await sleep(2000);
  await fly();
  for (let i = 0; i < 600 && state().pictures.sent < frames.length; ++i) await sleep(200);
  const { pictures, flight } = state();
  console.log(`pictures: ${pictures.sent} sent of ${frames.length}, ${pictures.waiting} wait, ${pictures.unpaired} unpaired, offset ${JSON.stringify(pictures.clock_offset_s)} s`);
  console.log(`before the finish: ${(await get(`/v1/flights/${flight.id}/sites`)).features.length} sites`);
  const sites = await sitesOf(flight.id);
  console.log(`through the link: ${shown(sites)}`);
  const { createHash } = await import('node:crypto');
  const digestOf = new Map(frames.map(({ image }) => [createHash('sha256').update(readFileSync(join(folder, image))).digest('hex'), image]));
  showRounding(flight.id, digestOf);
  compare('frame by frame, same meta and telemetry', sites, await sitesOf(await directly(request, flight.id, digestOf, givenMeta)));
  compare('frame by frame, rendered poses, same telemetry', sites, await sitesOf(await directly(request, flight.id, digestOf, renderedMeta)));
  compare('batch, rendered poses', sites, await sitesOf(await asBatch(request)));
}

const children = [];
try {
  await run(children);
} finally {
  for (const child of children) child.kill();
  socket.close();
  rmSync(work, { recursive: true, force: true });
}
