// Mission items as ArduPlane stores them: what does not fit in its storage is lost.

export const command = {
  waypoint: 16, loiterUnlimited: 17, loiterTurns: 18, loiterTime: 19, returnToLaunch: 20, land: 21,
  takeoff: 22, loiterToAltitude: 31, jump: 177, changeSpeed: 178, landStart: 189, rallyPoint: 5100,
};
export const missionType = { mission: 0, fence: 1, rally: 2 };
const maxNumItems = { [missionType.mission]: 700, [missionType.fence]: 70, [missionType.rally]: 10 };
const globalFrames = new Set([0, 5]);
const relativeFrames = new Set([3, 6]);
const terrainFrames = new Set([10, 11]);
const known = new Set([...Object.values(command), 30, 112, 114, 183, 201, 206, 203, 195, 197]);
export const isNavigation = (id) => id < 95;
const withPlace = new Set([16, 17, 18, 19, 21, 22, 30, 31, 189]);

const centimetres = (value) => Math.trunc(Math.fround(Math.fround(value) * 100)) / 100;
const byte = (value) => Math.trunc(value) & 0xff;
const word = (value) => Math.trunc(value) & 0xffff;
const float = (value) => (Number.isNaN(value) ? 0 : Math.fround(value));

// Of params 1 to 4, what comes back.
const storedParams = {
  [command.waypoint]: ([, radius, passBy]) => [0, byte(radius), byte(passBy), 0],
  [command.loiterUnlimited]: ([, , radius]) => [0, 0, Math.sign(radius) * word(Math.abs(radius)), 0],
  [command.loiterTurns]: ([turns, , radius, exit]) =>
    [byte(turns), 0, Math.sign(radius) * byte(Math.abs(radius)), Number(exit > 0)],
  [command.loiterTime]: ([time, , radius, exit]) => [word(time), 0, Math.sign(radius), Number(exit > 0)],
  [command.returnToLaunch]: () => [0, 0, 0, 0],
  [command.land]: ([abort, , , yaw]) => [word(abort), 0, 0, yaw < 0 ? -1 : 1],
  [command.takeoff]: ([pitch]) => [word(pitch), 0, 0, 0],
  [command.loiterToAltitude]: ([, radius, , exit]) =>
    [0, Math.sign(radius) * word(Math.abs(radius)), 0, Number(exit > 0)],
  [command.jump]: ([target, repeats]) => [word(target), Math.trunc(repeats), 0, 0],
  [command.changeSpeed]: ([type, speed, throttle]) => [byte(type), float(speed), float(throttle), 0],
  [command.landStart]: () => [0, 0, 0, 0],
};

const accepted = 0;
const unsupportedFrame = 2;
const unsupported = 3;
const invalid = 5;

// { result, item }: result is a MAV_MISSION_RESULT.
export function stored(type, sent) {
  const { frame, command: id, x, y, z } = sent;
  const isKnownFrame = [globalFrames, relativeFrames, terrainFrames].some((frames) => frames.has(frame));
  if (type === missionType.rally) return storedRally(sent, isKnownFrame);
  if (!known.has(id)) return { result: unsupported };
  const hasPlace = withPlace.has(id);
  if (hasPlace && !isKnownFrame) return { result: unsupportedFrame };
  if (hasPlace && (Math.abs(x) > 9e8 || Math.abs(y) > 18e8 || !Number.isFinite(z))) return { result: invalid };
  const params = [sent.param1, sent.param2, sent.param3, sent.param4].map(float);
  const [param1, param2, param3, param4] = (storedParams[id] ?? ((same) => same))(params);
  const shortFrame = { 5: 0, 6: 3, 11: 10 }[frame] ?? frame;
  return { result: accepted, item: {
    frame: hasPlace ? shortFrame : 0, command: id, param1, param2, param3, param4,
    x: hasPlace ? x : 0, y: hasPlace ? y : 0, z: hasPlace ? centimetres(z) : 0,
  } };
}

// Whole metres.
function storedRally({ frame, command: id, x, y, z }, isKnownFrame) {
  if (id !== command.rallyPoint) return { result: unsupported };
  if (!isKnownFrame) return { result: unsupportedFrame };
  const shortFrame = { 5: 0, 6: 3, 11: 10 }[frame] ?? frame;
  return { result: accepted, item: {
    frame: shortFrame, command: id, param1: 0, param2: 0, param3: 0, param4: 0, x, y, z: Math.trunc(z) } };
}

export const maxItems = (type) => maxNumItems[type];

// Of an item in the local frame: east_m, north_m, altitude_m above mean sea level. An item at 0, 0
// is where the aircraft is.
export function placeOf(item, { frame, home, ground, here }) {
  const isHere = item.x === 0 && item.y === 0;
  const local = isHere ? { east_m: here.east_m, north_m: here.north_m }
    : frame.toLocal({ latitude_deg: item.x / 1e7, longitude_deg: item.y / 1e7 });
  const base_m = relativeFrames.has(item.frame) ? home.altitude_m
    : terrainFrames.has(item.frame) ? ground(local.east_m, local.north_m) : 0;
  return { ...local, altitude_m: item.z + base_m };
}
