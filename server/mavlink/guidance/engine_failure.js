// Ties guidance to a link: when it begins, on whose word, and when it is over.

import { Autopilot } from '../autopilot.js';
import { Guidance } from './guidance.js';
import { isFlownByItself, isGuidable } from './guidance_modes.js';

const selectPeriod_s = 1;
// The current item is told once or twice a second: so long it may still be that of before AUTO.
const staleItem_s = 2;
// Of MIS_RESTART: AUTO begins at the first item.
const restartsMission = 1;

export class EngineFailure {
  #guidance;
  #landings;
  #outgoing;
  #state;
  #address;
  #log;
  #told;
  #isAutomatic;
  #handled;
  #declared;
  #selected_s = -Infinity;
  // On the final: since when AUTO has been seen with the LAND as its item, or with another one.
  #final = {};

  // recall(query): answer of /v1/emergency. outgoing: Outgoing. address(): of the autopilot. state(): of
  // the link, with its flight. log(text, kind), told(id, state, detail) of a command. isAutomatic:
  // the operator wants it without a person's word. options: of Guidance.
  constructor({ recall, outgoing, landings, address, state, log, told, isAutomatic, options }) {
    this.#landings = landings;
    this.#outgoing = outgoing;
    this.#state = state;
    this.#address = address;
    this.#log = log;
    this.#told = told;
    this.#isAutomatic = isAutomatic;
    this.#guidance = new Guidance({
      recall,
      autopilot: new Autopilot({
        send: (name, fields) => outgoing.send(name, fields),
        address: () => this.#target(),
        landItem: () => this.#restartedLand(),
      }),
      mission: landings.missions,
      log,
      options,
    });
  }

  get guidance() { return this.#guidance; }

  #target() {
    const { systemId, componentId } = this.#address();
    return { targetSystem: systemId, targetComponent: componentId };
  }

  // Parts of the link's state.
  stateParts(engine) {
    const guidance = this.#guidance.state();
    return { engine: { ...engine, declared_by: this.#declared }, ...(guidance && { guidance }) };
  }

  // command: { id, kind, confirmed_by }. False if the kind is not of this file.
  take({ id, kind, confirmed_by }, now_us) {
    if (kind === 'release') {
      this.#declared = undefined;
      this.#guidance.release('released by a person');
      return false;
    }
    if (kind !== 'engine_failure') return false;
    const state = this.#state();
    const refusal = refusalOf(state);
    if (refusal) {
      this.#told(id, 'failed', refusal);
      return true;
    }
    this.#declared = confirmed_by ?? 'a person';
    this.#engage(state, `declared by ${this.#declared}`, now_us);
    this.#told(id, 'done', 'guidance has begun');
    return true;
  }

  // Ten times a second. now_s: a clock that never steps.
  step(now_s, now_us) {
    const state = this.#state();
    if (state.is_armed === false) this.#declared = undefined;
    if (this.#isAutomatic) this.#watch(state, now_us);
    this.#guidance.step(state, now_s);
    this.#landings.missions.isHeld = this.#guidance.isOnFinal;
    this.#landings.isGuided = this.#guidance.isEngaged;
    this.#select(state, now_s);
  }

  // Each failure once: who ended guidance does not want it again.
  #watch(state, now_us) {
    const { engine } = state;
    // A watch that has begun anew knows nothing yet.
    if (engine.state === 'running' || state.is_armed === false) this.#handled = undefined;
    if (engine.state !== 'failed' || this.#handled) return;
    this.#handled = true;
    // A person has declared the same failure before it was noticed.
    if (this.#guidance.isEngaged) return;
    const refusal = refusalOf(state) ??
      (isFlownByItself(state.mode) ? undefined : `${state.mode} is flown by hand: nothing is sent`);
    if (refusal) this.#log(`engine failure, no guidance: ${refusal}`, 'engine');
    else this.#engage(state, engine.reason, now_us);
  }

  #engage(state, reason, now_us) {
    if (this.#guidance.isEngaged) return;
    this.#landings.end('an engine failure came after it');
    this.#guidance.engage(state, reason, now_us);
    this.#final = {};
  }

  #restartedLand() {
    const { parameters, items } = this.#landings.vehicle;
    return parameters?.MIS_RESTART === restartsMission && items ? items.length - 1 : undefined;
  }

  // The LAND stays the current item of the prepared mission; the message may be lost.
  #select(state, now_s) {
    const { num_items, current_item } = state.mission;
    if (!this.#guidance.hasLanding) return;
    const isLand = current_item === num_items - 1;
    if (this.#guidance.isOnFinal ? !this.#isFinalElsewhere(state, isLand, now_s) : isLand) return;
    if (now_s - this.#selected_s < selectPeriod_s) return;
    this.#selected_s = now_s;
    this.#outgoing.send('MISSION_SET_CURRENT', { ...this.#target(), seq: num_items - 1 });
  }

  // AUTO has begun at another item. Once it flies the LAND, nothing is sent any more: another item is then a person's doing.
  #isFinalElsewhere({ mode }, isLand, now_s) {
    const final = this.#final;
    if (mode !== 'AUTO') return false;
    if (isLand !== final.isLand) Object.assign(final, { isLand, changed_s: now_s });
    final.isFlown ||= isLand && now_s - final.changed_s > staleItem_s;
    return !isLand && !final.isFlown && now_s - final.changed_s >= selectPeriod_s;
  }
}

function refusalOf(state) {
  if (!state.is_connected) return 'the autopilot is silent';
  if (!state.is_armed) return 'it is not armed';
  return isGuidable(state.autopilot) ? undefined : `${state.autopilot} is not guided: only ArduPlane is`;
}
