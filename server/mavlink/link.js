// One link to one autopilot: packets in; telemetry lines and a state out. No sockets, no files.

import { BootClock } from './clock.js';
import { EngineWatch } from './engine/engine_watch.js';
import { capturedOf, feedbackOf, isTriggerPlace, placeOf, triggerOf } from './frames/camera_messages.js';
import { packetsInDatagram, PacketReader } from './framing.js';
import { heardMessages } from './mission/landings.js';
import { fieldsOf, idOf, MavModeFlag, nameOf } from './messages.js';
import { autopilotName, modeName, typeName } from './modes.js';
import { Pin } from './pin.js';
import { isAttitude, longestGap_s, PositionGate } from './plausibility.js';
import { Samples } from './samples.js';
import { WindSource } from './wind_source.js';

const degrees = (radians) => (radians * 180) / Math.PI;
// From here upwards a time is UNIX time, not time since boot.
const firstUnix_us = 1e15;
// A message of the camera comes soon after its exposure.
const maxTriggerDelay_us = 3e6;
const otherMessages = new Set(heardMessages.map((name) => idOf[name]));
const silent_s = 5;
const minFlyingAirspeed_mps = 8;
const minFlyingHeight_m = 5;

export class Link {
  #pin;
  #signing;
  #reader = new PacketReader();
  #gate = new PositionGate();
  #clock;
  #samples;
  #triggers;
  #wind;
  #engine = new EngineWatch();
  #onTrigger;
  #onEvent;
  #onMessage;
  #steady_us;
  #heartbeat;
  // Of the steady clock: when which was heard, and when the engine was judged.
  #heard_us;
  #attitudeHeard_us;
  #placeHeard_us;
  #hudHeard_us;
  #judged_us;
  #wasBlind = false;
  #attitude;
  #position;
  #velocity;
  #hud;
  #gps;
  #missionSequence;
  #camera = { num_triggers: 0 };
  #flyingSince_ms;
  #numAccepted = 0;
  #numDamaged = 0;
  #refused = {};

  // emit(line): one line of telemetry. onTrigger({ timestamp_us, kind, index, position?, attitude?, file? }):
  // one of the camera. onEvent(sentence): what a person wants to know.
  // onMessage(name, fields): each believed message that is not of the telemetry. steady_us(): a clock
  // that never steps.
  constructor({ pin = new Pin(), signing, clock = new BootClock(), emit, onTrigger = () => {}, onEvent = () => {}, onMessage = () => {},
    steady_us = () => performance.now() * 1000 }) {
    this.#pin = pin;
    this.#signing = signing;
    this.#clock = clock;
    this.#samples = new Samples(clock, emit);
    this.#triggers = new Samples(clock, onTrigger);
    this.#wind = new WindSource((boot_ms, wind, now_us) => this.#samples.add('wind', boot_ms, { wind }, now_us));
    this.#onTrigger = onTrigger;
    this.#onEvent = onEvent;
    this.#onMessage = onMessage;
    this.#steady_us = steady_us;
  }

