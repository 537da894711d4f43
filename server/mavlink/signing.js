// MAVLink 2 signatures: checks those of received packets and makes our own.
// https://mavlink.io/en/guide/message_signing.html

import { timingSafeEqual } from 'node:crypto';
import { readFileSync } from 'node:fs';

import mavlink from 'node-mavlink';

import { readState, replaceFile } from './state_file.js';

const { MavLinkPacketSignature, MavLinkProtocolV2 } = mavlink;

// Units of 10 us.
const epoch_ms = MavLinkProtocolV2.SIGNATURE_START_TIME;
const unitsPerMillisecond = 100;
// A stream that was never seen may be this much older than the newest signature known.
const newStreamAge_units = 60 * 1000 * unitsPerMillisecond;

// 64 hexadecimal digits are the key itself. Any other text is a passphrase, whose SHA-256 is the
// key, as in Mission Planner, QGroundControl and MAVProxy.
export function readKey(path) {
  const text = readFileSync(path, 'utf8').trim();
  if (text === '') throw new Error(`the signing key file ${path} is empty`);
  if (/^[0-9a-fA-F]{64}$/.test(text)) return Buffer.from(text, 'hex');
  return MavLinkPacketSignature.key(text);
}

// In constant time.
const isOf = (key, signature) => timingSafeEqual(Buffer.from(signature.calculate(key)), Buffer.from(signature.signature));

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
    const signature = new MavLinkPacketSignature(packet.bytes);
    if (!isOf(this.#key, signature)) return 'wrong_signature';
    const time_units = signature.timestamp;
    const stream = `${packet.systemId}/${packet.componentId}/${signature.linkId}`;
    const last = this.#newest.get(stream);
    const oldest = last ?? Math.max(0, ...this.#newest.values()) - newStreamAge_units;
    if (last !== undefined ? time_units <= last : time_units < oldest) return 'replayed';
    this.#newest.set(stream, time_units);
    return undefined;
  }

  save() { replaceFile(this.#path, JSON.stringify(Object.fromEntries(this.#newest))); }

  // The packet, made to be signed, with our signature. A clock that was set back must not repeat a time.
  signed(packet, { linkId, now_ms = Date.now() }) {
    const time_units = Math.round((now_ms - epoch_ms) * unitsPerMillisecond);
    this.#sent_units = Math.max(this.#sent_units + 1, time_units, ...this.#newest.values());
    const bytes = Buffer.concat([packet, Buffer.alloc(MavLinkPacketSignature.SIGNATURE_LENGTH)]);
    const signature = new MavLinkPacketSignature(bytes);
    signature.linkId = linkId;
    signature.timestamp = this.#sent_units;
    signature.signature = signature.calculate(this.#key);
    return bytes;
  }
}
