// One transfer of a list of items, the ground's side. Stepped: step(now_s) until `result` is set.
// https://mavlink.io/en/services/mission.html

import { itemOf } from './mission_items.js';

const ack = { accepted: 0, invalidSequence: 13, denied: 14, cancelled: 15 };
// After this the same message is sent again.
const repeat_s = 0.8;
// Somebody else uploads: the autopilot denies until it has ended or timed out (8 s in ArduPilot).
const busy_s = 1;
// Without any progress.
const giveUp_s = 15;

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

  _ask() {
    if (this.#count === undefined) this._send('MISSION_REQUEST_LIST', {});
    else this._send('MISSION_REQUEST_INT', { seq: this.#items.length });
  }

  hear(name, fields, now_s) {
    if (this.result || fields.missionType !== this._type) return;
    if (name === 'MISSION_COUNT' && this.#count === undefined) this.#begin(fields.count, now_s);
    else if (name === 'MISSION_ITEM_INT' && this.#count !== undefined) this.#take(fields, now_s);
    else if (name === 'MISSION_ACK' && fields.type === ack.denied) this._next_s = now_s + busy_s;
    // The list has become shorter meanwhile.
    else if (name === 'MISSION_ACK' && fields.type === 1) this._finish({ error: 'the list changed while it was read' });
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
    this._send('MISSION_ACK', { type: ack.accepted });
    this._finish({ items: this.#items });
  }
}

// result: { isAcknowledged } or { error }. Only what is read back says what the autopilot has.
export class Upload extends Transfer {
  #items;
  #hasBegun = false;
  #isComplete = false;

  constructor(out, type, items) {
    super(out, type);
    this.#items = items;
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
    this._send('MISSION_ITEM_INT', { ...one, seq, current: 0, autocontinue: 1 });
  }

  #onAck(type, now_s) {
    if (type === ack.invalidSequence) return;
    if (type === ack.accepted && this.#isComplete) this._finish({ isAcknowledged: true });
    else if (type === ack.denied && !this.#hasBegun) this._next_s = now_s + busy_s;
    else if (type !== ack.accepted) this._finish({ error: resultName(type) });
  }
}