  get pin() { return this.#pin; }

  // now_us: the host's clock, microseconds since 1970.
  take(bytes, from, isDatagram, now_us = Date.now() * 1000) {
    if (!this.#pin.isPossiblePeer(from, this.#steady_us())) return this.#refuse('other_peer');
    if (!isDatagram) {
      for (const packet of this.#reader.take(bytes)) this.#takePacket(packet, from, now_us);
      return undefined;
    }
    const { packets, numDamaged } = packetsInDatagram(bytes);
    this.#numDamaged += numDamaged;
    for (const packet of packets) this.#takePacket(packet, from, now_us);
    return undefined;
  }

  // Regularly, also while nothing arrives.
  tick(now_us = Date.now() * 1000) {
    this.#samples.release(now_us);
    this.#triggers.release(now_us);
    const isBlind = this.#isBlind;
    if (isBlind && !this.#wasBlind) this.#onEvent(`engine: unknown, because position, attitude or airspeed has not come for ${longestGap_s} s`);
    this.#wasBlind = isBlind;
  }

  #age_s(heard_us) { return heard_us === undefined ? undefined : (this.#steady_us() - heard_us) / 1e6; }
  #isRecent(heard_us) { return this.#age_s(heard_us) <= longestGap_s; }
  // An engine that has failed counts as failed until it is seen to run.
  get #isBlind() { return this.#engine.state === 'running' && !this.#isRecent(this.#judged_us); }

  #refuse(reason) { this.#refused[reason] = (this.#refused[reason] ?? 0) + 1; }

  #takePacket(packet, from, now_us) {
    // The signature first: a forged packet must not pin a peer.
    const forged = this.#signing?.refusal(packet);
    if (forged) return this.#refuse(forged);
    const isHeartbeat = packet.messageId === idOf.HEARTBEAT;
    const heartbeat = isHeartbeat ? fieldsOf(packet) : undefined;
    const wasPinned = this.#pin.peer;
    const refusal = this.#pin.refusal(packet, from, this.#steady_us(), heartbeat);
    if (refusal) return this.#refuse(refusal);
    if (this.#pin.peer !== wasPinned) this.#onEvent(`system ${packet.systemId} is heard at ${from}`);
    ++this.#numAccepted;
    const handler = this.#handlers[packet.messageId];
    const isOther = otherMessages.has(packet.messageId);
    if (!handler && !isOther) return undefined;
    const fields = heartbeat ?? fieldsOf(packet);
    if (handler) handler.call(this, fields, now_us, packet.componentId === this.#pin.componentId);
    if (isOther) this.#onMessage(nameOf(packet.messageId), fields);
    return undefined;
  }

  #handlers = {
    [idOf.HEARTBEAT]: this.#onHeartbeat,
    [idOf.SYSTEM_TIME]: this.#onSystemTime,
    [idOf.ATTITUDE]: this.#onAttitude,
    [idOf.GLOBAL_POSITION_INT]: this.#onPosition,
    [idOf.GPS_RAW_INT]: this.#onGps,
    [idOf.VFR_HUD]: this.#onHud,
    [idOf.WIND]: this.#onWind,
    [idOf.WIND_COV]: this.#onWindCov,
    [idOf.SYS_STATUS]: (status) => this.#hearSign('current_a', status.currentBattery / 100),
    [idOf.RPM]: (rpm) => this.#hearSign('rpm', Math.max(rpm.rpm1, rpm.rpm2)),
    [idOf.EFI_STATUS]: (efi) => this.#hearSign('rpm', efi.rpm),
    [idOf.ESC_TELEMETRY_1_TO_4]: (esc) => this.#hearSign('rpm', Math.max(...esc.rpm)),
    [idOf.MISSION_CURRENT]: (mission) => { this.#missionSequence = mission.seq; },
    [idOf.CAMERA_TRIGGER]: (camera, ...more) => this.#onCamera(triggerOf(camera), ...more),
    [idOf.CAMERA_FEEDBACK]: (camera, ...more) => this.#onCamera(feedbackOf(camera), ...more),
    [idOf.CAMERA_IMAGE_CAPTURED]: (camera, ...more) => this.#onCamera(capturedOf(camera), ...more),
  };

  #onHeartbeat(heartbeat) {
    this.#heard_us = this.#steady_us();
    const isArmed = (heartbeat.baseMode & MavModeFlag.SAFETY_ARMED) !== 0;
    if (this.#heartbeat && isArmed !== this.#isArmed) this.#onEvent(isArmed ? 'armed' : 'disarmed');
    this.#heartbeat = heartbeat;
  }

  get #isArmed() { return ((this.#heartbeat?.baseMode ?? 0) & MavModeFlag.SAFETY_ARMED) !== 0; }

  #hear(boot_ms, now_us) {
    if (this.#clock.hear(boot_ms, now_us)) return;
    this.#onEvent('the autopilot has restarted');
    this.#samples.restart();
    this.#triggers.restart();
    this.#gate.restart();
    this.#wind.restart();
    this.#engine = new EngineWatch();
    this.#flyingSince_ms = undefined;
  }

  #onSystemTime({ timeUnixUsec, timeBootMs }, now_us) {
    this.#hear(timeBootMs, now_us);
    this.#clock.set(Number(timeUnixUsec), timeBootMs);
    this.#samples.release(now_us);
  }

  #onAttitude(attitude, now_us) {
    this.#hear(attitude.timeBootMs, now_us);
    if (!isAttitude(attitude)) return this.#refuse('absurd_attitude');
    this.#attitude = attitude;
    this.#attitudeHeard_us = this.#steady_us();
    return this.#samples.add('attitude', attitude.timeBootMs, {
      attitude: {
        roll_deg: degrees(attitude.roll), pitch_deg: degrees(attitude.pitch), yaw_deg: degrees(attitude.yaw),
      },
    }, now_us);
  }

  #onPosition(message, now_us) {
    this.#hear(message.timeBootMs, now_us);
    const { position } = placeOf(message.lat, message.lon, message.alt / 1000);
    const refusal = this.#gate.refusal({ ...position, time_s: message.timeBootMs / 1000 });
    if (refusal) return this.#refuse(refusal);
    this.#placeHeard_us = this.#steady_us();
    this.#position = { ...position, height_above_home_m: message.relativeAlt / 1000 };
    this.#velocity = { east_mps: message.vy / 100, north_mps: message.vx / 100, climb_mps: -message.vz / 100 };
    this.#samples.add('position', message.timeBootMs, { position, altitude_datum: 'amsl' }, now_us);
    return this.#onMotion(message, now_us);
  }

