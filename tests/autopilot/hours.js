// Hours of the stand-in's normal flying, through the link: a different pilot, wind and aircraft each
// flight. Stepped; nothing of it is an engine failure.

import { Link } from '../../server/mavlink/link.js';
import { KnowingWatch } from './knowing_watch.js';
import { Standin } from './standin/aircraft.js';
import { survey } from './standin/missions.js';
import { Random } from './standin/random.js';

export const slowRates_hz = { HEARTBEAT: 1, SYSTEM_TIME: 0.5, ATTITUDE: 4, GLOBAL_POSITION_INT: 4, GPS_RAW_INT: 0,
  VFR_HUD: 4, WIND: 1, SYS_STATUS: 1, RPM: 1, MISSION_CURRENT: 0, HOME_POSITION: 0, CAMERA_FEEDBACK: 0 };

const aircraft = [
  {},
  { max_glide_ratio: 11, best_glide_airspeed_mps: 13, max_thrust_ratio: 0.45, stall_airspeed_mps: 9.5 },
  { max_glide_ratio: 17, best_glide_airspeed_mps: 12, max_thrust_ratio: 0.3, stall_airspeed_mps: 9 },
];
const speeds = [
  {},
  { AIRSPEED_CRUISE: 17, AIRSPEED_MIN: 12, AIRSPEED_MAX: 25, TECS_CLMB_MAX: 3, TECS_SINK_MAX: 4 },
  { AIRSPEED_CRUISE: 15, AIRSPEED_MIN: 11, AIRSPEED_MAX: 22, TECS_CLMB_MAX: 2, TECS_SINK_MAX: 3 },
];

// What a pilot does next, for how long.
const manoeuvres = {
  survey: (plane, random) => {
    plane.loadMission(survey(plane, { height_m: random.between(80, 200), spacing_m: random.between(30, 90) }));
    plane.control.setMode('LOITER');
    plane.control.setMode('AUTO');
    return random.between(120, 400);
  },
  climb: (plane, random) => {
    plane.control.setMode('GUIDED');
    plane.control.goTo({ east_m: random.between(-600, 600), north_m: random.between(-600, 600),
      altitude_m: plane.home.altitude_m + random.between(60, 350) }, random.between(60, 150), random.uniform() < 0.5 ? -1 : 1);
    return random.between(40, 120);
  },
  sticks: (plane, random) => {
    plane.control.setMode('FBWA');
    plane.pilotSticks({ bank_deg: random.between(-40, 40), path_deg: random.between(-6, 8), throttle: random.between(0.35, 0.9) });
    return random.between(4, 15);
  },
  throttleCut: (plane, random) => {
    plane.control.setMode('FBWA');
    plane.pilotSticks({ bank_deg: random.between(-20, 20), path_deg: random.between(-6, -3), throttle: 0 });
    return random.between(3, 12);
  },
  burst: (plane, random) => {
    plane.control.setMode('FBWA');
    plane.pilotSticks({ bank_deg: random.between(-45, 45), path_deg: random.between(0, 10), throttle: 1 });
    return random.between(3, 10);
  },
  loiter: (plane, random) => {
    plane.control.setMode('LOITER');
    return random.between(20, 90);
  },
  cruise: (plane, random) => {
    delete plane.control.pilot.altitude_m;
    plane.control.setMode('CRUISE');
    plane.pilotSticks({ bank_deg: random.between(-30, 30), path_deg: random.between(-10, 10), throttle: 0.5 });
    return random.between(10, 30);
  },
};

// A pilot brings it back up, slow and near the ground or far away.
function isInTrouble({ height_m, east_m, north_m, airspeed_mps }, parameters) {
  return height_m < 40 || Math.hypot(east_m, north_m) > 3000 || airspeed_mps < parameters.AIRSPEED_MIN + 1;
}

function planeOf(seed, random, withSigns) {
  const kind = seed % aircraft.length;
  return new Standin({ seed, rates_hz: slowRates_hz, aircraft: aircraft[kind], parameters: speeds[kind],
    wind: { speed_mps: random.between(0, 9), from_deg: random.between(0, 360), gust_sd_mps: random.between(0, 1.8),
      gust_time_s: random.between(2, 8), vertical_gust_sd_mps: random.between(0, 0.9) },
    sensors: { sends_rpm: withSigns, sends_current: withSigns } });
}

const longest_s = 40;

