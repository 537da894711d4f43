// What PX4 does otherwise than ArduPlane, as its documentation and sources tell: modes, what is stored of an
// item, the transfer of a mission, and which missions it flies. No PX4 was at hand.
// https://docs.px4.io/main/en/flight_modes_fw/mission.html https://mavlink.io/en/services/mission.html

import { distance } from './frame.js';
import { command, missionType } from './items.js';

const result = { accepted: 0, error: 1, unsupportedFrame: 2, unsupported: 3, noSpace: 4 };
const maxItems = { [missionType.mission]: 500, [missionType.fence]: 64, [missionType.rally]: 32 };
const transferTimeout_s = 5;
const repeatAfter_s = 0.25;
const slopeTolerance_deg = 0.1;
const degrees = (angle_rad) => (angle_rad * 180) / Math.PI;

export const px4Parameters = { FW_LND_ANG: 5, FW_LND_AIRSPD: 0, FW_AIRSPD_MIN: 10, NAV_LOITER_RAD: 80, MIS_TKO_LAND_REQ: 2 };

// Main mode and sub mode, in the upper half of the custom mode.
const modes = { MANUAL: [1, 0], FBWA: [7, 0], STABILIZE: [7, 0], FBWB: [2, 0], CRUISE: [3, 0], AUTO: [4, 4], LOITER: [4, 3],
  GUIDED: [4, 3], CIRCLE: [4, 3], RTL: [4, 5] };
export const px4ModeNumber = (name) => modes[name][0] * 0x10000 + modes[name][1] * 0x1000000;
export const px4ModeName = (main, sub) =>
  ['AUTO', 'LOITER', 'RTL', 'MANUAL', 'FBWA', 'CRUISE'].find((name) => modes[name][0] === main && modes[name][1] === sub);

const placeFrames = new Set([0, 3, 5, 6]);
const noPlaceFrame = 2;
const intFrame = { 0: 5, 3: 6, 5: 5, 6: 6 };
const float = Math.fround;
const yaw = (value) => (Number.isNaN(value) ? NaN : float(((value % 360) + 360) % 360));

// Of params 1 to 4 of an item with a place, what comes back.
const storedParams = {
  [command.waypoint]: ([time, radius, , heading]) => [float(time), float(radius), 0, yaw(heading)],
  [command.loiterUnlimited]: ([, , radius, heading]) => [0, 0, float(radius), yaw(heading)],
  [command.loiterTime]: ([time, heading, radius, exit]) => [float(time), Number(heading > 0), float(radius), Number(exit > 0)],
  [command.land]: ([, precision, , heading]) => [0, Math.trunc(precision), 0, yaw(heading)],
  [command.takeoff]: ([, , , heading]) => [0, 0, 0, yaw(heading)],
  [command.loiterToAltitude]: ([heading, radius, , exit]) => [Number(heading > 0), float(radius), 0, Number(exit > 0)],
  [command.rallyPoint]: () => [0, 0, 0, 0],
};
const withoutPlace = new Set([command.jump, command.changeSpeed, command.landStart, command.returnToLaunch, 93, 195, 197, 201, 203, 206]);

// { result, item }: result is a MAV_MISSION_RESULT.
export function storedByPx4(sent) {
  const { frame, command: id, x, y, z } = sent;
  const params = [sent.param1, sent.param2, sent.param3, sent.param4];
  if (frame === noPlaceFrame) {
    if (!withoutPlace.has(id)) return { result: result.unsupported };
    const [param1, param2, param3, param4] = params.map(float);
    return { result: result.accepted, item: { frame, command: id, param1, param2, param3, param4, x, y, z: float(z) } };
  }
  if (!placeFrames.has(frame)) return { result: result.unsupportedFrame };
  if (!storedParams[id]) return { result: result.unsupported };
  const [param1, param2, param3, param4] = storedParams[id](params);
  return { result: result.accepted,
    item: { frame: intFrame[frame], command: id, param1, param2, param3, param4, x, y, z: float(z) } };
}

// A sentence if the mission is not flown.
export function whyNotFlown(items, { placeOf, parameters }) {
  if (items.length === 0) return 'no mission';
  if (items.filter((one) => one.command === command.landStart).length > 1) return 'more than one land start';
  const landAt = items.findIndex((one) => one.command === command.land);
  if (landAt < 0) return parameters.MIS_TKO_LAND_REQ === 2 ? 'landing required' : undefined;
  if (landAt === 0) return 'starts with landing';
  const startAt = items.findIndex((one) => one.command === command.landStart);
  if (startAt > landAt - 1) return 'invalid land start';
  return whyNotLanded(items[landAt - 1], items[landAt], placeOf, parameters);
}

