// MAVLink 2 signatures: checks those of received packets and makes our own.
// https://mavlink.io/en/guide/message_signing.html

import { createHash, timingSafeEqual } from 'node:crypto';
import { readFileSync, writeFileSync, renameSync } from 'node:fs';

import mavlink from 'node-mavlink';

import { signatureBytes } from './framing.js';
import { readState } from './state_file.js';

const digestBytes = 6;
const signedFlag = 0x01;
// Units of 10 us since 2015-01-01.
const epoch_ms = Date.UTC(2015, 0, 1);
const unitsPerMillisecond = 100;
// A stream that was never seen may be this much older than the newest signature known.
const newStreamAge_units = 60 * 1000 * unitsPerMillisecond;

// 64 hexadecimal digits are the key itself. Any other text is a passphrase, whose SHA-256 is the
// key, as in Mission Planner, QGroundControl and MAVProxy.
export function readKey(path) {
  const text = readFileSync(path, 'utf8').trim();
  if (text === '') throw new Error(`the signing key file ${path} is empty`);
  if (/^[0-9a-fA-F]{64}$/.test(text)) return Buffer.from(text, 'hex');
  return createHash('sha256').update(text, 'utf8').digest();
}

const digestOf = (key, bytes) =>
  createHash('sha256').update(key).update(bytes).digest().subarray(0, digestBytes);

function extraOf(bytes) {
  const trailer = bytes.subarray(bytes.length - signatureBytes);
  return { linkId: trailer[0], time_units: trailer.readUIntLE(1, 6), digest: trailer.subarray(7) };
}

export class Signing {
  #key;
  #path;
  // Newest signature time of each stream, kept on disk: otherwise an old recording could be played
  // after a restart.
  #newest;
  #sent_units = 0;

  constructor(key, path, log) {
    this.#key = key;
    this.#path = path;
    this.#newest = new Map(Object.entries(readState(path, log) ?? {}));
  }

  // Why the packet is refused; nothing if it is believed.
  refusal(packet) {
    if (!packet.isSigned) return 'unsigned';
    const { linkId, time_units, digest } = extraOf(packet.bytes);
    const signed = packet.bytes.subarray(0, packet.bytes.length - digestBytes);
    if (!timingSafeEqual(digestOf(this.#key, signed), digest)) return 'wrong_signature';
    const stream = `${packet.systemId}/${packet.componentId}/${linkId}`;
    const last = this.#newest.get(stream);
    const oldest = last ?? Math.max(0, ...this.#newest.values()) - newStreamAge_units;
    if (last !== undefined ? time_units <= last : time_units < oldest) return 'replayed';
    this.#newest.set(stream, time_units);
    return undefined;
  }

  save() {
    writeFileSync(`${this.#path}.new`, JSON.stringify(Object.fromEntries(this.#newest)));
    renameSync(`${this.#path}.new`, this.#path);
  }

  // The packet with our signature. A clock that was set back must not repeat a time.
  signed(unsignedBytes, { linkId, extra, now_ms = Date.now() }) {
    const bytes = Buffer.concat([unsignedBytes, Buffer.alloc(signatureBytes)]);
    bytes[2] |= signedFlag;
    bytes.writeUInt16LE(checksum(bytes, extra), bytes.length - signatureBytes - 2);
    const time_units = Math.round((now_ms - epoch_ms) * unitsPerMillisecond);
    this.#sent_units = Math.max(this.#sent_units + 1, time_units, ...this.#newest.values());
    bytes[bytes.length - signatureBytes] = linkId;
    bytes.writeUIntLE(this.#sent_units, bytes.length - signatureBytes + 1, 6);
    digestOf(this.#key, bytes.subarray(0, bytes.length - digestBytes))
      .copy(bytes, bytes.length - digestBytes);
    return bytes;
  }
}

function checksum(bytes, extra) {
  return mavlink.x25crc(bytes, 1, signatureBytes + 2, extra);
}
