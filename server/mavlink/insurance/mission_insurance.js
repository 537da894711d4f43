// Whether a site stays in reach without power on the rest of the mission: the service checks it again
// and again, as the aircraft flies and the map grows.

import { remainingRoute } from './remaining_route.js';

const period_s = 30;
const afterChange_s = 5;
// Of the service's time. A slow one is asked for less of the mission, then less often.
const maxShare = 0.1;
const lookAhead_s = [300, 1800];
const firstLookAhead_s = 600;
const windChange_mps = 1.5;
const maxWindAge_s = 60;
// An older check is none.
const maxAge_s = 180;

const rounded = (value, digits) => Number(value.toFixed(digits));
const pointOf = ({ latitude_deg, longitude_deg, altitude_m }) =>
  ({ latitude_deg: rounded(latitude_deg, 7), longitude_deg: rounded(longitude_deg, 7), altitude_m: rounded(altitude_m, 2) });

function windOf({ wind }) {
  if (!wind || !(wind.age_s <= maxWindAge_s)) return undefined;
  return { east_mps: rounded(wind.east_mps, 2), north_mps: rounded(wind.north_mps, 2),
    ...(wind.sd_mps !== undefined && { sd_mps: rounded(wind.sd_mps, 2) }) };
}

// Why there is nothing to check.
function hindrance({ isConnected, isFlying, mode, missionMode, items, current_item, position, airspeed_mps }) {
  if (!isConnected) return 'the autopilot is silent';
  if (!isFlying) return 'it does not fly';
  if (mode !== missionMode) return `it does not fly its mission (mode ${mode})`;
  if (!items || current_item === undefined) return 'the mission is not known';
  return position && airspeed_mps > 0 ? undefined : 'place or airspeed are not known';
}

export class MissionInsurance {
  #check;
  #log;
  #state = { state: 'waiting' };
  #checked_s;
  #asked;
  #notBefore_s = -Infinity;
  #running;
  #hadGap;
  #lookAhead_s = firstLookAhead_s;

  // check(request): answer of /v1/routes/check. log(text): one decision.
  constructor({ check, log = () => {} }) {
    this.#check = check;
    this.#log = log;
  }

  // vehicle: isConnected, isFlying, mode, missionMode, items, current_item, position, home_altitude_m,
  // airspeed_mps, wind, flight. now_s: a clock that never steps.
  step(now_s, vehicle) {
    const why = hindrance(vehicle);
    if (why) {
      this.#state = { state: 'none', why };
      this.#asked = undefined;
      return undefined;
    }
    if (this.#asked && vehicle.items !== this.#asked.items) this.#asked = undefined;
    if (!this.#asked) this.#state = { state: 'waiting' };
    if (this.#running || now_s < this.#notBefore_s) return this.#running;
    const isDue = !this.#asked || now_s - this.#asked.now_s >= period_s || this.#isChanged(vehicle);
    if (!isDue) return undefined;
    this.#running = this.#ask(now_s, vehicle).finally(() => { this.#running = undefined; });
    return this.#running;
  }

  #isChanged({ flight, ...vehicle }) {
    const { wind: before } = this.#asked;
    const wind = windOf(vehicle);
    const isOtherWind = Boolean(wind) !== Boolean(before) ||
      (wind && Math.hypot(wind.east_mps - before.east_mps, wind.north_mps - before.north_mps) > windChange_mps);
    return flight?.id !== this.#asked.flight || isOtherWind;
  }

  async #ask(now_s, vehicle) {
    const { items, flight, airspeed_mps } = vehicle;
    const wind = windOf(vehicle);
    const asked = { now_s, items, wind, flight: flight?.id };
    this.#asked = asked;
    const begun_ms = performance.now();
    try {
      const { route, ...end } = remainingRoute({ ...vehicle, longest_m: this.#lookAhead_s * airspeed_mps });
      // One point is where the aircraft is.
      const answer = route.length < 2 ? undefined : await this.#check({
        route: route.map(pointOf), altitude_datum: 'amsl', airspeed_mps: rounded(airspeed_mps, 1),
        with_fixes: false, ...(wind && { wind }), ...(flight?.id && { flight: flight.id }) });
      if (this.#asked === asked) this.#take(answer, { now_s, ...end });
    } catch (error) {
      if (this.#asked === asked) this.#state = { ...this.#state, last_error: error.cause?.message ?? error.message };
    }
    const cost_s = (performance.now() - begun_ms) / 1000;
    const affordable_s = (this.#lookAhead_s * period_s * maxShare) / Math.max(cost_s, 0.01);
    this.#lookAhead_s = Math.min(lookAhead_s[1], Math.max(lookAhead_s[0], affordable_s));
    this.#notBefore_s = now_s + cost_s + Math.max(afterChange_s, cost_s / maxShare);
  }

  #take(answer, { now_s, end, isWhole }) {
    this.#checked_s = now_s;
    if (!answer) {
      this.#state = { state: 'none', why: `nothing is left before ${end}` };
      return;
    }
    const { covered_ratio, time_s, gaps, point_of_no_return: noReturn } = answer;
    this.#state = { state: 'checked', time_s, end, gaps: gaps.map(({ from_s, to_s, reason }) => ({ from_s, to_s, reason })),
      // Beyond what was looked at there may be sites again.
      no_return_s: isWhole ? noReturn?.time_s : undefined };
    const hasGap = gaps.length > 0;
    if (hasGap !== this.#hadGap) {
      const what = `the next ${Math.round(time_s)} s, to ${end}`;
      this.#log(hasGap ? `no site, verified or not, is in reach for ${Math.ceil((1 - covered_ratio) * time_s)} s of ${what}`
        : `a site, verified or not, is in reach on all of ${what}`);
    }
    this.#hadGap = hasGap;
  }

  // As `insurance` of the link's state. Times count from now, and so does the covered ratio.
  state(now_s) {
    const { state, why, last_error, end, gaps, time_s, no_return_s } = this.#state;
    if (state !== 'checked') return { state, why, last_error };
    const age_s = now_s - this.#checked_s;
    if (!(age_s < Math.min(maxAge_s, time_s))) return { state: 'none', why: `the last check is ${Math.round(age_s)} s old`, last_error };
    const ahead = gaps.filter(({ to_s }) => to_s > age_s)
      .map(({ from_s, to_s, reason }) => ({ in_s: Math.max(0, from_s - age_s), lasts_s: to_s - Math.max(from_s, age_s), reason }));
    const left_s = time_s - age_s;
    return {
      state, last_error, covered_ratio: 1 - ahead.reduce((sum, { lasts_s }) => sum + lasts_s, 0) / left_s, time_s: left_s, end, age_s,
      first_gap: ahead[0], num_gaps: ahead.length,
      point_of_no_return_in_s: no_return_s === undefined ? undefined : no_return_s - age_s,
    };
  }
}
