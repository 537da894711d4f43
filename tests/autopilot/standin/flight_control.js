// Modes of ArduPlane: from what the aircraft believes to bank, flight path and throttle.

import { clamp, distance } from './frame.js';
import { EnergyControl } from './energy.js';
import { MissionFlight } from './mission_flight.js';
import { bankForCircle, bankForLeg, bankLimit_rad } from './navigation.js';

const radians = (degrees) => (degrees * Math.PI) / 180;
export const modeNumber = { MANUAL: 0, CIRCLE: 1, STABILIZE: 2, FBWA: 5, FBWB: 6, CRUISE: 7, AUTO: 10, RTL: 11,
  LOITER: 12, GUIDED: 15 };
const modeNames = Object.fromEntries(Object.entries(modeNumber).map(([name, number]) => [number, name]));

export class FlightControl {
  #plane;
  #energy;
  #circle;
  #guidedSpeed_mps;
  cruise_mps;
  mission;
  mode = 'MANUAL';
  isArmed = false;
  // What the pilot's sticks demand in MANUAL and FBWA.
  pilot = { bank_rad: 0, path_rad: 0, throttle: 0 };

  // plane: now(), parameters, items(), placeOf(item), homeAltitude_m(), text(), reached(), rallyPlaces(), home().
  constructor(plane) {
    this.#plane = plane;
    this.#energy = new EnergyControl(plane.parameters);
    this.cruise_mps = plane.parameters.AIRSPEED_CRUISE;
    this.mission = new MissionFlight({
      ...plane,
      changeSpeed: (item) => this.changeSpeed(item.param1, item.param2),
      complete: () => {
        if (this.mode !== 'AUTO') return;
        plane.text('Mission complete, changing mode to RTL');
        this.setMode('RTL');
      },
      returnToLaunch: () => this.setMode('RTL'),
    });
  }

  get modeNumber() { return modeNumber[this.mode]; }

  setModeNumber(number) { return modeNames[number] ? this.setMode(modeNames[number]) : false; }

