// From the autopilot's time since boot to UTC.

// Before 2020 a clock was never set.
const firstPlausible_us = Date.UTC(2020, 0, 1) * 1000;
// A later one is no clock at all, and no date of JavaScript.
const lastPlausible_us = Date.UTC(2100, 0, 1) * 1000;
const maxNumOffsets = 9;
// A larger step is a new setting of the autopilot's clock, or another boot.
const maxStep_us = 1_000_000;
const numStepsToBelieve = 3;
// A packet that arrives late is this much older at most; anything older is a new boot.
const maxLate_ms = 5000;

const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];

export class BootClock {
  #offsets_us = [];
  #steps_us = [];
  #hostOffset_us;
  #firstHeard_us;
  #newest_ms;
  #fallbackAfter_s;
  numBoots = 1;

  // fallbackAfter_s: how long to wait for the autopilot's UTC before the host's clock is used.
  constructor({ fallbackAfter_s = 20 } = {}) {
    this.#fallbackAfter_s = fallbackAfter_s;
  }

  // Each message with a time since boot. False if it started a new boot.
  hear(boot_ms, arrived_us) {
    const isNewBoot = this.#newest_ms !== undefined && boot_ms < this.#newest_ms - maxLate_ms;
    if (isNewBoot) this.#forget();
    this.#newest_ms = Math.max(this.#newest_ms ?? boot_ms, boot_ms);
    this.#firstHeard_us ??= arrived_us;
    // The packet with the least delay tells the offset best.
    const offset_us = arrived_us - boot_ms * 1000;
    this.#hostOffset_us = Math.min(this.#hostOffset_us ?? offset_us, offset_us);
    return !isNewBoot;
  }

  // SYSTEM_TIME. The autopilot sends 0 before it knows UTC.
  set(unix_us, boot_ms) {
    if (unix_us < firstPlausible_us || unix_us > lastPlausible_us) return;
    const offset_us = unix_us - boot_ms * 1000;
    const known_us = this.#offsets_us.length ? median(this.#offsets_us) : offset_us;
    if (Math.abs(offset_us - known_us) <= maxStep_us) {
      this.#steps_us = [];
      this.#offsets_us.push(offset_us);
      if (this.#offsets_us.length > maxNumOffsets) this.#offsets_us.shift();
      return;
    }
    this.#steps_us.push(offset_us);
    if (this.#steps_us.length < numStepsToBelieve) return;
    if (Math.abs(offset_us - median(this.#steps_us)) <= maxStep_us) this.#offsets_us = this.#steps_us;
    this.#steps_us = [];
  }

  // Microseconds since 1970, or nothing while UTC is unknown.
  utc_us(boot_ms, now_us) {
    const source = this.source(now_us);
    if (source === 'none') return undefined;
    const offset_us = source === 'autopilot' ? median(this.#offsets_us) : this.#hostOffset_us;
    return Math.round(offset_us + boot_ms * 1000);
  }

  source(now_us) {
    if (this.#offsets_us.length) return 'autopilot';
    const waited_us = this.#firstHeard_us === undefined ? 0 : now_us - this.#firstHeard_us;
    const isHostSet = now_us >= firstPlausible_us;
    return isHostSet && waited_us > this.#fallbackAfter_s * 1e6 ? 'host' : 'none';
  }

  get newest_ms() { return this.#newest_ms; }

  get spread_us() {
    if (!this.#offsets_us.length) return undefined;
    return Math.max(...this.#offsets_us) - Math.min(...this.#offsets_us);
  }

  #forget() {
    this.#offsets_us = [];
    this.#steps_us = [];
    this.#hostOffset_us = undefined;
    this.#firstHeard_us = undefined;
    this.#newest_ms = undefined;
    ++this.numBoots;
  }
}
