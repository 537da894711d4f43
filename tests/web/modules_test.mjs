// Modules of the page that need no browser.

import assert from 'node:assert/strict';
import test from 'node:test';

import { outerRings, withWholeShapes } from '../../web/antimeridian.js';
import { plainText } from '../../web/dom.js';
import { nearestSites } from '../../web/nearest.js';
import { circleAround, draftOf, extentOf, faultOf, featureOf, fieldOf } from '../../web/obstacle_shape.js';
import { offersOf } from '../../web/offers.js';
import { findRegion } from '../../web/places.js';
import { atBest } from '../../web/plan.js';
import { progressOf, waitText } from '../../web/progress.js';
import { requestOf } from '../../web/reach.js';
import { createQueue, isElsewhere, tilePath } from '../../web/tile_queue.js';
import { lastCourse } from '../../web/track.js';
import { age, area, courseTo, heading, margin, photographed, strip, windFrom, windTo } from '../../web/units.js';
import { clearUnseen } from '../../web/unseen_hatch.js';
import { chunksOf, frameId, sharesOf, sortOut, splitPoses } from '../../web/upload_plan.js';
import { headlineOf } from '../../web/why.js';
import { bestDirections, radiusOf, roseText } from '../../web/wind_rose_shape.js';

test('shapes that the server has cut at the antimeridian are drawn in one place', () => {
  const cut = { type: 'MultiLineString', coordinates: [[[179, 1], [180, 2]], [[-180, 2], [-179, 3]]] };
  const halves = { type: 'MultiPolygon', coordinates: [[[[179, 0], [180, 0], [180, 1], [179, 0]]], [[[-180, 0], [-179, 0], [-180, 1], [-180, 0]]]] };
  const point = { type: 'Point', coordinates: [-179.9, 1] };
  const { features: [line, area, place], sites: [site] } = withWholeShapes({
    features: [{ geometry: cut }, { geometry: halves }, { geometry: point }], sites: [{ path: cut }, {}] });
  assert.deepEqual(line.geometry, { type: 'LineString', coordinates: [[179, 1], [180, 2], [181, 3]] });
  assert.deepEqual(site.path, line.geometry);
  assert.deepEqual(outerRings(area.geometry)[1][1], [181, 0]);
  assert.deepEqual(place.geometry, point);
  const region = { properties: { area_m2: 1 }, geometry: area.geometry };
  assert.equal(findRegion({ features: [region] }, { lat: 0.1, lng: 180.5 }), region);
  assert.equal(findRegion({ features: [region] }, { lat: 0.1, lng: 181.5 }), null);
});

test('wind: JSON states where the air moves to, the page where it comes from', () => {
  const from = windFrom({ east_mps: 5, north_mps: 0 });
  assert.equal(from.speed_mps, 5);
  assert.equal(from.from_deg, 270);
  const to = windTo(5, 270);
  assert.ok(Math.abs(to.east_mps - 5) < 1e-9 && Math.abs(to.north_mps) < 1e-9);
  assert.equal(windFrom(null), null);
});

test('photographs without a usable date: the age of their ground is unknown, not zero', () => {
  assert.equal(photographed({ age_s: null, last_seen_at: null }), 'date unknown');
  assert.equal(photographed({ age_s: null, last_seen_at: null, new_look: { age_s: null } }), 'date unknown');
  assert.equal(photographed({ age_s: 86400, last_seen_at: 'x' }), 'photographed 1 d ago');
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
  assert.equal(age(400 * 86400), '400 d');
  assert.equal(age(3801 * 86400), '10 years');
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
  assert.equal(headlineOf({ verdict: 'unverified', first_failed: 'circle_seen' }), '? Unverified here: loiter circle not fully measured');
  assert.equal(headlineOf({ verdict: 'rejected', first_failed: 'hazard_distance' }), '✕ Not landable: too close to a hazard');
});

