// Modules of the page that need no browser.

import assert from 'node:assert/strict';
import test from 'node:test';

import { findRegion } from '../../web/places.js';
import { lastCourse } from '../../web/track.js';
import { age, area, courseTo, heading, strip, windFrom, windTo } from '../../web/units.js';
import { chunksOf, frameId, sharesOf, sortOut, splitPoses } from '../../web/upload_plan.js';
import { headlineOf } from '../../web/why.js';
import { bestDirections, radiusOf, roseText } from '../../web/wind_rose_shape.js';

test('wind: JSON states where the air moves to, the page where it comes from', () => {
  const from = windFrom({ east_mps: 5, north_mps: 0 });
  assert.equal(from.speed_mps, 5);
  assert.equal(from.from_deg, 270);
  const to = windTo(5, 270);
  assert.ok(Math.abs(to.east_mps - 5) < 1e-9 && Math.abs(to.north_mps) < 1e-9);
  assert.equal(windFrom(null), null);
});

// Letters by speed, in them by direction: l(andable), u(nverified), r(ejected).
function roseOf(speeds_mps, letters) {
  const verdict = { l: 'landable', u: 'unverified', r: 'rejected' };
  const directions_deg = [...letters[0]].map((_, i) => 360 * i / letters[0].length);
  const entries = speeds_mps.flatMap((wind_speed_mps, k) => directions_deg.map((wind_from_deg, i) =>
    ({ wind_from_deg, wind_speed_mps, verdict: verdict[letters[k][i]] })));
  return { directions_deg, speeds_mps, entries };
}

test('wind rose: the text names the best directions, also across north; a calm counts once', () => {
  const rose = roseOf([0, 5, 10], ['llllllll', 'llurrrll', 'lrurrrrl']);
  assert.deepEqual(bestDirections(rose), { from_deg: 315, to_deg: 0 });
  assert.equal(roseText(rose), 'Landable in 7 of 17 winds, unverified in 2. Best from 315° to 000°.');
  assert.equal(roseText(roseOf([5], ['rlrr'])), 'Landable in 1 of 4 winds. Best from 090°.');
});

test('wind rose: the text for no landable wind, and for equal directions', () => {
  assert.equal(roseText(roseOf([5], ['rruu'])), 'Landable in none of 4 winds, unverified in 2. Best from 180° to 270°.');
  assert.equal(roseText(roseOf([5], ['rrrr'])), 'Landable in none of 4 winds.');
  assert.equal(roseText(roseOf([0, 5], ['rrrr', 'llll'])), 'Landable in 4 of 5 winds. All directions are equal.');
});

test('wind rose: a wind stands in its ring, a stronger one than any on the rim', () => {
  assert.equal(radiusOf(0), 0);
  assert.ok(radiusOf(2.5) < radiusOf(3) && radiusOf(3) < radiusOf(5));
  assert.equal(radiusOf(10.5), radiusOf(40));
});

test('units: an unknown value reads unknown, and headings have three digits', () => {
  assert.equal(heading(7.4), '007°');
  assert.equal(heading(359.7), '000°');
  assert.equal(heading(null), 'unknown');
  assert.equal(area(null), 'unknown');
  assert.equal(age(3700), '1 h');
});

test('course: a tenth of a degree of latitude north is 11.12 km on 000°', () => {
  const course = courseTo({ latitude_deg: 47, longitude_deg: 8 }, { latitude_deg: 47.1, longitude_deg: 8 });
  assert.ok(Math.abs(course.distance_m - 11119.5) < 1);
  assert.ok(Math.abs(course.bearing_deg) < 1e-9);
});

test('track: noise of the receiver does not change the last course', () => {
  const east = [[8, 47, 500], [8.001, 47, 500]];
  assert.ok(Math.abs(lastCourse(east) - 90) < 0.01);
  const nearby = [...east, [8.001 + 1e-6, 47 + 5e-6, 501]];
  assert.ok(Math.abs(lastCourse(nearby) - 90) < 1, 'half a metre to the north turns nothing');
  assert.ok(Math.abs(lastCourse([...east, [8.001, 46.999, 500]]) - 180) < 0.01);
  assert.equal(lastCourse([[8, 47, 500], [8, 47, 510]]), null);
});