  #onMotion(message, now_us) {
    const hud = this.#hud;
    if (!this.#isRecent(this.#attitudeHeard_us) || !this.#isRecent(this.#hudHeard_us)) return;
    const motion = {
      time_s: message.timeBootMs / 1000,
      east_mps: message.vy / 100,
      north_mps: message.vx / 100,
      climb_mps: -message.vz / 100,
      heading_rad: this.#attitude.yaw,
      bank_rad: this.#attitude.roll,
      airspeed_mps: hud.airspeed,
      height_m: message.relativeAlt / 1000,
      isArmed: this.#isArmed,
    };
    const isFlying = motion.isArmed && hud.airspeed >= minFlyingAirspeed_mps &&
      motion.height_m >= minFlyingHeight_m;
    this.#flyingSince_ms = isFlying ? this.#flyingSince_ms ?? message.timeBootMs : undefined;
    if (isFlying) this.#wind.move(motion, now_us);
    this.#judged_us = this.#steady_us();
    if (!this.#engine.step(motion)) return;
    if (this.#engine.state === 'failed') this.#onEvent(`ENGINE FAILURE: ${this.#engine.reason}`);
    else this.#onEvent(`engine: ${this.#engine.state}`);
  }

  #onGps(gps) { this.#gps = gps; }

  #onHud(hud) {
    if (!Number.isFinite(hud.airspeed) || !Number.isFinite(hud.groundspeed)) return;
    this.#hud = hud;
    this.#hudHeard_us = this.#steady_us();
    if (this.#clock.newest_ms === undefined) return;
    this.#engine.hearThrottle(hud.throttle / 100, this.#clock.newest_ms / 1000);
  }

  #hearSign(sign, value) {
    if (this.#clock.newest_ms === undefined) return;
    this.#engine.hearSign(sign, value, this.#clock.newest_ms / 1000);
  }

  // No time of its own: it comes with the newest message that has one.
  #onWind({ direction, speed }, now_us) {
    this.#wind.hearFrom({ from_deg: direction, speed_mps: speed }, this.#clock.newest_ms,
      this.#flyingSince_ms, now_us);
  }

  #onWindCov({ windX, windY }, now_us) {
    this.#wind.hearTowards({ east_mps: windY, north_mps: windX }, this.#clock.newest_ms, now_us);
  }

