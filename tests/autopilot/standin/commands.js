// COMMAND_LONG, COMMAND_INT and guided targets, with ArduPlane's answers.

import { command, missionType } from './items.js';

const result = { accepted: 0, temporarilyRejected: 1, denied: 2, unsupported: 3, failed: 4 };
const globalFrames = new Set([0, 5]);
const relativeFrames = new Set([3, 6]);
const customModeFlag = 1;
const changeModeFlag = 1;
const guidedItem = 2;
const changeAltitudeItem = 3;
// Bits of SET_POSITION_TARGET that say that latitude, longitude and altitude are not meant.
const ignoresPlace = 0b111;

export class Commands {
  #plane;

  // plane: control, arm(isArming, isForced), send, placeAt({ x, y, z, frame }), parameters, mission().
  constructor(plane) { this.#plane = plane; }

  take(name, fields, peer) { this.#handlers[name]?.call(this, fields, peer); }

  #handlers = {
    COMMAND_LONG: (fields, peer) => this.#onCommand(fields.command, {
      params: [0, fields._param1, fields._param2, fields._param3, fields._param4, fields._param5, fields._param6, fields._param7],
      frame: 3, x: fields._param5 * 1e7, y: fields._param6 * 1e7, z: fields._param7 }, peer),
    COMMAND_INT: (fields, peer) => this.#onCommand(fields.command, {
      params: [0, fields._param1, fields._param2, fields._param3, fields._param4],
      frame: fields.frame, x: fields._param5, y: fields._param6, z: fields._param7 }, peer),
    SET_MODE: ({ customMode, baseMode }) => {
      if (baseMode & customModeFlag) this.#plane.control.setModeNumber(customMode);
    },
    SET_POSITION_TARGET_GLOBAL_INT: this.#onPositionTarget,
    MISSION_ITEM_INT: this.#onGuidedItem,
    MISSION_SET_CURRENT: ({ seq }) => { this.#plane.control.setCurrent(seq); },
    PARAM_REQUEST_READ: this.#onParamRequest,
  };

  #onCommand(id, more, peer) {
    const handler = this.#commands[id];
    const code = handler ? handler.call(this, more) : result.unsupported;
    this.#plane.send('COMMAND_ACK', { command: id, result: code, progress: 0, resultParam2: 0,
      targetSystem: peer.systemId, targetComponent: peer.componentId });
  }

  #commands = {
    17: () => this.#mode('LOITER'),
    20: () => this.#mode('RTL'),
    176: ({ params }) => (this.#plane.control.setModeNumber(params[2]) ? result.accepted : result.failed),
    178: this.#changeSpeed,
    189: () => (this.#plane.control.land() ? result.accepted : result.failed),
    192: this.#reposition,
    224: ({ params }) => (this.#plane.control.setCurrent(params[1]) ? result.accepted : result.denied),
    300: () => this.#mode('AUTO'),
    400: ({ params }) => (this.#plane.arm(params[1] === 1, params[2] === 21196) ? result.accepted : result.failed),
    511: ({ params }) => (this.#plane.setInterval(params[1], params[2]) ? result.accepted : result.failed),
    512: ({ params }) => (this.#plane.sendOnce(params[1]) ? result.accepted : result.failed),
    43000: this.#guidedSpeed,
  };

  #mode(name) { return this.#plane.control.setMode(name) ? result.accepted : result.failed; }

  #changeSpeed({ params }) {
    const { control } = this.#plane;
    if (control.mode !== 'AUTO' && control.mode !== 'GUIDED') return result.failed;
    return control.changeSpeed(params[1], params[2]) ? result.accepted : result.failed;
  }

  #guidedSpeed({ params }) {
    const { control, parameters } = this.#plane;
    if (control.mode !== 'GUIDED') return result.failed;
    if (params[1] !== 0 || params[2] < parameters.AIRSPEED_MIN || params[2] > parameters.AIRSPEED_MAX) return result.denied;
    control.changeGuidedSpeed(params[2]);
    return result.accepted;
  }

  #reposition({ params, frame, x, y, z }) {
    const { control } = this.#plane;
    const isPlace = Number.isFinite(z) && (globalFrames.has(frame) || relativeFrames.has(frame));
    if (!isPlace || Math.abs(x) > 9e8 || Math.abs(y) > 18e8) return result.denied;
    if (!(params[2] & changeModeFlag) && control.mode !== 'GUIDED') return result.failed;
    control.setMode('GUIDED');
    const isCounterClockwise = Number.isFinite(params[4]) && params[4] !== 0;
    const radius_m = Number.isFinite(params[3]) && params[3] > 0 ? params[3] : undefined;
    control.goTo(this.#plane.placeAt({ x, y, z, frame }), radius_m, isCounterClockwise ? -1 : 1);
    return result.accepted;
  }

  #onPositionTarget({ coordinateFrame, typeMask, latInt, lonInt, alt }) {
    const { control } = this.#plane;
    if (control.mode !== 'GUIDED') return;
    const isPlane = globalFrames.has(coordinateFrame) || relativeFrames.has(coordinateFrame);
    if (!isPlane || !Number.isFinite(alt)) return;
    const target = this.#plane.placeAt({ x: latInt, y: lonInt, z: alt, frame: coordinateFrame });
    if ((typeMask & ignoresPlace) === 0) control.goTo(target);
    else if ((typeMask & 0b100) === 0) control.goTo({ ...control.guidedPlace, altitude_m: target.altitude_m });
  }

  // True if the item was a target and no part of an upload.
  #onGuidedItem(item, peer) {
    const { control } = this.#plane;
    let isAccepted = control.mode === 'GUIDED' || item.current === guidedItem;
    if (item.current === guidedItem && item.command === command.waypoint) {
      isAccepted = control.setMode('GUIDED');
      control.goTo(this.#plane.placeAt(item));
    } else if (item.current === changeAltitudeItem && control.guidedPlace) {
      control.goTo({ ...control.guidedPlace, altitude_m: this.#plane.placeAt(item).altitude_m });
    }
    this.#plane.send('MISSION_ACK', { targetSystem: peer.systemId, targetComponent: peer.componentId,
      type: isAccepted ? 0 : 1, missionType: missionType.mission });
  }

  #onParamRequest({ paramId, paramIndex }) {
    const names = Object.keys(this.#plane.parameters);
    const name = paramIndex >= 0 ? names[paramIndex] : paramId;
    const value = this.#plane.parameters[name];
    if (value !== undefined) this.#plane.sendParameter(name);
  }
}

export const isGuidedItem = (fields) => fields.current === guidedItem || fields.current === changeAltitudeItem;
