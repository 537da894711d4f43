// The program's own heartbeat.

import { MavAutopilot, MavState, MavType } from './messages.js';

export const heartbeat = {
  type: MavType.ONBOARD_CONTROLLER, autopilot: MavAutopilot.INVALID, baseMode: 0, customMode: 0,
  systemStatus: MavState.ACTIVE, mavlinkVersion: 3,
};
