// The wind that is offered: the autopilot's own if it sends one, else that from drift.

import { DriftWind } from './wind_drift.js';

// ArduPilot sends WIND from its start; the estimate is useful only some time after take-off.
const settle_ms = 20_000;
const autopilotIsSilentAfter_ms = 10_000;
const maxDriftSd_mps = 1.0;
const driftPeriod_ms = 1000;
const maxSpeed_mps = 60;

const isWind = ({ east_mps, north_mps }) => Math.hypot(east_mps, north_mps) <= maxSpeed_mps;

export class WindSource {
  #drift = new DriftWind();
  #emit;
  #autopilot;
  #offered;
  #driftOffered_ms = -Infinity;

  // emit(boot_ms, { east_mps, north_mps, source, sd_mps? }, now_us)
  constructor(emit) { this.#emit = emit; }

  // WIND of ArduPilot: the direction that the wind comes from.
  hearFrom({ from_deg, speed_mps }, boot_ms, flyingSince_ms, now_us) {
    if (flyingSince_ms === undefined || boot_ms - flyingSince_ms < settle_ms) return;
    const from_rad = (from_deg * Math.PI) / 180;
    this.hearTowards(
      { east_mps: -speed_mps * Math.sin(from_rad), north_mps: -speed_mps * Math.cos(from_rad) },
      boot_ms, now_us);
  }

  // WIND_COV of PX4: where the air moves.
  hearTowards(wind, boot_ms, now_us) {
    if (boot_ms === undefined || !isWind(wind)) return;
    this.#autopilot = boot_ms;
    this.#offer({ ...wind, source: 'autopilot' }, boot_ms, now_us);
  }

  // At each position in flight.
  move(motion, now_us) {
    this.#drift.add(motion);
    const boot_ms = motion.time_s * 1000;
    const isTold = boot_ms - (this.#autopilot ?? -Infinity) < autopilotIsSilentAfter_ms;
    if (isTold || boot_ms - this.#driftOffered_ms < driftPeriod_ms) return;
    this.#driftOffered_ms = boot_ms;
    const wind = this.#drift.estimate();
    if (wind && wind.sd_mps <= maxDriftSd_mps && isWind(wind)) {
      this.#offer({ ...wind, source: 'drift' }, boot_ms, now_us);
    }
  }

  restart() {
    this.#drift.restart();
    this.#autopilot = undefined;
    this.#offered = undefined;
    this.#driftOffered_ms = -Infinity;
  }

  state(boot_ms) {
    if (!this.#offered) return undefined;
    const { wind, boot_ms: offered_ms } = this.#offered;
    return { ...wind, age_s: (boot_ms - offered_ms) / 1000 };
  }

  #offer(wind, boot_ms, now_us) {
    this.#offered = { wind, boot_ms };
    this.#emit(boot_ms, wind, now_us);
  }
}