test('why not here: the title is the verdict of the server and the first rule that fails', () => {
  assert.equal(headlineOf({ verdict: 'landable', first_failed: null }), '✓ Landable here');
  assert.equal(headlineOf({ verdict: 'unverified', first_failed: 'circle_seen' }), '? Unverified here: loiter circle partly unseen');
  assert.equal(headlineOf({ verdict: 'rejected', first_failed: 'hazard_distance' }), '✕ Not landable: too close to a hazard');
});

test('strip: length and width are rounded down, an old site has none', () => {
  assert.equal(strip({ usable_length_m: 180.9, usable_width_m: 35.2 }), '180 × 35 m');
  assert.equal(strip({ usable_length_m: null, usable_width_m: null }), 'unknown');
  assert.equal(strip({}), 'unknown');
});

test('regions: the smallest region at a place wins', () => {
  const square = (size, area_m2) => ({
    properties: { area_m2 },
    geometry: { type: 'Polygon', coordinates: [[[-size, -size], [size, -size], [size, size], [-size, size], [-size, -size]]] },
  });
  const collection = { features: [square(2, 400), square(1, 100)] };
  assert.equal(findRegion(collection, { lat: 0.5, lng: 0.5 }).properties.area_m2, 100);
  assert.equal(findRegion(collection, { lat: 1.5, lng: 0 }).properties.area_m2, 400);
  assert.equal(findRegion(collection, { lat: 5, lng: 0 }), null);
});

test('upload: files are told apart and photographs put in their natural order', () => {
  const file = (name) => ({ name, size: 1 });
  const sorted = sortOut(['b10.jpg', 'b9.JPG', 'poses.csv', 'flight.json', 'x.exe'].map(file));
  assert.deepEqual(sorted.images.map((f) => f.name), ['b9.JPG', 'b10.jpg']);
  assert.equal(sorted.poses.name, 'poses.csv');
  assert.equal(sorted.flightJson.name, 'flight.json');
  assert.deepEqual(sorted.ignored.map((f) => f.name), ['x.exe']);
  assert.equal(frameId('a b(1).jpg'), 'a_b_1_.jpg');
});

test('upload: each request gets the poses of its own photographs, whatever the column is called', () => {
  const csv = 'lat,photo,lon\r\n1,"a.jpg",2\n3,b.jpg,4\n';
  const split = splitPoses(csv, ['a.jpg', 'b.jpg', 'c.jpg']);
  assert.equal(split.linesOf(['b.jpg']), 'lat,photo,lon\n3,b.jpg,4');
  assert.equal(split.linesOf(['c.jpg']), '');
  const lines = splitPoses('{"image":"a.jpg","timestamp_us":1}\n{"image":"b.jpg"}\n', ['a.jpg']);
  assert.equal(lines.linesOf(['a.jpg']), '{"image":"a.jpg","timestamp_us":1}');
  assert.equal(splitPoses('EPSG:4326\na.jpg 1 2 3\n', ['a.jpg']), null);
  assert.equal(splitPoses('image,name\na.jpg,"x, y"\n', ['a.jpg']), null);
});

test('upload: chunks stay small, and what is sent is shared out file by file', () => {
  const entries = Array.from({ length: 20 }, (_, i) => ({ file: { size: 1 << 20, name: `${i}` } }));
  assert.deepEqual(chunksOf(entries).map((chunk) => chunk.length), [8, 8, 4]);
  const large = Array.from({ length: 3 }, () => ({ file: { size: 20 << 20 } }));
  assert.equal(chunksOf(large).length, 3);
  assert.deepEqual(sharesOf([{ size: 100 }, { size: 100 }, { size: 100 }], 150), [1, 0.5, 0]);
});
