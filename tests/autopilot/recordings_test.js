// Both recordings of a real ArduPlane, message by message.

import assert from 'node:assert/strict';
import test from 'node:test';

import { BootClock } from '../../server/mavlink/clock.js';
import { report } from './report.js';
import { readTlog, recording, skipReason } from './tlog.js';
import { messagesOf, throughLink, trueWind } from './truth.js';

const names = ['arduplane_landing.tlog', 'arduplane_engine_out.tlog'];
// Before, the filter drifts about 0, 0, then sends the place with the altitude of another frame.
const firstFix_ms = 16_000;
const maxClockError_ms = 20;
const maxWindError_mps = 1.0;
const maxDetection_s = 3.0;

const windError_mps = (wind) =>
  Math.hypot(wind.east_mps - trueWind.east_mps, wind.north_mps - trueWind.north_mps);
const rms = (values) => Math.sqrt(values.reduce((sum, one) => sum + one * one, 0) / values.length);

for (const name of names) {
  const path = recording(name);
  const options = { skip: path ? false : skipReason };

  test(`${name}: every message is decoded`, options, () => {
    const records = readTlog(path);
    const messages = messagesOf(records);
    assert.equal(messages.length, records.length);
    for (const message of messages) assert.ok(message.fields, `message ${message.packet.messageId}`);
    const kinds = new Set(messages.map((message) => message.name));
    report(name, 'messages decoded', `${messages.length} of ${records.length}, ${kinds.size} kinds`);
  });

  test(`${name}: boot time becomes UTC within 20 ms`, options, () => {
    const clock = new BootClock();
    const errors_ms = [];
    for (const { name: kind, fields, time_us } of messagesOf(readTlog(path))) {
      if (kind !== 'SYSTEM_TIME' || fields.timeUnixUsec === 0n) continue;
      clock.hear(fields.timeBootMs, time_us);
      // Each one is compared before it is used.
      const mapped_us = clock.utc_us(fields.timeBootMs, time_us);
      if (mapped_us !== undefined) errors_ms.push(Math.abs(mapped_us - Number(fields.timeUnixUsec)) / 1000);
      clock.set(Number(fields.timeUnixUsec), fields.timeBootMs);
    }
    assert.ok(errors_ms.length > 200);
    assert.ok(Math.max(...errors_ms) <= maxClockError_ms);
    report(name, 'clock, largest error', `${Math.max(...errors_ms).toFixed(2)} ms of ${errors_ms.length}`);
  });

  test(`${name}: positions and attitudes are those of the recording`, options, () => {
    const records = readTlog(path);
    const { lines } = throughLink(records);
    const positions = lines.filter((line) => line.position);
    const said = messagesOf(records).filter(({ name: kind, fields }) =>
      kind === 'GLOBAL_POSITION_INT' && fields.timeBootMs >= firstFix_ms);
    const missed = positions.length - said.length;
    assert.ok(missed >= 0);
    positions.slice(missed).forEach(({ position, altitude_datum }, i) => {
      const { fields } = said[i];
      assert.equal(position.latitude_deg, fields.lat / 1e7);
      assert.equal(position.longitude_deg, fields.lon / 1e7);
      assert.equal(position.altitude_m, fields.alt / 1000);
      assert.equal(altitude_datum, 'amsl');
    });
    report(name, 'positions', `${said.length} of ${said.length} since the first fix, all equal`);
  });

  test(`${name}: wind from drift alone, after two turns`, options, () => {
    const errors_mps = [];
    const all = [];
    let first;
    const turns = turnCounter();
    throughLink(readTlog(path), {
      keep: (kind) => kind !== 'WIND',
      onStep: (link, kind, fields) => {
        if (kind === 'ATTITUDE') turns.add(fields.yaw);
        const { wind, position } = link.state();
        if (kind !== 'GLOBAL_POSITION_INT' || !wind || wind.age_s > 2) return;
        assert.equal(wind.source, 'drift');
        all.push(windError_mps(wind));
        first ??= { turned_deg: turns.total_deg, error_mps: windError_mps(wind) };
        // The simulator's wind is less near the ground.
        if (turns.total_deg >= 720 || turns.numTurns >= 2) {
          if (position.height_above_home_m > 60) errors_mps.push(windError_mps(wind));
        }
      },
    });
    assert.ok(errors_mps.length > 300);
    assert.ok(rms(errors_mps) <= maxWindError_mps);
    report(name, 'wind from drift after two turns, RMS error', `${rms(errors_mps).toFixed(2)} m/s`);
    report(name, 'wind from drift, first offered',
      `after ${first.turned_deg.toFixed(0)} degrees of turn, error ${first.error_mps.toFixed(2)} m/s; RMS of all offered ${rms(all).toFixed(2)} m/s`);
  });

  test(`${name}: the autopilot's own wind is offered, and not before it has settled`, options, () => {
    const records = readTlog(path);
    const { lines, link } = throughLink(records);
    const winds = lines.filter((line) => line.wind).map((line) => windError_mps(line.wind));
    assert.equal(link.state().wind.source, 'autopilot');
    assert.ok(winds.length > 200);
    assert.ok(winds[0] < 0.35 * 6);
    report(name, "autopilot's own wind, RMS error", `${rms(winds).toFixed(2)} m/s of ${winds.length}`);
  });
}

