// Names of vehicle types and flight modes, as people know them.

import { MavAutopilot, MavType, PlaneMode } from './messages.js';

const px4MainModes = {
  1: 'MANUAL', 2: 'ALTCTL', 3: 'POSCTL', 4: 'AUTO', 5: 'ACRO', 6: 'OFFBOARD', 7: 'STABILIZED',
  10: 'TERMINATION', 11: 'ALTITUDE_CRUISE',
};
const px4AutoModes = {
  1: 'READY', 2: 'TAKEOFF', 3: 'LOITER', 4: 'MISSION', 5: 'RTL', 6: 'LAND', 8: 'FOLLOW_TARGET', 9: 'PRECLAND',
  10: 'VTOL_TAKEOFF',
};

export const typeName = (type) => (MavType[type] ?? `type ${type}`).toLowerCase();
export const autopilotName = (autopilot) =>
  (MavAutopilot[autopilot] ?? `autopilot ${autopilot}`).toLowerCase();

export function modeName(autopilot, customMode) {
  if (autopilot === MavAutopilot.ARDUPILOTMEGA) return PlaneMode[customMode] ?? `mode ${customMode}`;
  if (autopilot === MavAutopilot.PX4) {
    const main = (customMode >> 16) & 0xff;
    const sub = (customMode >> 24) & 0xff;
    const name = px4MainModes[main] ?? `mode ${main}`;
    return main === 4 && px4AutoModes[sub] ? `${name}.${px4AutoModes[sub]}` : name;
  }
  return `mode ${customMode}`;
}
