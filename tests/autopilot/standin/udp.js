// A stand-in over UDP, in real time or faster.

import dgram from 'node:dgram';

import { Transport } from './transport.js';

const tick_ms = 20;
// After a pause of the machine it does not catch up more than this.
const longestStep_s = 1;

// toPort: where the link listens. faults: as of transport.js, both ways. Gives { plane, up, down,
// close(), onStep }.
export function serveUdp(plane, { host = '127.0.0.1', toPort = 14550, speed = 1, faults = {} } = {}) {
  const socket = dgram.createSocket('udp4');
  const down = new Transport((bytes) => socket.send(bytes, toPort, host), faults);
  const up = new Transport((bytes) => plane.take(bytes), { ...faults, seed: (faults.seed ?? 1) + 1 });
  plane.onSend = (bytes) => down.send(bytes, plane.time_s);
  socket.on('message', (bytes) => up.send(bytes, plane.time_s));
  // Nobody listens yet.
  socket.on('error', () => {});
  const served = { plane, up, down, onStep: () => {}, close: () => {
    clearInterval(timer);
    socket.close();
  } };
  let last_ms = performance.now();
  let left_s = 0;
  const timer = setInterval(() => {
    const now_ms = performance.now();
    left_s += Math.min(longestStep_s, (now_ms - last_ms) / 1000) * speed;
    last_ms = now_ms;
    const { step_s } = plane.options;
    for (; left_s >= step_s; left_s -= step_s) {
      up.step(plane.time_s);
      plane.step(step_s);
      down.step(plane.time_s);
      served.onStep(plane);
    }
  }, tick_ms);
  return new Promise((resolve) => { socket.bind(0, () => resolve(served)); });
}
