// Watches the engine of a stand-in as nobody can: drag, thrust and the strength of the gusts are known, and only
// the gusts themselves and the errors of the telemetry are not. How soon it is sure bounds what a watch can do.

import { packetsInDatagram } from '../../server/mavlink/framing.js';
import { fieldsOf } from '../../server/mavlink/messages.js';
import { defaultPowerDropOptions, Onset } from '../../server/mavlink/engine/power_drop.js';
import { Innovations, PowerNoise } from '../../server/mavlink/engine/power_noise.js';

const gravity_mps2 = 9.81;
const { limit, onsets_s } = defaultPowerDropOptions;

export class KnowingWatch {
  #plane;
  #noise;
  #innovations = new Innovations();
  #onsets = [];
  #last;
  alarms_s = [];

  constructor(plane) {
    this.#plane = plane;
    const { wind, sensors, parameters } = plane.options;
    this.#noise = new PowerNoise({ gusts_s: wind.gust_time_s, gust_mps: Math.max(0.1, wind.vertical_gust_sd_mps),
      error_m: (sensors.velocity_sd_mps * parameters.AIRSPEED_CRUISE) / gravity_mps2 });
  }

  // bytes: a GLOBAL_POSITION_INT, just sent.
  step(bytes) {
    const [packet] = packetsInDatagram(bytes).packets;
    const { vx, vy, vz, timeBootMs } = fieldsOf(packet);
    const before = this.#last;
    this.#last = { time_s: timeBootMs / 1000, east_mps: vy / 100, north_mps: vx / 100, climb_mps: -vz / 100, ...this.#truth() };
    if (before) this.#weigh(before, this.#last);
  }

  #truth() {
    const { body, options } = this.#plane;
    return { heading_rad: body.heading_rad, airspeed_mps: body.airspeed_mps, drag_ratio: body.drag_ratio(body.load),
      thrust_ratio: body.throttle * options.aircraft.max_thrust_ratio };
  }

  #weigh(before, now) {
    const duration_s = now.time_s - before.time_s;
    const mean = (name) => (before[name] + now[name]) / 2;
    const turned_rad = Math.atan2(Math.sin(now.heading_rad - before.heading_rad), Math.cos(now.heading_rad - before.heading_rad));
    const middle_rad = before.heading_rad + turned_rad / 2;
    const gained_mps = (now.east_mps - before.east_mps) * Math.sin(middle_rad) + (now.north_mps - before.north_mps) * Math.cos(middle_rad);
    const power_mps = mean('climb_mps') + (mean('airspeed_mps') * gained_mps) / duration_s / gravity_mps2;
    // The thrust follows the throttle 0.2 s later.
    const thrust_mps = mean('airspeed_mps') * before.thrust_ratio;
    const residual_mps = power_mps - thrust_mps + mean('airspeed_mps') * mean('drag_ratio');
    const filter = this.#noise.next(duration_s);
    const innovation_mps = this.#innovations.next(filter, residual_mps);
    this.#onsets.push(new Onset(now.time_s));
    while (this.#onsets[0].time_s <= now.time_s - onsets_s) this.#onsets.shift();
    this.#onsets.forEach((one) => one.add(filter, thrust_mps, innovation_mps, filter.variance_mps2));
    const evidence = Math.max(...this.#onsets.map((one) => one.evidence(1, 1)));
    if (evidence > limit) this.alarms_s.push(this.#plane.time_s);
  }
}
