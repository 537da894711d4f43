// Landings by mission on one link: takes people's commands, fetches the approach from the service, and
// keeps the mission (and, opt-in, the rally points) of the autopilot.

import { landingOfApproach, NoLanding } from './landing_items.js';
import { MissionKeeper } from './mission_keeper.js';
import { ownComponent } from '../outgoing.js';
import { landingParameters, ParameterReader, px4Parameters } from './parameters.js';
import { RallyKeeper } from './rally_keeper.js';

const minFlyingAirspeed_mps = 8;
// An older wind is not asked for: then the site's own plan is flown.
const maxWindAge_s = 60;
const missionModes = { ardupilotmega: 'AUTO', px4: 'AUTO.MISSION' };
const targeted = /^MISSION_(REQUEST|REQUEST_INT|COUNT|ITEM_INT|ACK)$/;

export const heardMessages = ['PARAM_VALUE', 'MISSION_REQUEST', 'MISSION_COUNT', 'MISSION_ACK', 'MISSION_REQUEST_INT',
  'MISSION_ITEM_INT', 'COMMAND_ACK', 'STATUSTEXT', 'MISSION_CURRENT'];

export class Landings {
  #service;
  #out;
  #address;
  #linkState;
  #log;
  #told;
  #parameters;
  #missions;
  #rally;
  #vehicle = {};
  #autopilot;
  #boots;
  #wasConnected = false;
  #wasArmed;
  // The person's word to land that counts: { id, isPlanned, wasModeChanged }.
  #order;
  // After an engine failure the rally points stay as they are.
  isGuided = false;

  // service: site(id), approach(id, wind), emergency(query). out: Outgoing. address(): systemId and
  // componentId of the autopilot. linkState(): of the link. recall(): a promise of the sites in reach,
  // if rally points are wanted.
  constructor({ service, out, address, linkState, log, told, store, recall }) {
    this.#service = service;
    this.#address = address;
    this.#linkState = linkState;
    this.#log = log;
    this.#told = told;
    this.#out = { send: (name, fields) => out.send(name, { ...this.#target(), ...fields }) };
    this.#parameters = new ParameterReader(this.#out);
    this.#missions = new MissionKeeper({
      out: this.#out, vehicle: () => this.#vehicle, log: (text) => log('mission', text), told, store });
    this.#rally = recall && new RallyKeeper({ out: this.#out, recall, log: (text) => log('rally', text) });
  }

