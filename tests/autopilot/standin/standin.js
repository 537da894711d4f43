#!/usr/bin/env node
// A stand-in aircraft on the command line.

import { readFileSync } from 'node:fs';
import { createInterface } from 'node:readline';
import { parseArgs } from 'node:util';

import { readKey } from '../../../server/mavlink/signing.js';
import { Standin } from './aircraft.js';
import { gridFrom } from './ground.js';
import { landing, survey } from './missions.js';
import { serveUdp } from './udp.js';

const usage = `standin.js [options]: an ArduPlane that flies in this program and speaks MAVLink 2 over UDP

  --to HOST:PORT          where it sends (default 127.0.0.1:14550)
  --system ID             its system id (default 1)
  --seed N                of wind and noise (default 1)
  --speed FACTOR          of real time (default 1)
  --home LAT,LON,ALT      degrees, metres above mean sea level
  --in-flight HEIGHT      starts in the air, in a loiter, metres above ground; otherwise on the runway
  --survey                a mission: lines to and fro about home, and a landing; starts in AUTO
  --mission FILE          items as JSON: [{ frame, command, param1, ..., x, y, z }]
  --wind SPEED,FROM       m/s and degrees (default 6,70)
  --gusts SD              m/s
  --ground FILE           elevations as JSON, see ground.js
  --engine-stops SECONDS  after the start
  --signing-key FILE      signs, and believes only what is signed
  --loss R --duplicates R --reorder R   shares of the packets, both ways
  --set NAME=VALUE        any option of options.js, such as aircraft.max_glide_ratio=10; repeatable
  --help

Commands at standard input: engine off | engine on | mode NAME | sticks BANK PATH THROTTLE | cut SECONDS |
restart [SECONDS] | picture | state | quit
`;

const options = {
  to: { type: 'string', default: '127.0.0.1:14550' }, system: { type: 'string', default: '1' },
  seed: { type: 'string', default: '1' }, speed: { type: 'string', default: '1' }, home: { type: 'string' },
  'in-flight': { type: 'string' }, survey: { type: 'boolean', default: false }, mission: { type: 'string' },
  wind: { type: 'string' }, gusts: { type: 'string' }, ground: { type: 'string' }, 'engine-stops': { type: 'string' },
  'signing-key': { type: 'string' }, loss: { type: 'string', default: '0' },
  duplicates: { type: 'string', default: '0' }, reorder: { type: 'string', default: '0' },
  set: { type: 'string', multiple: true, default: [] }, help: { type: 'boolean', default: false },
};

function optionsFrom(values) {
  const result = { seed: Number(values.seed), system_id: Number(values.system), wind: {}, start_us: Date.now() * 1000 };
  if (values.home) {
    const [latitude_deg, longitude_deg, altitude_m] = values.home.split(',').map(Number);
    result.home = { latitude_deg, longitude_deg, altitude_m };
  }
  if (values.wind) [result.wind.speed_mps, result.wind.from_deg] = values.wind.split(',').map(Number);
  if (values.gusts) result.wind.gust_sd_mps = Number(values.gusts);
  if (values.ground) result.ground = gridFrom(values.ground);
  for (const one of values.set) {
    const [path, text] = one.split('=');
    const names = path.split('.');
    const last = names.pop();
    const holder = names.reduce((at, name) => (at[name] ??= {}), result);
    holder[last] = text === 'true' ? true : text === 'false' ? false : Number(text);
  }
  return result;
}

function planeFrom(values) {
  const signingKey = values['signing-key'] && readKey(values['signing-key']);
  const plane = new Standin(optionsFrom(values), { signingKey });
  plane.onText = (text) => console.log(`${plane.time_s.toFixed(1)} s: ${text}`);
  if (values.survey) {
    plane.loadMission([...survey(plane, { withTakeoff: values['in-flight'] === undefined }), ...landing(plane)]);
  }
  if (values.mission) plane.loadMission(JSON.parse(readFileSync(values.mission, 'utf8')));
  if (values['in-flight'] !== undefined) {
    plane.startInFlight({ height_m: Number(values['in-flight']), mode: values.survey ? 'AUTO' : 'LOITER' });
  }
  return plane;
}

// Arms by itself, as its pilot would, as soon as arming is no longer refused.
function armWhenReady(plane) {
  let hasTried_s = 0;
  return () => {
    if (plane.control.isArmed || plane.touchdown || plane.time_s - hasTried_s < 3) return;
    hasTried_s = plane.time_s;
    if (plane.control.setMode('AUTO')) plane.arm();
  };
}

function obey(served, line) {
  const { plane } = served;
  const [name, ...words] = line.trim().split(/\s+/);
  const numbers = words.map(Number);
  const cut = () => [served.up, served.down].forEach((one) => one.cut(plane.time_s, numbers[0]));
  const commands = {
    engine: () => (words[0] === 'on' ? plane.startEngine() : plane.stopEngine()),
    mode: () => plane.pilotMode(words[0]),
    sticks: () => plane.pilotSticks({ bank_deg: numbers[0], path_deg: numbers[1], throttle: numbers[2] }),
    cut, restart: () => plane.restart(numbers[0] || 3), picture: () => plane.takePicture(),
    state: () => console.log(JSON.stringify(plane.truth)), quit: () => process.exit(0),
  };
  if (commands[name]) commands[name]();
  else if (name) console.log(`unknown: ${name}`);
}

async function run(values) {
  const plane = planeFrom(values);
  const [host, port] = values.to.split(':');
  const faults = { seed: Number(values.seed), loss_ratio: Number(values.loss),
    duplicate_ratio: Number(values.duplicates), reorder_ratio: Number(values.reorder) };
  const served = await serveUdp(plane, { host, toPort: Number(port), speed: Number(values.speed), faults });
  const arm = values.survey && values['in-flight'] === undefined ? armWhenReady(plane) : () => {};
  const stops_s = values['engine-stops'] === undefined ? Infinity : Number(values['engine-stops']);
  served.onStep = () => {
    arm();
    if (plane.time_s >= stops_s) plane.stopEngine();
  };
  createInterface({ input: process.stdin }).on('line', (line) => obey(served, line));
  console.log(`system ${values.system} flies, and sends to ${values.to}`);
}

try {
  const { values } = parseArgs({ options });
  if (values.help) console.log(usage);
  else await run(values);
} catch (error) {
  console.error(`standin.js: ${error.message}\n\n${usage}`);
  process.exit(2);
}
