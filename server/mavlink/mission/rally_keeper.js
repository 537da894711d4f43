// Rally points at the best sites in reach, if the operator wants them (--rally): the places to which
// an autopilot returns by itself.

import { MavCmd, MavFrame, MavMissionType } from '../messages.js';
import { changeItems, outcome, Task } from './mission_change.js';
import { areSame, item } from './mission_items.js';

const ask_s = 30;
const maxNumPoints = 5;
// As in the service's rally files: the circle at a rally point is of the autopilot.
const rallyHeight_m = 100;

// sites: of an answer of /v1/emergency. ArduPilot stores whole metres above home.
function rallyItems(sites, home_altitude_m) {
  const isFit = ({ reachable, verdict, altitude_datum, airspaces }) =>
    reachable !== false && verdict === 'landable' && altitude_datum === 'amsl' && !airspaces?.length;
  return sites.filter(isFit)
    .slice(0, maxNumPoints)
    .map(({ touchdown }) => item(MavCmd.NAV_RALLY_POINT,
      { ...touchdown, altitude_m: Math.ceil(touchdown.altitude_m - home_altitude_m + rallyHeight_m) }, [], MavFrame.GLOBAL_RELATIVE_ALT));
}

export class RallyKeeper {
  #out;
  #recall;
  #log;
  #task;
  #sites;
  #isAsking = false;
  #asked_s = -Infinity;
  #points;
  alarm;

  // recall(): a promise of an answer of /v1/emergency for the present state, or nothing.
  constructor({ out, recall, log }) {
    this.#out = out;
    this.#recall = recall;
    this.#log = log;
  }

  get isBusy() { return this.#task !== undefined; }
  get numPoints() { return this.#points?.length; }

  hear(name, fields, now_s) {
    if (!fields.isForeign) this.#task?.hear(name, fields, now_s);
  }

  // mayWrite: no other transfer runs, and the aircraft is not on a final.
  step(now_s, { mayWrite, home_altitude_m }) {
    this.#task?.step(now_s);
    if (this.#task || !mayWrite || home_altitude_m === undefined) return;
    if (this.#sites) {
      const items = rallyItems(this.#sites, home_altitude_m);
      this.#sites = undefined;
      // No site in reach: the former points stay, because without any the autopilot returns home.
      if (items.length && !(this.#points && areSame(items, this.#points))) this.#write(items);
      return;
    }
    if (this.#isAsking || now_s - this.#asked_s < ask_s) return;
    this.#asked_s = now_s;
    this.#isAsking = true;
    Promise.resolve(this.#recall()).then((answer) => { this.#sites = answer?.sites; }, () => {})
      .finally(() => { this.#isAsking = false; });
  }

  #write(items) {
    this.#task = new Task(changeItems({
      out: this.#out, type: MavMissionType.RALLY, rules: {}, wantedFrom: () => items, onWrite: () => {},
      onTrouble: (why) => {
        this.alarm = `it is not known which rally points the autopilot has: ${why}`;
      },
    }), ({ outcome: how, items: found, why }) => {
      this.#task = undefined;
      this.#points = found;
      if (how !== outcome.done) {
        this.#log(`the rally points could not be written: ${why ?? how}`);
        return;
      }
      this.alarm = undefined;
      this.#log(`${found.length} rally points at the best sites in reach`);
    });
  }
}