  get isBusy() { return this.#missions.isBusy; }
  get missions() { return this.#missions; }
  // What is known of the aircraft and its mission, for whoever plans ahead.
  get vehicle() { return { ...this.#vehicle, items: this.#missions.items, cruise_mps: this.#parameters.cruise_mps }; }

  #target() {
    const { systemId, componentId } = this.#address();
    return { targetSystem: systemId, targetComponent: componentId };
  }

  // As `mission` of the link's state.
  state() {
    const rally = this.#rally && { num_points: this.#rally.numPoints, alarm: this.#rally.alarm };
    return { ...this.#missions.state(), ...(rally && { rally }) };
  }

  hear(name, fields, now_s) {
    if (name === 'PARAM_VALUE') {
      this.#parameters.hear(fields);
      return;
    }
    const { systemId } = this.#address();
    const isForeign = targeted.test(name) && !(fields.targetSystem === systemId &&
      (fields.targetComponent === ownComponent || fields.targetComponent === 0));
    const heard = { ...fields, isForeign };
    this.#missions.hear(name, heard, now_s);
    this.#rally?.hear(name, heard, now_s);
  }

  // Ten times a second.
  step(now_s) {
    this.#look();
    if (!this.#vehicle.isConnected) return;
    this.#parameters.step(now_s);
    this.#missions.step(now_s);
    const mayWrite = !this.#missions.isBusy && !this.#isLanding && !this.isGuided;
    this.#rally?.step(now_s, { mayWrite, home_altitude_m: this.#vehicle.home_altitude_m });
  }

  get #isLanding() { return this.#vehicle.mode === this.#vehicle.missionMode && this.#missions.state().kind === 'landing'; }

  #look() {
    const state = this.#linkState();
    const before = this.#vehicle;
    const { position } = state;
    if (state.autopilot !== this.#autopilot) {
      this.#autopilot = state.autopilot;
      this.#parameters.want(state.autopilot === 'px4' ? px4Parameters : landingParameters);
    }
    if (this.#wasArmed && state.is_armed === false) this.#missions.forgetAlarm();
    this.#wasArmed = state.is_armed;
    this.#vehicle = {
      isConnected: state.is_connected, mode: state.mode, missionMode: missionModes[state.autopilot] ?? 'AUTO',
      isArdupilot: state.autopilot === 'ardupilotmega', isKnown: state.autopilot in missionModes,
      isFlying: state.is_armed === true && this.#isFast(state.airspeed_mps),
      home_altitude_m: position && position.altitude_m - position.height_above_home_m,
      current_item: state.mission?.current_item, parameters: this.#parameters.values,
      landing_airspeed_mps: this.#parameters.landingAirspeed_mps, wind: state.wind,
    };
    if (before.mode !== undefined && this.#vehicle.mode !== before.mode) {
      if (this.#order) this.#order.wasModeChanged = true;
      this.#missions.onMode(this.#vehicle.mode);
    }
    this.#watchConnection(state);
  }

  // While the airspeed is not known, it flies as before.
  #isFast(airspeed_mps) {
    return airspeed_mps === undefined ? this.#vehicle.isFlying === true : airspeed_mps >= minFlyingAirspeed_mps;
  }

  #watchConnection(state) {
    const boots = state.clock?.num_boots;
    const isBack = state.is_connected && !this.#wasConnected;
    const isRestarted = this.#boots !== undefined && boots !== this.#boots;
    this.#boots = boots;
    this.#wasConnected = state.is_connected;
    if (isRestarted) this.#parameters.restart();
    if (isRestarted) this.#missions.doubt('the autopilot has restarted');
    else if (isBack) this.#missions.doubt('the autopilot was silent');
  }

  // command: { id, kind, site_id, wind, confirmed_by }. False if the kind is not of this file.
  take(command) {
    if (command.kind === 'mission') {
      this.#land(command);
      return true;
    }
    if (command.kind === 'rally' && !this.#rally) {
      this.#told(command.id, 'failed', 'the link was started without --rally');
      return true;
    }
    if (command.kind === 'release') {
      this.end('released');
      this.#missions.forgetAlarm();
    }
    return false;
  }

  // Whatever comes after a command to land ends it.
  end(why) {
    const order = this.#order;
    this.#order = undefined;
    if (order && !order.isPlanned) this.#told(order.id, 'failed', why);
    this.#missions.end(why);
  }

  async #land({ id, site_id, wind, confirmed_by }) {
    this.end('another landing was wanted');
    const order = { id, isPlanned: false, wasModeChanged: false };
    this.#order = order;
    this.#log('mission', `landing to ${site_id} wanted${confirmed_by ? ` by ${confirmed_by}` : ''}`);
    try {
      if (!this.#vehicle.isKnown) throw new NoLanding('landing missions are only for ArduPilot and PX4');
      const landing = await this.#landingOf(site_id, wind);
      if (this.#order !== order) return;
      order.isPlanned = true;
      this.#missions.land(id, landing, order);
    } catch (error) {
      if (this.#order !== order) return;
      order.isPlanned = true;
      this.#log('mission', `no landing to ${site_id}: ${error.message}`);
      this.#told(id, 'failed', error.message);
    }
  }

  // confirmed: the wind that the person saw the approach for, if any.
  async #landingOf(siteId, confirmed) {
    const { properties } = await this.#service.site(siteId);
    const { verdict, superseded_by, superseded_detail, reject_detail } = properties;
    if (superseded_by) throw new NoLanding(`the site is superseded: ${superseded_detail ?? superseded_by}`);
    if (verdict === 'rejected') throw new NoLanding(`the site is rejected: ${reject_detail ?? ''}`);
    const { wind } = this.#vehicle;
    const known = confirmed ?? (wind && wind.age_s <= maxWindAge_s ? wind : undefined);
    const answer = await this.#service.approach(siteId, known);
    const planned = answer.plan?.verdict ?? answer.verdict ?? verdict;
    if (planned !== 'landable') this.#log('mission', `${siteId} is UNVERIFIED: not everything was seen`);
    return landingOfApproach(siteId, {
      ...answer, altitude_datum: answer.altitude_datum ?? properties.altitude_datum, verdict: planned,
    }, properties.aircraft?.landing_airspeed_mps);
  }
}
