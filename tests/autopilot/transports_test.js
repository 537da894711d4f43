// Bytes between the link and an autopilot over TCP and over a serial line, and what happens when either goes away.

import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import { closeSync, constants, createReadStream, existsSync, mkdtempSync, openSync, rmSync, writeSync } from 'node:fs';
import net from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test from 'node:test';

import { open, parseAddress } from '../../server/mavlink/connection.js';
import { PacketReader } from '../../server/mavlink/framing.js';
import { heartbeat } from '../../server/mavlink/heartbeat.js';
import { messageOf, packetBytes } from '../../server/mavlink/messages.js';

const sleep = (duration_ms) => new Promise((resolve) => { setTimeout(resolve, duration_ms); });
const hasSocat = spawnSync('socat', ['-V']).status === 0;

async function until(what, condition) {
  for (const end_ms = Date.now() + 15_000; Date.now() < end_ms; await sleep(20)) {
    const value = condition();
    if (value) return value;
  }
  throw new Error(`waited in vain for: ${what}`);
}

// The link's end of a connection: the packets that it heard, and its states.
async function connected(t, address) {
  const end = { packets: [], states: [], froms: new Set() };
  const reader = new PacketReader();
  const connection = await open(parseAddress(address), (bytes, from, isDatagram) => {
    assert.equal(isDatagram, false);
    end.froms.add(from);
    end.packets.push(...reader.take(bytes));
  }, (state) => end.states.push(state));
  t.after(() => connection.close());
  return Object.assign(end, { send: connection.send });
}

const heartbeatBytes = (systemId, sequence) => packetBytes(messageOf('HEARTBEAT', heartbeat), { systemId, componentId: 191, sequence });
const packets = (count, first = 0) => Array.from({ length: count }, (_, i) => heartbeatBytes(7, (first + i) % 256));

test('TCP: packets in both directions, however they are cut, and again after the autopilot went away', async (t) => {
  const heard = [];
  const clients = new Set();
  const listen = (port) => new Promise((resolve) => {
    const server = net.createServer((client) => {
      clients.add(client);
      client.on('data', (bytes) => heard.push(bytes)).on('error', () => {});
    });
    server.listen(port, '127.0.0.1', () => resolve(server));
  });
  let server = await listen(0);
  const { port } = server.address();
  t.after(() => { clients.forEach((client) => client.destroy()); server.close(); });
  const end = await connected(t, `tcp:127.0.0.1:${port}`);
  await until('a client', () => clients.size === 1);
  const stream = Buffer.concat(packets(50));
  for (let i = 0; i < stream.length; i += 7) {
    [...clients][0].write(stream.subarray(i, i + 7));
    if (i % 70 === 0) await sleep(1);
  }
  await until('50 packets', () => end.packets.length === 50);
  end.send(heartbeatBytes(1, 0));
  await until('an answer', () => Buffer.concat(heard).length === heartbeatBytes(1, 0).length);

  clients.forEach((client) => client.destroy());
  clients.clear();
  await new Promise((resolve) => { server.close(resolve); });
  await until('the loss', () => end.states.at(-1) !== 'open');
  end.send(heartbeatBytes(1, 1));
  server = await listen(port);
  await until('the link again', () => clients.size === 1);
  [...clients][0].write(packets(1, 50)[0]);
  await until('one more packet', () => end.packets.length === 51);
  assert.equal(end.states.at(-1), 'open');
});

test('TCP: nobody listens at first', async (t) => {
  const server = net.createServer();
  await new Promise((resolve) => { server.listen(0, '127.0.0.1', resolve); });
  const { port } = server.address();
  await new Promise((resolve) => { server.close(resolve); });
  const end = await connected(t, `tcp:127.0.0.1:${port}`);
  await until('a refusal', () => end.states.some((state) => /ECONNREFUSED/.test(state)));
  server.on('connection', (client) => client.on('error', () => {}).write(packets(1)[0]));
  server.listen(port, '127.0.0.1');
  t.after(() => server.close());
  await until('a packet', () => end.packets.length === 1);
});

// Two ends of one line, as two terminals: the autopilot's and the link's.
async function serialLine(t) {
  const folder = mkdtempSync(join(tmpdir(), 'freelsd-serial-'));
  const line = { near: join(folder, 'link'), far: join(folder, 'autopilot') };
  line.plug = async () => {
    line.socat = spawn('socat', [`pty,raw,echo=0,link=${line.far}`, `pty,raw,echo=0,link=${line.near}`], { stdio: 'ignore' });
    await until('the line', () => existsSync(line.near) && existsSync(line.far));
  };
  line.unplug = () => new Promise((resolve) => { line.socat.once('exit', resolve).kill(); });
  t.after(async () => {
    await line.unplug();
    rmSync(folder, { recursive: true, force: true });
  });
  await line.plug();
  return line;
}

test('serial: packets in both directions, and again after the plug was pulled', { skip: hasSocat ? false : 'no socat' }, async (t) => {
  const line = await serialLine(t);
  const end = await connected(t, `serial:${line.near}:57600`);
  await until('an open port', () => end.states.includes('open'));
  let far = openSync(line.far, constants.O_RDWR | constants.O_NOCTTY);
  writeSync(far, Buffer.concat(packets(50)));
  await until('50 packets', () => end.packets.length === 50);
  const heard = [];
  const reading = createReadStream(line.far).on('data', (bytes) => heard.push(bytes)).on('error', () => {});
  end.send(heartbeatBytes(1, 0));
  await until('an answer', () => Buffer.concat(heard).length === heartbeatBytes(1, 0).length);
  reading.destroy();
  closeSync(far);

  await line.unplug();
  await until('the loss', () => end.states.at(-1) !== 'open');
  const numOpened = end.states.filter((state) => state === 'open').length;
  await line.plug();
  await until('the port again', () => end.states.filter((state) => state === 'open').length > numOpened);
  far = openSync(line.far, constants.O_RDWR | constants.O_NOCTTY);
  writeSync(far, packets(1, 50)[0]);
  await until('one more packet', () => end.packets.length === 51);
  closeSync(far);
});

test('serial: a port that is not there yet', { skip: hasSocat ? false : 'no socat' }, async (t) => {
  const line = await serialLine(t);
  await line.unplug();
  const end = await connected(t, `serial:${line.near}:57600`);
  await until('a refusal', () => end.states.some((state) => /No such file/.test(state)));
  await line.plug();
  await until('an open port', () => end.states.includes('open'));
});
