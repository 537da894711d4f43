// The landing mission in the autopilot: puts it there, knows whether it is there, and starts it.
// No sockets and no clock: step(now_s), hear(name, fields, now_s), and what it sends goes to `out`.

import { MavCmd, MavMissionResult, MavMissionType } from '../messages.js';
import { ardupilotItems, landingOfRecall, NoLanding, px4Items } from './landing_items.js';
import { LandingStart } from './landing_start.js';
import { warningsOf } from './landing_warnings.js';
import { changeItems, finishChange, outcome, Task } from './mission_change.js';
import { areSame, item } from './mission_items.js';
import { Download } from './item_transfer.js';

const requests = new Set(['MISSION_REQUEST', 'MISSION_REQUEST_INT']);
// Somebody else's upload may still run when its first sign is heard.
const suspicion_s = 1.5;
const ownUpload_s = 5;
const recheck_s = 30;
const reread_s = 10;
// How often it is asked whether somebody writes: while a list is written, ArduPilot denies to tell its length.
const probe_s = 1;

const alarmOf = {
  trouble: (why) => `it is not known which mission the autopilot has: ${why}`,
  restored: 'the landing mission could not be written; the former mission is back',
  foreign: 'another ground station has changed the mission',
};

export class MissionKeeper {
  #out;
  #vehicle;
  #log;
  #store;
  #told;
  #task;
  #job;
  #now_s = 0;
  #known;
  // The last one that was written: items, site, warning.
  #landing;
  #state = { state: 'unknown' };
  #isWritten_s = -Infinity;
  #suspect_s;
  // Another ground station writes, or has written.
  #isForeign = false;
  #checked_s = -Infinity;
  #probed_s = -Infinity;
  #total;
  #start;
  // An alarm that stays until the next landing is wanted, Release or disarming.
  #lasting;

  // out.send(name, fields): with the autopilot's address. vehicle(): what the link knows: isArdupilot,
  // isFlying, mode, missionMode, home_altitude_m, parameters, landing_airspeed_mps, current_item.
  // log(text): one decision. told(id, state, detail): what became of a command.
  // store: load(), save(value), clear() of a change that is under way.
  constructor({ out, vehicle, log, told = () => {}, store = { load() {}, save() {}, clear() {} } }) {
    this.#out = out;
    this.#vehicle = vehicle;
    this.#log = log;
    this.#told = told;
    this.#store = store;
    this.#start = new LandingStart({ out, vehicle, log, told });
  }

  // While it is true, the mission is not read again: guidance is on the final.
  isHeld = false;

