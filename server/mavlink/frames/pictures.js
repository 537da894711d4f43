// Pictures of the camera's folder become frames of the flight: found, paired with triggers, sent.
// A picture whose trigger is not sure is not sent, because the service would give it a pose by its
// own time.

import { createHash } from 'node:crypto';
import { readFile, stat } from 'node:fs/promises';
import { join } from 'node:path';

import { exposureTime, isWhole } from './jpeg_file.js';
import { keyOf, Ledger } from './ledger.js';
import { Pairing, triggersThatCount } from './pairing.js';
import { PictureFolder } from './picture_folder.js';
import { TriggerLog } from './trigger_log.js';

const lookPeriod_ms = 1000;
// A large folder on a slow card must not take the processor.
const lookShare = 0.05;
const numReadAtOnce = 20;
const maxBytes = 64 * 1024 * 1024;
const maxNumTimes = 5000;
const pairPeriod_ms = 1000;
const patience_ms = 5000;
// A picture whose end is still missing then was not written further: the service judges it.
const endless_ms = 30_000;
const firstPause_ms = 500;
const longestPause_ms = 10_000;
// A flight that was deleted.
const maxNumMissing = 10;
const final = new Set([400, 404, 409, 413, 415, 422]);

const digestOf = (bytes) => createHash('sha256').update(bytes).digest('hex');
// The service knows a picture again by its frame's id.
const frameIdOf = (sha256) => `picture-${sha256.slice(0, 32)}`;

export function metaOf({ time_us, position, attitude }) {
  return { timestamp_us: Math.round(time_us), ...(position && { position, altitude_datum: 'amsl' }), ...(attitude && { attitude }) };
}

export class Pictures {
  #folder;
  #look;
  #service;
  #flightOf;
  #session;
  #isCovered;
  #log;
  #ledger;
  #triggers;
  #pairing;
  #waiting = new Map();
  // Of pictures that were sent: time, kind of time, order.
  #times;
  #order;
  #paired = { pairs: new Map(), unpaired: [] };
  #incomplete = new Map();
  #numOf;
  #numVanished = 0;
  #running;
  #notBefore_ms = 0;
  #lookCost_ms = 0;
  #pairedAt_ms = -Infinity;
  #isChanged = true;
  #numFailures = 0;
  #numMissing = 0;
  #sentTo_us = -Infinity;
  #last;
  lastError;
  lastRefusal;

  // folder: of the pictures. path(name): of a file of its own. service: putFrame(flight, frame, bytes,
  // meta). flightOf(session): id of a flight. session(): the current one. isCovered(timestamp_us): the
  // service has the telemetry of that time. limit_s: how far the pictures' clock is from UTC at most. log(text).
  constructor({ folder, path, service, flightOf, session, isCovered, limit_s, log = () => {} }) {
    this.#folder = folder;
    this.#look = new PictureFolder(folder);
    this.#service = service;
    this.#flightOf = flightOf;
    this.#session = session;
    this.#isCovered = isCovered;
    this.#log = log;
    this.#ledger = new Ledger(path('pictures.ndjson'));
    this.#triggers = new TriggerLog(path('triggers.ndjson'));
    this.#pairing = new Pairing({ limit_us: limit_s * 1e6 });
    const { entries } = this.#ledger;
    this.#times = entries.filter(({ time_us }) => time_us !== undefined).slice(-maxNumTimes);
    this.#order = Math.max(0, ...[...this.#times, ...this.#triggers.triggers].map(({ order }) => order));
    this.#numOf = { sent: 0, duplicate: 0, refused: 0, earlier: 0 };
    for (const { fate } of entries) ++this.#numOf[fate];
  }

  // trigger: { kind, index, timestamp_us, session, position?, attitude?, file? }. Without a session there is
  // no telemetry of its time.
  hear({ timestamp_us, ...trigger }) {
    if (!trigger.session) return;
    const isNew = this.#triggers.add({ ...trigger, time_us: timestamp_us, order: ++this.#order });
    if (isNew) this.#isChanged = true;
  }

