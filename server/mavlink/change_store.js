// A mission change that is under way, on disk: after a crash of this program the former mission is
// still known.

import { closeSync, existsSync, fsyncSync, openSync, readFileSync, renameSync, rmSync, writeSync } from 'node:fs';

export class ChangeStore {
  #path;

  constructor(path) { this.#path = path; }

  load() { return existsSync(this.#path) ? JSON.parse(readFileSync(this.#path, 'utf8'), restored) : undefined; }

  save(value) {
    const file = openSync(`${this.#path}.new`, 'w', 0o600);
    writeSync(file, JSON.stringify(value, kept));
    fsyncSync(file);
    closeSync(file);
    renameSync(`${this.#path}.new`, this.#path);
  }

  clear() { rmSync(this.#path, { force: true }); }
}

// JSON has no NaN, which stands for an unset parameter.
const kept = (_, value) => (Number.isNaN(value) ? 'NaN' : value);
const restored = (_, value) => (value === 'NaN' ? NaN : value);
