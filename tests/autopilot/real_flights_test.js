// Wind from drift on logs of flown aircraft. Nobody has measured the wind there: what is compared with
// comes from the same flights, by other ways.

import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import test from 'node:test';

import { DriftWind } from '../../server/mavlink/wind_drift.js';
import { WindSource } from '../../server/mavlink/wind_source.js';
import { report } from './report.js';

const radians = (degrees) => (degrees * Math.PI) / 180;
const along = (angle_rad, length) => ({ east_mps: length * Math.sin(angle_rad), north_mps: length * Math.cos(angle_rad) });
const apart_mps = (a, b) => Math.hypot(a.east_mps - b.east_mps, a.north_mps - b.north_mps);
const rms = (values) => Math.sqrt(values.reduce((sum, value) => sum + value * value, 0) / values.length);
const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
const meanWind = (winds) => ({ east_mps: mean(winds.map((one) => one.east_mps)), north_mps: mean(winds.map((one) => one.north_mps)) });
const text = ({ east_mps, north_mps }) => {
  const from_deg = (Math.atan2(-east_mps, -north_mps) * 180) / Math.PI;
  return `${Math.hypot(east_mps, north_mps).toFixed(1)} m/s from ${((from_deg + 360) % 360).toFixed(0)}`;
};

const pathOf = (...parts) => process.env.FREELSD_DATA && join(process.env.FREELSD_DATA, ...parts);
const isThere = (path) => path && existsSync(path);

// Quoted fields may hold commas.
function rowsOf(path) {
  const [head, ...lines] = readFileSync(path, 'utf8').trim().split(/\r?\n/)
    .map((line) => line.match(/("[^"]*"|[^,]*)(,|$)/g).map((cell) => cell.replace(/,$/, '').replace(/"/g, '')));
  return lines.map((cells) => Object.fromEntries(head.map((name, i) => [name, cells[i]])));
}

// The constant wind for which all ground velocities have one airspeed: without heading and airspeed.
function windOfSpeeds(velocities) {
  let wind = { east_mps: 0, north_mps: 0 };
  for (let round = 0; round < 200; ++round) {
    const airs = velocities.map(({ east_mps, north_mps }) => ({ east_mps: east_mps - wind.east_mps, north_mps: north_mps - wind.north_mps }));
    const airspeed_mps = mean(airs.map(({ east_mps, north_mps }) => Math.hypot(east_mps, north_mps)));
    const missing = airs.map(({ east_mps, north_mps }) => {
      const share = 1 - airspeed_mps / Math.hypot(east_mps, north_mps);
      return { east_mps: share * east_mps, north_mps: share * north_mps };
    });
    const step = meanWind(missing);
    wind = { east_mps: wind.east_mps + step.east_mps, north_mps: wind.north_mps + step.north_mps };
  }
  return wind;
}

const snowpeak = pathOf('places', 'snowpeak_ebee');
const skip = (path) => (isThere(path) ? false : 'the real flights are not here: set FREELSD_DATA');
const minHeight_m = 30;

function snowpeakLog() {
  const told = rowsOf(join(snowpeak, 'wind.csv')).map((row) => ({
    time_s: row.time_ms / 1000, ...along(radians(Number(row['wind.direction'])), Number(row['wind.speed'])) }));
  const motions = rowsOf(join(snowpeak, 'state.csv')).map((row) => ({
    time_s: row.time_ms / 1000, ...along(radians(Number(row.course)), Number(row.ground_speed_ms)),
    heading_rad: radians(Number(row.heading)), airspeed_mps: Number(row.airspeed_ms),
    climb_mps: Number(row.vertical_speed_ms), height_m: Number(row.height_agl_m), roll_deg: Number(row.roll),
    trueAirspeed_mps: Number(row.tas_ms),
  })).filter(({ height_m }) => height_m >= minHeight_m);
  return { told, motions };
}

const toldAt = (told, time_s) => told.findLast((one) => one.time_s <= time_s);

// What the link offers: { wind, time_s, isAfterTurns }.
function offeredBy(motions) {
  const offered = [];
  const source = new WindSource((boot_ms, wind) => offered.push({ wind, time_s: boot_ms / 1000 }));
  motions.forEach((motion) => source.move(motion, 0));
  return offered;
}

