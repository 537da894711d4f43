// Which packets are found in damaged bytes. The rules in which node-mavlink's reader differs: see
// tests/evaluation/decisions/0050-keep-the-reader-of-packets.md.

import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import test from 'node:test';

import { packetsInDatagram, PacketReader } from '../../server/mavlink/framing.js';
import { messageOf, packetBytes } from '../../server/mavlink/messages.js';
import { Signing } from '../../server/mavlink/signing.js';
import { Random } from './standin/random.js';

const { MavLinkProtocolV2 } = createRequire(new URL('../../server/mavlink/package.json', import.meta.url))('node-mavlink');

const numPackets = 4000;
// More than the longest packet: nobody waits for the rest of a false one.
const end = Buffer.alloc(300);

const message = (boot_ms) => messageOf('GLOBAL_POSITION_INT', {
  timeBootMs: boot_ms, lat: 474000000, lon: 85000000, alt: 500000, relativeAlt: 70000, vx: 0, vy: 1800, vz: 0, hdg: 9000 });
const packet = (boot_ms, more = {}) => packetBytes(message(boot_ms), { systemId: 1, componentId: 1, sequence: boot_ms & 0xff, ...more });

const damages = {
  'a wrong bit': (bytes, random) => {
    bytes[Math.floor(random.uniform() * bytes.length)] ^= 1 << Math.floor(8 * random.uniform());
    return bytes;
  },
  'a lost end': (bytes, random) => bytes.subarray(0, Math.floor(random.uniform() * bytes.length)),
  'a lost beginning': (bytes, random) => bytes.subarray(Math.ceil(random.uniform() * bytes.length)),
  noise: (bytes, random) => bytes.map(() => Math.floor(256 * random.uniform())),
};

for (const [what, damage] of Object.entries(damages)) {
  for (const version of [1, 2]) {
    test(`MAVLink ${version}, every fourth packet with ${what}: each of the others is read once, and nothing else`, () => {
      const random = new Random(version);
      const good = [];
      const parts = [];
      for (let i = 0; i < numPackets; ++i) {
        const bytes = packet(i, { version });
        if (i % 4 !== 1) good.push(bytes.toString('hex'));
        parts.push(i % 4 === 1 ? damage(bytes, random) : bytes);
      }
      const stream = Buffer.concat([...parts, end]);
      const reader = new PacketReader();
      const read = [];
      for (let start = 0; start < stream.length;) {
        const next = start + 1 + Math.floor(200 * random.uniform());
        read.push(...reader.take(stream.subarray(start, next)).map(({ bytes }) => bytes.toString('hex')));
        start = next;
      }
      assert.deepEqual(read, good);
    });
  }
}

test('a false header of a message that nobody knows hides no packet behind it', () => {
  const falseHeader = Buffer.from([0xfd, 200, 0, 0, 0, 1, 1, 0xff, 0xff, 0x7f]);
  const bytes = Buffer.concat([falseHeader, ...Array.from({ length: 10 }, (_, i) => packet(i))]);
  assert.equal(packetsInDatagram(bytes).packets.length, 10);
});

test('a packet with a flag that a receiver must understand, and does not, is refused', () => {
  const accepted = (flags) => packetsInDatagram(new MavLinkProtocolV2(1, 1, flags).serialize(message(0), 0)).packets.length;
  assert.equal(accepted(0), 1);
  for (let flag = MavLinkProtocolV2.IFLAG_SIGNED << 1; flag < 256; flag <<= 1) assert.equal(accepted(flag), 0);
});

test('text without a start byte is not kept', () => {
  const reader = new PacketReader();
  const text = Buffer.from('nsh> an autopilot that boots\r\n');
  for (let i = 0; i < 1000; ++i) {
    assert.deepEqual(reader.take(text), []);
    assert.equal(reader.numUsedBytes, text.length);
  }
  assert.equal(reader.take(packet(0)).length, 1);
});

test('signatures of one millisecond have different times, and a clock that was set back repeats none', () => {
  const key = Buffer.alloc(32, 7);
  const sender = new Signing(key, '/nowhere/signatures.json', () => {});
  const receiver = new Signing(key, '/nowhere/signatures.json', () => {});
  const now_ms = Date.UTC(2026, 5, 1);
  for (const at_ms of [now_ms, now_ms, now_ms, now_ms - 3600_000, now_ms + 1]) {
    const bytes = sender.signed(packet(0, { isSigned: true }), { linkId: 1, now_ms: at_ms });
    const [received] = packetsInDatagram(bytes).packets;
    assert.equal(receiver.refusal(received), undefined);
    assert.equal(receiver.refusal(received), 'replayed');
  }
});
