// The program's own heartbeat: the only message that it sends.

import { checksumExtraOf, idOf, messageOf, packetBytes } from './messages.js';

// A companion computer is a component of the aircraft's own system. It is no ground station, so the
// autopilot's ground station failsafe does not count it.
const onboardComputer = 191;
const onboardController = 18;
const noAutopilot = 8;
const active = 4;

export function heartbeatBytes(systemId, sequence, signing) {
  const message = messageOf('HEARTBEAT', {
    type: onboardController, autopilot: noAutopilot, baseMode: 0, customMode: 0,
    systemStatus: active, mavlinkVersion: 3,
  });
  const bytes = packetBytes(message, { systemId, componentId: onboardComputer, sequence });
  const extra = checksumExtraOf(idOf.HEARTBEAT);
  return signing ? signing.signed(bytes, { linkId: onboardComputer, extra }) : bytes;
}
