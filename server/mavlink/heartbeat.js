// The program's own heartbeat.

const onboardController = 18;
const noAutopilot = 8;
const active = 4;

export const heartbeat = {
  type: onboardController, autopilot: noAutopilot, baseMode: 0, customMode: 0, systemStatus: active, mavlinkVersion: 3,
};