test('strip: length and width are rounded down, a site without an approach has none', () => {
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

// A server of these sites that lists the 1000 best of a box, by score. asked: the boxes.
function listOf(sites, asked = []) {
  return async (bbox) => {
    asked.push(bbox);
    const [west, south, east, north] = bbox.split(',').map(Number);
    const isBetween = (lon) => (west <= east ? lon >= west && lon <= east : lon >= west || lon <= east);
    const within = sites.filter(({ geometry: { coordinates: [lon, lat] } }) => isBetween(lon) && lat >= south && lat <= north);
    return { features: within.sort((a, b) => b.properties.score - a.properties.score).slice(0, 1000) };
  };
}

const storedAt = (id, longitude_deg, latitude_deg, score, verdict = 'landable') =>
  ({ geometry: { type: 'Point', coordinates: [longitude_deg, latitude_deg] }, properties: { id, score, verdict } });
const isWanted = ({ properties }) => properties.verdict !== 'rejected';
const idsNear = async (from, sites, asked) =>
  (await nearestSites(from, 3, { list: listOf(sites, asked), isWanted })).map(({ feature }) => feature.properties.id);

test('nearest sites: a site at hand comes before a thousand better ones far away', async () => {
  const far = Array.from({ length: 1500 }, (_, i) => storedAt(`far-${i}`, 20 + 0.001 * i, 55, 0.9));
  const near = [storedAt('115 m', 8, 47.001034, 0.1), storedAt('2 km', 8, 47.018, 0.2), storedAt('30 km', 8, 47.27, 0.3),
    storedAt('rejected', 8, 47.0001, 0, 'rejected')];
  const asked = [];
  const sites = await nearestSites({ latitude_deg: 47, longitude_deg: 8 }, 3, { list: listOf([...far, ...near], asked), isWanted });
  assert.deepEqual(sites.map(({ feature }) => feature.properties.id), ['115 m', '2 km', '30 km']);
  assert.ok(Math.abs(sites[0].distance_m - 115) < 1 && Math.abs(sites[0].bearing_deg % 360) < 0.1);
  assert.ok(asked.length <= 4, `${asked.length} lists`);
});

test('nearest sites: more than a list holds within one box are all looked at', async () => {
  const crowd = Array.from({ length: 4000 }, (_, i) => storedAt(`crowd-${i}`, 8.02 + 1e-5 * (i % 60), 47.02 + 1e-5 * Math.floor(i / 60), 0.9));
  assert.deepEqual((await idsNear({ latitude_deg: 47, longitude_deg: 8 },
    [...crowd, storedAt('near', 8, 47.0005, 0), storedAt('next', 8, 47.0008, 0), storedAt('third', 8, 47.001, 0)])),
  ['near', 'next', 'third']);
});

test('nearest sites: a corner of the box does not come before a place beyond its rim', async () => {
  const corner_deg = 3900 / 111195;
  const rim_deg = 4100 / 111195;
  const sites = [storedAt('corner', corner_deg, corner_deg, 0.5), storedAt('north', 0, rim_deg, 0.5), storedAt('south', 0, -rim_deg, 0.5),
    storedAt('east', rim_deg, 0, 0.5)];
  assert.ok(!(await idsNear({ latitude_deg: 0, longitude_deg: 0 }, sites)).includes('corner'));
});

test('nearest sites: across the antimeridian, at the poles, and where there are few', async () => {
  const sites = [storedAt('fiji', -179.99, -17, 0.5), storedAt('pole', 100, 89.99, 0.5)];
  assert.deepEqual(await idsNear({ latitude_deg: -17, longitude_deg: 179.99 }, sites), ['fiji', 'pole']);
  assert.deepEqual(await idsNear({ latitude_deg: 89.99, longitude_deg: -80 }, sites), ['pole', 'fiji']);
  assert.deepEqual(await idsNear({ latitude_deg: 10, longitude_deg: 20 }, []), []);
});

test('margin: rounded down, so that it never promises more height than there is', () => {
  assert.deepEqual([86.9, 0.4, -0.4, -11.2, null].map(margin), ['+86 m', '+0 m', '−1 m', '−12 m', 'unknown']);
});

test('obstacles: the circle of people lies wholly in its polygon, within 1 % of the radius', () => {
  const centre = [8, 47];
  const place = ([longitude_deg, latitude_deg]) => ({ longitude_deg, latitude_deg });
  const ring = circleAround(centre, 100);
  ring.slice(1).forEach((corner, i) => {
    const middle = corner.map((value, k) => (value + ring[i][k]) / 2);
    const { distance_m } = courseTo(place(centre), place(middle));
    assert.ok(distance_m >= 99.9 && distance_m < 101, `a side passes at ${distance_m} m`);
  });
});

test('obstacles: a clockwise area is turned, and the server gets only what belongs to its kind', () => {
  const draft = { id: 'o', kind: 'no_fly', points: [[0, 0], [0, 1], [1, 1]], values: { name: ' Zone ', height_m: '12', floor_m: '', ceiling_m: '900', altitude_datum: 'amsl' } };
  const { geometry, properties } = featureOf(draft, 0);
  assert.deepEqual(geometry.coordinates, [[[1, 1], [0, 1], [0, 0], [1, 1]]]);
  assert.deepEqual(properties, { kind: 'no_fly', name: 'Zone', ceiling_m: 900, altitude_datum: 'amsl' });
});

test('obstacles: altitudes of a stored wire survive an edit; a new point without one asks for the height', () => {
  const stored = { type: 'Feature', id: 'w', properties: { kind: 'wire', altitude_datum: 'amsl' }, geometry: { type: 'LineString', coordinates: [[8, 47, 520], [8.1, 47, 530]] } };
  const draft = draftOf(stored);
  assert.equal(faultOf(draft), null);
  assert.deepEqual(featureOf(draft, 0), { type: 'Feature', geometry: stored.geometry, properties: stored.properties });
  draft.points.push([8.2, 47]);
  assert.equal(faultOf(draft).field, 'height_m');
  draft.values.height_m = '30';
  assert.deepEqual(featureOf(draft, 0).geometry.coordinates, [[8, 47], [8.1, 47], [8.2, 47]]);
});

test('obstacles: heights above ground of an airspace survive an edit, unless an altitude is entered', () => {
  const properties = { kind: 'no_fly', floor_above_ground_m: 300, ceiling_m: 900, altitude_datum: 'amsl' };
  const stored = { type: 'Feature', id: 'z', properties, geometry: { type: 'Polygon', coordinates: [[[0, 0], [1, 0], [1, 1], [0, 0]]] } };
  const draft = draftOf(stored);
  assert.deepEqual(featureOf(draft, 0).properties, properties);
  assert.equal(extentOf(stored), 'from 300 m above ground to 900 m');
  draft.values.floor_m = '500';
  assert.deepEqual(featureOf(draft, 0).properties, { kind: 'no_fly', floor_m: 500, ceiling_m: 900, altitude_datum: 'amsl' });
});

test('obstacles: the pointer of a problem names the field of the form', () => {
  assert.equal(fieldOf('/properties/height_m'), 'height_m');
  assert.equal(fieldOf('/properties/expires_at'), 'expires_h');
  assert.equal(fieldOf('/geometry/coordinates/0/1'), 'points');
  assert.equal(fieldOf(''), null);
});

test('offers: a part counts only if the API description has it', () => {
  assert.deepEqual(offersOf({ paths: { '/v1/sites': { get: { parameters: [{ name: 'bbox' }] } } } }), { flightMap: false, flightWhy: false, landing: false, nextLook: false, baseMap: false, reach: false, reachLimit: false, links: false, notices: false, obstacles: false, routeCheck: false, newLook: false });
  assert.deepEqual(offersOf({ paths: { '/v1/reach': { get: { parameters: [{ name: 'limit' }] } }, '/v1/obstacles': {}, '/v1/routes/check': {}, '/v1/sites': { get: { parameters: [{ $ref: '#/components/parameters/order' }] } } } }),
    { flightMap: false, flightWhy: false, landing: false, nextLook: false, baseMap: false, reach: true, reachLimit: true, links: false, notices: false, obstacles: true, routeCheck: true, newLook: true });
  const { flightMap, flightWhy, landing, nextLook, baseMap } = offersOf({ paths: { '/v1/flights/{flight}/map': {}, '/v1/flights/{flight}/next-look': {}, '/v1/flights/{flight}/map/{layer}.tif': {}, '/v1/base-map': {} } });
  assert.deepEqual([flightMap, flightWhy, landing, nextLook, baseMap], [true, false, false, true, true]);
});

test('reach: the request has the position and the flight: the server knows the ages of the rest', () => {
  const request = requestOf('f-1', { pose: { latitude_deg: 47, longitude_deg: 8, altitude_m: 600, altitude_datum: 'amsl', age_s: 1 }, wind: { east_mps: 3, north_mps: 0, age_s: 7200 } }, null);
  assert.deepEqual(JSON.parse(JSON.stringify(request)),
    { latitude_deg: 47, longitude_deg: 8, altitude_m: 600, glide_ratio: null, flight: 'f-1' });
});

test('plan: what the emergency answer calls unverified is not landable in its view', () => {
  const collection = { features: [], plan: { verdict: 'landable', summary: 'Landable' } };
  assert.equal(atBest('unverified', { collection }).collection.plan.verdict, 'unverified');
  assert.equal(atBest('landable', { collection }).collection.plan.verdict, 'landable');
  assert.equal(atBest(undefined, { collection }).collection.plan.verdict, 'landable');
  assert.deepEqual(atBest('unverified', { refusal: 'blocked' }), { collection: undefined, refusal: 'blocked' });
});

test('progress: an older server is worded as before; a summary, the time left and the area are taken as told', () => {
  const flight = { state: 'processing', frames: { received: 9, processed: 9 } };
  const job = { state: 'running', kind: 'finish', progress: 0, stage: 'dense_stereo' };
  assert.deepEqual(progressOf(flight, [job]), { value: null, text: 'Evaluating regions: dense stereo' });
  assert.deepEqual(progressOf({ ...flight, frames: { received: 9, processed: 3 } }, []), { value: 1 / 3, text: 'Photographs 3 of 9' });
  assert.equal(progressOf({ ...flight, state: 'failed' }, [job]), null);
  assert.equal(progressOf(flight, []), null);
  const area = { type: 'Point', coordinates: [8, 47] };
  assert.deepEqual(progressOf(flight, [{ ...job, progress: 0.5, stage_title: 'Measuring', summary: 'Measuring 3 of 6.', time_left_s: 61, area }]),
    { value: 0.5, text: 'Measuring', summary: 'Measuring 3 of 6.', left: 'about 2 min left', area });
});

test('progress: the time left is stated once', () => {
  const flight = { state: 'processing', frames: { received: 9, processed: 9 } };
  const job = { state: 'running', kind: 'finish', progress: 0.5, stage_title: 'Judging the ground', time_left_s: 40 };
  const { summary, left } = progressOf(flight, [{ ...job, summary: 'Judging the ground, about 40 s left' }]);
  assert.deepEqual([summary, left], ['Judging the ground, about 40 s left', '']);
  assert.equal(progressOf(flight, [{ ...job, summary: 'Judging the ground' }]).left, 'about 40 s left');
});

test('progress: while photographs are counted, a batch that waits says nothing', () => {
  const flight = { state: 'processing', frames: { received: 9, processed: 3 } };
  const batch = { state: 'queued', kind: 'batch', summary: 'Waiting for its turn' };
  assert.deepEqual(progressOf(flight, [batch]), { value: 1 / 3, text: 'Photographs 3 of 9' });
  const finish = { state: 'queued', kind: 'finish', summary: 'Waiting until the photographs are processed' };
  assert.equal(progressOf(flight, [batch, finish]).summary, finish.summary);
});

test('progress: a waiting job names what it waits for', () => {
  const waiting = { state: 'queued', kind: 'finish', waiting_for: { flight_id: 'f-2', flight_name: 'North field', time_left_s: 30 } };
  const progress = progressOf({ state: 'processing', frames: { received: 1, processed: 1 } }, [waiting]);
  assert.deepEqual([progress.text, progress.summary, progress.value], ['Waiting', 'Waiting for North field, about 30 s left', null]);
});

test('progress: the time left is rounded up, and an unknown one is not stated', () => {
  assert.deepEqual([1, 31, 60, 61, 3600, 7260, null, undefined, -1].map(waitText), ['about 10 s left', 'about 40 s left', 'about 1 min left',
    'about 2 min left', 'about 1 h 0 min left', 'about 2 h 1 min left', '', '', '']);
});

test('tiles: their path is on this server, whatever host the address names', () => {
  const place = { z: 17, x: 5, y: 6 };
  assert.equal(tilePath('https://other.example:8443/v1/flights/f/map/photo/{z}/{x}/{y}.png', place), '/v1/flights/f/map/photo/17/5/6.png');
  assert.equal(tilePath('/v1/base-map/{z}/{x}/{y}', place), '/v1/base-map/17/5/6');
});

test('tiles: another server is one of another scheme, host or port', () => {
  const isOther = (template) => isElsewhere(template, 'https://plane.example');
  assert.deepEqual(['/v1/base-map/{z}/{x}/{y}', 'https://plane.example/{z}', 'HTTPS://Plane.example/{z}'].map(isOther), [false, false, false]);
  assert.deepEqual(['http://plane.example/{z}', 'https://plane.example:8443/{z}', 'https://plane.example.org/{z}'].map(isOther), [true, true, true]);
});

test('tiles: few at once, in order; a task that is not wanted any more never starts', async () => {
  const inTurn = createQueue(2);
  const started = [];
  const ends = [];
  const task = (name) => () => {
    started.push(name);
    return new Promise((resolve) => { ends.push(() => resolve(name)); });
  };
  const left = new AbortController();
  const { signal } = new AbortController();
  const results = ['a', 'b', 'c', 'd'].map((name) => inTurn(task(name), name === 'c' ? left.signal : signal));
  results[2].catch(() => {});
  assert.deepEqual(started, ['a', 'b']);
  left.abort();
  ends[0]();
  assert.equal(await results[0], 'a');
  await assert.rejects(results[2], { name: 'AbortError' });
  assert.deepEqual(started, ['a', 'b', 'd']);
});

test('credit: markup of a map file becomes text', () => {
  assert.equal(plainText('<a href="x">&copy; Survey</a> 2026 <img src=x onerror=alert(1)>&#169;'), '© Survey 2026 ©');
});

test('unseen cells lose their black, all else stays; blank places are told apart', () => {
  const data = [126, 211, 150, 255, 26, 26, 26, 255, 200, 70, 0, 255];
  assert.deepEqual(clearUnseen(data), { hasUnseen: true, hasBlank: false });
  assert.deepEqual(data, [126, 211, 150, 255, 26, 26, 26, 0, 200, 70, 0, 255]);
  assert.deepEqual(clearUnseen([0, 0, 0, 0, 27, 26, 26, 255]), { hasUnseen: false, hasBlank: true });
});