  setMode(name) {
    if (!(name in modeNumber)) return false;
    if (name === 'AUTO' && this.#plane.items().length < 2) return false;
    if (name === this.mode) return true;
    this.mode = name;
    this.#guidedSpeed_mps = undefined;
    this.#circle = undefined;
    this.#resetEnergy();
    if (name === 'AUTO') this.mission.resume();
    else this.mission.stop();
    if (['LOITER', 'GUIDED', 'CIRCLE'].includes(name)) this.goTo({ ...this.#plane.now() });
    if (name === 'RTL') this.#returnHome();
    return true;
  }

  #resetEnergy() {
    const { altitude_m, path_rad } = this.#plane.now();
    this.#energy.reset(altitude_m, path_rad);
  }

  // The DO_LAND_START of the mission, in AUTO.
  land() {
    const index = this.mission.landingStart();
    if (index === undefined) return false;
    if (this.mode !== 'AUTO') {
      this.mode = 'AUTO';
      this.#resetEnergy();
    }
    this.mission.start(index);
    this.#plane.text('Landing sequence start');
    return true;
  }

  setCurrent(index) {
    if (index >= this.#plane.items().length) return false;
    if (this.mode === 'AUTO') this.mission.start(Math.max(1, index));
    else this.mission.select(index);
    return true;
  }

  // Circles about a place: with altitude_m; radius_m and direction may be missing. The demanded
  // altitude falls along the way if it is far to fall; else it changes at once.
  goTo(place, radius_m, direction) {
    const now = this.#plane.now();
    const { WP_LOITER_RAD } = this.#plane.parameters;
    this.#circle = {
      centre: place,
      radius_m: radius_m > 0 ? radius_m : Math.abs(WP_LOITER_RAD),
      direction: direction ?? (WP_LOITER_RAD < 0 ? -1 : 1),
      start_m: distance(now, place), startAltitude_m: now.altitude_m,
    };
  }

  get guidedPlace() { return this.mode === 'GUIDED' ? this.#circle?.centre : undefined; }

  // speedType 0: airspeed.
  changeSpeed(speedType, speed_mps) {
    const { AIRSPEED_MIN, AIRSPEED_MAX } = this.#plane.parameters;
    if (speedType !== 0 || speed_mps < AIRSPEED_MIN || speed_mps > AIRSPEED_MAX) return false;
    this.cruise_mps = speed_mps;
    return true;
  }

  changeGuidedSpeed(speed_mps) { this.#guidedSpeed_mps = speed_mps; }

  #returnHome() {
    const { RTL_AUTOLAND } = this.#plane.parameters;
    if (RTL_AUTOLAND === 2 && this.mission.landingStart() !== undefined) {
      this.land();
      return;
    }
    const now = this.#plane.now();
    const places = [...this.#plane.rallyPlaces(), this.#plane.home()];
    const nearest = places.reduce((best, one) => (distance(now, one) < distance(now, best) ? one : best));
    this.goTo(nearest, this.#plane.parameters.RTL_RADIUS);
  }

  // bank_rad, path_rad, throttle.
  step(duration_s) {
    const now = this.#plane.now();
    const idle = { bank_rad: 0, path_rad: 0, throttle: 0 };
    if (!this.isArmed) return idle;
    if (this.mode === 'MANUAL' || this.mode === 'FBWA' || this.mode === 'STABILIZE') return this.#byPilot(now);
    if (this.mode === 'FBWB' || this.mode === 'CRUISE') return this.#byPilotAtHeight(duration_s, now);
    const target = this.mode === 'AUTO' ? this.mission.step(duration_s) : this.#circleTarget(now);
    if (!target) return idle;
    const bank_rad = this.#bankFor(target, now);
    if (target.path_rad !== undefined) {
      this.#energy.reset(now.altitude_m, now.path_rad);
      return { bank_rad, path_rad: target.path_rad, throttle: target.throttle ?? target.maxThrottle ?? 0 };
    }
    return { bank_rad, ...this.#vertical(duration_s, target, now) };
  }

  #vertical(duration_s, target, now) {
    const cruise_mps = (this.mode === 'GUIDED' && this.#guidedSpeed_mps) || this.cruise_mps;
    return this.#energy.step(duration_s, { airspeed_mps: cruise_mps, ...target }, now);
  }

  #circleTarget(now) {
    const { centre, radius_m, direction, start_m, startAltitude_m } = this.#circle;
    const onWay_m = distance(now, centre) - radius_m;
    const left = start_m > radius_m + 1 ? clamp(onWay_m / (start_m - radius_m), 0, 1) : 0;
    const fall_m = startAltitude_m - centre.altitude_m;
    const slope_m = fall_m < this.#plane.parameters.ALT_SLOPE_MIN ? 0 : fall_m * left;
    return { circle: { centre, radius_m, direction }, altitude_m: centre.altitude_m + slope_m };
  }

  #bankFor(target, now) {
    const limit_rad = Math.min(bankLimit_rad(now.airspeed_mps, this.#plane.parameters), target.maxBank_rad ?? 2);
    let bank_rad = target.bank_rad ?? 0;
    if (target.circle) {
      const { centre, radius_m, direction } = target.circle;
      bank_rad = bankForCircle(now, now.velocity, centre, radius_m, direction);
    } else if (target.leg) {
      const [from, to] = target.leg;
      bank_rad = bankForLeg(now, now.velocity, from, to, this.#plane.parameters.NAVL1_PERIOD);
    }
    return clamp(bank_rad, -limit_rad, limit_rad);
  }

  #byPilot(now) {
    const { ROLL_LIMIT_DEG, PTCH_LIM_MAX_DEG, PTCH_LIM_MIN_DEG } = this.#plane.parameters;
    const limit_rad = Math.min(radians(ROLL_LIMIT_DEG), bankLimit_rad(now.airspeed_mps, this.#plane.parameters));
    return {
      bank_rad: clamp(this.pilot.bank_rad, -limit_rad, limit_rad),
      path_rad: clamp(this.pilot.path_rad, radians(PTCH_LIM_MIN_DEG), radians(PTCH_LIM_MAX_DEG)),
      throttle: clamp(this.pilot.throttle, 0, 1),
    };
  }

  // Height is held, the throttle with it; the sticks turn and climb.
  #byPilotAtHeight(duration_s, now) {
    this.pilot.altitude_m ??= now.altitude_m;
    this.pilot.altitude_m += 5 * clamp(this.pilot.path_rad, -1, 1) * duration_s;
    const limit_rad = bankLimit_rad(now.airspeed_mps, this.#plane.parameters);
    const bank_rad = clamp(this.pilot.bank_rad, -limit_rad, limit_rad);
    return { bank_rad, ...this.#vertical(duration_s, { altitude_m: this.pilot.altitude_m }, now) };
  }
}

