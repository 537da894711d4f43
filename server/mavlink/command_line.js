import { readFileSync } from 'node:fs';
import { homedir } from 'node:os';
import { join } from 'node:path';
import { parseArgs } from 'node:util';

import { parseAddress } from './connection.js';

export const usage = `freelsd-mavlink --connect ADDRESS --url URL [options]

  --connect udp:PORT | udp:ADDRESS:PORT | tcp:HOST:PORT | serial:/dev/NAME:BAUD
                       where the autopilot is heard; "udp:PORT" listens on loopback only
  --url URL            of freelsd-server, such as http://127.0.0.1:8080
  --token-file FILE    token of the service, scope ingest
  --signing-key FILE   believe only packets with a MAVLink 2 signature of this key:
                       64 hexadecimal digits, or a passphrase
  --system ID          believe only this system; without it the first autopilot heard
  --peer ADDRESS       believe only this host (UDP)
  --name NAME          of the link in the service (default: the system id)
  --flight ID          existing flight that takes the telemetry; without it a new one
  --aircraft PROFILE   of new flights and of recall: techpod, atlantiksolar or small
  --flight-request FILE
                       JSON of what new flights are created with, such as camera and options
                       (FlightRequest of /docs)
  --pictures DIR       folder of the camera's JPEG files: they become frames of the flight
  --picture-clock-error S
                       the pictures' time (EXIF, else file) is right within S seconds (default
                       54000: the offset must follow from the pattern of the times)
  --spool DIR          lines that wait for the service (default ~/.local/state/freelsd-mavlink)
  --spool-limit MIB    size of the spool (default 256)
  --status FILE        JSON state, as /v1/links tells it, written once a second
  --rally              keep the autopilot's rally points at the best sites in reach
  --on-engine-failure land
                       fly to the best site in reach without a person's word; only over serial or
                       with --signing-key
  --touchdown-uncertainty M
                       without an engine the autopilot comes down within M metres of the touchdown,
                       the ground of which is judged (default 14, or more as the aircraft has it)
  --silent             send nothing to the autopilot: no heartbeat, no mission
  --help
`;

const options = {
  connect: { type: 'string' },
  url: { type: 'string' },
  'token-file': { type: 'string' },
  'signing-key': { type: 'string' },
  system: { type: 'string' },
  peer: { type: 'string' },
  name: { type: 'string' },
  flight: { type: 'string' },
  aircraft: { type: 'string' },
  'flight-request': { type: 'string' },
  pictures: { type: 'string' },
  'picture-clock-error': { type: 'string', default: '54000' },
  spool: { type: 'string' },
  'spool-limit': { type: 'string', default: '256' },
  status: { type: 'string' },
  'on-engine-failure': { type: 'string' },
  'touchdown-uncertainty': { type: 'string' },
  rally: { type: 'boolean', default: false },
  silent: { type: 'boolean', default: false },
  help: { type: 'boolean', default: false },
};

function wholeNumber(name, text, min, max) {
  const number = Number(text);
  if (!Number.isInteger(number) || number < min || number > max) {
    throw new Error(`--${name} ${text}: must be a whole number from ${min} to ${max}`);
  }
  return number;
}

function positiveNumber(name, text, max) {
  const number = Number(text);
  if (number > 0 && number <= max) return number;
  throw new Error(`--${name} ${text}: must be a number above 0, at most ${max}`);
}

function flightRequest({ 'flight-request': path, aircraft }) {
  const request = path ? JSON.parse(readFileSync(path, 'utf8')) : {};
  return { ...request, ...(aircraft && { aircraft: { profile: idOf('aircraft', aircraft) } }) };
}

function idOf(option, text) {
  if (/^[A-Za-z0-9._-]{1,128}$/.test(text)) return text;
  throw new Error(`--${option} ${text}: must be letters, digits, ".", "_" and "-", at most 128`);
}

const defaultSpool = () =>
  join(process.env.XDG_STATE_HOME ?? join(homedir(), '.local', 'state'), 'freelsd-mavlink');

// Whoever can send from the autopilot's address could pretend the failure.
function isAutomatic({ 'on-engine-failure': wanted, 'signing-key': key, silent }, { kind }) {
  if (wanted === undefined) return false;
  if (wanted !== 'land') throw new Error(`--on-engine-failure ${wanted}: must be land`);
  if (kind !== 'serial' && !key) throw new Error('--on-engine-failure: only over serial or with --signing-key');
  if (silent) throw new Error('--on-engine-failure: not with --silent');
  return true;
}

function guidanceOptions({ 'touchdown-uncertainty': text }) {
  return text === undefined ? {} : { touchdownUncertainty_m: positiveNumber('touchdown-uncertainty', text, 500) };
}

export function parseCommandLine(args) {
  const { values } = parseArgs({ args, options });
  if (values.help) return { isHelp: true };
  for (const name of ['connect', 'url']) if (!values[name]) throw new Error(`--${name} is missing`);
  const address = parseAddress(values.connect);
  return {
    address,
    isAutomatic: isAutomatic(values, address),
    connect: values.connect,
    url: values.url,
    token: values['token-file'] && readFileSync(values['token-file'], 'utf8').trim(),
    signingKeyPath: values['signing-key'],
    systemId: values.system && wholeNumber('system', values.system, 1, 255),
    peerHost: values.peer,
    name: values.name && idOf('name', values.name),
    flight: values.flight,
    aircraft: values.aircraft && idOf('aircraft', values.aircraft),
    flightRequest: flightRequest(values),
    picturesFolder: values.pictures,
    pictureClockError_s: positiveNumber('picture-clock-error', values['picture-clock-error'], 1e9),
    spoolFolder: values.spool ?? defaultSpool(),
    spoolBytes: wholeNumber('spool-limit', values['spool-limit'], 2, 65536) * 1024 * 1024,
    statusPath: values.status,
    guidanceOptions: guidanceOptions(values),
    isRally: values.rally,
    isSilent: values.silent,
  };
}
