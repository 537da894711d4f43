// How much height the aircraft truly loses of what the told ways say. Only for the shape of the
// way to a site that is flown to: what is in reach counts on the told glide alone. Pure.

// Counts as much as if so much height had been lost as told: a short glide says little.
const prior_m = 40;
// Kept in reserve: lift or a lull may have helped.
const reserve = 0.03;
const least = 0.8;

export class GlideShare {
  #told_m = 0;
  #lost_m = 0;
  #last;

  // way: the present one. altitude_m: of the way there. energy_m: the aircraft's height above it.
  add(way, altitude_m, energy_m) {
    const last = this.#last;
    this.#last = { way, altitude_m, height_m: altitude_m + energy_m };
    if (last?.way !== way || altitude_m > last.altitude_m) return;
    this.#told_m += last.altitude_m - altitude_m;
    this.#lost_m += last.height_m - this.#last.height_m;
  }

  // 1 and less.
  get share() {
    const share = (this.#lost_m + prior_m) / (this.#told_m + prior_m);
    return Math.min(1, Math.max(least, share + reserve));
  }
}
