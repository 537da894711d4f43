// The link's own reader of MAVLink packets beside that of node-mavlink: speed, floods, damage, signatures.
//
//   node tests/bench/mavlink_framing.mjs RECORDING.tlog...
//
// Prints tables. Times are of the processor, the median of 5.
import { mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import { packetsInDatagram, PacketReader } from '../../server/mavlink/framing.js';
import { fieldsOf, messageClasses, messageOf, packetBytes } from '../../server/mavlink/messages.js';
import { Signing } from '../../server/mavlink/signing.js';
import { Random } from '../autopilot/standin/random.js';
import { readTlog } from '../autopilot/tlog.js';

const mavlink = createRequire(new URL('../../server/mavlink/package.json', import.meta.url))('node-mavlink');
const { MavLinkPacketParser, MavLinkPacketSignature, MavLinkPacketSplitter, MavLinkProtocolV2, MSG_ID_MAGIC_NUMBER } = mavlink;

const numRuns = 5;
const readBytes = 1024;
const numDatagrams = 1000;

const own = {
  name: 'own',
  stream() {
    const reader = new PacketReader();
    const take = (bytes) => reader.take(bytes);
    take.numKept = (last) => last.length - reader.numUsedBytes;
    return take;
  },
  datagram: (bytes) => packetsInDatagram(bytes).packets,
  fields: fieldsOf,
};

// read() gives at once what write() has made complete, as the link needs it: a packet is judged by its sender.
const theirs = {
  name: 'node-mavlink',
  stream() {
    const splitter = new MavLinkPacketSplitter();
    const parser = new MavLinkPacketParser();
    const take = (bytes) => {
      const packets = [];
      splitter.write(bytes);
      for (let frame = splitter.read(); frame !== null; frame = splitter.read()) {
        parser.write(frame);
        packets.push(parser.read());
      }
      return packets;
    };
    take.numKept = () => splitter.buffer.length;
    return take;
  },
  datagram: (bytes) => theirs.stream()(bytes),
  fields: ({ header, payload, protocol }) => protocol.data(payload, messageClasses[header.msgid]),
};
const readers = [own, theirs];
const bytesOf = (packet) => packet.bytes ?? packet.buffer;

function median(values) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[(sorted.length - 1) / 2];
}

function processor_s(work) {
  const times_s = [];
  for (let run = 0; run < numRuns; ++run) {
    const begun = process.cpuUsage();
    work();
    const { user, system } = process.cpuUsage(begun);
    times_s.push((user + system) / 1e6);
  }
  return median(times_s);
}

function* pieces(bytes) {
  for (let start = 0; start < bytes.length; start += readBytes) yield bytes.subarray(start, start + readBytes);
}

function table(title, rows) {
  console.log(`\n${title}\n\n| | ${readers.map(({ name }) => name).join(' | ')} |\n|---|---|---|`);
  for (const [what, ...values] of rows) console.log(`| ${what} | ${values.join(' | ')} |`);
}

function speed(frames) {
  const whole = Buffer.concat(frames);
  const rate = (work) => `${Math.round(frames.length / processor_s(work) / 1000)} 000`;
  const inStream = ({ stream, fields }) => () => {
    const take = stream();
    let count = 0;
    for (const piece of pieces(whole)) for (const packet of take(piece)) count += fields(packet) ? 1 : 0;
    if (count !== frames.length) throw new Error(`${count} of ${frames.length} packets`);
  };
  const inDatagrams = ({ datagram, fields }) => () => {
    let count = 0;
    for (const frame of frames) for (const packet of datagram(frame)) count += fields(packet) ? 1 : 0;
    if (count !== frames.length) throw new Error(`${count} of ${frames.length} packets`);
  };
  table(`Packets a second to fields, ${frames.length} recorded ones`, [
    [`a stream, ${readBytes} bytes at once`, ...readers.map((reader) => rate(inStream(reader)))],
    ['a datagram each', ...readers.map((reader) => rate(inDatagrams(reader)))],
  ]);
}

const falseHeader = Buffer.from([0xfd, 9, 0, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0]);

function floods(frames) {
  const kinds = {
    'one valid packet': frames[0],
    'start bytes only, 1400 bytes': Buffer.alloc(1400, 0xfd),
    'start bytes of MAVLink 1 only, 1400 bytes': Buffer.alloc(1400, 0xfe),
    'false headers, 1400 bytes': Buffer.concat(Array(100).fill(falseHeader)),
  };
  table(`${numDatagrams} datagrams`, Object.entries(kinds).map(([what, bytes]) => [what, ...readers.map(({ datagram }) => {
    const spent_s = processor_s(() => { for (let i = 0; i < numDatagrams; ++i) datagram(bytes); });
    return `${(1000 * spent_s).toFixed(0)} ms`;
  })]));
}

// A serial line at the wrong speed, or an autopilot's console.
function textOnStream() {
  const text = Buffer.alloc(64, 'nsh> no start byte of MAVLink is in this text\r\n');
  const numBytes = 256 * 1024;
  const results = readers.map(({ stream }) => {
    let kept = 0;
    const spent_s = processor_s(() => {
      const take = stream();
      for (let sent = 0; sent < numBytes; sent += text.length) take(text);
      kept = take.numKept(text);
    });
    return `${(1000 * spent_s).toFixed(0)} ms, ${kept / 1024} KiB kept`;
  });
  table('A stream without any start byte', [[`${numBytes / 1024} KiB, ${text.length} bytes at once`, ...results]]);
}

function hasRightChecksum(bytes) {
  const isV2 = bytes[0] === 0xfd;
  const trailer = isV2 && bytes[2] & 1 ? 15 : 2;
  const extra = MSG_ID_MAGIC_NUMBER[isV2 ? bytes.readUIntLE(7, 3) : bytes[5]];
  return extra !== undefined && mavlink.x25crc(bytes, 1, trailer, extra) === bytes.readUInt16LE(bytes.length - trailer);
}

