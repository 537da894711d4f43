// Triggers of the camera, on disk: pictures may come minutes later, also after a restart of this program.

import { appendFileSync, existsSync, readFileSync } from 'node:fs';

import { replaceFile } from '../state_file.js';

const defaultMaxNum = 20_000;
// The same message on two ways.
const same_us = 15_000;

function parsed(line) {
  try {
    return [JSON.parse(line)];
  } catch {
    // A power cut may leave half a line.
    return [];
  }
}

export const linesOf = (path) => (existsSync(path) ? readFileSync(path, 'utf8').split('\n').filter(Boolean).flatMap(parsed) : []);

export const writeLines = (path, values) => replaceFile(path, values.map((value) => `${JSON.stringify(value)}\n`).join(''));

export class TriggerLog {
  #path;
  #maxNum;
  #pending = [];
  #numLines;
  triggers;

  constructor(path, { maxNum = defaultMaxNum } = {}) {
    this.#path = path;
    this.#maxNum = maxNum;
    const lines = linesOf(path);
    this.triggers = lines.slice(-maxNum);
    this.#rewrite();
  }

  // trigger: { kind, index, time_us, order, session, position?, attitude?, file? }. False if it is known.
  add(trigger) {
    const isSame = (other) => other.kind === trigger.kind && other.index === trigger.index &&
      Math.abs(other.time_us - trigger.time_us) < same_us;
    if (this.triggers.slice(-50).some(isSame)) return false;
    this.triggers.push(trigger);
    this.#pending.push(trigger);
    if (this.triggers.length > this.#maxNum) this.triggers.shift();
    return true;
  }

  // Ten times a second. Throws if the disk refuses; then the lines stay for the next time.
  save() {
    if (this.#pending.length === 0) return;
    appendFileSync(this.#path, `\n${this.#pending.map((one) => JSON.stringify(one)).join('\n')}\n`, { mode: 0o600 });
    this.#numLines += this.#pending.length;
    this.#pending = [];
    if (this.#numLines > 2 * this.#maxNum) this.#rewrite();
  }

  #rewrite() {
    writeLines(this.#path, this.triggers);
    this.#numLines = this.triggers.length;
    this.#pending = [];
  }
}
