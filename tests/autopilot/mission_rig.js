// A stand-in, a radio with faults and the link's landings, in stepped time.

import { Link } from '../../server/mavlink/link.js';
import { Landings } from '../../server/mavlink/landings.js';
import { Outgoing } from '../../server/mavlink/outgoing.js';
import { Standin } from './standin/aircraft.js';
import { landing, survey } from './standin/missions.js';
import { Transport } from './standin/transport.js';

const tick_s = 0.1;
const rates_hz = { HEARTBEAT: 1, SYSTEM_TIME: 1, ATTITUDE: 0.5, GLOBAL_POSITION_INT: 2, GPS_RAW_INT: 0, VFR_HUD: 1, WIND: 1,
  SYS_STATUS: 0, RPM: 0, MISSION_CURRENT: 1, HOME_POSITION: 0, CAMERA_FEEDBACK: 0 };
const flush = () => new Promise((resolve) => { setImmediate(resolve); });

// What the service answers for a site whose final ends at touchdown, in the stand-in's own frame.
export function approachAnswer(plane, { east_m = 0, north_m = 0, heading_deg = 90, final_m = 150, height_m = 12, radius_m = 41.3,
  isRight = true, airspeed_mps = 16, elevation_m = 431.7 } = {}) {
  const heading_rad = (heading_deg * Math.PI) / 180;
  const at = (back_m, right_m, altitude_m) => {
    const { latitude_deg, longitude_deg } = plane.frame.toGlobal({
      east_m: east_m - back_m * Math.sin(heading_rad) + right_m * Math.cos(heading_rad),
      north_m: north_m - back_m * Math.cos(heading_rad) - right_m * Math.sin(heading_rad),
    });
    return [longitude_deg, latitude_deg, altitude_m];
  };
  const top_m = elevation_m + height_m;
  const side = isRight ? 1 : -1;
  const corner = (i) => {
    const angle = (i * Math.PI) / 18;
    return at(final_m + radius_m * Math.sin(angle), side * (radius_m - radius_m * Math.cos(angle)), top_m);
  };
  const feature = (kind, coordinates, more) => ({ type: 'Feature', properties: { kind, ...more }, geometry: { coordinates } });
  return {
    altitude_datum: 'amsl', verdict: 'landable', plan: { aircraft: { landing_airspeed_mps: airspeed_mps } },
    features: [
      feature('approach', [at(final_m, 0, top_m), at(0, 0, elevation_m)], { heading_deg, ground_speed_mps: airspeed_mps - 3 }),
      feature('loiter', Array.from({ length: 37 }, (_, i) => corner(i % 36)), { radius_m, direction: isRight ? 'right' : 'left', height_m }),
      feature('touchdown', at(0, 0, elevation_m), { heading_deg }),
    ],
  };
}

export const siteAnswer = { properties: { verdict: 'landable', altitude_datum: 'amsl', aircraft: { landing_airspeed_mps: 16 } } };

export class Rig {
  log = [];
  told = new Map();
  #others = [];

  constructor({ seed = 1, faults = {}, options = {}, service, mode = 'AUTO', recall } = {}) {
    this.plane = new Standin({ seed, rates_hz, ...options });
    this.service = { site: async () => siteAnswer, approach: async () => approachAnswer(this.plane), ...service };
    this.recall = recall;
    const radio = { delay_s: 0.05, ...faults };
    this.up = new Transport((bytes) => this.#reachPlanes(bytes), { ...radio, seed: 2 * seed });
    this.down = new Transport((bytes) => this.link.take(bytes, '127.0.0.1 5760', true, this.plane.utc_us), { ...radio, seed: 2 * seed + 1 });
    this.plane.onSend = (bytes) => this.down.send(bytes, this.plane.time_s);
    this.plane.loadMission([...survey(this.plane, { width_m: 240, spacing_m: 80 }), ...landing(this.plane)]);
    this.plane.startInFlight({ height_m: 120, mode });
    this.startProgram();
  }

  // The change store survives the program.
  stored = undefined;

  startProgram() {
    const { plane } = this;
    this.link = new Link({ emit: () => {}, steady_us: () => plane.time_s * 1e6, onEvent: () => {},
      onMessage: (name, fields) => this.landings.hear(name, fields, plane.time_s) });
    this.outgoing = new Outgoing({ send: (bytes) => this.up.send(bytes, plane.time_s), systemId: () => this.link.pin.systemId });
    this.landings = new Landings({
      service: this.service, out: this.outgoing, address: () => this.link.pin,
      linkState: () => this.link.state(plane.utc_us),
      log: (kind, text) => this.log.push({ time_s: plane.time_s, kind, text }),
      told: (id, state, detail) => this.told.set(id, { state, detail }),
      store: { load: () => this.stored, save: (value) => { this.stored = structuredClone(value); }, clear: () => { this.stored = undefined; } },
      recall: this.recall,
    });
  }

  get mission() { return this.landings.state(); }

  // Another aircraft on the same radio.
  addPlane(options) {
    const other = new Standin({ rates_hz, ...options });
    other.onSend = (bytes) => this.down.send(bytes, this.plane.time_s);
    other.startInFlight({ height_m: 90 });
    this.#others.push(other);
    return other;
  }

  #reachPlanes(bytes) {
    for (const plane of [this.plane, ...this.#others]) plane.take(bytes);
  }

  async step(duration_s, onTick = () => {}) {
    for (const end_s = this.plane.time_s + duration_s - tick_s / 2; this.plane.time_s < end_s;) {
      this.up.step(this.plane.time_s);
      this.plane.step(tick_s);
      this.#others.forEach((one) => one.step(tick_s));
      this.down.step(this.plane.time_s);
      this.landings.step(this.plane.time_s);
      await flush();
      onTick(this);
    }
  }
}