  // Time since boot is of the autopilot's boot only if the autopilot tells it.
  #isTriggerTime(time_us, now_us, isAutopilot) {
    const isUnix = time_us >= firstUnix_us;
    const own_us = isUnix ? this.#clock.utc_us(this.#clock.newest_ms, now_us) : this.#clock.newest_ms * 1000;
    return (isUnix || (isAutopilot && time_us > 0)) && Math.abs(own_us - time_us) <= maxTriggerDelay_us;
  }

  #onCamera(trigger, now_us, isAutopilot) {
    if (!trigger) return undefined;
    const { time_us, position, attitude, ...details } = trigger;
    ++this.#camera.num_triggers;
    // Without such a time it fits to no picture.
    if (!this.#isTriggerTime(time_us, now_us, isAutopilot)) return this.#refuse('trigger_time');
    const isUnix = time_us >= firstUnix_us;
    const timestamp_us = isUnix ? time_us : this.#clock.utc_us(time_us / 1000, now_us);
    this.#camera.last = { timestamp_us, ...details, ...(position && { position }) };
    const told = isTriggerPlace(position, this.#position) ? { ...details, position, attitude } : details;
    return isUnix ? this.#onTrigger({ timestamp_us, ...told }) : this.#triggers.add(details.kind, time_us / 1000, told, now_us);
  }

  // As an item of /v1/links.
  state(now_us = Date.now() * 1000) {
    const heartbeat = this.#heartbeat;
    const age_s = this.#age_s(this.#heard_us);
    const hud = this.#isRecent(this.#hudHeard_us) ? this.#hud : undefined;
    const velocity = this.#velocity;
    const utc = (time_s) => timeText(this.#clock.utc_us(time_s * 1000, now_us));
    return {
      id: this.#pin.systemId === undefined ? undefined : String(this.#pin.systemId),
      system_id: this.#pin.systemId,
      peer: this.#pin.peer,
      is_connected: age_s !== undefined && age_s < silent_s,
      age_s,
      type: heartbeat && typeName(heartbeat.type),
      autopilot: heartbeat && autopilotName(heartbeat.autopilot),
      mode: heartbeat && modeName(heartbeat.autopilot, heartbeat.customMode),
      is_armed: heartbeat && this.#isArmed,
      is_signed: Boolean(this.#signing),
      position: this.#position && { ...this.#position, altitude_datum: 'amsl', age_s: this.#age_s(this.#placeHeard_us) },
      velocity,
      airspeed_mps: hud?.airspeed,
      ground_speed_mps: hud?.groundspeed ?? (velocity && Math.hypot(velocity.east_mps, velocity.north_mps)),
      climb_mps: hud?.climb ?? velocity?.climb_mps,
      throttle_ratio: hud && hud.throttle / 100,
      gps: this.#gps && {
        fix_type: this.#gps.fixType,
        num_satellites: this.#gps.satellitesVisible === 255 ? undefined : this.#gps.satellitesVisible,
        position_sd_m: this.#gps.hAcc ? this.#gps.hAcc / 1000 : undefined,
        altitude_sd_m: this.#gps.vAcc ? this.#gps.vAcc / 1000 : undefined,
      },
      wind: this.#wind.state(this.#clock.newest_ms),
      mission: { state: 'unknown', current_item: this.#missionSequence },
      engine: {
        state: this.#isBlind ? 'unknown' : this.#engine.state,
        since: this.#engine.since_s === undefined ? undefined : utc(this.#engine.since_s),
        reason: this.#engine.reason,
      },
      camera: this.#camera,
      clock: {
        source: this.#clock.source(now_us),
        spread_ms: this.#clock.spread_us === undefined ? undefined : this.#clock.spread_us / 1000,
        num_boots: this.#clock.numBoots,
      },
      packets: {
        accepted: this.#numAccepted, damaged: this.#numDamaged + this.#reader.numDamaged, refused: { ...this.#refused },
      },
      samples: { waiting_for_utc: this.#samples.numHeld, without_utc: this.#samples.numDropped },
    };
  }
}

const timeText = (time_us) => (time_us === undefined ? undefined : new Date(time_us / 1000).toISOString());
