// From a packet to named fields, in the units of the MAVLink definition, and the numbers of that definition.

import mavlink from 'node-mavlink';

const { MavLinkProtocolV1, MavLinkProtocolV2 } = mavlink;

export const { MavAutopilot, MavComponent, MavModeFlag, MavState, MavType } = mavlink.minimal;
export const { MavCmd, MavDoRepositionFlags, MavFrame, MavMissionResult, MavMissionType, MavResult, SpeedType } = mavlink.common;
export const { PlaneMode } = mavlink.ardupilotmega;

export const messageClasses = {};
export const idOf = {};
for (const dialect of ['minimal', 'common', 'standard', 'ardupilotmega', 'development']) {
  for (const [id, messageClass] of Object.entries(mavlink[dialect].REGISTRY)) {
    messageClasses[id] ??= messageClass;
    idOf[messageClass.MSG_NAME] ??= Number(id);
  }
}

const protocol = new MavLinkProtocolV2();
// MAVLink 2 cuts zeros at the end of a payload; fields are read from a payload of full length.
const longestPayload = 255;

export const nameOf = (messageId) => messageClasses[messageId]?.MSG_NAME;

// The fields of a known message. MAVLink 1 carries no extension fields: they become 0 here.
export function fieldsOf(packet) {
  const messageClass = messageClasses[packet.messageId];
  if (!messageClass) return undefined;
  const payload = Buffer.alloc(longestPayload);
  packet.payload.copy(payload);
  return protocol.data(payload, messageClass);
}

export function messageOf(name, fields) {
  return Object.assign(new messageClasses[idOf[name]](), fields);
}

// What is to be signed says so in its header. MAVLink 1 has no signatures.
export function packetBytes(message, { systemId, componentId, sequence, version = 2, isSigned = false }) {
  const sender = version === 1 ? new MavLinkProtocolV1(systemId, componentId)
    : new MavLinkProtocolV2(systemId, componentId, isSigned ? MavLinkProtocolV2.IFLAG_SIGNED : 0);
  return sender.serialize(message, sequence & 0xff);
}
