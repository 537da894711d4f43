// The program and the service as processes of one test, with a folder and ports of their own.

import { spawn } from 'node:child_process';
import dgram from 'node:dgram';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import net from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

import { recording, skipReason } from './tlog.js';

const root = fileURLToPath(new URL('../..', import.meta.url));
const server = process.env.FREELSD_SERVER ?? join(root, 'build/release/server/freelsd-server');
const program = join(root, 'server/mavlink/freelsd-mavlink.js');
export const path = recording('arduplane_landing.tlog');
export const skip = !path ? skipReason
  : !existsSync(server) ? 'no freelsd-server: build it or set FREELSD_SERVER' : false;

export const sleep = (duration_ms) => new Promise((resolve) => { setTimeout(resolve, duration_ms); });

export async function until(what, condition, limit_ms = 30_000) {
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

export const ended = (child) => new Promise((resolve) => { child.once('exit', resolve); });

export async function setUp(t) {
  const folder = mkdtempSync(join(tmpdir(), 'freelsd-link-'));
  const setup = {
    folder,
    url: `http://127.0.0.1:${await freePort(() => net.createServer())}`,
    udpPort: await freePort(() => dgram.createSocket('udp4')),
    children: [],
    startServer: (...more) => start(setup, server, ['--data', join(folder, 'data'), '--listen', setup.url.slice(7), ...more]),
    startLink: (...more) => start(setup, process.execPath, [program, '--connect', `udp:${setup.udpPort}`, '--url', setup.url,
      '--spool', join(folder, 'spool'), '--status', join(folder, 'status.json'), ...more]),
    state: () => JSON.parse(readFileSync(join(folder, 'status.json'), 'utf8')).links[0],
    get: async (where, headers = {}) => (await fetch(`${setup.url}${where}`, { headers })).json(),
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

export const isReady = (setup) => until('the service', async () => (await fetch(`${setup.url}/healthz`)).ok);
