// Replaces a list of items in the autopilot: reads the old one, writes the new one, reads back and
// compares. What is neither of the two after a broken upload is replaced by the old one, for as long
// as it takes. A list that somebody else has written is left alone.
//
// A generator: it yields transfers, and seconds to wait; it is resumed with the transfer's result.

import { Download, Upload } from './item_transfer.js';
import { areSame, isMixture } from './mission_items.js';

const retry_s = 2;
const wait_s = 0.2;
const numReads = 3;

export const outcome = { done: 'done', unchanged: 'unchanged', restored: 'restored', foreign: 'foreign' };

// Gives { items } or { error }.
function* readOf(out, type) {
  let result;
  for (let i = 0; i < numReads; ++i) {
    result = yield new Download(out, type);
    if (result.items) break;
  }
  return result;
}

// After something was written: the answer is needed, so it is asked for again and again.
function* readAgain(out, type, onTrouble) {
  for (;;) {
    const { items, error } = yield new Download(out, type);
    if (items) return items;
    onTrouble(error);
    yield retry_s;
  }
}

function* restore({ out, type, old, wanted, earlier = [], rules, flownItem = () => undefined, onTrouble }, found) {
  let items = found;
  for (;;) {
    if (areSame(items, old, rules)) return { outcome: outcome.restored, items };
    if (areSame(items, wanted, rules)) return { outcome: outcome.done, items };
    if (!isMixture(items, [old, wanted, ...earlier], rules)) return { outcome: outcome.foreign, items };
    const { error } = yield new Upload(out, type, old, flownItem());
    if (error) onTrouble(error);
    items = yield* readAgain(out, type, onTrouble);
    if (!areSame(items, old, rules)) yield retry_s;
  }
}

// Of a change that another run of the program has begun.
export function* finishChange(setting) {
  const items = yield* readAgain(setting.out, setting.type, setting.onTrouble);
  return yield* restore(setting, items);
}

// setting: out, type; rules as of areSame; wantedFrom(old items): the new list, or a sentence why there
// must be none; mayWrite(): false while it must wait; known: the list that
// the autopilot has, if it need not be read again; base: the old list and earlier: wanted ones of
// changes that were given up; flownItem(): the item that must stay the current one, if any; onWrite({ old, wanted }); onTrouble(why): from now on it is unknown what
// the autopilot has.
// Gives { outcome, items, why? }.
export function* changeItems({ out, type, rules, wantedFrom, mayWrite = () => true, base, known, earlier,
  flownItem = () => undefined, onWrite, onTrouble }) {
  const isEnough = known && !areSame(known, wantedFrom(base ?? known), rules);
  // What a change that was given up has left there must be known.
  const read = isEnough ? { items: known } : base ? { items: yield* readAgain(out, type, onTrouble) } : yield* readOf(out, type);
  if (!read.items) return { outcome: outcome.unchanged, why: `the old list cannot be read: ${read.error}` };
  const old = base ?? read.items;
  const wanted = wantedFrom(old);
  if (typeof wanted === 'string') {
    const end = base ? yield* restore({ out, type, old, wanted: old, earlier, rules, flownItem, onTrouble }, read.items)
      : { outcome: outcome.unchanged, items: read.items };
    return { why: wanted, ...end };
  }
  if (areSame(read.items, wanted, rules)) return { outcome: outcome.done, items: read.items };
  while (!mayWrite()) yield wait_s;
  onWrite({ old, wanted });
  const written = yield new Upload(out, type, wanted, flownItem());
  if (written.error) onTrouble(written.error);
  const items = yield* readAgain(out, type, onTrouble);
  if (areSame(items, wanted, rules)) return { outcome: outcome.done, items };
  const why = written.error ?? 'what was read back differs';
  if (areSame(items, old, rules)) return { outcome: outcome.unchanged, items, why };
  onTrouble(why);
  const end = yield* restore({ out, type, old, wanted, earlier, rules, flownItem, onTrouble }, items);
  return { why, ...end };
}

// Runs one such generator.
export class Task {
  #generator;
  #transfer;
  #upload;
  #resume_s = -Infinity;
  #finished;

  constructor(generator, finished) {
    this.#generator = generator;
    this.#finished = finished;
    this.#take(generator.next());
  }

  get isOver() { return this.#generator === undefined; }

  hear(name, fields, now_s) {
    // A late copy of MISSION_COUNT makes the autopilot ask once more.
    if (this.#upload !== this.#transfer) this.#upload?.hear(name, fields, now_s);
    this.#transfer?.hear(name, fields, now_s);
  }

  step(now_s) {
    if (this.isOver || now_s < this.#resume_s) return;
    if (typeof this.#transfer === 'object') {
      this.#transfer.step(now_s);
      if (!this.#transfer.result) return;
      this.#take(this.#generator.next(this.#transfer.result), now_s);
      return;
    }
    this.#take(this.#generator.next(), now_s);
  }

  #take({ value, done }, now_s = -Infinity) {
    if (done) {
      this.#generator = undefined;
      this.#finished(value);
    } else if (typeof value === 'number') {
      this.#transfer = undefined;
      this.#resume_s = now_s + value;
    } else {
      this.#transfer = value;
      if (value instanceof Upload) this.#upload = value;
    }
  }
}
