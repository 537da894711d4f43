// Engine alarms over hours of normal flying, and how soon a true failure is detected.

import assert from 'node:assert/strict';
import test from 'node:test';

import { failAfterSurvey, flyHour } from './hours.js';
import { report } from './report.js';

// A short form for every run; all of it with FREELSD_HOURS=10.
const numHours = Number(process.env.FREELSD_HOURS ?? 1);
const subject = 'engine';

test(`${numHours} hours of normal flying: no alarm`, { timeout: 3_600_000 }, () => {
  let flown_s = 0;
  for (let hour = 1; hour <= numHours; ++hour) {
    // Every third flight without RPM and current.
    const { alarms, flown_s: one_s } = flyHour(hour, { withSigns: hour % 3 !== 0 });
    assert.deepEqual(alarms, [], `hour ${hour}`);
    flown_s += one_s;
  }
  report(subject, 'false alarms', `0 in ${(flown_s / 3600).toFixed(1)} h of the stand-in: climbs, gusts, throttle cuts`);
});

// Without RPM and current the missing energy must be seen: a clean glider loses little in 3 s.
for (const [withSigns, limit_s] of [[true, 3], [false, 20]]) {
  const label = withSigns ? 'with RPM and current' : 'without';
  test(`a true failure of each aircraft is detected within ${limit_s} s, ${label}`, () => {
    const delays_s = [];
    for (let seed = 1; seed <= 9; ++seed) {
      const delay_s = failAfterSurvey(seed, { withSigns });
      assert.ok(delay_s !== undefined, `flight ${seed}`);
      delays_s.push(delay_s);
    }
    const text = delays_s.sort((a, b) => a - b).map((delay_s) => delay_s.toFixed(1)).join(', ');
    report(subject, `failure in a survey detected after, ${label}`, `${text} s; glide ratios 8, 11, 17`);
    assert.ok(Math.max(...delays_s) <= limit_s, text);
  });
}
