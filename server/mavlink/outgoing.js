// The closed list of what this program may send to an autopilot. Nothing is sent past this file.
//
// Not in the list, and refused: arming and disarming, taking off, setting parameters, servos, relays,
// motors, the home, and every other message and command of MAVLink.

import { MavCmd, MavComponent, MavModeFlag, messageOf, packetBytes, PlaneMode, SpeedType } from './messages.js';

// A companion computer is a component of the aircraft's own system. It is no ground station, so the
// autopilot's ground station failsafe does not count it.
export const ownComponent = MavComponent.ONBOARD_COMPUTER;

const autoModes = new Set([PlaneMode.AUTO, PlaneMode.GUIDED]);

// Each one tells whether it may be sent, by its fields.
const allowedCommands = {
  [MavCmd.DO_SET_MODE]: ({ _param1, _param2 }) => _param1 === MavModeFlag.CUSTOM_MODE_ENABLED && autoModes.has(_param2),
  [MavCmd.DO_CHANGE_SPEED]: ({ _param1 }) => _param1 === SpeedType.AIRSPEED,
  [MavCmd.DO_LAND_START]: () => true,
  [MavCmd.DO_REPOSITION]: () => true,
};
const isAllowedCommand = (fields) => allowedCommands[fields.command]?.(fields) ?? false;

export const allowed = {
  HEARTBEAT: () => true,
  PARAM_REQUEST_READ: () => true,
  MISSION_REQUEST_LIST: () => true,
  MISSION_REQUEST_INT: () => true,
  MISSION_COUNT: ({ count }) => count > 0,
  // 1: the item that is flown. An item with another `current` is a guided target or a change of altitude.
  MISSION_ITEM_INT: ({ current }) => current === 0 || current === 1,
  MISSION_ACK: () => true,
  MISSION_SET_CURRENT: () => true,
  COMMAND_INT: isAllowedCommand,
  COMMAND_LONG: isAllowedCommand,
};

export class NotAllowed extends Error {}

export class Outgoing {
  #send;
  #systemId;
  #signing;
  #sequence = 0;
  // Names of what was sent, with counts: for the state and for tests.
  counts = {};

  // send(bytes). systemId(): of the aircraft.
  constructor({ send, systemId, signing }) {
    this.#send = send;
    this.#systemId = systemId;
    this.#signing = signing;
  }

  send(name, fields) {
    if (!allowed[name]?.(fields)) {
      throw new NotAllowed(`${name} ${fields.command ?? ''} is not in the list of what may be sent`);
    }
    this.counts[name] = (this.counts[name] ?? 0) + 1;
    this.#send(this.#bytes(name, fields));
  }

  #bytes(name, fields) {
    const bytes = packetBytes(messageOf(name, fields), {
      systemId: this.#systemId(), componentId: ownComponent, sequence: this.#sequence++, isSigned: Boolean(this.#signing),
    });
    return this.#signing?.signed(bytes, { linkId: ownComponent }) ?? bytes;
  }
}
