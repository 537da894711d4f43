// What became of each picture, on disk. A picture is sent again until this file says that the service
// has it, and not afterwards.

import { closeSync, existsSync, fsyncSync, openSync, writeSync } from 'node:fs';

import { linesOf, writeLines } from './trigger_log.js';

const maxNum = 40_000;

export const keyOf = ({ name, size, mtime_ms }) => `${name} ${size} ${mtime_ms}`;

export class Ledger {
  #path;
  #entries;
  #digests;
  // Times of the triggers whose pictures were sent.
  usedTriggers_us;
  // The folder was never looked at before.
  isNew;

  constructor(path) {
    this.#path = path;
    this.isNew = !existsSync(path);
    const entries = linesOf(path).slice(-maxNum);
    this.#entries = new Map(entries.map((entry) => [entry.key, entry]));
    this.#digests = new Set(entries.map(({ sha256 }) => sha256).filter(Boolean));
    this.usedTriggers_us = new Set(entries.map(({ trigger_us }) => trigger_us).filter(Boolean));
    if (!this.isNew) writeLines(path, entries);
  }

  get entries() { return [...this.#entries.values()]; }
  has(file) { return this.#entries.has(keyOf(file)); }
  hasDigest(sha256) { return this.#digests.has(sha256); }

  // fate: sent, duplicate, refused or earlier. Survives a power cut.
  add(values) {
    const entries = values.map(({ picture, fate, ...more }) => ({ key: keyOf(picture), fate, ...more }));
    const file = openSync(this.#path, 'a', 0o600);
    try {
      writeSync(file, `\n${entries.map((entry) => JSON.stringify(entry)).join('\n')}\n`);
      fsyncSync(file);
    } finally {
      closeSync(file);
    }
    this.isNew = false;
    for (const entry of entries) {
      this.#entries.set(entry.key, entry);
      if (entry.sha256) this.#digests.add(entry.sha256);
      if (entry.trigger_us) this.usedTriggers_us.add(entry.trigger_us);
    }
    this.#bound();
  }

  #bound() {
    if (this.#entries.size <= maxNum) return;
    const kept = this.entries.slice(-maxNum / 2);
    this.#entries = new Map(kept.map((entry) => [entry.key, entry]));
    writeLines(this.#path, kept);
  }
}
