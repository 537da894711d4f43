// From samples with a time since boot to lines of telemetry with UTC, in the service's own format.

// While UTC is unknown, samples wait; at 20 a second this is several minutes.
const maxNumHeld = 5000;
// Closer samples of one kind bring nothing, and a flood of them would fill the spool.
const minStep_ms = 15;

export class Samples {
  #clock;
  #emit;
  #held = [];
  #last_ms = {};
  numDropped = 0;

  // emit(line): { timestamp_us, position | attitude | wind }.
  constructor(clock, emit) {
    this.#clock = clock;
    this.#emit = emit;
  }

  get numHeld() { return this.#held.length; }

  add(kind, boot_ms, fields, now_us) {
    const step_ms = boot_ms - (this.#last_ms[kind] ?? -Infinity);
    // A reordered sample is older, and is kept.
    if (step_ms >= 0 && step_ms < minStep_ms) return;
    this.#last_ms[kind] = Math.max(boot_ms, this.#last_ms[kind] ?? boot_ms);
    this.#held.push({ boot_ms, fields });
    if (this.#held.length > maxNumHeld) {
      this.#held.shift();
      ++this.numDropped;
    }
    this.release(now_us);
  }

  release(now_us) {
    if (this.#held.length === 0 || this.#clock.source(now_us) === 'none') return;
    for (const { boot_ms, fields } of this.#held) {
      this.#emit({ timestamp_us: this.#clock.utc_us(boot_ms, now_us), ...fields });
    }
    this.#held = [];
  }

  // Samples of an earlier boot have no UTC any more.
  restart() {
    this.numDropped += this.#held.length;
    this.#held = [];
    this.#last_ms = {};
  }
}
