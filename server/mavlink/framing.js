// Finds MAVLink 1 and 2 packets in bytes and checks their checksums.

import mavlink from 'node-mavlink';

const { MavLinkPacketSignature, MavLinkProtocol, MavLinkProtocolV1, MavLinkProtocolV2, MSG_ID_MAGIC_NUMBER, x25crc } = mavlink;

const startOfV1 = MavLinkProtocolV1.START_BYTE;
const startOfV2 = MavLinkProtocolV2.START_BYTE;
const headerBytes = { [startOfV1]: MavLinkProtocolV1.PAYLOAD_OFFSET, [startOfV2]: MavLinkProtocolV2.PAYLOAD_OFFSET };
const checksumBytes = MavLinkProtocol.CHECKSUM_LENGTH;
const signatureBytes = MavLinkPacketSignature.SIGNATURE_LENGTH;
const signedFlag = MavLinkProtocolV2.IFLAG_SIGNED;

function lengthOf(bytes, start) {
  const version = bytes[start];
  const signature = version === startOfV2 && bytes[start + 2] & signedFlag ? signatureBytes : 0;
  return headerBytes[version] + bytes[start + 1] + checksumBytes + signature;
}

function packetOf(bytes) {
  const isV1 = bytes[0] === startOfV1;
  const at = isV1 ? 2 : 4;
  const header = headerBytes[bytes[0]];
  return {
    version: isV1 ? 1 : 2,
    sequence: bytes[at],
    systemId: bytes[at + 1],
    componentId: bytes[at + 2],
    messageId: isV1 ? bytes[5] : bytes.readUIntLE(7, 3),
    isSigned: !isV1 && (bytes[2] & signedFlag) !== 0,
    payload: bytes.subarray(header, header + bytes[1]),
    bytes,
  };
}

// A receiver must drop a packet with a flag that it does not understand.
const hasUnknownFlag = (bytes) => bytes[0] === startOfV2 && (bytes[2] & ~signedFlag) !== 0;

function isIntact(packet) {
  const extra = MSG_ID_MAGIC_NUMBER[packet.messageId];
  if (extra === undefined) return false;
  const trailer = checksumBytes + (packet.isSigned ? signatureBytes : 0);
  const { bytes } = packet;
  return x25crc(bytes, 1, trailer, extra) === bytes.readUInt16LE(bytes.length - trailer);
}

// One reader per serial or TCP connection. A datagram has a reader of its own, because no packet
// continues in the next datagram.
export class PacketReader {
  #rest = Buffer.alloc(0);
  #maxNumDamaged;
  numDamaged = 0;
  // Of the last chunk: what is before the packet that is still incomplete.
  numUsedBytes = 0;

  constructor(maxNumDamaged = Infinity) {
    this.#maxNumDamaged = maxNumDamaged;
  }

  // The packets that are complete with these bytes.
  take(chunk) {
    const bytes = this.#rest.length ? Buffer.concat([this.#rest, chunk]) : chunk;
    const packets = [];
    let start = 0;
    while (start < bytes.length && this.numDamaged <= this.#maxNumDamaged) {
      if (headerBytes[bytes[start]] === undefined) {
        ++start;
        continue;
      }
      if (start + 3 > bytes.length) break;
      const end = start + lengthOf(bytes, start);
      if (end > bytes.length) break;
      const candidate = bytes.subarray(start, end);
      const packet = packetOf(candidate);
      if (!hasUnknownFlag(candidate) && isIntact(packet)) {
        packets.push(packet);
        start = end;
      } else {
        ++this.numDamaged;
        ++start;
      }
    }
    this.numUsedBytes = start;
    this.#rest = Buffer.from(bytes.subarray(start));
    return packets;
  }
}

// A datagram of false start bytes must not cost more than one of packets.
const maxNumDamagedInDatagram = 4;

// The rest of a datagram after a start byte without a whole packet is searched too: otherwise one
// false start byte hides the packets behind it.
export function packetsInDatagram(bytes) {
  const packets = [];
  let numDamaged = 0;
  let start = 0;
  while (start < bytes.length && numDamaged <= maxNumDamagedInDatagram) {
    const reader = new PacketReader(maxNumDamagedInDatagram);
    packets.push(...reader.take(bytes.subarray(start)));
    numDamaged += reader.numDamaged;
    start += reader.numUsedBytes;
    if (start >= bytes.length) break;
    ++start;
    ++numDamaged;
  }
  return { packets, numDamaged };
}
