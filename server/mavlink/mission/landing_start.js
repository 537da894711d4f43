// Starts the landing that is in the autopilot by DO_LAND_START, and says what became of it.
// A person who takes another mode ends it.

import { MavCmd, MavFrame, MavResult } from '../messages.js';

const repeat_s = 1.5;
const numStarts = 4;
// From the autopilot's word that it flies the landing until it is seen to.
const seen_s = 8;

const landingAt = (items) => items.findIndex((one) => one.command === MavCmd.DO_LAND_START);

export class LandingStart {
  #out;
  #vehicle;
  #log;
  #told;
  // The one that runs; also while the landing is flown.
  #start;

  // As of MissionKeeper.
  constructor({ out, vehicle, log, told }) {
    this.#out = out;
    this.#vehicle = vehicle;
    this.#log = log;
    this.#told = told;
  }

  // From the first command until the landing is seen to be flown.
  get isWaiting() { return this.#start !== undefined && !this.#start.isFlown; }

  begin(commandId, site) {
    this.#start = { commandId, site, itemBefore: this.#vehicle().current_item, sent_s: -Infinity, numSent: 0 };
  }

  // Nothing is sent any more.
  end(why) {
    if (this.isWaiting) this.#fail(`but ${why}`);
    this.#start = undefined;
  }

  #fail(why) {
    const { commandId } = this.#start;
    this.#start = undefined;
    this.#told(commandId, 'failed', `in the autopilot, ${why}`);
  }

  // items: of the mission in the autopilot.
  step(now_s, items) {
    const start = this.#start;
    if (!start || start.isFlown) return;
    if (this.#hasBegun(items)) start.accepted_s ??= now_s;
    if (start.accepted_s !== undefined) this.#watch(now_s, items);
    else if (now_s - start.sent_s >= repeat_s) this.#send(now_s);
  }

  #send(now_s) {
    const start = this.#start;
    if (start.numSent >= numStarts) {
      this.#fail('but it did not start it');
      return;
    }
    start.sent_s = now_s;
    ++start.numSent;
    this.#out.send('COMMAND_INT', { command: MavCmd.DO_LAND_START, frame: MavFrame.GLOBAL, current: 0, autocontinue: 0 });
  }

  onAck({ command: id, result }, now_s) {
    const start = this.#start;
    if (id !== MavCmd.DO_LAND_START || !start || start.accepted_s !== undefined) return;
    if (result === MavResult.ACCEPTED) start.accepted_s = now_s;
    else this.#fail(`but it refused to start it (${result})`);
  }

  // The acknowledgement may be lost. The item stays when a person takes another mode.
  #hasBegun(items) {
    const { itemBefore, numSent } = this.#start;
    const { current_item } = this.#vehicle();
    const wasBefore = itemBefore < landingAt(items) && numSent > 0;
    return this.#isFlown(items) || (wasBefore && current_item >= landingAt(items));
  }

  #isFlown(items) {
    const { mode, missionMode, current_item } = this.#vehicle();
    return mode === missionMode && landingAt(items) >= 0 && current_item >= landingAt(items);
  }

  // PX4 accepts the command also when it does not fly the mission.
  #watch(now_s, items) {
    const start = this.#start;
    if (this.#isFlown(items)) {
      start.isFlown = true;
      this.#log(`the autopilot flies the landing to ${start.site}`);
      this.#told(start.commandId, 'done', 'flown');
    } else if (now_s - start.accepted_s > seen_s) {
      const { mode, current_item } = this.#vehicle();
      const seen = `mode ${mode}, item ${current_item ?? 'unknown'}`;
      this.#log(`the autopilot is not seen to fly the landing to ${start.site}: ${seen}`);
      this.#fail(`and accepted, but not flown as far as is known: ${seen}`);
    }
  }

  // It is told only changes.
  onMode(mode) {
    if (!this.#start || mode === this.#vehicle().missionMode) return;
    this.#log(`mode ${mode}: the link's part in the landing has ended`);
    this.end(`the mode was changed to ${mode}`);
  }
}