function whyNotLanded(entrance, land, placeOf, { FW_LND_ANG }) {
  const [from, to] = [placeOf(entrance), placeOf(land)];
  const isCircle = entrance.command === command.loiterToAltitude;
  if (!isCircle && entrance.command !== command.waypoint) return 'landing entrance of another type';
  const fall_m = from.altitude_m - to.altitude_m;
  if (fall_m <= 0) return 'approach below the landing point';
  const radius_m = isCircle ? Math.abs(entrance.param2) : 0;
  const away_m = distance(from, to);
  if (away_m <= radius_m) return 'landing point within the circle';
  const slope_deg = degrees(Math.atan2(fall_m, Math.sqrt(away_m ** 2 - radius_m ** 2)));
  return slope_deg > FW_LND_ANG + slopeTolerance_deg ? `slope of ${slope_deg.toFixed(1)} degrees` : undefined;
}

// The list is written beside the one that is flown and takes its place when it is complete.
export class Px4ItemProtocol {
  #type;
  #send;
  #onComplete;
  #upload;
  #download;
  #asksWithInt = false;
  items = [];
  id = 0;

  // onComplete(current): a new list; current: the item marked as such, or nothing.
  constructor(type, send, { onComplete = () => {} } = {}) {
    this.#type = type;
    this.#send = send;
    this.#onComplete = onComplete;
  }

  get isReceiving() { return this.#upload !== undefined; }

  restart() {
    this.#upload = undefined;
    this.#download = undefined;
  }

  step(now_s) {
    const transfer = this.#upload ?? this.#download;
    if (!transfer) return;
    if (now_s - transfer.heard_s > transferTimeout_s) this.restart();
    else if (this.#upload && now_s - transfer.asked_s > repeatAfter_s) this.#ask(now_s);
  }

  take(name, fields, peer, now_s) { this.#handlers[name]?.call(this, fields, peer, now_s); }

  #handlers = {
    MISSION_COUNT: this.#onCount,
    MISSION_ITEM_INT: this.#onItem,
    MISSION_REQUEST_LIST: this.#onRequestList,
    MISSION_REQUEST_INT: this.#onRequest,
    MISSION_REQUEST: this.#onRequest,
    MISSION_ACK: (_, peer) => { if (isSame(peer, this.#download?.peer)) this.#download = undefined; },
  };

  #onCount({ count }, peer, now_s) {
    const upload = this.#upload;
    if (upload && isSame(peer, upload.peer) && upload.next === 0) {
      this.#ask(now_s);
      return;
    }
    if (upload || this.#download) {
      this.#acknowledge(peer, result.error);
      return;
    }
    if (count > maxItems[this.#type]) {
      this.#acknowledge(peer, result.noSpace);
      return;
    }
    this.#upload = { peer, count, next: 0, items: [], current: undefined, heard_s: now_s, asked_s: now_s };
    if (count === 0) this.#complete();
    else this.#ask(now_s);
  }

  #onItem(fields, peer, now_s) {
    const upload = this.#upload;
    this.#asksWithInt = true;
    if (!upload) {
      const isLast = this.#last && isSame(peer, this.#last.peer) && fields.seq === this.#last.count - 1;
      this.#acknowledge(peer, isLast ? result.accepted : result.error);
      return;
    }
    if (!isSame(peer, upload.peer) || fields.seq !== upload.next) return;
    upload.heard_s = now_s;
    const { result: code, item } = storedByPx4(fields);
    if (code !== result.accepted) {
      this.#upload = undefined;
      this.#acknowledge(peer, code);
      return;
    }
    upload.items.push(item);
    if (fields.current) upload.current = fields.seq;
    ++upload.next;
    if (upload.next === upload.count) this.#complete();
    else this.#ask(now_s);
  }

  #last;

  #complete() {
    const { peer, count, items, current } = this.#upload;
    this.#upload = undefined;
    this.#last = { peer, count };
    this.items = items;
    ++this.id;
    this.#onComplete(current);
    this.#acknowledge(peer, result.accepted);
  }

  #onRequestList(_, peer, now_s) {
    if (this.#upload) return;
    this.#download = { peer, next: 0, heard_s: now_s };
    this.#send('MISSION_COUNT', this.#to(peer, { count: this.items.length }));
    if (this.items.length === 0) this.#download = undefined;
  }

  // Only the next item, or the last one once more.
  #onRequest({ seq }, peer, now_s) {
    const download = this.#download;
    if (!download || !isSame(peer, download.peer)) return;
    download.heard_s = now_s;
    if (seq === download.next && seq < this.items.length) ++download.next;
    else if (seq !== download.next - 1) {
      this.#download = undefined;
      this.#acknowledge(peer, result.error);
      return;
    }
    this.#send('MISSION_ITEM_INT', this.#to(peer, { seq, ...this.items[seq], current: 0, autocontinue: 1 }));
  }

  #ask(now_s) {
    const upload = this.#upload;
    upload.asked_s = now_s;
    this.#send(this.#asksWithInt ? 'MISSION_REQUEST_INT' : 'MISSION_REQUEST', this.#to(upload.peer, { seq: upload.next }));
  }

  #acknowledge(peer, code) { this.#send('MISSION_ACK', this.#to(peer, { type: code })); }

  #to(peer, fields) {
    return { targetSystem: peer.systemId, targetComponent: peer.componentId, missionType: this.#type, ...fields };
  }
}

const isSame = (a, b) => a?.systemId === b?.systemId && a?.componentId === b?.componentId;
