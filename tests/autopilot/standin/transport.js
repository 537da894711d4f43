// One direction of a radio link, with faults: loss, duplicates, reordering, delay and cuts. Stepped:
// it has no clock of its own.

import { Random } from './random.js';

const defaults = {
  seed: 1,
  // Shares of the packets.
  loss_ratio: 0, duplicate_ratio: 0, reorder_ratio: 0,
  delay_s: 0,
  // A packet that is reordered, or the copy of one, is late by up to this.
  max_late_s: 0.3,
};

export class Transport {
  #options;
  #random;
  #waiting = [];
  #cuts = [];
  #count = 0;
  numLost = 0;

  // deliver(bytes)
  constructor(deliver, options = {}) {
    this.deliver = deliver;
    this.#options = { ...defaults, ...options };
    this.#random = new Random(this.#options.seed);
  }

  // Nothing that is sent from start_s on passes, for duration_s.
  cut(start_s, duration_s) { this.#cuts.push({ start_s, end_s: start_s + duration_s }); }

  send(bytes, now_s) {
    const { loss_ratio, duplicate_ratio, reorder_ratio, delay_s } = this.#options;
    const isCut = this.#cuts.some(({ start_s, end_s }) => now_s >= start_s && now_s < end_s);
    if (isCut || this.#random.uniform() < loss_ratio) {
      ++this.numLost;
      return;
    }
    const isLate = this.#random.uniform() < reorder_ratio;
    this.#wait(bytes, now_s + delay_s + (isLate ? this.#late_s() : 0));
    if (this.#random.uniform() < duplicate_ratio) this.#wait(bytes, now_s + delay_s + this.#late_s());
  }

  // Delivers what is due.
  step(now_s) {
    for (;;) {
      const first = this.#waiting[0];
      if (!first || first.due_s > now_s + 1e-9) return;
      this.#waiting.shift();
      this.deliver(first.bytes);
    }
  }

  #late_s() { return this.#options.max_late_s * this.#random.uniform(); }

  #wait(bytes, due_s) {
    const one = { bytes: Buffer.from(bytes), due_s, number: this.#count++ };
    const after = this.#waiting.findIndex((other) => other.due_s > due_s);
    if (after < 0) this.#waiting.push(one);
    else this.#waiting.splice(after, 0, one);
  }
}
