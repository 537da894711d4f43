#!/usr/bin/env node
// Listens to an autopilot, sends its telemetry to freelsd-server, and brings landing missions to it.
// What it may send to the autopilot is in outgoing.js.

import { mkdirSync } from 'node:fs';
import { join } from 'node:path';

import { ChangeStore } from './mission/change_store.js';
import { parseCommandLine, usage } from './command_line.js';
import { open } from './connection.js';
import { Decisions } from './decisions.js';
import { Pictures } from './frames/pictures.js';
import { EngineFailure } from './guidance/engine_failure.js';
import { heartbeat } from './heartbeat.js';
import { Alternates } from './insurance/alternates.js';
import { MissionInsurance } from './insurance/mission_insurance.js';
import { Landings } from './mission/landings.js';
import { Link } from './link.js';
import { lock } from './lock.js';
import { Outgoing } from './outgoing.js';
import { Pin } from './pin.js';
import { isPlaceKnown } from './plausibility.js';
import { queryOf } from './guidance/recall_query.js';
import { Reporter } from './reporter.js';
import { Service } from './service.js';
import { Sessions } from './sessions.js';
import { readKey, Signing } from './signing.js';
import { Spool } from './spool.js';
import { replaceFile } from './state_file.js';
import { Uplink } from './uplink.js';

const flushPeriod_ms = 100;
const heartbeatPeriod_ms = 1000;
// Wrong options: systemd does not start it again. It does after anything else.
const configurationError = 78;
const otherError = 1;

const log = (sentence) => console.error(`${new Date().toISOString()} ${sentence}`);

function parsed() {
  try {
    const config = parseCommandLine(process.argv.slice(2));
    if (config.isHelp) return config;
    return { ...config, service: new Service(config.url, config.token), signingKey: config.signingKeyPath && readKey(config.signingKeyPath) };
  } catch (error) {
    console.error(`freelsd-mavlink: ${error.message}\n\n${usage}`);
    process.exit(configurationError);
  }
}

function stateOf(parts, connection) {
  const { link, spool, uplink, sessions, decisions, pictures, landings, engineFailure } = parts;
  const heard = link.state();
  return {
    ...heard,
    ...engineFailure?.stateParts(heard.engine),
    connection,
    flight: sessions.name && { id: uplink.flightOf(sessions.name), name: sessions.name },
    service: {
      is_reachable: uplink.isReachable, last_error: uplink.lastError, accepted: uplink.numDelivered,
      rejected: uplink.numRejected, last_rejection: uplink.lastRejection,
    },
    spool: { waiting: spool.numWaiting, lost: spool.numLost, size_bytes: spool.numBytes,
      last_error: spool.lastError },
    ...(landings && { mission: landings.state() }),
    ...parts.ahead?.state(),
    ...(pictures && { pictures: pictures.state() }),
    run: decisions.run,
    log: decisions.newest,
  };
}

// Anyone may read it.
const saveState = (path, state) => replaceFile(path, `${JSON.stringify({ links: [state] }, undefined, 2)}\n`, 0o666);

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
  const spool = new Spool(join(folder, 'lines'), { maxBytes: config.spoolBytes, log });
  const sessions = new Sessions(join(folder, 'session.json'), log);
  const signing = config.signingKey && new Signing(config.signingKey, join(folder, 'signatures.json'), log);
  const { service } = config;
  const uplink = new Uplink({ service, spool, path: join(folder, 'flights.json'), fixedFlight: config.flight,
    request: config.flightRequest, log });
  const decisions = new Decisions();
  const pictures = config.picturesFolder && new Pictures({
    folder: config.picturesFolder, path: (name) => join(folder, name), service, limit_s: config.pictureClockError_s,
    flightOf: (session) => uplink.flightOf(session), session: () => sessions.name, isCovered: (timestamp_us) => uplink.isCovered(timestamp_us),
    log: (text) => {
      log(text);
      decisions.add('picture', text);
    },
  });
  const parts = {};
  const link = new Link({
    pin: new Pin({ systemId: config.systemId, peerHost: config.peerHost }),
    signing,
    onEvent: (sentence) => {
      log(sentence);
      decisions.add('link', sentence);
    },
    onMessage: (name, fields) => parts.landings?.hear(name, fields, performance.now() / 1000),
    onTrigger: (trigger) => pictures?.hear({ ...trigger, session: sessions.find(trigger.timestamp_us, link.pin.systemId) }),
    emit: (line) => spool.append({ session: sessions.at(line.timestamp_us, link.pin.systemId), line }),
  });
  return Object.assign(parts, { service, spool, sessions, signing, uplink, decisions, pictures, link });
}

function outgoingOf({ link, signing }, socket) {
  return new Outgoing({
    send: (bytes) => { if (link.pin.peer) socket.send(bytes, link.pin.peer); },
    systemId: () => link.pin.systemId,
    signing,
  });
}

