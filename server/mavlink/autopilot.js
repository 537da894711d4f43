// What guidance tells the autopilot, as commands of MAVLink.

import { MavCmd, MavDoRepositionFlags, MavFrame, MavModeFlag, PlaneMode, SpeedType } from './messages.js';

export class Autopilot {
  #send;
  #address;
  #landItem;

  // send(message name, fields). address(): targetSystem and targetComponent. landItem(): the LAND of the mission, if
  // the autopilot begins a mission anew in AUTO.
  constructor({ send, address, landItem = () => undefined }) {
    this.#send = send;
    this.#address = address;
    this.#landItem = landItem;
  }

  // target: place with altitude_m above mean sea level, and radius_m.
  goTo({ latitude_deg, longitude_deg, altitude_m, radius_m }, mayChangeMode) {
    this.#send('COMMAND_INT', {
      ...this.#address(), frame: MavFrame.GLOBAL, command: MavCmd.DO_REPOSITION, current: 0, autocontinue: 0,
      _param1: -1, _param2: mayChangeMode ? MavDoRepositionFlags.CHANGE_MODE : 0, _param3: radius_m, _param4: NaN,
      _param5: Math.round(latitude_deg * 1e7), _param6: Math.round(longitude_deg * 1e7), _param7: altitude_m,
    });
  }

  setSpeed(airspeed_mps) { this.#command(MavCmd.DO_CHANGE_SPEED, [SpeedType.AIRSPEED, airspeed_mps, -1]); }

  // The mission is flown from its current item, which is the LAND.
  beginFinal() {
    this.#command(MavCmd.DO_SET_MODE, [MavModeFlag.CUSTOM_MODE_ENABLED, PlaneMode.AUTO]);
    const seq = this.#landItem();
    if (seq !== undefined) this.#send('MISSION_SET_CURRENT', { ...this.#address(), seq });
  }

  #command(command, params) {
    const fields = { ...this.#address(), command, confirmation: 0 };
    for (let i = 0; i < 7; ++i) fields[`_param${i + 1}`] = params[i] ?? 0;
    this.#send('COMMAND_LONG', fields);
  }
}
