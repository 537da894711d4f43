// Lines that wait for the service, on disk, oldest first. Bounded: when it is full, the oldest
// segment goes and its lines are counted as lost.
//
// A spool is a folder of segments NNNNNNNNNN.ndjson and `read.json`, which says what has been
// delivered. Lines are delivered at least once: the service replaces a sample of the same time.

import {
  closeSync, fdatasync, fdatasyncSync, mkdirSync, openSync, readFileSync, readSync, readdirSync,
  statSync, unlinkSync, writeSync,
} from 'node:fs';
import { join } from 'node:path';

import { readState, replaceFile } from './state_file.js';

const segmentBytes = 1024 * 1024;
const newline = 0x0a;
// Some minutes of an aircraft.
const maxNumInMemory = 20_000;

const nameOf = (number) => `${String(number).padStart(10, '0')}.ndjson`;

function countLines(path, start) {
  return readFileSync(path).subarray(start).filter((byte) => byte === newline).length;
}

export class Spool {
  #folder;
  #maxBytes;
  #segments = [];
  #writing;
  #read = { segment: 0, offset: 0 };
  #pending = [];
  #isSynced = true;
  numWaiting = 0;
  numLost = 0;
  lastError;

  constructor(folder, { maxBytes = 256 * 1024 * 1024, log } = {}) {
    this.#folder = folder;
    this.#maxBytes = Math.max(maxBytes, 2 * segmentBytes);
    mkdirSync(folder, { recursive: true });
    this.#read = readState(join(folder, 'read.json'), log) ?? this.#read;
    const names = readdirSync(folder).filter((name) => /^\d{10}\.ndjson$/.test(name)).sort();
    for (const name of names) this.#adopt(Number.parseInt(name, 10));
  }

  get numBytes() { return this.#segments.reduce((sum, one) => sum + one.size, 0); }

  // On disk at the next flush.
  append(value) {
    this.#pending.push(JSON.stringify(value));
  }

  // While the disk refuses, lines wait in memory.
  flush() {
    if (this.#pending.length === 0) return;
    try {
      this.#write(Buffer.from(`${this.#pending.join('\n')}\n`), this.#pending.length);
      this.#pending = [];
      this.lastError = undefined;
      this.#bound();
    } catch (error) {
      this.lastError = error.message;
      const tooMany = Math.max(0, this.#pending.length - maxNumInMemory);
      this.#pending.splice(0, tooMany);
      this.numLost += tooMany;
    }
  }

  // Survives a power cut. Costs a write of the disk, so once a second is enough. A slow disk must
  // not stop the link: the write runs beside it.
  sync() {
    try {
      this.#saveRead();
    } catch (error) {
      this.lastError = error.message;
    }
    if (this.#isSynced || !this.#writing) return;
    this.#isSynced = true;
    fdatasync(this.#writing.file, (error) => {
      if (!error) return;
      this.#isSynced = false;
      this.lastError = error.message;
    });
  }

  // Up to maxBytes of whole lines: { values, mark }; nothing if none wait.
  next(maxBytes) {
    for (const segment of this.#segments) {
      const start = segment.number === this.#read.segment ? this.#read.offset : 0;
      if (segment.size <= start) continue;
      const bytes = this.#bytesOf(segment, start, Math.min(maxBytes, segment.size - start));
      const end = bytes.lastIndexOf(newline) + 1;
      // A power cut may leave half a line at the end of an old segment.
      if (end === 0) {
        if (segment === this.#writing) return undefined;
        this.#read = { segment: segment.number, offset: segment.size };
        continue;
      }
      const texts = bytes.subarray(0, end - 1).toString('utf8').split('\n');
      const mark = { segment: segment.number, offset: start + end, numLines: texts.length };
      return { values: texts.map(parsed).filter((value) => value !== undefined), mark };
    }
    return undefined;
  }

  delivered({ segment: number, offset, numLines }) {
    // It may have been dropped while it was sent.
    const segment = this.#segments.find((one) => one.number === number);
    if (!segment) return;
    this.#read = { segment: number, offset };
    segment.numLines -= numLines;
    this.numWaiting -= numLines;
    for (const old of this.#segments.filter((one) => one.number < number)) this.#remove(old);
    if (segment !== this.#writing && offset >= segment.size) this.#remove(segment);
  }

  #write(bytes, numLines) {
    const segment = this.#segmentForWriting();
    let numWritten = 0;
    try {
      while (numWritten < bytes.length) numWritten += writeSync(segment.file, bytes, numWritten);
    } catch (error) {
      // Part of a line is on disk, so the next lines go to another segment.
      segment.size += numWritten;
      this.#writing = undefined;
      closeSync(segment.file);
      throw error;
    }
    segment.size += bytes.length;
    segment.numLines += numLines;
    this.numWaiting += numLines;
    this.#isSynced = false;
  }

  close() {
    this.flush();
    this.sync();
    if (this.#writing) {
      fdatasyncSync(this.#writing.file);
      closeSync(this.#writing.file);
    }
    this.#writing = undefined;
  }

  #adopt(number) {
    const path = join(this.#folder, nameOf(number));
    const start = number === this.#read.segment ? this.#read.offset : 0;
    const segment = { number, size: statSync(path).size, numLines: 0 };
    if (number >= this.#read.segment) segment.numLines = countLines(path, start);
    this.#segments.push(segment);
    this.numWaiting += segment.numLines;
    if (number < this.#read.segment || segment.size <= start) this.#remove(segment);
  }

  #segmentForWriting() {
    if (this.#writing && this.#writing.size < segmentBytes) return this.#writing;
    if (this.#writing) {
      fdatasyncSync(this.#writing.file);
      closeSync(this.#writing.file);
    }
    const number = Math.max(this.#read.segment, this.#segments.at(-1)?.number ?? 0) + 1;
    const file = openSync(join(this.#folder, nameOf(number)), 'a', 0o600);
    this.#writing = { number, size: 0, numLines: 0, file };
    this.#segments.push(this.#writing);
    return this.#writing;
  }

  #bytesOf(segment, start, length) {
    const file = openSync(join(this.#folder, nameOf(segment.number)), 'r');
    try {
      const bytes = Buffer.alloc(length);
      return bytes.subarray(0, readSync(file, bytes, 0, length, start));
    } finally {
      closeSync(file);
    }
  }

  #bound() {
    while (this.numBytes > this.#maxBytes && this.#segments.length > 1) {
      this.numLost += this.#segments[0].numLines;
      this.numWaiting -= this.#segments[0].numLines;
      this.#remove(this.#segments[0]);
    }
  }

  #remove(segment) {
    unlinkSync(join(this.#folder, nameOf(segment.number)));
    this.#segments = this.#segments.filter((one) => one !== segment);
  }

  #saveRead() { replaceFile(join(this.#folder, 'read.json'), JSON.stringify(this.#read)); }
}

function parsed(text) {
  try {
    return JSON.parse(text);
  } catch {
    return undefined;
  }
}