// In a survey the engine ends. { delay_s: to the alarm, known_s: to that of one who knows all; Infinity if
// there is none in time, hadAlarm: before it ended }.
export function failAfterSurvey(seed, { withSigns = true } = {}) {
  const random = new Random(seed * 104729);
  const plane = planeOf(seed, random, withSigns);
  const alarms_s = [];
  const link = new Link({ emit: () => {}, steady_us: () => plane.time_s * 1e6, onEvent: (sentence) => {
    if (sentence.startsWith('ENGINE')) alarms_s.push(plane.time_s);
  } });
  const knowing = new KnowingWatch(plane);
  plane.onSend = (bytes, name) => {
    link.take(bytes, '127.0.0.1 5760', true, plane.utc_us);
    if (name === 'GLOBAL_POSITION_INT') knowing.step(bytes);
  };
  plane.loadMission(survey(plane, { height_m: random.between(80, 200) }));
  plane.startInFlight({ height_m: 150, mode: 'AUTO' });
  plane.step(random.between(90, 300));
  const stopped_s = plane.time_s;
  const after_s = (times_s) => (times_s.find((time_s) => time_s > stopped_s) ?? Infinity) - stopped_s;
  plane.stopEngine();
  const isOver = () => plane.time_s >= stopped_s + longest_s || plane.touchdown;
  while (!isOver() && !(after_s(alarms_s) < Infinity && after_s(knowing.alarms_s) < Infinity)) plane.step(0.1);
  return { delay_s: after_s(alarms_s), known_s: after_s(knowing.alarms_s), hadAlarm: alarms_s.some((time_s) => time_s <= stopped_s) };
}

// One flight of an hour. Gives the alarms of the link: [{ time_s, sentence, manoeuvre, truth }].
export function flyHour(seed, { duration_s = 3600, withSigns = true } = {}) {
  const random = new Random(seed * 7919);
  const plane = planeOf(seed, random, withSigns);
  const alarms = [];
  let manoeuvre = 'loiter';
  const link = new Link({ emit: () => {}, steady_us: () => plane.time_s * 1e6, onEvent: (sentence) => {
    if (sentence.startsWith('ENGINE')) alarms.push({ time_s: plane.time_s, sentence, manoeuvre, truth: plane.truth });
  } });
  plane.onSend = (bytes) => link.take(bytes, '127.0.0.1 5760', true, plane.utc_us);
  plane.startInFlight({ height_m: 150 });
  let until_s = 0;
  while (plane.time_s < duration_s && !plane.touchdown) {
    if (isInTrouble(plane.truth, plane.parameters) && manoeuvre !== 'rescue') {
      manoeuvre = 'rescue';
      plane.control.setMode('GUIDED');
      plane.control.goTo({ east_m: 0, north_m: 0, altitude_m: plane.home.altitude_m + 150 }, 100, 1);
      until_s = plane.time_s + 60;
    } else if (plane.time_s >= until_s) {
      const names = Object.keys(manoeuvres);
      manoeuvre = names[Math.floor(random.uniform() * names.length)];
      until_s = plane.time_s + manoeuvres[manoeuvre](plane, random);
    }
    plane.step(0.5);
  }
  return { alarms, flown_s: plane.time_s, touchdown: plane.touchdown, engine: link.state(plane.utc_us).engine.state };
}

// A failure of 20 s in a survey at height. { wasFailed: until the engine was started, back_s: from then to
// its being believed }.
export function restartAfterFailure(seed) {
  const plane = planeOf(seed, new Random(seed * 104729), false);
  const link = new Link({ emit: () => {}, steady_us: () => plane.time_s * 1e6 });
  const state = () => link.state(plane.utc_us).engine.state;
  plane.onSend = (bytes) => link.take(bytes, '127.0.0.1 5760', true, plane.utc_us);
  plane.loadMission(survey(plane, { height_m: 300 }));
  plane.startInFlight({ height_m: 300, mode: 'AUTO' });
  plane.step(240);
  plane.stopEngine();
  for (let i = 0; i < 40 && state() !== 'failed'; ++i) plane.step(1);
  plane.step(10);
  const wasFailed = state() === 'failed';
  plane.startEngine();
  const started_s = plane.time_s;
  while (state() === 'failed' && plane.time_s < started_s + 120) plane.step(0.5);
  return { wasFailed, back_s: plane.time_s - started_s };
}

// The autopilot starts anew in a survey, and later the engine ends. { delay_s: to the alarm; Infinity if
// there is none in time, hadAlarm: before it ended }.
export function failAfterReboot(seed) {
  const plane = planeOf(seed, new Random(seed * 104729), false);
  const link = new Link({ emit: () => {}, steady_us: () => plane.time_s * 1e6 });
  const hasFailed = () => link.state(plane.utc_us).engine.state === 'failed';
  plane.onSend = (bytes) => link.take(bytes, '127.0.0.1 5760', true, plane.utc_us);
  plane.loadMission(survey(plane, { height_m: 300 }));
  plane.startInFlight({ height_m: 300, mode: 'AUTO' });
  plane.step(60);
  plane.restart();
  plane.step(90);
  const hadAlarm = hasFailed();
  const stopped_s = plane.time_s;
  plane.stopEngine();
  while (!hasFailed() && plane.time_s < stopped_s + longest_s) plane.step(0.1);
  return { delay_s: hasFailed() ? plane.time_s - stopped_s : Infinity, hadAlarm };
}
