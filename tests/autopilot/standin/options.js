// What can be set of the stand-in. The defaults are the aircraft of the two recordings.

import { px4Parameters } from './px4.js';

const defaults = {
  // Or 'px4': what is otherwise there is in px4.js.
  firmware: 'ardupilot',
  seed: 1,
  step_s: 0.02,
  system_id: 1,
  component_id: 1,
  // UTC at the start of the autopilot.
  start_us: Date.UTC(2026, 5, 1) * 1000,
  home: { latitude_deg: 47.3977, longitude_deg: 8.5456, altitude_m: 430 },
  runway_heading_deg: 90,
  aircraft: {
    // Without power, at the best airspeed, wings level.
    max_glide_ratio: 7.8,
    best_glide_airspeed_mps: 6.75,
    stall_airspeed_mps: 7.8,
    // Thrust by weight at full throttle.
    max_thrust_ratio: 1.43,
    thrust_lag_s: 0.2,
    max_throttle_rate_per_s: 1.0,
    max_bank_rate_deg_s: 70,
    bank_lag_s: 0.35,
    path_lag_s: 0.35,
    takeoff_airspeed_mps: 14,
    // Share of its speed that it loses in a second of rolling.
    roll_decay_per_s: 0.34,
    max_rpm: 7000,
    max_current_a: 47.2,
    idle_current_a: 0,
    battery_ah: 3.3,
  },
  wind: {
    speed_mps: 6,
    from_deg: 70,
    // Below this height above ground there is less of it.
    gradient_height_m: 60,
    gust_sd_mps: 0,
    gust_time_s: 3,
    vertical_gust_sd_mps: 0,
  },
  sensors: {
    position_sd_m: 0.3,
    altitude_sd_m: 0.15,
    // Constant, as of a barometer that was set elsewhere.
    altitude_bias_m: 0,
    velocity_sd_mps: 0.08,
    attitude_sd_deg: 0.2,
    airspeed_sd_mps: 0.12,
    // Of the wind estimate, after it has settled.
    wind_bias_ratio: 0.05,
    wind_bias_deg: 1.5,
    wind_settle_s: 7,
    sends_rpm: true,
    sends_current: true,
    has_airspeed: true,
  },
  // Messages a second; 0 sends none.
  rates_hz: {
    HEARTBEAT: 1, SYSTEM_TIME: 1, ATTITUDE: 5, GLOBAL_POSITION_INT: 5, GPS_RAW_INT: 2, VFR_HUD: 5,
    WIND: 2, WIND_COV: 0, SYS_STATUS: 1, RPM: 1, MISSION_CURRENT: 2, HOME_POSITION: 0.1, CAMERA_FEEDBACK: 0,
  },
  parameters: {
    AIRSPEED_CRUISE: 22, AIRSPEED_MIN: 10, AIRSPEED_MAX: 30, ROLL_LIMIT_DEG: 45, PTCH_LIM_MAX_DEG: 20,
    PTCH_LIM_MIN_DEG: -25, WP_RADIUS: 50, WP_LOITER_RAD: 80, RTL_ALTITUDE: 100, RTL_AUTOLAND: 2,
    RTL_RADIUS: 0, RALLY_LIMIT_KM: 5, RALLY_INCL_HOME: 1, TECS_CLMB_MAX: 5, TECS_SINK_MAX: 5,
    TECS_TIME_CONST: 5, TECS_SPDWEIGHT: 1, TECS_LAND_ARSPD: -1, TECS_LAND_SINK: 0.25, TECS_LAND_TCONST: 2,
    LAND_FLARE_ALT: 3, LAND_FLARE_SEC: 3, LAND_FLARE_AIM: 50, LAND_WIND_COMP: 50, LAND_DISARMDELAY: 20, NAVL1_PERIOD: 12,
    ALT_SLOPE_MIN: 15,
    MIS_TOTAL: 0, MIS_RESTART: 0, SYSID_THISMAV: 1,
    ...px4Parameters,
  },
  // Arming is refused for so long after the start.
  arming_refused_s: 24,
  // Elevation above mean sea level at (east_m, north_m) of home. Nothing: flat, at home's altitude.
  ground: undefined,
};

const isPlain = (value) => value !== null && typeof value === 'object' && value.constructor === Object;

function merged(base, more) {
  const result = { ...base };
  for (const [name, value] of Object.entries(more)) {
    if (value === undefined) continue;
    if (!(name in base)) throw new Error(`unknown option of the stand-in: ${name}`);
    result[name] = isPlain(base[name]) && isPlain(value) ? merged(base[name], value) : value;
  }
  return result;
}

export const standinOptions = (options = {}) => merged(defaults, options);
