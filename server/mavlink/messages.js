// From a packet to named fields, in the units of the MAVLink definition.

import mavlink from 'node-mavlink';

const { MavLinkProtocolV1, MavLinkProtocolV2, MSG_ID_MAGIC_NUMBER } = mavlink;

export const messageClasses = {};
for (const dialect of ['minimal', 'common', 'standard', 'ardupilotmega', 'development']) {
  for (const [id, messageClass] of Object.entries(mavlink[dialect].REGISTRY)) {
    messageClasses[id] ??= messageClass;
  }
}

export const idOf = {
  HEARTBEAT: 0, SYS_STATUS: 1, SYSTEM_TIME: 2, PARAM_REQUEST_READ: 20, PARAM_VALUE: 22, GPS_RAW_INT: 24,
  ATTITUDE: 30, GLOBAL_POSITION_INT: 33, MISSION_REQUEST: 40, MISSION_SET_CURRENT: 41, MISSION_CURRENT: 42,
  MISSION_REQUEST_LIST: 43, MISSION_COUNT: 44, MISSION_ACK: 47, MISSION_REQUEST_INT: 51, MISSION_ITEM_INT: 73,
  VFR_HUD: 74, COMMAND_INT: 75, COMMAND_LONG: 76, COMMAND_ACK: 77, CAMERA_TRIGGER: 112, WIND: 168,
  CAMERA_FEEDBACK: 180, EFI_STATUS: 225, RPM: 226, WIND_COV: 231, STATUSTEXT: 253, CAMERA_IMAGE_CAPTURED: 263,
  ESC_TELEMETRY_1_TO_4: 11030,
};

const protocol = new MavLinkProtocolV2();
// MAVLink 2 cuts zeros at the end of a payload; fields are read from a payload of full length.
const longestPayload = 255;

export const checksumExtraOf = (messageId) => MSG_ID_MAGIC_NUMBER[messageId];
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

// For the program's own heartbeat, and for tests.
export function packetBytes(message, { systemId, componentId, sequence, version = 2 }) {
  const Protocol = version === 1 ? MavLinkProtocolV1 : MavLinkProtocolV2;
  return new Protocol(systemId, componentId).serialize(message, sequence & 0xff);
}
