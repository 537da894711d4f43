// Reads a telemetry log: 8 bytes big-endian microseconds, then one packet, repeated.

import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';

const headerBytes = { 0xfe: 6, 0xfd: 10 };

function packetLength(bytes, start) {
  const header = headerBytes[bytes[start]];
  if (!header) throw new Error(`no packet at byte ${start}`);
  const signature = bytes[start] === 0xfd && bytes[start + 2] & 1 ? 13 : 0;
  return header + bytes[start + 1] + 2 + signature;
}

// [{ time_us, bytes }]
export function readTlog(path) {
  const bytes = readFileSync(path);
  const records = [];
  for (let start = 0; start + 8 < bytes.length;) {
    const end = start + 8 + packetLength(bytes, start + 8);
    const time_us = Number(bytes.readBigUInt64BE(start));
    records.push({ time_us, bytes: bytes.subarray(start + 8, end) });
    start = end;
  }
  return records;
}

// The folder of recordings: FREELSD_AUTOPILOT, or beside FREELSD_DATA.
export function recording(name) {
  const folder = process.env.FREELSD_AUTOPILOT ??
    (process.env.FREELSD_DATA && join(process.env.FREELSD_DATA, '..', 'autopilot'));
  const path = folder && join(folder, name);
  return path && existsSync(path) ? path : undefined;
}

export const skipReason = 'the recordings are not here: set FREELSD_DATA or FREELSD_AUTOPILOT';
