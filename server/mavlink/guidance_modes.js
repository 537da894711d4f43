// Whether the autopilot is still in the mode that guidance has put it into. A person who changes
// the mode ends guidance. Pure.

const modesOf = {
  ardupilotmega: { guided: 'GUIDED', mission: 'AUTO' },
  px4: { guided: 'AUTO.LOITER', mission: 'AUTO.MISSION' },
};
// Modes in which the autopilot flies by itself. In the others a person flies by hand.
const flownByItself = new Set([
  'AUTO', 'GUIDED', 'LOITER', 'CIRCLE', 'RTL', 'TAKEOFF', 'AVOID_ADSB', 'THERMAL', 'LOITER_ALT_QLAND',
  'AUTO.MISSION', 'AUTO.LOITER', 'AUTO.RTL', 'AUTO.TAKEOFF', 'AUTO.READY',
]);
// Heartbeats come once a second, and the change itself takes its time.
const change_s = 4;
const repeat_s = 1.5;

export const isFlownByItself = (mode) => flownByItself.has(mode);
export const hasModes = (autopilot) => autopilot in modesOf;

export class ModeWatch {
  #names;
  #before;
  #wanted;
  #sent_s;
  #isThere = false;
  #now_s = 0;

  constructor({ autopilot, mode }) {
    this.#names = modesOf[autopilot] ?? modesOf.ardupilotmega;
    this.#before = mode;
  }

  // A target may change the mode only until the autopilot has been seen in it.
  get mayChange() { return !this.#isThere; }
  get isGuided() { return this.#isThere && this.#wanted === this.#names.guided; }
  get isMissionLate() {
    return !this.#isThere && this.#wanted === this.#names.mission && this.#now_s - this.#sent_s > repeat_s;
  }

  sendsGuided(now_s) {
    if (this.#wanted) return;
    this.#wanted = this.#names.guided;
    this.#sent_s = now_s;
  }

  sendsMission(now_s) {
    this.#before = this.#names.guided;
    this.#wanted = this.#names.mission;
    this.#sent_s = now_s;
    this.#isThere = false;
  }

  // A sentence if the mode is another's doing.
  interference({ mode }, now_s) {
    this.#now_s = now_s;
    if (!this.#wanted) return mode === this.#before ? undefined : `the mode is now ${mode}`;
    if (mode === this.#wanted) {
      this.#isThere = true;
      return undefined;
    }
    if (this.#isThere) return `the mode is now ${mode}`;
    if (mode !== this.#before) return `the mode is now ${mode}`;
    return now_s - this.#sent_s > change_s ? `the autopilot stays in ${mode}` : undefined;
  }
}
