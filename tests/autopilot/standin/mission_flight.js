// Flies the items of a mission, one after the other, as ArduPlane's AUTO.

import { bearing, clamp, distance, wrapped } from './frame.js';
import { command, isNavigation } from './items.js';
import { Landing } from './landing.js';
import { onLeg } from './navigation.js';

const radians = (degrees) => (degrees * Math.PI) / 180;
const linedUp_rad = radians(10);
const altitudeReached_m = 5;
const maxNumSkipped = 1000;

export class MissionFlight {
  #plane;
  #index = 0;
  #item;
  #from;
  #to;
  #loiter;
  #landing;
  #jumps = new Map();

  // plane: items(), placeOf(item), parameters, now() (place, velocity, height above ground and so
  // on), firstItem (1 if item 0 is home), text(sentence), reached(index), changeSpeed(item), complete().
  constructor(plane) { this.#plane = plane; }

  get index() { return this.#index; }
  get isLanding() { return this.#item?.command === command.land; }
  get isFlaring() { return this.#landing?.isFlaring ?? false; }
  get isTakingOff() { return this.#item?.command === command.takeoff; }
  get landPoint() { return this.isLanding ? this.#to : undefined; }
  get hasItem() { return this.#item !== undefined; }

  start(index) {
    // After a change of mode or of the current item, the leg begins where the aircraft is.
    this.#to = undefined;
    this.#loiter = undefined;
    this.#jumps.clear();
    this.#begin(index);
  }

  resume() {
    const first = this.#plane.firstItem;
    const isAnew = this.#plane.parameters.MIS_RESTART === 1;
    if (isAnew || this.#index < first || this.#index >= this.#plane.items().length) this.start(first);
    else this.start(this.#index);
  }

  // Where resume() begins.
  select(index) { this.#index = index; }

  stop() { this.#item = undefined; }

  // The list has become shorter.
  onTruncate(count) {
    if (this.#index < count) return;
    const wasFlying = this.#item !== undefined;
    this.#item = undefined;
    this.#index = 0;
    if (wasFlying) this.#plane.complete();
  }

  landingStart() {
    const items = this.#plane.items();
    const index = items.findIndex((item, i) => i >= this.#plane.firstItem && item.command === command.landStart);
    return index < 0 ? undefined : index;
  }

  // The target: leg or circle, altitude and airspeed; nothing if the mission has ended.
  step(duration_s) {
    if (!this.#item) return undefined;
    const now = this.#plane.now();
    const target = this.#targets[this.#item.command].call(this, now, duration_s);
    if (target !== 'reached') return target;
    this.#plane.reached(this.#index);
    this.#begin(this.#index + 1);
    return this.#item ? this.step(0) : undefined;
  }

  #begin(first) {
    const items = this.#plane.items();
    let index = first;
    for (let i = 0; i < maxNumSkipped && index < items.length; ++i) {
      const item = items[index];
      if (isNavigation(item.command) && this.#targets[item.command]) {
        this.#startItem(index, item);
        return;
      }
      index = this.#do(index, item);
    }
    this.#item = undefined;
    this.#plane.complete();
  }

  // A command that takes no time. Gives the index of the next item.
  #do(index, item) {
    this.#index = index;
    this.#plane.reached(index);
    if (item.command === command.changeSpeed) this.#plane.changeSpeed(item);
    if (item.command !== command.jump) return index + 1;
    const left = this.#jumps.get(index) ?? item.param2;
    if (left === 0) return index + 1;
    this.#jumps.set(index, left > 0 ? left - 1 : left);
    return item.param1;
  }

  #startItem(index, item) {
    const now = this.#plane.now();
    // A circle with the exit bit ends where the aircraft is.
    this.#from = this.#loiter?.leavesHere || !this.#to ? { ...now } : this.#to;
    if (distance(now, this.#from) > 2000) this.#from = { ...now };
    this.#index = index;
    this.#item = item;
    this.#to = this.#plane.placeOf(item);
    const circles = { [command.loiterUnlimited]: item.param3, [command.loiterToAltitude]: item.param2,
      [command.loiterTurns]: item.param3, [command.loiterTime]: item.param3 };
    const radius = circles[item.command];
    this.#loiter = radius === undefined ? undefined : this.#newLoiter(item, radius, now);
    this.#landing = item.command === command.land ? new Landing(this.#plane.parameters) : undefined;
    if (this.#landing) this.#plane.text(`Landing approach start at ${(now.altitude_m - this.#plane.homeAltitude_m()).toFixed(1)}m`);
  }

  #newLoiter(item, radius, now) {
    const { WP_LOITER_RAD } = this.#plane.parameters;
    const isDefault = Math.abs(radius) <= 1;
    return {
      radius_m: isDefault ? Math.abs(WP_LOITER_RAD) : Math.abs(radius),
      direction: radius < 0 ? -1 : 1,
      leavesHere: item.param4 > 0,
      turned_rad: 0, lap: 0, lapAltitude_m: now.altitude_m, hasAltitude: false, time_s: 0,
      courseBefore_rad: undefined,
    };
  }

  #targets = {
    [command.waypoint]: this.#waypoint,
    [command.takeoff]: this.#takeoff,
    [command.land]: this.#land,
    [command.loiterUnlimited]: (now) => this.#circle(now),
    [command.loiterTime]: this.#loiterTime,
    [command.loiterTurns]: this.#loiterTurns,
    [command.loiterToAltitude]: this.#loiterToAltitude,
    [command.returnToLaunch]: () => { this.#plane.returnToLaunch(); return undefined; },
  };

  #waypoint(now) {
    const leg = onLeg(now, this.#from, this.#to);
    const distance_m = distance(now, this.#to);
    if (distance_m <= this.#acceptance_m() || leg.along_m >= leg.length_m) {
      this.#plane.text(`Reached waypoint #${this.#index} dist ${Math.floor(distance_m)}m`);
      return 'reached';
    }
    return { leg: [this.#from, this.#to], altitude_m: this.#altitudeAlong(leg.share) };
  }

  #altitudeAlong(share) {
    return this.#from.altitude_m + clamp(share, 0, 1) * (this.#to.altitude_m - this.#from.altitude_m);
  }

  #acceptance_m() {
    if (this.#item.param2 > 0) return this.#item.param2;
    const next = this.#nextPlace();
    const turn_rad = next ? Math.abs(wrapped(bearing(this.#to, next) - bearing(this.#from, this.#to))) : Math.PI / 2;
    return this.#plane.parameters.WP_RADIUS * clamp(turn_rad / (Math.PI / 2), 0.25, 1);
  }

  #nextPlace() {
    const items = this.#plane.items();
    const next = items.findIndex((item, i) => i > this.#index && isNavigation(item.command));
    return next < 0 ? undefined : this.#plane.placeOf(items[next]);
  }

  #takeoff(now) {
    if (now.altitude_m >= this.#to.altitude_m) {
      this.#plane.text(`Takeoff complete at ${(now.altitude_m - this.#plane.homeAltitude_m()).toFixed(2)}m`);
      this.#to = { ...now };
      return 'reached';
    }
    const climb_rad = radians(this.#item.param1 > 0 ? this.#item.param1 : 10);
    return { bank_rad: 0, path_rad: now.airspeed_mps < this.#plane.parameters.AIRSPEED_MIN ? 0 : climb_rad, throttle: 1 };
  }

  #land(now) {
    const { east_mps, north_mps } = now.velocity;
    const course_rad = bearing(this.#from, this.#to);
    const headwind_mps = -(now.wind.east_mps * Math.sin(course_rad) + now.wind.north_mps * Math.cos(course_rad));
    const wasFlaring = this.#landing.isFlaring;
    const target = this.#landing.step(now, this.#from, this.#to, {
      groundSpeed_mps: Math.max(0.5, Math.hypot(east_mps, north_mps)), sink_mps: -now.climb_mps, headwind_mps, power_ratio: now.power_ratio });
    if (this.#landing.isFlaring && !wasFlaring) {
      this.#plane.text(`Flare ${(now.altitude_m - this.#to.altitude_m).toFixed(1)}m sink=${(-now.climb_mps).toFixed(2)} ` +
        `speed=${Math.hypot(east_mps, north_mps).toFixed(1)} dist=${distance(now, this.#to).toFixed(1)}`);
    }
    // The point aimed at stays ahead, also beyond the LAND point.
    const leg = onLeg(now, this.#from, this.#to);
    const ahead_m = Math.max(leg.length_m, leg.along_m + 200);
    const far = { east_m: this.#from.east_m + ahead_m * Math.sin(course_rad),
      north_m: this.#from.north_m + ahead_m * Math.cos(course_rad) };
    return { leg: [this.#from, far], ...target };
  }

  #circle(now) {
    const loiter = this.#loiter;
    const { east_mps, north_mps } = now.velocity;
    const course_rad = Math.atan2(east_mps, north_mps);
    const distance_m = distance(now, this.#to);
    const isOnCircle = distance_m < loiter.radius_m * 1.25 + 20;
    if (isOnCircle && loiter.courseBefore_rad !== undefined) {
      loiter.turned_rad += loiter.direction * wrapped(course_rad - loiter.courseBefore_rad);
    }
    loiter.courseBefore_rad = isOnCircle ? course_rad : undefined;
    const start_m = distance(this.#from, this.#to);
    const share = start_m > loiter.radius_m ? 1 - clamp(distance_m / start_m, 0, 1) : 1;
    return { circle: { centre: this.#to, radius_m: loiter.radius_m, direction: loiter.direction },
      altitude_m: isOnCircle ? this.#to.altitude_m : this.#altitudeAlong(share) };
  }

  #loiterTime(now, duration_s) {
    const target = this.#circle(now);
    if (this.#loiter.turned_rad > 0) this.#loiter.time_s += duration_s;
    return this.#loiter.time_s > this.#item.param1 && this.#isLinedUp(now) ? 'reached' : target;
  }

  #loiterTurns(now) {
    const target = this.#circle(now);
    return this.#loiter.turned_rad > 2 * Math.PI * this.#item.param1 && this.#isLinedUp(now) ? 'reached' : target;
  }

  #loiterToAltitude(now) {
    const target = this.#circle(now);
    const loiter = this.#loiter;
    const hasBegun = Math.abs(loiter.turned_rad) > radians(0.01);
    if (hasBegun && !loiter.hasAltitude) {
      loiter.hasAltitude = Math.abs(now.altitude_m - this.#to.altitude_m) < altitudeReached_m || this.#isStuck(now);
    }
    if (!loiter.hasAltitude || !this.#isLinedUp(now)) return target;
    this.#plane.text('Loiter to alt complete');
    return 'reached';
  }

  // A whole turn without a change of altitude.
  #isStuck(now) {
    const loiter = this.#loiter;
    const lap = Math.floor(Math.abs(loiter.turned_rad) / (2 * Math.PI));
    if (lap <= loiter.lap) return false;
    loiter.lap = lap;
    const change_m = Math.abs(now.altitude_m - loiter.lapAltitude_m);
    loiter.lapAltitude_m = now.altitude_m;
    return change_m < altitudeReached_m;
  }

  #isLinedUp(now) {
    const next = this.#nextPlace();
    if (!next || distance(this.#to, next) < Math.abs(this.#plane.parameters.WP_LOITER_RAD) * 1.05) return true;
    const { east_mps, north_mps } = now.velocity;
    const error_rad = Math.abs(wrapped(bearing(now, next) - Math.atan2(east_mps, north_mps)));
    const laps = Math.floor(Math.abs(this.#loiter.turned_rad) / (2 * Math.PI));
    return error_rad <= linedUp_rad * (1 + laps);
  }
}

