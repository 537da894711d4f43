// Carries the spool to the service, in order, and waits while the service is away.
//
// A value in the spool is { session, line }: `session` names the flight that the line belongs to.
// `flights.json` beside the spool knows the service's id of each session.

import { readState, replaceFile } from './state_file.js';

const batchBytes = 128 * 1024;
const firstPause_ms = 200;
const longestPause_ms = 5000;
const maxNumSessions = 50;
const covers_us = 1_000_000;

const pauseOf = (numFailures) => Math.min(longestPause_ms, firstPause_ms * 2 ** numFailures);

export class Uplink {
  #service;
  #spool;
  #path;
  #flights;
  #fixedFlight;
  #request;
  #numFailures = 0;
  #notBefore_ms = 0;
  #running;
  isReachable = false;
  lastError;
  numDelivered = 0;
  numRejected = 0;
  lastRejection;
  // Time of the newest line that the service has.
  deliveredTo_us = -Infinity;

  // fixedFlight: the id of an existing flight that takes every session.
  // request: what new flights are created with.
  constructor({ service, spool, path, fixedFlight, request, log }) {
    this.#service = service;
    this.#spool = spool;
    this.#path = path;
    this.#fixedFlight = fixedFlight;
    this.#request = request;
    this.#flights = readState(path, log) ?? {};
  }

  flightOf(session) { return this.#fixedFlight ?? this.#flights[session]; }

  // The service has what was heard up to a little after this time.
  isCovered(timestamp_us) { return this.#spool.numWaiting === 0 || this.deliveredTo_us >= timestamp_us + covers_us; }

  // Call it often; it does nothing while a request runs or a pause lasts.
  step(now_ms = Date.now()) {
    if (this.#running || now_ms < this.#notBefore_ms) return this.#running ?? Promise.resolve();
    this.#running = this.#deliver().finally(() => { this.#running = undefined; });
    return this.#running;
  }

  async #deliver() {
    try {
      for (;;) {
        const batch = this.#spool.next(batchBytes);
        if (!batch) break;
        await this.#send(batch.values);
        this.#spool.delivered(batch.mark);
        this.isReachable = true;
        this.lastError = undefined;
        this.#numFailures = 0;
      }
    } catch (error) {
      this.isReachable = error.status !== undefined;
      this.lastError = error.cause?.message ?? error.message;
      this.#notBefore_ms = Date.now() + pauseOf(this.#numFailures);
      ++this.#numFailures;
    }
  }

  async #send(values) {
    for (let start = 0; start < values.length;) {
      const { session } = values[start];
      let end = start;
      while (end < values.length && values[end].session === session) ++end;
      await this.#sendSession(session, values.slice(start, end).map((value) => value.line));
      start = end;
    }
  }

  async #sendSession(session, lines) {
    const flightId = this.flightOf(session) ?? await this.#create(session);
    let answer;
    try {
      answer = await this.#service.sendTelemetry(flightId, lines);
    } catch (error) {
      // Somebody deleted the flight: the next try makes it anew.
      if (error.status === 404 && !this.#fixedFlight) this.#remember(session, undefined);
      throw error;
    }
    for (const { timestamp_us } of lines) this.deliveredTo_us = Math.max(this.deliveredTo_us, timestamp_us);
    this.numDelivered += answer.accepted;
    this.numRejected += answer.num_rejected ?? answer.rejected.length;
    if (answer.rejected.length) this.lastRejection = answer.rejected.at(-1).detail;
  }

  async #create(session) {
    const flightId = await this.#service.flightNamed(session) ??
      await this.#service.createFlight(session, this.#request);
    this.#remember(session, flightId);
    return flightId;
  }

  #remember(session, flightId) {
    this.#flights[session] = flightId;
    const newest = Object.entries(this.#flights).slice(-maxNumSessions);
    this.#flights = Object.fromEntries(newest);
    replaceFile(this.#path, JSON.stringify(this.#flights));
  }
}
