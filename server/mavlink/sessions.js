// Which flight of the service a sample belongs to. A restart of this program, or of the autopilot,
// in the air does not begin another one; a long pause does.

import { readState, replaceFile } from './state_file.js';

const longestPause_us = 15 * 60 * 1e6;
// The autopilot's clock may be corrected.
const longestStepBack_us = 60 * 1e6;

export class Sessions {
  #path;
  #current;
  #isSaved = true;

  constructor(path, log) {
    this.#path = path;
    this.#current = readState(path, log);
  }

  // The name of the flight of a line of telemetry, which may begin another one.
  at(timestamp_us, systemId) {
    if (!this.#isIn(timestamp_us, systemId)) {
      const began = new Date(timestamp_us / 1000).toISOString();
      this.#current = { name: `MAVLink system ${systemId}, ${began}`, system_id: systemId, last_us: timestamp_us };
    }
    this.#current.last_us = Math.max(this.#current.last_us, timestamp_us);
    this.#isSaved = false;
    return this.#current.name;
  }

  // The name of the flight of what does not begin one; nothing if it is not the current one.
  find(timestamp_us, systemId) { return this.#isIn(timestamp_us, systemId) ? this.#current.name : undefined; }

  #isIn(timestamp_us, systemId) {
    const pause_us = timestamp_us - (this.#current?.last_us ?? -Infinity);
    return this.#current?.system_id === systemId && pause_us <= longestPause_us && pause_us >= -longestStepBack_us;
  }

  get name() { return this.#current?.name; }

  save() {
    if (this.#isSaved) return;
    replaceFile(this.#path, JSON.stringify(this.#current));
    this.#isSaved = true;
  }
}
