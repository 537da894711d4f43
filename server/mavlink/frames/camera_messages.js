// What the camera's messages tell of one exposure: { kind, index, time_us, position?, attitude?, file? }.
// time_us: since boot, or since 1970. Pure.

import { distance_m } from '../flat_frame.js';

// From where the aircraft was heard last.
const maxAway_m = 500;

export const placeOf = (latitude_e7, longitude_e7, altitude_m) => ({
  position: { latitude_deg: latitude_e7 / 1e7, longitude_deg: longitude_e7 / 1e7, altitude_m },
});

export const triggerOf = ({ timeUsec, seq }) => ({ kind: 'CAMERA_TRIGGER', index: seq, time_us: Number(timeUsec) });

// ArduPilot: the aircraft's own attitude.
function attitudeOf({ roll, pitch, yaw }) {
  const isKnown = [roll, pitch, yaw].every(Number.isFinite) && (roll || pitch || yaw) && Math.abs(pitch) <= 90;
  return isKnown ? { roll_deg: roll, pitch_deg: pitch, yaw_deg: yaw } : undefined;
}

export const feedbackOf = (camera) => ({
  kind: 'CAMERA_FEEDBACK', index: camera.imgIdx, time_us: Number(camera.timeUsec),
  ...placeOf(camera.lat, camera.lng, camera.altMsl), attitude: attitudeOf(camera),
});

// Nothing if no picture was taken. Its quaternion may be of a gimbal: the attitude comes from telemetry.
export const capturedOf = (camera) => (camera.captureResult === 0 ? undefined : {
  kind: 'CAMERA_IMAGE_CAPTURED', index: camera.imageIndex, time_us: Number(camera.timeUtc) || camera.timeBootMs * 1000,
  ...placeOf(camera.lat, camera.lon, camera.alt / 1000), file: camera.fileUrl || undefined,
});

// A place is believed near the aircraft's own. Otherwise the pose comes from telemetry.
export function isTriggerPlace(position, aircraft) {
  if (!position || !aircraft) return false;
  return Math.hypot(distance_m(position, aircraft), position.altitude_m - aircraft.altitude_m) <= maxAway_m;
}