test('snowpeak: the logged direction of the wind is where it blows to', { skip: skip(snowpeak) }, () => {
  const { told, motions } = snowpeakLog();
  const straight = motions.filter(({ roll_deg }) => Math.abs(roll_deg) < 5);
  const drifts = straight.map(({ east_mps, north_mps, heading_rad, trueAirspeed_mps, time_s }) => {
    const air = along(heading_rad, trueAirspeed_mps);
    return { drift: { east_mps: east_mps - air.east_mps, north_mps: north_mps - air.north_mps }, told: toldAt(told, time_s) };
  });
  const to_mps = rms(drifts.map(({ drift, told: to }) => apart_mps(drift, to)));
  const from_mps = rms(drifts.map(({ drift, told: to }) => apart_mps(drift, { east_mps: -to.east_mps, north_mps: -to.north_mps })));
  report('snowpeak (eBee)', 'ground velocity less air velocity against the logged wind',
    `${to_mps.toFixed(1)} m/s RMS if its direction is "to", ${from_mps.toFixed(1)} if "from": it is "to"`);
  assert.ok(to_mps < 0.3 * from_mps);
});

for (const [label, withAirspeed] of [['with airspeed', true], ['without airspeed', false]]) {
  test(`snowpeak: wind from drift, ${label}`, { skip: skip(snowpeak) }, () => {
    const { told, motions } = snowpeakLog();
    const given = motions.map((motion) => (withAirspeed ? motion : { ...motion, airspeed_mps: undefined }));
    const offered = offeredBy(given);
    const errors_mps = offered.map(({ wind, time_s }) => apart_mps(wind, toldAt(told, time_s)));
    const numWithin = offered.filter(({ wind }, i) => errors_mps[i] <= 2 * wind.sd_mps).length;
    report('snowpeak (eBee)', `wind from drift, ${label}, against its autopilot's own`,
      `RMS ${rms(errors_mps).toFixed(2)} m/s, at most ${Math.max(...errors_mps).toFixed(1)}; offered ${offered.length} s of ${(motions.at(-1).time_s - motions[0].time_s).toFixed(0)}, first after ${(offered[0].time_s - motions[0].time_s).toFixed(0)} s`);
    report('snowpeak (eBee)', `mean wind, ${label}`,
      `${text(meanWind(offered.map(({ wind }) => wind)))}; autopilot ${text(meanWind(offered.map(({ time_s }) => toldAt(told, time_s))))}; from ground velocities alone ${text(windOfSpeeds(motions))}`);
    report('snowpeak (eBee)', `told deviation, ${label}`,
      `${mean(offered.map(({ wind }) => wind.sd_mps)).toFixed(2)} m/s; ${((100 * numWithin) / offered.length).toFixed(0)} % of the differences within two of it`);
    assert.ok(rms(errors_mps) <= 1.5);
  });
}

// 28 photographs of 20 minutes. Each tells heading and ground velocity; the airspeed is not in the file.
test('Garfield Park: wind from drift of the photographs', { skip: skip(pathOf('flights', 'garfield_park')) }, () => {
  const motions = rowsOf(pathOf('flights', 'garfield_park', 'poses_from_exif.csv')).map((row) => {
    const [east_mps, north_mps, climb_mps] = row.imu_linear_velocity_mps.split(',').map(Number);
    const time_s = row.utc.split(' ')[1].split(':').reduce((sum, part) => 60 * sum + Number(part), 0);
    return { time_s, east_mps, north_mps, climb_mps, heading_rad: radians(Number(row.yaw_deg)) };
  });
  assert.equal(offeredBy(motions).length, 0);
  const drift = new DriftWind();
  // As one piece: without the gaps, in which its window of 150 s would end.
  motions.forEach((motion, i) => drift.add({ ...motion, time_s: 5 * i }));
  const wind = drift.estimate();
  const bySpeeds = windOfSpeeds(motions);
  report('Garfield Park (eBee)', 'wind from drift, 28 photographs without airspeed',
    `nothing offered: fewer than 10 of them in 150 s; all as one piece: ${text(wind)}, told deviation ${wind.sd_mps.toFixed(2)} m/s; from ground velocities alone ${text(bySpeeds)}; its README: westerly, 3.5 to 4 m/s`);
  assert.ok(apart_mps(wind, bySpeeds) < 1.5);
});
