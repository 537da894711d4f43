// A mission change that is under way, on disk: after a crash of this program the former mission is
// still known. While the disk refuses, it is known only until then.

import { closeSync, fsyncSync, openSync, renameSync, rmSync, writeSync } from 'node:fs';

import { readState } from '../state_file.js';

export class ChangeStore {
  #path;
  #log;
  #value;

  constructor(path, log) {
    this.#path = path;
    this.#log = log;
    this.#value = readState(path, log, restored);
  }

  load() { return this.#value; }

  save(value) {
    this.#value = value;
    this.#onDisk(() => {
      const file = openSync(`${this.#path}.new`, 'w', 0o600);
      try {
        writeSync(file, JSON.stringify(value, kept));
        fsyncSync(file);
      } finally {
        closeSync(file);
      }
      renameSync(`${this.#path}.new`, this.#path);
    });
  }

  clear() {
    this.#value = undefined;
    this.#onDisk(() => rmSync(this.#path, { force: true }));
  }

  #onDisk(act) {
    try {
      act();
    } catch (error) {
      this.#log(`the former mission is not safe from a crash of this program: ${error.message}`);
    }
  }
}

// JSON has no NaN, which stands for an unset parameter.
const kept = (_, value) => (Number.isNaN(value) ? 'NaN' : value);
const restored = (_, value) => (value === 'NaN' ? NaN : value);
