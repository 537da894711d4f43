// A stand-in for a real ArduPlane: flies, and speaks MAVLink 2. No sockets and no clock of its own:
// step() lets time pass.
//
//   const plane = new Standin({ seed: 3, wind: { speed_mps: 4, from_deg: 250 } });
//   plane.onSend = (bytes) => link.take(bytes, '127.0.0.1 5760', true, plane.utc_us);
//   plane.startInFlight({ height_m: 150, heading_deg: 40 });
//   plane.stopEngine();
//   plane.step(30);

import { packetsInDatagram } from '../../../server/mavlink/framing.js';
import { nameOf } from '../../../server/mavlink/messages.js';
import { Signing } from '../../../server/mavlink/signing.js';
import { Air } from './air.js';
import { Body } from './body.js';
import { Commands, isGuidedItem } from './commands.js';
import { FlightControl } from './flight_control.js';
import { distance, LocalFrame } from './frame.js';
import { flat } from './ground.js';
import { itemLists, storedItem } from './item_lists.js';
import { command, missionType, placeOf } from './items.js';
import { standinOptions } from './options.js';
import { whyNotFlown } from './px4.js';
import { Random } from './random.js';
import { Sensors } from './sensors.js';
import { Streams } from './streams.js';
import { allZero, fieldsOf, Sender } from './wire.js';

const radians = (degrees) => (degrees * Math.PI) / 180;
const degrees = (angle_rad) => (angle_rad * 180) / Math.PI;
const inform = 6;
const warn = 2;
const restSpeed_mps = 0.3;
const hardSink_mps = 3.5;
const hardBank_rad = radians(35);
const itemMessages = new Set(['MISSION_COUNT', 'MISSION_ITEM_INT', 'MISSION_REQUEST_LIST', 'MISSION_REQUEST_INT',
  'MISSION_REQUEST', 'MISSION_CLEAR_ALL', 'MISSION_ACK']);
const ardupilot = 3;
const px4 = 12;

export class Standin {
  #options;
  #body;
  #air;
  #sensors;
  #streams;
  #commands;
  #sender;
  #signing;
  #protocols;
  #frame;
  #time_s = 0;
  #booted_s = 0;
  #silentUntil_s = 0;
  #used_as = 0;
  #imageIndex = 0;
  #restedAt_s;
  #wind;
  onSend = () => {};
  onText = () => {};
  // Of the ground: touchdown and where it came to rest.
  touchdown;
  rest;
  control;
  parameters;
  home;
  ground;

