// Engine alarms over hours of normal flying, and how soon a true failure is detected.

import assert from 'node:assert/strict';
import test from 'node:test';

import { failAfterSurvey, flyHour } from './hours.js';
import { report } from './report.js';

// A short form for every run; all of it with FREELSD_HOURS=10.
const numHours = Number(process.env.FREELSD_HOURS ?? 0.5);
const numFlights = Math.max(3, numHours);
const subject = 'engine';

test(`${numHours} hours of normal flying: no alarm`, { timeout: 3_600_000 }, () => {
  let flown_s = 0;
  for (let flight = 1; flight <= numFlights; ++flight) {
    // Every second flight without RPM and current.
    const { alarms, flown_s: one_s } = flyHour(flight, { withSigns: flight % 2 === 0, duration_s: (3600 * numHours) / numFlights });
    assert.deepEqual(alarms, [], `flight ${flight}`);
    flown_s += one_s;
  }
  report(subject, 'false alarms', `0 in ${(flown_s / 3600).toFixed(1)} h of the stand-in: climbs, gusts, throttle cuts`);
});

// What the engine gave to a clean glider is little, and in gusts hard to see. Without RPM and
// current the missing energy must be seen.
for (const [withSigns, limits_s] of [[true, [3, 3, 10]], [false, [3, 30, 40]]]) {
  const label = withSigns ? 'with RPM and current' : 'without';
  test(`a true failure of each aircraft is detected, ${label}`, () => {
    for (const [kind, glide_ratio] of [[0, 8], [1, 11], [2, 17]]) {
      const delays_s = [3, 6, 9].map((first) => failAfterSurvey(first + kind, { withSigns }));
      const text = delays_s.map((delay_s) => delay_s?.toFixed(1)).join(', ');
      report(subject, `failure in a survey detected after, ${label}, glide ratio ${glide_ratio}`, `${text} s`);
      assert.ok(delays_s.every((delay_s) => delay_s <= limits_s[kind]), `${glide_ratio}: ${text}`);
    }
  });
}