  get isBusy() { return this.#task !== undefined || this.#start.isWaiting; }
  // What the autopilot has, as it was read last; nothing while that is not known.
  get items() { return this.#state.state === 'current' ? this.#known?.items : undefined; }

  // The landing to this site was read back from the autopilot, and nothing tells that somebody has written
  // since. Silence of a weak radio is no such sign: an aircraft without an engine must not miss its final for it.
  hasLanding(site) {
    return this.#known?.site === site && !this.#job && !this.#isForeign;
  }

  // As `mission` of the link's state.
  state() { return { ...this.#state, current_item: this.#vehicle().current_item, num_items: this.#known?.items.length }; }

  // A person's command. landing: as of landing_items.js. order.wasModeChanged: since the command.
  land(commandId, landing, order) {
    this.#begin({ landing, keepsOthers: true, finish: (isThere, why) => {
      const hindrance = !this.#vehicle().isFlying ? 'it does not fly' : order.wasModeChanged ? 'the mode was changed' : undefined;
      if (!isThere) this.#told(commandId, 'failed', why);
      else if (hindrance) this.#told(commandId, 'done', `in the autopilot; not started, because ${hindrance}`);
      else this.#start.begin(commandId, landing.site_id);
    } });
  }

  // For guidance: resolves when the landing mission is in the autopilot and its LAND is the current
  // item. site: of an answer of /v1/emergency.
  prepare(site) {
    return new Promise((resolve, reject) => {
      this.#begin({ landing: landingOfRecall(site), keepsOthers: false, trustsKnown: true, finish: (isThere, why) => {
        if (!isThere) {
          reject(new Error(why));
          return;
        }
        this.#out.send('MISSION_SET_CURRENT', { seq: this.#known.items.length - 1 });
        resolve();
      } });
    });
  }

  // The last word: nothing is started any more, and what is not written yet will not be.
  end(why) {
    this.#start.end(why);
    this.#giveUp(why);
  }

  // What was told of a mission that is past.
  forgetAlarm() {
    this.#lasting = undefined;
    if (this.#state.state === 'current') this.#know(this.#known.items);
  }

  // Guidance is over.
  abandon(why) { if (this.#job && !this.#job.keepsOthers) this.#giveUp(why); }

  // What is being written is ended, or the former mission is written back.
  #giveUp(why) {
    const job = this.#job;
    if (!job) return;
    job.finish(false, why);
    job.finish = () => {};
    if (job.wanted) return;
    this.#job = undefined;
    this.#task = undefined;
    this.#log(`no landing mission: ${why}`);
    if (job.old) {
      this.#finishLeft({ ...job, wanted: job.earlier.at(-1), site: job.landing.site_id });
      return;
    }
    if (job.wasKnown && this.#suspect_s === undefined) this.#know(this.#known.items);
    else this.#state = { state: 'unknown' };
    this.#checked_s = -Infinity;
  }

  #begin({ landing, keepsOthers, trustsKnown = false, finish }) {
    const left = this.#job ?? this.#store.load();
    this.#job?.finish(false, 'another landing was wanted');
    const job = { finish, landing, keepsOthers, old: left?.old, wanted: undefined,
      wasKnown: this.#job ? this.#job.wasKnown : this.#state.state === 'current',
      earlier: [...(left?.earlier ?? []), ...(left?.wanted ? [left.wanted] : [])] };
    this.#job = job;
    this.#start.end('another landing was wanted');
    this.#lasting = undefined;
    this.#state = { state: 'uploading', site: landing.site_id, kind: 'landing' };
    this.#task = new Task(changeItems({
      out: this.#out, type: MavMissionType.MISSION, rules: this.#rules(), base: job.old, earlier: job.earlier,
      known: trustsKnown && this.#suspect_s === undefined && !left ? this.#known?.items : undefined,
      wantedFrom: (old) => (keepsOthers && this.#whyNot(old)) || this.#missionWith(landing, keepsOthers ? old : old.slice(0, Number(this.#vehicle().isArdupilot))),
      // The item that is flown would end, and the autopilot return to launch.
      mayWrite: () => keepsOthers || !this.#fliesMission,
      flownItem: () => this.#flownItem,
      onWrite: ({ old, wanted }) => {
        Object.assign(job, { old, wanted });
        this.#isWritten_s = this.#now_s;
        this.#store.save({ old, wanted, earlier: job.earlier, site: landing.site_id });
      },
      onTrouble: (why) => this.#alarm(alarmOf.trouble(why)),
    }), (end) => this.#end(job, end));
  }

  #rules() { return { hasHome: this.#vehicle().isArdupilot }; }

  get #fliesMission() {
    const { isFlying, mode, missionMode } = this.#vehicle();
    return isFlying && mode === missionMode;
  }

  // ArduPilot stays at the item of the same number.
  get #flownItem() {
    const { isArdupilot, current_item } = this.#vehicle();
    return !isArdupilot && this.#fliesMission ? current_item : undefined;
  }

  // Its own landing sequence would be replaced under it.
  #whyNot(old) {
    const landingAt = old.findIndex((one) => one.command === MavCmd.DO_LAND_START);
    const isLanding = this.#fliesMission && landingAt >= 0 && this.#vehicle().current_item >= landingAt;
    return isLanding ? 'the autopilot flies a landing sequence: take another mode first' : undefined;
  }

  // The items before a landing sequence stay as they are, so that what is flown stays in place. A sentence if
  // this autopilot does not take the landing.
  #missionWith(landing, old) {
    const { isArdupilot, parameters, home_altitude_m, landing_airspeed_mps } = this.#vehicle();
    let ours;
    try {
      ours = isArdupilot ? ardupilotItems(landing, { parameters, home_altitude_m, landing_airspeed_mps }) : px4Items(landing, { parameters });
    } catch (error) {
      if (error instanceof NoLanding) return error.message;
      throw error;
    }
    const landingAt = old.findIndex((one) => one.command === MavCmd.DO_LAND_START);
    const before = landingAt < 0 ? old : old.slice(0, landingAt);
    if (isArdupilot && before.length === 0) return [item(MavCmd.NAV_WAYPOINT), ...ours];
    return [...before, ...ours];
  }

  #end(job, { outcome: how, items, why }) {
    this.#task = undefined;
    this.#job = undefined;
    this.#store.clear();
    this.#checked_s = this.#now_s;
    this.#total = undefined;
    if (how === outcome.done) {
      this.#landing = { items, site: job.landing.site_id, warning: this.#warned(job.landing) };
      this.#know(items);
      this.#log(`the landing mission to ${job.landing.site_id} is in the autopilot, read back equal`);
      job.finish(true);
      return;
    }
    this.#lasting = { [outcome.foreign]: alarmOf.foreign, [outcome.restored]: alarmOf.restored }[how];
    if (items) this.#know(items);
    else this.#state = { state: 'unknown', alarm: alarmOf.trouble(why) };
    this.#log(`no landing mission: ${[why, this.#lasting].filter(Boolean).join('; ')}`);
    job.finish(false, why ?? this.#lasting);
  }

  #warned(landing) {
    const warnings = warningsOf(landing, this.#vehicle());
    warnings.forEach((text) => this.#log(text));
    return warnings.join('; ') || undefined;
  }

  // What the autopilot has was read, and whether it is the last landing that was written. While it stays
  // the same, `items` stays the same array.
  #know(read) {
    const items = this.#known && areSame(read, this.#known.items, this.#rules()) ? this.#known.items : read;
    const { items: ours, site, warning } = this.#landing ?? {};
    const isLanding = ours !== undefined && areSame(items, ours, this.#rules());
    this.#known = { items, site: isLanding ? site : undefined };
    this.#isForeign = false;
    this.#state = {
      state: 'current', kind: isLanding ? 'landing' : 'other', ...(isLanding && { site }),
      ...(isLanding && warning && { warning }), ...(this.#lasting && { alarm: this.#lasting }),
    };
  }

  onMode(mode) { this.#start.onMode(mode); }

  // The autopilot was silent, or has started anew: what it has is read again.
  doubt(why) {
    if (this.#known || this.#task) this.#suspect(why, 0);
  }

  #suspectOther(why) {
    this.#isForeign = true;
    this.#suspect(why);
  }

  #suspect(why, delay_s = suspicion_s) {
    if (this.#suspect_s !== undefined) return;
    this.#suspect_s = this.#now_s + delay_s;
    if (this.#known && !this.#task) this.#alarm(alarmOf.trouble(why));
  }

  #alarm(text) {
    if (this.#state.state !== 'unknown' || this.#state.alarm !== text) this.#log(text);
    this.#state = { ...this.#state, state: 'unknown', alarm: text };
  }

  hear(name, fields, now_s) {
    this.#now_s = now_s;
    if (name === 'COMMAND_ACK') this.#start.onAck(fields, now_s);
    else if (name === 'MISSION_CURRENT') this.#onCurrent(fields);
    else if (name === 'STATUSTEXT') this.#onText(fields.text);
    else if (fields.isForeign) this.#onForeign(name, fields);
    else if (this.#task) this.#task.hear(name, fields, now_s);
    else this.#onProbe(name, fields);
    if (!fields.isForeign && requests.has(name)) this.#isWritten_s = now_s;
  }

  #onForeign(name, { missionType: type }) {
    const isOfUpload = requests.has(name) || name === 'MISSION_ACK';
    if (type === MavMissionType.MISSION && isOfUpload) this.#suspectOther('another ground station writes');
  }

  #onProbe(name, { missionType: type, type: code, count }) {
    if (type !== MavMissionType.MISSION || !this.#known?.site) return;
    const isWriting = name === 'MISSION_ACK' && code === MavMissionResult.DENIED;
    if (isWriting || (name === 'MISSION_COUNT' && count !== this.#known.items.length)) this.#suspectOther('another ground station writes');
  }

  #onText(text) {
    if (!/flight plan received/i.test(text) || this.#now_s - this.#isWritten_s < ownUpload_s) return;
    this.#suspectOther('another ground station has written');
  }

  // total: how many items there are; missionId: of PX4.
  #onCurrent({ total, missionId }) {
    const sign = `${total}/${missionId}`;
    const isOwn = this.#task || this.#now_s - this.#isWritten_s < ownUpload_s;
    if (this.#total !== undefined && sign !== this.#total && !isOwn) this.#suspectOther('the number of items has changed');
    this.#total = sign;
  }

  step(now_s) {
    this.#now_s = now_s;
    // A mere look at what is there ends when the final begins.
    if (this.#isOnFinal && this.#task && !this.#job) this.#task = undefined;
    this.#task?.step(now_s);
    if (this.#task) return;
    if (this.#known) this.#start.step(now_s, this.#known.items);
    if (this.#isOnFinal || this.isHeld) return;
    const isSuspect = this.#suspect_s !== undefined && now_s >= this.#suspect_s;
    const isDue = now_s - this.#checked_s > (this.#known ? recheck_s : reread_s);
    if (isSuspect || isDue) this.#check();
    else this.#probe();
  }

  // PX4 tells another list by its number.
  #probe() {
    const isWanted = this.#vehicle().isArdupilot && this.#known?.site && this.#suspect_s === undefined;
    if (!isWanted || this.#now_s - this.#probed_s < probe_s) return;
    this.#probed_s = this.#now_s;
    this.#out.send('MISSION_REQUEST_LIST', { missionType: MavMissionType.MISSION });
  }

  // Nothing is sent on the final.
  get #isOnFinal() {
    const { current_item, mode, missionMode } = this.#vehicle();
    return this.#known?.items[current_item]?.command === MavCmd.NAV_LAND && mode === missionMode;
  }

  #check() {
    this.#suspect_s = undefined;
    this.#checked_s = this.#now_s;
    const left = this.#known ? undefined : this.#store.load();
    if (left) {
      this.#finishLeft(left);
      return;
    }
    const download = new Download(this.#out, MavMissionType.MISSION);
    const read = function* read() { return yield download; };
    this.#task = new Task(read(), (result) => {
      this.#task = undefined;
      this.#checked_s = this.#now_s;
      if (result.items) this.#compare(result.items);
      else if (this.#known) this.#alarm(alarmOf.trouble(result.error));
    });
  }

  #compare(items) {
    const hadLanding = this.#known?.site !== undefined;
    const isSame = this.#known && areSame(items, this.#known.items, this.#rules());
    if (hadLanding && !isSame) {
      this.#lasting = alarmOf.foreign;
      this.#log(this.#lasting);
      this.#start.end(alarmOf.foreign);
    }
    this.#know(items);
  }

  // The program was ended during a change.
  #finishLeft({ old, wanted, earlier, site }) {
    this.#state = { state: 'uploading', site, kind: 'landing' };
    const job = { finish: () => {}, landing: { site_id: site }, old, wanted, earlier };
    this.#job = job;
    this.#task = new Task(finishChange({
      out: this.#out, type: MavMissionType.MISSION, rules: this.#rules(), old, wanted, earlier,
      flownItem: () => this.#flownItem,
      onTrouble: (why) => this.#alarm(alarmOf.trouble(why)),
    }), (end) => this.#end(job, end));
  }
}
