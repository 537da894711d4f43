// Numbers from a seed: the same seed gives the same flight.

export class Random {
  #state;
  #spare;

  constructor(seed) { this.#state = (seed * 2654435761 + 0x9e3779b9) >>> 0; }

  // In [0, 1). Mulberry32.
  uniform() {
    this.#state = (this.#state + 0x6d2b79f5) >>> 0;
    let mixed = this.#state;
    mixed = Math.imul(mixed ^ (mixed >>> 15), mixed | 1);
    mixed ^= mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61);
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 4294967296;
  }

  between(low, high) { return low + (high - low) * this.uniform(); }

  gauss(sd = 1) {
    if (this.#spare !== undefined) {
      const value = this.#spare;
      this.#spare = undefined;
      return sd * value;
    }
    const radius = Math.sqrt(-2 * Math.log(1 - this.uniform()));
    const angle = 2 * Math.PI * this.uniform();
    this.#spare = radius * Math.sin(angle);
    return sd * radius * Math.cos(angle);
  }
}

// Noise that changes slowly, with the given standard deviation (first-order Gauss-Markov).
export class SlowNoise {
  #random;
  #sd;
  #time_s;
  value = 0;

  constructor(random, sd, time_s) {
    this.#random = random;
    this.#sd = sd;
    this.#time_s = time_s;
  }

  step(duration_s) {
    if (this.#sd === 0) return 0;
    const kept = Math.exp(-duration_s / this.#time_s);
    this.value = kept * this.value + this.#random.gauss(this.#sd * Math.sqrt(1 - kept * kept));
    return this.value;
  }
}