  // options: as of options.js. signingKey: 32 bytes; then everything is signed and must be.
  constructor(options = {}, { signingKey } = {}) {
    const all = standinOptions(options);
    this.#options = all;
    this.home = { ...all.home };
    this.parameters = { ...all.parameters };
    this.ground = all.ground ?? flat(all.home.altitude_m);
    this.#frame = new LocalFrame(all.home);
    const random = new Random(all.seed);
    this.#air = new Air(all.wind, random);
    this.#sensors = new Sensors(all.sensors, random);
    this.#body = new Body(all.aircraft);
    this.#wind = this.#air.step(0, 0);
    this.#body.place({ altitude_m: this.ground(0, 0), heading_rad: radians(all.runway_heading_deg) }, this.#wind);
    this.#streams = new Streams(all.rates_hz);
    this.#signing = signingKey && new Signing(signingKey, '');
    this.#sender = new Sender({ systemId: all.system_id, componentId: all.component_id },
      signingKey && new Signing(signingKey, ''));
    this.#protocols = this.#newProtocols();
    this.control = this.#newControl();
    this.#commands = this.#newCommands();
  }

  get options() { return this.#options; }
  get isPx4() { return this.#options.firmware === 'px4'; }
  // Item 0 of ArduPlane is its home.
  get #firstItem() { return this.isPx4 ? 0 : 1; }
  get time_s() { return this.#time_s; }
  get utc_us() { return Math.round(this.#options.start_us + this.#time_s * 1e6); }
  get frame() { return this.#frame; }
  get body() { return this.#body; }
  get mission() { return this.#protocols[missionType.mission].items; }
  get rally() { return this.#protocols[missionType.rally].items; }
  get isReceivingItems() { return Object.values(this.#protocols).some((one) => one.isReceiving); }

  // What is true, not what it believes.
  get truth() {
    const body = this.#body;
    const velocity = body.velocity;
    return {
      time_s: this.#time_s, east_m: body.east_m, north_m: body.north_m, altitude_m: body.altitude_m,
      ...this.#frame.toGlobal(body), height_m: body.altitude_m - this.ground(body.east_m, body.north_m),
      airspeed_mps: body.airspeed_mps, indicated_mps: body.indicated_mps, climb_mps: body.climb_mps, heading_deg: degrees(body.heading_rad),
      bank_deg: degrees(body.bank_rad), ground_speed_mps: Math.hypot(velocity.east_mps, velocity.north_mps),
      ...velocity, wind: this.#wind, throttle: body.throttle, isOnGround: body.isOnGround,
      isEngineStopped: body.isEngineStopped, mode: this.control.mode, isArmed: this.control.isArmed,
    };
  }

  // In the air, armed, with a wind estimate that has settled.
  startInFlight({ east_m = 0, north_m = 0, height_m = 150, heading_deg = 90, airspeed_mps, mode = 'LOITER' } = {}) {
    const altitude_m = this.ground(east_m, north_m) + height_m;
    this.#wind = this.#air.step(0, height_m);
    this.#body.place({ east_m, north_m, altitude_m, heading_rad: radians(heading_deg), isOnGround: false,
      airspeed_mps: airspeed_mps ?? this.parameters.AIRSPEED_CRUISE }, this.#wind);
    this.#booted_s = this.#time_s - 120;
    this.control.isArmed = true;
    for (let i = 0; i < 60; ++i) {
      this.#sensors.step(1, { isOnGround: false, airspeed_mps: 20, heading_rad: i }, this.#air.mean(height_m));
    }
    if (!this.control.setMode(mode)) throw new Error(`mode ${mode} is refused`);
    return this;
  }

  stopEngine() { this.#body.isEngineStopped = true; }
  startEngine() { this.#body.isEngineStopped = false; }

  // By the pilot's own switch, not by a message.
  pilotMode(name) { return this.control.setMode(name); }

  // bank_deg, path_deg, throttle: the sticks of MANUAL, FBWA, FBWB and CRUISE.
  pilotSticks({ bank_deg = 0, path_deg = 0, throttle = 0.5 }) {
    Object.assign(this.control.pilot, { bank_rad: radians(bank_deg), path_rad: radians(path_deg), throttle });
  }

  // Items as sent: frame, command, param1 to 4, x, y, z.
  loadMission(items) {
    this.#protocols[missionType.mission].items = items.map((item) => storedItem(this.isPx4, item));
    this.parameters.MIS_TOTAL = items.length;
  }

  // The autopilot starts anew in flight: it is silent, then its time begins again. Items stay.
  restart(outage_s = 3) {
    this.#silentUntil_s = this.#time_s + outage_s;
    this.#booted_s = this.#silentUntil_s;
    Object.values(this.#protocols).forEach((one) => one.restart());
    this.#streams.restart();
    this.#sensors.restart();
  }

  arm(isForced = false) { return this.#arm(true, isForced); }

  // Triggers the camera.
  takePicture() {
    ++this.#imageIndex;
    this.#emit('CAMERA_FEEDBACK', this.#streams.fields('CAMERA_FEEDBACK', this.#state()));
  }

  step(duration_s = this.#options.step_s) {
    const { step_s } = this.#options;
    const end_s = this.#time_s + duration_s - step_s / 2;
    while (this.#time_s < end_s) this.#stepOnce(step_s);
  }

  // Bytes from a ground station or a companion.
  take(bytes) {
    if (this.#time_s < this.#silentUntil_s) return;
    for (const packet of packetsInDatagram(bytes).packets) {
      if (this.#signing?.refusal(packet)) continue;
      const fields = fieldsOf(packet);
      if (fields.targetSystem && fields.targetSystem !== this.#options.system_id) continue;
      this.#dispatch(nameOf(packet.messageId), fields, { systemId: packet.systemId, componentId: packet.componentId });
    }
  }

  #dispatch(name, fields, peer) {
    if (itemMessages.has(name) && !(name === 'MISSION_ITEM_INT' && isGuidedItem(fields))) {
      this.#protocols[fields.missionType]?.take(name, fields, peer, this.#time_s);
      return;
    }
    this.#commands.take(name, fields, peer);
  }

  #stepOnce(step_s) {
    const body = this.#body;
    const height_m = body.altitude_m - this.ground(body.east_m, body.north_m);
    this.#wind = this.#air.step(step_s, height_m);
    this.#sensors.step(step_s, body, this.#air.mean(height_m));
    const demand = this.control.step(step_s);
    body.step(step_s, demand, this.#wind);
    this.#time_s += step_s;
    this.#meetGround();
    this.#used_as += this.#current_a() * step_s;
    if (this.#time_s < this.#silentUntil_s) return;
    Object.values(this.#protocols).forEach((one) => one.step(this.#time_s));
    this.#sendStreams();
  }

  #meetGround() {
    const body = this.#body;
    const ground_m = this.ground(body.east_m, body.north_m);
    if (body.isOnGround) {
      body.altitude_m = ground_m;
      this.#watchRest();
    } else if (body.altitude_m < ground_m) {
      const isHard = body.climb_mps < -hardSink_mps || Math.abs(body.bank_rad) > hardBank_rad;
      this.touchdown = { ...this.truth, sink_mps: -body.climb_mps, isHard, isFlared: this.control.mission.isFlaring };
      body.isBroken = isHard || !this.control.mission.isFlaring;
      body.touchDown(ground_m);
      this.#text(`SIM Hit ground at ${this.touchdown.sink_mps.toFixed(6)} m/s`);
    }
  }

  #watchRest() {
    if (!this.touchdown) return;
    const isAtRest = this.#body.airspeed_mps < restSpeed_mps;
    this.#restedAt_s = isAtRest ? this.#restedAt_s ?? this.#time_s : undefined;
    if (isAtRest) this.rest ??= this.truth;
    const { mission } = this.control;
    const isOver = isAtRest && mission.isFlaring && this.#time_s - this.#restedAt_s > this.parameters.LAND_DISARMDELAY;
    if (!isOver || !this.control.isArmed) return;
    this.control.isArmed = false;
    this.#text('Throttle disarmed');
    this.#text('Auto disarmed');
    this.#text(`Distance from LAND point=${distance(this.#body, mission.landPoint).toFixed(2)}m`);
  }

  // What the control and the streams work with.
  #now() {
    const body = this.#body;
    const believed = this.#sensors.place(body);
    return { ...believed, airspeed_mps: body.indicated_mps, acceleration_mps2: body.acceleration_mps2,
      power_ratio: body.power_ratio, climb_mps: body.climb_mps, path_rad: body.path_rad, velocity: body.velocity, wind: this.#sensors.wind,
      drag_ratio: body.drag_ratio(body.load), levelDrag_ratio: (airspeed_mps) => body.drag_ratio(1, airspeed_mps), max_thrust_ratio: this.#options.aircraft.max_thrust_ratio };
  }

  #state() {
    const read = this.#sensors.read(this.#body);
    const { sensors, aircraft } = this.#options;
    const { east_mps, north_mps } = this.#sensors.wind;
    if (!sensors.has_airspeed) read.airspeed_mps = Math.hypot(read.east_mps - east_mps, read.north_mps - north_mps);
    return {
      ...read, ...this.#frame.toGlobal(read), home: this.home, wind: this.#sensors.wind, utc_us: this.utc_us,
      boot_ms: Math.round((this.#time_s - this.#booted_s) * 1000), throttle: this.control.isArmed ? this.#body.throttle : 0,
      isArmed: this.control.isArmed, modeNumber: this.control.modeNumber,
      rpm: aircraft.max_rpm * this.#body.power_ratio, current_a: this.#current_a(),
      battery_ratio: 1 - this.#used_as / 3600 / aircraft.battery_ah,
      sendsCurrent: sensors.sends_current, sendsRpm: sensors.sends_rpm,
      missionIndex: this.control.mission.index, numItems: this.mission.length, autopilot: this.isPx4 ? px4 : ardupilot,
      totalItems: this.isPx4 ? this.mission.length || 0xffff : Math.max(0, this.mission.length - 1),
      missionId: this.#protocols[missionType.mission].id ?? 0,
      isInMission: this.control.mode === 'AUTO', imageIndex: this.#imageIndex,
    };
  }

  #current_a() {
    const { max_current_a, idle_current_a } = this.#options.aircraft;
    return idle_current_a + max_current_a * this.#body.power_ratio ** 2;
  }

  #sendStreams() {
    const names = this.#streams.due(this.#time_s);
    if (names.length === 0) return;
    const state = this.#state();
    for (const name of names) {
      if (name === 'CAMERA_FEEDBACK') state.imageIndex = ++this.#imageIndex;
      const fields = this.#streams.fields(name, state);
      if (fields) this.#emit(name, fields);
    }
  }

  #emit(name, fields) {
    if (this.#time_s < this.#silentUntil_s) return;
    this.onSend(this.#sender.bytes(name, { ...allZero(name), ...fields }, this.utc_us / 1000), name);
  }

  #text(text, severity = inform) {
    this.onText(text);
    this.#emit('STATUSTEXT', { severity, text: text.slice(0, 50) });
  }

  #arm(isArming, isForced) {
    if (!isArming) {
      if (!this.#body.isOnGround && !isForced) return false;
      this.control.isArmed = false;
      this.#text('Throttle disarmed');
      return true;
    }
    const hasLanding = this.mission.some((item) => item.command === command.landStart);
    const isEarly = this.#time_s - this.#booted_s < this.#options.arming_refused_s;
    const reason = isEarly ? 'Gyros inconsistent'
      : hasLanding && this.parameters.RTL_AUTOLAND === 0 ? 'DO_LAND_START set and RTL_AUTOLAND disabled' : undefined;
    if (reason && !isForced) {
      this.#text(`Arm: ${reason}`, warn);
      return false;
    }
    this.control.isArmed = true;
    this.#text('Throttle armed');
    return true;
  }

  #newProtocols() {
    const send = (name, fields) => this.#emit(name, fields);
    const hooks = {
      onTruncate: (count) => {
        this.parameters.MIS_TOTAL = Math.min(this.parameters.MIS_TOTAL, count);
        this.control.mission.onTruncate(count);
      },
      onItem: (index) => {
        if (index < this.parameters.MIS_TOTAL) return;
        this.parameters.MIS_TOTAL = index + 1;
        this.#sendParameter('MIS_TOTAL');
      },
      onComplete: () => this.#text('Flight plan received'),
      onText: (text) => this.#text(text, warn),
      home: () => this.#homeItem(),
      onNewMission: (current) => this.#beginMission(current),
    };
    return itemLists(this.isPx4, send, hooks);
  }

  // Of PX4: a new mission begins with the item that is marked, else with the first.
  #beginMission(current = 0) {
    this.control.mission.select(current);
    if (this.control.mode !== 'AUTO') return;
    if (this.#whyNotFlown()) this.control.setMode('LOITER');
    else this.control.mission.start(current);
  }

  #whyNotFlown() {
    if (!this.isPx4) return this.mission.length < 2 ? 'no mission' : undefined;
    return whyNotFlown(this.mission, { placeOf: (item) => this.#place(item), parameters: this.parameters });
  }

  // Before the first fix it is 0, 0.
  #homeItem() {
    const isKnown = this.#time_s - this.#booted_s > 10;
    const { latitude_deg, longitude_deg, altitude_m } = this.home;
    const place = isKnown
      ? { x: Math.round(latitude_deg * 1e7), y: Math.round(longitude_deg * 1e7), z: altitude_m } : { x: 0, y: 0, z: 0 };
    return { frame: 0, command: command.waypoint, param1: 0, param2: 0, param3: 0, param4: 0, ...place };
  }

  #place(item) {
    return placeOf(item, { frame: this.#frame, home: this.home, ground: this.ground, here: this.#now() });
  }

  #newControl() {
    return new FlightControl({
      isPx4: this.isPx4,
      firstItem: this.#firstItem,
      whyNotFlown: () => this.#whyNotFlown(),
      now: () => this.#now(),
      parameters: this.parameters,
      items: () => this.mission,
      placeOf: (item) => this.#place(item),
      homeAltitude_m: () => this.home.altitude_m,
      home: () => ({ east_m: 0, north_m: 0, altitude_m: this.home.altitude_m + this.parameters.RTL_ALTITUDE }),
      rallyPlaces: () => this.rally.map((item) => this.#place(item)),
      text: (text) => this.#text(text),
      reached: (seq) => this.#emit('MISSION_ITEM_REACHED', { seq }),
    });
  }

  #newCommands() {
    return new Commands({
      isPx4: this.isPx4,
      control: this.control,
      parameters: this.parameters,
      send: (name, fields) => this.#emit(name, fields),
      placeAt: (item) => this.#place(item),
      arm: (isArming, isForced) => this.#arm(isArming, isForced),
      sendParameter: (name) => this.#sendParameter(name),
      setInterval: (id, interval_us) => this.#streams.setInterval(nameOf(id), interval_us),
      sendOnce: (id) => {
        const fields = this.#streams.fields(nameOf(id), this.#state());
        if (fields) this.#emit(nameOf(id), fields);
        return fields !== undefined;
      },
    });
  }

  #sendParameter(name) {
    const names = Object.keys(this.parameters);
    this.#emit('PARAM_VALUE', { paramId: name, paramValue: this.parameters[name], paramType: 9,
      paramCount: names.length, paramIndex: names.indexOf(name) });
  }
}
