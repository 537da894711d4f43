// Answers of the service across the antimeridian: landings and ways are whole, and on the right side of the earth.

import assert from 'node:assert/strict';
import test from 'node:test';

import { withWholeLines } from '../../server/mavlink/antimeridian.js';
import { distance_m, FlatFrame } from '../../server/mavlink/flat_frame.js';
import { ToldWay } from '../../server/mavlink/guidance/told_way.js';
import { ardupilotItems, landingOfApproach } from '../../server/mavlink/mission/landing_items.js';
import { report } from './report.js';

const subject = 'antimeridian';
const touchdown = { latitude_deg: -17, longitude_deg: -179.9995, altitude_m: 20 };
const cut = (west, east) => ({ type: 'MultiLineString', coordinates: [west, east] });

// A final of 213 m to the east, half of it on either side, after a circle of 60 m to its north.
function approachAnswer() {
  const frame = new FlatFrame(touchdown);
  const circle = Array.from({ length: 73 }, (_, i) => {
    const angle = (i * Math.PI) / 36;
    const { latitude_deg, longitude_deg } = frame.toGlobal({ east_m: -53 + 60 * Math.sin(angle), north_m: 60 - 60 * Math.cos(angle) });
    return [longitude_deg, latitude_deg, 35];
  });
  const feature = (kind, geometry, more = {}) => ({ type: 'Feature', properties: { kind, ...more }, geometry });
  return {
    altitude_datum: 'amsl', verdict: 'landable',
    features: [
      feature('approach', cut([[179.9985, -17, 35], [180, -17, 24]], [[-180, -17, 24], [-179.9995, -17, 20]]), { heading_deg: 90 }),
      feature('loiter', { type: 'LineString', coordinates: circle }, { radius_m: 60, direction: 'left' }),
    ],
  };
}

test('a landing across the antimeridian has its circle and its points there', () => {
  const landing = landingOfApproach('s1', withWholeLines(approachAnswer()));
  const apart_m = distance_m(landing.touchdown, landing.centre);
  report(subject, 'centre of the circle from the touchdown', `${apart_m.toFixed(0)} m of 80`);
  assert.ok(Math.abs(apart_m - Math.hypot(53, 60)) < 1);
  assert.ok(Math.abs(distance_m(landing.start, landing.touchdown) - 213) < 1);
  for (const { y } of ardupilotItems(landing)) {
    assert.ok(Math.abs(y) <= 180e7 && Math.abs(y) > 179.99e7, `${y}`);
  }
});

test('a way across the antimeridian is one line, each place with its own time', () => {
  const site = {
    touchdown, approach: { start: { altitude_m: 35 } },
    path: cut([[179.996, -17, 80], [179.9985, -17, 35], [180, -17, 24]], [[-180, -17, 24], [-179.9995, -17, 20]]),
    times_s: [0, 20, 30, 30, 34],
  };
  const { sites: [whole] } = withWholeLines({ sites: [site] });
  assert.deepEqual(whole.times_s, [0, 20, 34]);
  const way = new ToldWay(whole);
  assert.ok(Math.abs(way.length_m - 480) < 2, `${way.length_m}`);
  assert.ok(Math.abs(way.at(way.length_m / 2).longitude_deg - 179.99825) < 1e-4);
  assert.equal(way.timeToFinal_s(0), 20);
});
