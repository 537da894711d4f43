// A small picture of colours, written as PNG.

import { writeFileSync } from 'node:fs';
import { crc32 as nodeCrc32, deflateSync } from 'node:zlib';

const table = Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c >>> 0;
});
// Node 18 has no crc32.
const crc32 = nodeCrc32 ?? ((bytes) => {
  let c = 0xffffffff;
  for (const byte of bytes) c = table[(c ^ byte) & 0xff] ^ (c >>> 8);
  return (c ^ 0xffffffff) >>> 0;
});

function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type), data]);
  const bytes = Buffer.alloc(body.length + 8);
  bytes.writeUInt32BE(data.length, 0);
  body.copy(bytes, 4);
  bytes.writeUInt32BE(crc32(body), body.length + 4);
  return bytes;
}

export class Picture {
  #bytes;

  constructor(width, height) {
    Object.assign(this, { width, height });
    this.#bytes = Buffer.alloc(height * (1 + 3 * width));
  }

  // Row 0 is at the top.
  set(column, row, colour) {
    const x = Math.round(column);
    const y = Math.round(row);
    if (x < 0 || y < 0 || x >= this.width || y >= this.height) return;
    colour.forEach((value, i) => { this.#bytes[y * (1 + 3 * this.width) + 1 + 3 * x + i] = value; });
  }

  line([fromColumn, fromRow], [toColumn, toRow], colour) {
    const steps = Math.max(1, Math.ceil(Math.hypot(toColumn - fromColumn, toRow - fromRow) * 2));
    for (let i = 0; i <= steps; ++i) {
      this.set(fromColumn + ((toColumn - fromColumn) * i) / steps, fromRow + ((toRow - fromRow) * i) / steps, colour);
    }
  }

  circle([column, row], radius, colour) {
    for (let angle = 0; angle < 2 * Math.PI; angle += 0.3 / radius) {
      this.set(column + radius * Math.cos(angle), row + radius * Math.sin(angle), colour);
    }
  }

  write(path) {
    const header = Buffer.alloc(13);
    header.writeUInt32BE(this.width, 0);
    header.writeUInt32BE(this.height, 4);
    header.set([8, 2, 0, 0, 0], 8);
    writeFileSync(path, Buffer.concat([Buffer.from([0x89, 0x50, 0x4e, 0x47, 13, 10, 26, 10]), chunk('IHDR', header),
      chunk('IDAT', deflateSync(this.#bytes)), chunk('IEND', Buffer.alloc(0))]));
  }
}
