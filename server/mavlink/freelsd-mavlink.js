#!/usr/bin/env node
// Listens to an autopilot and sends its telemetry to freelsd-server. The only message that it sends
// to the autopilot is its own heartbeat.

import { mkdirSync, renameSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { parseCommandLine, usage } from './command_line.js';
import { open } from './connection.js';
import { Decisions } from './decisions.js';
import { heartbeatBytes } from './heartbeat.js';
import { Link } from './link.js';
import { lock } from './lock.js';
import { Pin } from './pin.js';
import { Reporter } from './reporter.js';
import { Service } from './service.js';
import { Sessions } from './sessions.js';
import { readKey, Signing } from './signing.js';
import { Spool } from './spool.js';
import { Uplink } from './uplink.js';

const flushPeriod_ms = 100;
const heartbeatPeriod_ms = 1000;
const configurationError = 78;

const log = (sentence) => console.error(`${new Date().toISOString()} ${sentence}`);

function parsed() {
  try {
    return parseCommandLine(process.argv.slice(2));
  } catch (error) {
    console.error(`freelsd-mavlink: ${error.message}\n\n${usage}`);
    process.exit(configurationError);
  }
}

function stateOf(parts, connection) {
  const { link, spool, uplink, sessions, decisions } = parts;
  return {
    ...link.state(),
    connection,
    flight: sessions.name && { id: uplink.flightOf(sessions.name), name: sessions.name },
    service: {
      is_reachable: uplink.isReachable, last_error: uplink.lastError, accepted: uplink.numDelivered,
      rejected: uplink.numRejected, last_rejection: uplink.lastRejection,
    },
    spool: { waiting: spool.numWaiting, lost: spool.numLost, size_bytes: spool.numBytes,
      last_error: spool.lastError },
    run: decisions.run,
    log: decisions.newest,
  };
}

function saveState(path, state) {
  writeFileSync(`${path}.new`, `${JSON.stringify({ links: [state] }, undefined, 2)}\n`);
  renameSync(`${path}.new`, path);
}

// A full disk must not end the program: it still delivers what it hears.
function saveAll(parts, config, connection) {
  try {
    parts.sessions.save();
    parts.signing?.save();
    if (config.statusPath) saveState(config.statusPath, stateOf(parts, connection));
  } catch (error) {
    log(error.message);
  }
}

function partsFrom(config) {
  const folder = config.spoolFolder;
  mkdirSync(folder, { recursive: true, mode: 0o700 });
  lock(folder);
  const spool = new Spool(join(folder, 'lines'), { maxBytes: config.spoolBytes });
  const sessions = new Sessions(join(folder, 'session.json'));
  const signing = config.signingKeyPath &&
    new Signing(readKey(config.signingKeyPath), join(folder, 'signatures.json'));
  const service = new Service(config.url, config.token);
  const uplink = new Uplink({ service, spool, path: join(folder, 'flights.json'), fixedFlight: config.flight });
  const decisions = new Decisions();
  const link = new Link({
    pin: new Pin({ systemId: config.systemId, peerHost: config.peerHost }),
    signing,
    onEvent: (sentence) => {
      log(sentence);
      decisions.add('link', sentence);
    },
    emit: (line) => spool.append({ session: sessions.at(line.timestamp_us, link.pin.systemId), line }),
  });
  return { service, spool, sessions, signing, uplink, decisions, link };
}

async function run(config) {
  const parts = partsFrom(config);
  const { spool, signing, uplink, link } = parts;
  const state = { address: config.connect, state: 'closed' };
  const socket = await open(config.address,
    (bytes, from, isDatagram) => link.take(bytes, from, isDatagram),
    (text) => { state.state = text; });
  log(`listening at ${config.connect}, sending to ${config.url}`);
  const reporter = new Reporter({
    service: parts.service,
    name: config.name,
    state: () => stateOf(parts, state),
    onCommand: ({ id, kind }) => reporter.told(id, 'failed', `this program does not know the command ${kind}`),
  });
  parts.decisions.onAdd = () => reporter.changed();

  const timers = [
    setInterval(() => {
      link.tick();
      spool.flush();
      uplink.step();
      reporter.step();
    }, flushPeriod_ms),
    setInterval(() => {
      spool.sync();
      saveAll(parts, config, state);
    }, 1000),
  ];
  let sequence = 0;
  if (!config.isSilent) {
    timers.push(setInterval(() => {
      if (link.pin.peer) socket.send(heartbeatBytes(link.pin.systemId, sequence++, signing), link.pin.peer);
    }, heartbeatPeriod_ms));
  }
  const stop = () => {
    timers.forEach(clearInterval);
    socket.close();
    spool.close();
    saveAll(parts, config, state);
    process.exit(0);
  };
  process.on('SIGTERM', stop);
  process.on('SIGINT', stop);
}

const config = parsed();
if (config.isHelp) {
  console.log(usage);
} else {
  run(config).catch((error) => {
    console.error(`freelsd-mavlink: ${error.message}`);
    process.exit(configurationError);
  });
}