// Each makes of one frame what arrives instead of it. What arrives unchanged must be read.
const noise = (random, length) => Buffer.from(Array.from({ length }, () => Math.floor(256 * random.uniform())));
const damages = {
  'one bit wrong in every fourth packet': (frame, random) => {
    const bytes = Buffer.from(frame);
    bytes[Math.floor(random.uniform() * bytes.length)] ^= 1 << Math.floor(8 * random.uniform());
    return bytes;
  },
  'every fourth packet cut off': (frame, random) => frame.subarray(0, Math.floor(random.uniform() * frame.length)),
  'every fourth packet without its beginning': (frame, random) => frame.subarray(Math.ceil(random.uniform() * frame.length)),
  'noise of 1 to 64 bytes for every fourth packet': (frame, random) => noise(random, 1 + Math.floor(64 * random.uniform())),
};

const keyOf = (bytes) => bytes.toString('latin1');

function afterDamage(frames) {
  const rows = Object.entries(damages).map(([what, damage]) => {
    const random = new Random(1);
    const good = [];
    const sent = frames.map((frame, i) => {
      if (i % 4 === 1) return damage(frame, random);
      good.push(frame);
      return frame;
    });
    // Zeros behind the end, so that nobody waits for the rest of a false packet.
    const whole = Buffer.concat([...sent, Buffer.alloc(300)]);
    return [what, ...readers.map(({ stream }) => {
      const take = stream();
      const read = [...pieces(whole)].flatMap((piece) => take(piece)).map(bytesOf);
      const numFalse = read.filter((bytes) => !hasRightChecksum(bytes)).length;
      const left = new Map();
      for (const key of good.map(keyOf)) left.set(key, (left.get(key) ?? 0) + 1);
      let numOthers = 0;
      for (const key of read.map(keyOf)) {
        if (left.get(key) > 0) left.set(key, left.get(key) - 1);
        else ++numOthers;
      }
      const numLost = [...left.values()].reduce((sum, count) => sum + count, 0);
      return `${numLost} of ${good.length} good ones lost; ${numFalse} with a wrong checksum, ${numOthers} others`;
    })];
  });
  table('A damaged stream', rows);
}

const heartbeat = messageOf('HEARTBEAT', { type: 1, autopilot: 3, mavlinkVersion: 3 });

function oddities(frame) {
  const unknownFlag = 0x02;
  const unknownHeader = Buffer.from([0xfd, 200, 0, 0, 0, 1, 1, 0xff, 0xff, 0x7f]);
  const kinds = {
    'an unknown flag that a receiver must refuse': [new MavLinkProtocolV2(1, 1, unknownFlag).serialize(heartbeat, 0)],
    'ten good ones behind a false header of an unknown message': [unknownHeader, ...Array(10).fill(frame)],
    'ten good ones behind the second half of one': [frame.subarray(frame.length >> 1), ...Array(10).fill(frame)],
  };
  table('Packets read of one datagram', Object.entries(kinds).map(([what, parts]) => [what, ...readers.map(({ datagram }) =>
    datagram(Buffer.concat(parts)).length)]));
}

function signatures() {
  const folder = mkdtempSync(join(tmpdir(), 'framing-'));
  const key = Buffer.alloc(32, 7);
  const now_ms = Date.UTC(2026, 5, 1);
  const signer = () => new Signing(key, join(folder, 'none.json'));
  const protocol = new MavLinkProtocolV2(1, 1, MavLinkProtocolV2.IFLAG_SIGNED);
  const unsigned = packetBytes(heartbeat, { systemId: 1, componentId: 1, sequence: 0, isSigned: true });
  const signs = [
    (sender) => sender.signed(unsigned, { linkId: 1, now_ms }),
    () => protocol.sign(protocol.serialize(heartbeat, 0), 1, key, now_ms),
  ];
  const inSameMillisecond = signs.map((sign) => {
    const sender = signer();
    return [0, 1, 2].map(() => new MavLinkPacketSignature(sign(sender)).timestamp);
  });
  const sender = signer();
  const signed = Array.from({ length: 1000 }, (_, i) => sender.signed(unsigned, { linkId: 1, now_ms: now_ms + i }));
  const packets = readers.map(({ stream }) => stream()(Buffer.concat(signed)));
  const receiver = signer();
  const accepts = [(packet) => receiver.refusal(packet) === undefined, ({ signature }) => signature?.matches(key) ?? false];
  const firstTime = packets.map((some, i) => some.filter(accepts[i]).length);
  const replayed = packets.map((some, i) => some.filter(accepts[i]).length);
  const spent_s = [
    processor_s(() => { const fresh = signer(); for (const packet of packets[0]) fresh.refusal(packet); }),
    processor_s(() => { for (const { signature } of packets[1]) signature.matches(key); }),
  ];
  table('Signatures', [
    ['times of three signed in one millisecond, different', ...inSameMillisecond.map((times) => new Set(times).size)],
    [`${signed.length} signed packets: accepted`, ...firstTime],
    ['the same again: accepted', ...replayed],
    ['checked a second', ...spent_s.map((one_s) => `${Math.round(signed.length / one_s / 1000)} 000`)],
  ]);
  rmSync(folder, { recursive: true });
}

const recorded = process.argv.slice(2).flatMap((path) => readTlog(path).map(({ bytes }) => bytes));
if (recorded.length === 0) {
  console.error('mavlink_framing.mjs RECORDING.tlog...');
  process.exit(2);
}
speed(recorded);
floods(recorded);
textOnStream();
afterDamage(recorded);
oddities(recorded[0]);
signatures();
