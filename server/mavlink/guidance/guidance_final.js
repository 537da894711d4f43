// When the final begins: the aircraft is at its start, and nearly in its direction. Pure.

const defaultGateOptions = {
  // So long before the start, because the mode changes late.
  lead_s: 0.3,
  maxAngle_deg: 25,
  maxAside_m: 10,
  // From here on the final is begun as it is: a mission lands better than targets do.
  late_m: 15,
};

const wrapped_deg = (angle) => ((((angle + 180) % 360) + 360) % 360) - 180;

export class FinalGate {
  #options;

  constructor(options = {}) { this.#options = { ...defaultGateOptions, ...options }; }

  isOpen(way, { along_m, away_m }, state) {
    const options = this.#options;
    const past_m = along_m - way.finalStart_m;
    if (past_m < -options.lead_s * state.ground_speed_mps) return false;
    if (past_m > options.late_m) return true;
    const { east_mps, north_mps } = state.velocity;
    const course_deg = (Math.atan2(east_mps, north_mps) * 180) / Math.PI;
    const angle_deg = wrapped_deg(course_deg - way.heading_deg(way.end_m));
    return Math.abs(angle_deg) < options.maxAngle_deg && away_m < options.maxAside_m;
  }
}
