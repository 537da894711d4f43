// One transfer of a list of items, the ground's side. Stepped: step(now_s) until `result` is set.
// https://mavlink.io/en/services/mission.html

import { MavMissionResult } from '../messages.js';
import { itemOf } from './mission_items.js';

// After this the same message is sent again.
const repeat_s = 0.8;
// Somebody else uploads: the autopilot denies until it has ended or timed out (8 s in ArduPilot).
const busy_s = 1;
// Without any progress.
const giveUp_s = 15;
// A list that cannot be read so often in a row.
const maxNumBroken = 3;

const resultName = (code) => ({ 1: 'error', 2: 'unsupported frame', 3: 'unsupported', 4: 'no space', 5: 'invalid',
  14: 'denied', 15: 'cancelled' })[code] ?? `result ${code}`;

class Transfer {
  result;
  _out;
  _type;
  _next_s = -Infinity;
  _progress_s;

  constructor(out, type) {
    this._out = out;
    this._type = type;
  }

  step(now_s) {
    this._progress_s ??= now_s;
    if (this.result || now_s < this._next_s) return;
    if (now_s - this._progress_s > giveUp_s) {
      this._finish({ error: 'no answer' });
      return;
    }
    this._next_s = now_s + repeat_s;
    this._ask(now_s);
  }

  _send(name, fields) { this._out.send(name, { ...fields, missionType: this._type }); }
  _finish(result) { this.result ??= result; }

  _advance(now_s) {
    this._progress_s = now_s;
    this._next_s = now_s + repeat_s;
  }
}

// result: { items } or { error }.
export class Download extends Transfer {
  #count;
  #items = [];
  #numBroken = 0;

  _ask() {
    if (this.#count === undefined) this._send('MISSION_REQUEST_LIST', {});
    else this._send('MISSION_REQUEST_INT', { seq: this.#items.length });
  }

  hear(name, fields, now_s) {
    if (this.result || fields.missionType !== this._type) return;
    if (name === 'MISSION_COUNT' && this.#count === undefined) this.#begin(fields.count, now_s);
    else if (name === 'MISSION_ITEM_INT' && this.#count !== undefined) this.#take(fields, now_s);
    else if (name === 'MISSION_ACK' && fields.type === MavMissionResult.DENIED) this._next_s = now_s + busy_s;
    else if (name === 'MISSION_ACK' && fields.type === MavMissionResult.ERROR) this.#beginAnew(now_s);
  }

  // The list has become shorter meanwhile, or a late copy of a request was one too many for PX4.
  #beginAnew(now_s) {
    if (++this.#numBroken > maxNumBroken) {
      this._finish({ error: 'the list changed while it was read' });
      return;
    }
    this.#count = undefined;
    this.#items = [];
    this._next_s = now_s + busy_s;
  }

  #begin(count, now_s) {
    this.#count = count;
    this._advance(now_s);
    if (count === 0) this.#end();
    else this._ask();
  }

  #take(fields, now_s) {
    if (fields.seq !== this.#items.length) return;
    this.#items.push(itemOf(fields));
    this._advance(now_s);
    if (this.#items.length === this.#count) this.#end();
    else this._ask();
  }

  #end() {
    this._send('MISSION_ACK', { type: MavMissionResult.ACCEPTED });
    this._finish({ items: this.#items });
  }
}

// result: { isAcknowledged } or { error }. Only what is read back says what the autopilot has.
export class Upload extends Transfer {
  #items;
  #hasBegun = false;
  #isComplete = false;
  #current;

  // current: the item that is flown. PX4 begins a new mission at its first item, if none is marked.
  constructor(out, type, items, current) {
    super(out, type);
    this.#items = items;
    this.#current = current;
  }

  // Once it is asked for items, the autopilot asks again by itself.
  _ask(now_s) {
    if (!this.#hasBegun) this._send('MISSION_COUNT', { count: this.#items.length });
    else if (this.#isComplete && now_s - this._progress_s > 4 * repeat_s) this._finish({ isAcknowledged: false });
  }

  hear(name, fields, now_s) {
    if (fields.missionType !== this._type) return;
    if (name === 'MISSION_REQUEST' || name === 'MISSION_REQUEST_INT') this.#answer(fields.seq, now_s);
    else if (name === 'MISSION_ACK' && !this.result) this.#onAck(fields.type, now_s);
  }

  // Also after its end: a late copy of MISSION_COUNT makes the autopilot ask once more.
  #answer(seq, now_s) {
    const one = this.#items[seq];
    if (!one) return;
    this.#hasBegun = true;
    this.#isComplete ||= seq === this.#items.length - 1;
    this._advance(now_s);
    this._send('MISSION_ITEM_INT', { ...one, seq, current: Number(seq === this.#current), autocontinue: 1 });
  }

  #onAck(type, now_s) {
    if (type === MavMissionResult.INVALID_SEQUENCE) return;
    if (type === MavMissionResult.ACCEPTED && this.#isComplete) this._finish({ isAcknowledged: true });
    // PX4 says error where ArduPilot says denied.
    else if ((type === MavMissionResult.DENIED || type === MavMissionResult.ERROR) && !this.#hasBegun) this._next_s = now_s + busy_s;
    else if (type !== MavMissionResult.ACCEPTED) this._finish({ error: resultName(type) });
  }
}
