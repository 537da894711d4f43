// Reads parameters of the autopilot. It never writes one.

const repeat_s = 1.5;
const numTries = 10;
const longestName = 16;

// Of ArduPlane: how it lands, and whether it begins a mission anew in AUTO. Two names are of the same value, in new and old
// versions.
export const landingParameters = ['TECS_LAND_ARSPD', 'TECS_LAND_SINK', 'LAND_FLARE_SEC', 'LAND_FLARE_ALT',
  'LAND_FLARE_AIM', 'WP_LOITER_RAD', 'AIRSPEED_CRUISE', 'AIRSPEED_MIN', 'TRIM_ARSPD_CM', 'ARSPD_FBW_MIN',
  'MIS_RESTART'];

// Of PX4: how steep and how fast it lands.
export const px4Parameters = ['FW_LND_ANG', 'FW_LND_AIRSPD', 'FW_AIRSPD_MIN'];

export class ParameterReader {
  #out;
  #wanted;
  #tries = new Map();
  #next_s = -Infinity;
  values = {};

  constructor(out, names = landingParameters) {
    this.#out = out;
    this.#wanted = new Set(names);
  }

  // Other ones than before.
  want(names) { this.#wanted = new Set(names); }

  // The autopilot may be another one, or have other values.
  restart() {
    this.#tries.clear();
    this.values = {};
  }

  hear({ paramId, paramValue }) {
    const name = paramId.slice(0, longestName).replace(/\0.*$/, '');
    if (this.#wanted.has(name) && Number.isFinite(paramValue)) this.values[name] = paramValue;
  }

  step(now_s) {
    if (now_s < this.#next_s) return;
    const isMissing = (name) => this.values[name] === undefined && (this.#tries.get(name) ?? 0) < numTries;
    const missing = [...this.#wanted].filter(isMissing);
    if (missing.length === 0) return;
    this.#next_s = now_s + repeat_s;
    for (const name of missing) {
      this.#tries.set(name, (this.#tries.get(name) ?? 0) + 1);
      this.#out.send('PARAM_REQUEST_READ', { paramId: name, paramIndex: -1 });
    }
  }

  get cruise_mps() {
    const { AIRSPEED_CRUISE, TRIM_ARSPD_CM } = this.values;
    return AIRSPEED_CRUISE ?? (TRIM_ARSPD_CM === undefined ? undefined : TRIM_ARSPD_CM / 100);
  }

  // Without TECS_LAND_ARSPD, ArduPlane lands half way between its lowest and its usual airspeed.
  get landingAirspeed_mps() {
    const { FW_LND_AIRSPD, FW_AIRSPD_MIN } = this.values;
    // PX4: its lowest airspeed, if it is not set.
    if (FW_LND_AIRSPD !== undefined) return FW_LND_AIRSPD > 0 ? FW_LND_AIRSPD : FW_AIRSPD_MIN;
    const { TECS_LAND_ARSPD, AIRSPEED_MIN, ARSPD_FBW_MIN } = this.values;
    if (TECS_LAND_ARSPD === undefined) return undefined;
    if (TECS_LAND_ARSPD > 0) return TECS_LAND_ARSPD;
    const { cruise_mps } = this;
    const min_mps = AIRSPEED_MIN ?? ARSPD_FBW_MIN;
    return cruise_mps === undefined || min_mps === undefined ? undefined : (cruise_mps + min_mps) / 2;
  }
}