  // Often; it does nothing while it is at work or pauses.
  step(now_ms = performance.now()) {
    this.#save();
    if (this.#running || now_ms < this.#notBefore_ms) return this.#running ?? Promise.resolve();
    this.#running = this.#work(now_ms)
      .catch((error) => { this.lastError = error.message; })
      .finally(() => {
        this.#notBefore_ms = Math.max(this.#notBefore_ms, now_ms + Math.max(lookPeriod_ms, this.#lookCost_ms / lookShare));
        this.#running = undefined;
      });
    return this.#running;
  }

  #save() {
    try {
      this.#triggers.save();
    } catch (error) {
      this.lastError = error.message;
    }
  }

  async #work(now_ms) {
    const files = await this.#look.look(now_ms);
    this.#lookCost_ms = performance.now() - now_ms;
    if (!files) {
      this.lastError = this.#look.lastError;
      return;
    }
    if (this.#ledger.isNew) this.#add(files.map((picture) => ({ picture, fate: 'earlier' })));
    this.#forgetGone(files);
    const isNew = (file) => file.isSettled && !this.#ledger.has(file) && !this.#waiting.has(keyOf(file)) &&
      !(performance.now() - this.#incomplete.get(keyOf(file)) < endless_ms);
    for (const file of files.filter(isNew).slice(0, numReadAtOnce)) await this.#read(file);
    this.#pair(now_ms);
    await this.#send();
  }

  #forgetGone(files) {
    const keys = new Set(files.map(keyOf));
    for (const held of [this.#waiting, this.#incomplete]) {
      for (const key of held.keys()) {
        if (keys.has(key)) continue;
        held.delete(key);
        if (held === this.#waiting) ++this.#numVanished;
      }
    }
  }

  #add(values) {
    this.#ledger.add(values);
    for (const { fate } of values) ++this.#numOf[fate];
  }

  async #bytesOf({ name, size, mtime_ms }) {
    const path = join(this.#folder, name);
    const bytes = await readFile(path);
    const now = await stat(path);
    return bytes.length === size && now.size === size && now.mtimeMs === mtime_ms ? bytes : undefined;
  }

  async #read(file) {
    const key = keyOf(file);
    if (file.size > maxBytes) {
      this.#refuse(file, `${file.name} has more than ${maxBytes >> 20} MiB`);
      return;
    }
    const bytes = await this.#bytesOf(file).catch(() => undefined);
    if (!bytes) return;
    if (!isWhole(bytes) && !this.#incomplete.has(key)) {
      this.#incomplete.set(key, performance.now());
      return;
    }
    this.#incomplete.delete(key);
    const sha256 = digestOf(bytes);
    const isTwice = this.#ledger.hasDigest(sha256) || [...this.#waiting.values()].some((one) => one.sha256 === sha256);
    if (isTwice) {
      this.#add([{ picture: file, fate: 'duplicate' }]);
      return;
    }
    const taken = exposureTime(bytes);
    this.#waiting.set(key, { ...file, sha256, order: ++this.#order, read_ms: performance.now(),
      time_us: taken?.time_us ?? file.mtime_ms * 1000,
      time_kind: !taken ? 'file' : taken.isFine ? 'exif' : 'exif_seconds' });
    this.#isChanged = true;
  }

  #refuse(picture, why) {
    this.lastRefusal = why;
    this.#log(`picture refused: ${why}`);
    this.#settle(picture, { fate: 'refused' });
  }

  // Its time stays: it is part of the pattern, and its trigger is taken.
  #settle(picture, more) {
    const { name, sha256, order, time_us, time_kind } = picture;
    const entry = { name, sha256, order, time_us, time_kind, ...more };
    this.#add([{ picture, ...entry }]);
    this.#waiting.delete(keyOf(picture));
    this.#paired.pairs.delete(picture);
    if (time_us === undefined) return;
    this.#times.push(entry);
    if (this.#times.length > maxNumTimes) this.#times.shift();
  }

  #pair(now_ms) {
    const isOpen = this.#waiting.size > 0 && now_ms - this.#pairedAt_ms >= longestPause_ms;
    if (!(this.#isChanged || isOpen) || now_ms - this.#pairedAt_ms < pairPeriod_ms) return;
    this.#pairedAt_ms = now_ms;
    this.#isChanged = false;
    const pictures = [...this.#times, ...this.#waiting.values()];
    this.#paired = this.#pairing.pair(pictures, this.#triggers.triggers,
      { session: this.#session(), used_us: this.#ledger.usedTriggers_us, now_ms });
  }

  async #send() {
    const ready = [...this.#paired.pairs].filter(([picture]) => this.#waiting.has(keyOf(picture)))
      .sort(([, a], [, b]) => a.time_us - b.time_us);
    const taken = new Set(ready.map(([, trigger]) => trigger));
    const open = ready.length === 0 ? [] : triggersThatCount(this.#triggers.triggers).filter((trigger) => !taken.has(trigger));
    const halted = new Set();
    for (const [picture, trigger] of ready) {
      const flight = this.#flightOf(trigger.session);
      const mustWait = !flight || !this.#isCovered(trigger.time_us) || this.#isEarly(picture, trigger, open);
      // The frames of one flight go in order.
      if (mustWait) halted.add(trigger.session);
      if (halted.has(trigger.session)) continue;
      if (!await this.#sendOne(picture, trigger, flight)) return;
      this.#sentTo_us = Math.max(this.#sentTo_us, trigger.time_us);
    }
  }

  // The picture of a trigger before this one may still come: the engine works in the order of arrival.
  #isEarly({ read_ms }, { time_us }, open) {
    if (performance.now() - read_ms > patience_ms) return false;
    return open.some((one) => one.time_us > this.#sentTo_us && one.time_us < time_us);
  }

  async #sendOne(picture, trigger, flight) {
    const bytes = await this.#bytesOf(picture).catch(() => undefined);
    // It was changed or removed meanwhile.
    if (!bytes || digestOf(bytes) !== picture.sha256) return true;
    const frame = frameIdOf(picture.sha256);
    try {
      await this.#service.putFrame(flight, frame, bytes, metaOf(trigger));
    } catch (error) {
      return this.#onFailure(picture, error);
    }
    this.#onSent(picture, { trigger_us: trigger.time_us, flight, frame });
    return true;
  }

  #onSent(picture, more) {
    this.#settle(picture, { fate: 'sent', ...more });
    this.#last = { name: picture.name, at: new Date().toISOString() };
    this.lastError = undefined;
    this.#numFailures = 0;
    this.#numMissing = 0;
  }

  // True if the next one can be tried.
  #onFailure(picture, error) {
    this.lastError = error.cause?.message ?? error.message;
    const isMissing = error.status === 404 && ++this.#numMissing < maxNumMissing;
    if (final.has(error.status) && !isMissing) {
      this.#refuse(picture, `${picture.name}: ${error.message}`);
      return true;
    }
    this.#notBefore_ms = performance.now() + Math.min(longestPause_ms, firstPause_ms * 2 ** this.#numFailures++);
    return false;
  }

  // As `pictures` of the link's state.
  state() {
    const { sent, duplicate, refused, earlier } = this.#numOf;
    const unpaired = this.#paired.unpaired.filter((picture) => this.#waiting.has(keyOf(picture))).length;
    const waiting = this.#waiting.size - unpaired;
    return {
      folder: this.#folder, num_triggers: this.#triggers.triggers.length, sent, waiting, unpaired,
      duplicates: duplicate, refused, incomplete: this.#incomplete.size, vanished: this.#numVanished, earlier, ignored: this.#look.numIgnored,
      clock_offset_s: this.#pairing.offsets_s, last_sent: this.#last, last_error: this.lastError, last_refusal: this.lastRefusal,
      text: this.#text(waiting),
    };
  }

  #text(waiting) {
    if (this.#look.lastError) return `the folder cannot be read: ${this.#look.lastError}`;
    const isPaired = Object.keys(this.#pairing.offsets_s).length > 0;
    if (waiting > 0 && !isPaired && this.#paired.pairs.size === 0) return 'it is not sure yet which trigger took which picture';
    return undefined;
  }
}