function landingsFrom(parts, { config, outgoing, reporter, state }) {
  const { link, service, decisions } = parts;
  const recall = () => {
    const now = state();
    return isPlaceKnown(now) && now.velocity ? service.emergency(queryOf(now, now.wind, 0)) : undefined;
  };
  return new Landings({
    service,
    out: outgoing,
    address: () => link.pin,
    linkState: () => link.state(),
    log: (kind, text) => {
      log(text);
      decisions.add(kind, text);
    },
    told: (id, result, detail) => reporter.told(id, result, detail),
    store: new ChangeStore(join(config.spoolFolder, 'mission.json'), log),
    recall: config.isRally ? recall : undefined,
  });
}

function engineFailureFrom(parts, { config, outgoing, reporter, state }) {
  const { link, service, decisions, landings } = parts;
  return new EngineFailure({
    recall: (query) => service.emergency(config.aircraft ? { ...query, aircraft: config.aircraft } : query),
    outgoing,
    landings,
    address: () => link.pin,
    state,
    log: (text, kind) => {
      log(text);
      decisions.add(kind, text);
    },
    told: (id, result, detail) => reporter.told(id, result, detail),
    isAutomatic: config.isAutomatic,
    options: config.guidanceOptions,
  });
}

// What the aircraft could reach: now, and on the rest of its mission.
function aheadFrom({ service, decisions, landings, link, uplink, sessions }) {
  const alternates = new Alternates((flight) => service.alternates(flight));
  const insurance = new MissionInsurance({
    check: (request) => service.checkRoute(request),
    log: (text) => {
      log(text);
      decisions.add('insurance', text);
    },
  });
  const now_s = () => performance.now() / 1000;
  const vehicle = () => {
    const state = link.state();
    const { airspeed_mps } = state;
    const position = isPlaceKnown(state) ? state.position : undefined;
    const { cruise_mps, ...known } = landings.vehicle;
    return { ...known, position, airspeed_mps: cruise_mps ?? airspeed_mps, flight: { id: uplink.flightOf(sessions.name) } };
  };
  return {
    step: () => [alternates, insurance].forEach((one) => one.step(now_s(), vehicle())),
    state: () => ({ alternates: alternates.state(now_s()), insurance: insurance.state(now_s()) }),
  };
}

// Each problem once, not at each try.
function problemLog(uplink) {
  let last;
  return () => {
    if (uplink.lastError && uplink.lastError !== last) log(`not sent yet: ${uplink.lastError}`);
    last = uplink.lastError;
  };
}

// A fault of one part must not end the link in the air. Each once, not at each try. Gives a guard of what is called often.
function logFaults(decisions) {
  const told = new Set();
  const tell = (reason) => {
    const text = `fault: ${reason?.message ?? reason}`;
    if (told.has(text)) return;
    told.add(text);
    log(reason?.stack ?? text);
    decisions.add('link', text);
  };
  process.on('unhandledRejection', tell);
  return (act) => {
    try {
      act();
    } catch (error) {
      tell(error);
    }
  };
}

async function run(config) {
  const parts = partsFrom(config);
  const guard = logFaults(parts.decisions);
  const { spool, uplink, link } = parts;
  const state = { address: config.connect, state: 'closed' };
  const socket = await open(config.address,
    (bytes, from, isDatagram) => guard(() => link.take(bytes, from, isDatagram)),
    (text) => { state.state = text; });
  log(`listening at ${config.connect}, sending to ${config.url}`);
  const reporter = new Reporter({
    service: parts.service,
    name: config.name,
    state: () => stateOf(parts, state),
    onCommand: (command) => {
      const isTaken = parts.engineFailure?.take(command, Date.now() * 1000);
      if (isTaken || parts.landings?.take(command)) return;
      if (command.kind === 'release') reporter.told(command.id, 'done');
      else reporter.told(command.id, 'failed', parts.landings ? `this program does not know the command ${command.kind}` : 'the link is silent');
    },
  });
  const outgoing = outgoingOf(parts, socket);
  if (!config.isSilent) {
    const setting = { config, outgoing, reporter, state: () => stateOf(parts, state) };
    parts.landings = landingsFrom(parts, setting);
    parts.engineFailure = engineFailureFrom(parts, setting);
    parts.ahead = aheadFrom(parts);
  }
  parts.decisions.onAdd = () => reporter.changed();
  const logProblem = problemLog(uplink);
  const timers = [
    setInterval(() => {
      guard(() => link.tick());
      guard(() => parts.landings?.step(performance.now() / 1000));
      guard(() => parts.engineFailure?.step(performance.now() / 1000, Date.now() * 1000));
      guard(() => parts.ahead?.step());
      guard(() => spool.flush());
      guard(() => uplink.step());
      guard(() => parts.pictures?.step());
      guard(() => reporter.step());
    }, flushPeriod_ms),
    setInterval(() => {
      guard(() => spool.sync());
      logProblem();
      saveAll(parts, config, state);
    }, 1000),
  ];
  if (!config.isSilent) {
    timers.push(setInterval(() => { if (link.pin.peer) outgoing.send('HEARTBEAT', heartbeat); }, heartbeatPeriod_ms));
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
    process.exit(otherError);
  });
}
