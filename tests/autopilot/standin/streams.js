// What the autopilot sends by itself, at settable rates.

const degrees = (radians) => (radians * 180) / Math.PI;
const e7 = (value_deg) => Math.round(value_deg * 1e7);
const milli = (value) => Math.round(value * 1000);
const centi = (value) => Math.round(value * 100);
const boundedWord = (value) => Math.min(65534, Math.max(0, Math.round(value)));
const positive = (angle_deg) => (angle_deg + 360) % 360;

const fixedWing = 1;
const ardupilot = 3;
const standby = 3;
const active = 4;
const armedMode = 217;
const safeMode = 89;
const emptyVoltage_v = 12.6;
const resistance_ohm = 0.0148;

// state: what plane.belief() gives, beside time, mode and so on.
const makers = {
  HEARTBEAT: (s) => ({ type: fixedWing, autopilot: ardupilot, baseMode: s.isArmed ? armedMode : safeMode,
    customMode: s.modeNumber, systemStatus: s.isArmed ? active : standby, mavlinkVersion: 3 }),
  SYSTEM_TIME: (s) => ({ timeUnixUsec: BigInt(Math.round(s.utc_us)), timeBootMs: s.boot_ms }),
  ATTITUDE: (s) => ({ timeBootMs: s.boot_ms, roll: s.roll_rad, pitch: s.pitch_rad, yaw: s.yaw_rad,
    rollspeed: 0, pitchspeed: 0, yawspeed: 0 }),
  GLOBAL_POSITION_INT: (s) => ({ timeBootMs: s.boot_ms, lat: e7(s.latitude_deg), lon: e7(s.longitude_deg),
    alt: milli(s.altitude_m), relativeAlt: milli(s.altitude_m - s.home.altitude_m), vx: centi(s.north_mps),
    vy: centi(s.east_mps), vz: centi(-s.climb_mps), hdg: boundedWord(100 * positive(degrees(s.yaw_rad))) }),
  GPS_RAW_INT: (s) => ({ timeUsec: BigInt(s.boot_ms) * 1000n, fixType: 6, lat: e7(s.latitude_deg),
    lon: e7(s.longitude_deg), alt: milli(s.altitude_m), eph: 121, epv: 200,
    vel: boundedWord(100 * Math.hypot(s.east_mps, s.north_mps)),
    cog: boundedWord(100 * positive(degrees(Math.atan2(s.east_mps, s.north_mps)))), satellitesVisible: 10,
    altEllipsoid: milli(s.altitude_m), hAcc: 300, vAcc: 300, velAcc: 0, hdgAcc: 0, yaw: 0 }),
  VFR_HUD: (s) => ({ airspeed: s.airspeed_mps, groundspeed: Math.hypot(s.east_mps, s.north_mps),
    heading: Math.round(positive(degrees(s.yaw_rad))) % 360, throttle: Math.round(100 * s.throttle), alt: s.altitude_m,
    climb: s.climb_mps }),
  WIND: (s) => ({ direction: degrees(Math.atan2(-s.wind.east_mps, -s.wind.north_mps)),
    speed: Math.hypot(s.wind.east_mps, s.wind.north_mps), speedZ: 0 }),
  SYS_STATUS: (s) => ({ onboardControlSensorsPresent: 325188671, onboardControlSensorsEnabled: 325188671,
    onboardControlSensorsHealth: 322042943, load: 0,
    voltageBattery: milli(emptyVoltage_v - resistance_ohm * s.current_a),
    currentBattery: s.sendsCurrent ? centi(s.current_a) : -1, batteryRemaining: Math.max(0, Math.round(100 * s.battery_ratio)) }),
  RPM: (s) => (s.sendsRpm ? { rpm1: s.rpm, rpm2: 0 } : undefined),
  MISSION_CURRENT: (s) => ({ seq: s.missionIndex, total: Math.max(0, s.numItems - 1),
    missionState: s.numItems < 2 ? 1 : s.isInMission ? 3 : 2, missionMode: s.isInMission ? 1 : 0 }),
  HOME_POSITION: (s) => ({ latitude: e7(s.home.latitude_deg), longitude: e7(s.home.longitude_deg),
    altitude: milli(s.home.altitude_m), q: [1, 0, 0, 0], timeUsec: BigInt(s.boot_ms) * 1000n }),
  // One for each picture that the camera takes.
  CAMERA_FEEDBACK: (s) => ({ timeUsec: BigInt(s.boot_ms) * 1000n, lat: e7(s.latitude_deg), lng: e7(s.longitude_deg),
    altMsl: s.altitude_m, altRel: s.altitude_m - s.home.altitude_m, roll: degrees(s.roll_rad),
    pitch: degrees(s.pitch_rad), yaw: degrees(s.yaw_rad), imgIdx: s.imageIndex }),
};

export class Streams {
  #due = new Map();
  #rates;

  constructor(rates_hz) { this.#rates = { ...rates_hz }; }

  restart() { this.#due.clear(); }

  // interval_us: -1 sends none, 0 is the default. False if there is no such stream.
  setInterval(name, interval_us) {
    if (!makers[name]) return false;
    if (interval_us !== 0) this.#rates[name] = interval_us < 0 ? 0 : 1e6 / interval_us;
    return true;
  }

  fields(name, state) { return makers[name]?.(state); }

  // Names of what is due.
  due(time_s) {
    const names = [];
    for (const [name, rate_hz] of Object.entries(this.#rates)) {
      if (!(rate_hz > 0)) continue;
      const due_s = this.#due.get(name) ?? time_s;
      if (time_s < due_s - 1e-9) continue;
      names.push(name);
      this.#due.set(name, Math.max(due_s + 1 / rate_hz, time_s));
    }
    return names;
  }
}
