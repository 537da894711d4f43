#!/usr/bin/env node
// Plays a telemetry log over UDP, in its own time or faster.
//
//   tests/autopilot/replay.js FILE HOST:PORT [SPEED]

import dgram from 'node:dgram';
import { fileURLToPath } from 'node:url';

import { readTlog } from './tlog.js';

const sleep = (duration_ms) => new Promise((resolve) => { setTimeout(resolve, duration_ms); });

// Longest burst without a pause: a receiver's socket holds about 200 KB.
const maxBurst = 64;

// records: as of readTlog. speed 1 is the time of the recording. onRecord(index) may be async.
export async function replay(records, { host = '127.0.0.1', port, speed = 1, onRecord }) {
  const socket = dgram.createSocket('udp4');
  const heard = [];
  socket.on('message', (bytes) => heard.push(bytes));
  await new Promise((resolve) => { socket.bind(0, resolve); });
  let begun_ms = performance.now();
  let numTogether = 0;
  for (const [index, { time_us, bytes }] of records.entries()) {
    const due_ms = (time_us - records[0].time_us) / 1000 / speed;
    const wait_ms = due_ms - (performance.now() - begun_ms);
    if (wait_ms > 1 || ++numTogether >= maxBurst) {
      numTogether = 0;
      await sleep(Math.max(1, wait_ms));
    }
    await new Promise((resolve) => { socket.send(bytes, port, host, resolve); });
    if (!onRecord) continue;
    // The recording stands still meanwhile.
    const paused_ms = performance.now();
    await onRecord(index);
    begun_ms += performance.now() - paused_ms;
  }
  await sleep(20);
  socket.close();
  return heard;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [path, address, speed = '1'] = process.argv.slice(2);
  if (!address) {
    console.error('replay.js FILE HOST:PORT [SPEED]');
    process.exit(2);
  }
  const [host, port] = address.split(':');
  const records = readTlog(path);
  await replay(records, { host, port: Number(port), speed: Number(speed) });
  console.log(`${records.length} packets sent`);
}