// A turn is a change of heading by at least 60 degrees.
function turnCounter() {
  let last;
  let sinceTurn_deg = 0;
  return {
    total_deg: 0,
    numTurns: 0,
    add(yaw) {
      if (last !== undefined) {
        const step_deg = (Math.atan2(Math.sin(yaw - last), Math.cos(yaw - last)) * 180) / Math.PI;
        this.total_deg += Math.abs(step_deg);
        sinceTurn_deg += step_deg;
        if (Math.abs(sinceTurn_deg) >= 60) {
          ++this.numTurns;
          sinceTurn_deg = 0;
        }
      }
      last = yaw;
    },
  };
}

const isSign = (kind) =>
  ['SYS_STATUS', 'RPM', 'EFI_STATUS', 'ESC_TELEMETRY_1_TO_4'].includes(kind);

// The first status in flight without current, while the throttle is up.
function failureTime_s(records) {
  let boot_s;
  let throttle = 0;
  let last_s;
  for (const { name, fields } of messagesOf(records)) {
    if (name === 'ATTITUDE') boot_s = fields.timeBootMs / 1000;
    if (name === 'VFR_HUD') throttle = fields.throttle;
    if (name !== 'SYS_STATUS') continue;
    if (fields.currentBattery === 0 && throttle > 30 && boot_s > 100) return { before_s: last_s, after_s: boot_s };
    last_s = boot_s;
  }
  return undefined;
}

for (const [label, keep] of [['with RPM and current', () => true], ['without', (kind) => !isSign(kind)]]) {
  const path = recording(names[1]);
  test(`engine failure is detected within 3 s, ${label}`, { skip: path ? false : skipReason }, () => {
    const records = readTlog(path);
    const { before_s } = failureTime_s(records);
    let boot_s;
    let failed_s;
    const { events } = throughLink(records, {
      keep,
      onStep: (link, kind, fields) => {
        if (kind === 'ATTITUDE') boot_s = fields.timeBootMs / 1000;
        if (failed_s === undefined && link.state().engine.state === 'failed') failed_s = boot_s;
      },
    });
    assert.equal(events.filter((event) => event.startsWith('ENGINE FAILURE')).length, 1);
    assert.ok(failed_s - before_s > 0 && failed_s - before_s <= maxDetection_s);
    report(names[1], `engine failure detected, ${label}`, `at most ${(failed_s - before_s).toFixed(1)} s after it`);
  });

  const calm = recording(names[0]);
  test(`no engine alarm in the first recording, ${label}`, { skip: calm ? false : skipReason }, () => {
    const { events } = throughLink(readTlog(calm), { keep });
    assert.deepEqual(events.filter((event) => event.startsWith('ENGINE')), []);
    report(names[0], `engine alarms, ${label}`, '0');
  });
}
