// The view "Route": what it asks, and what it shows of a sample answer in front of a running server that holds a
// finished flight, and of the server's own; see page_test.mjs.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import {
  changedPart, clock, coveredText, draftText, faultOf, momentText, planOf, planQueryOf, requestOf, sentenceOf, siteName, spansOf,
} from '../../web/route_request.js';
import { accessibilityFaults, flownSite, isOptional, launch, openPage, smallTargets, url } from './browser.mjs';
import { offset, sampleInsurance } from './sample_parts.mjs';
import { kWait, shoot } from './site_page.mjs';
import { startStandIn } from './stand_in.mjs';

const phone = { width: 390, height: 844 };
const kLong = { timeout: 60000 };  // a real check searches for changes
let browser;
let site;

before(async () => { [browser, site] = await Promise.all([launch(), flownSite()]); });
after(() => browser?.close());

// --- Request and texts ---

const at = (east_m, altitude_m) => {
  const [longitude_deg, latitude_deg] = offset([8, 47], east_m, 0);
  return { latitude_deg, longitude_deg, altitude_m };
};
const drawn = { points: [{ latitude_deg: 47, longitude_deg: 8 }, { latitude_deg: 47, longitude_deg: 8.1, altitude_m: 700 }], plan: null };
const values = { altitude_m: 600, airspeed_mps: 14, wind_speed_mps: 5, wind_from_deg: 270, wind_sd_mps: 1, aircraft: 'small' };

test('route: the request has the altitude of the form where a point has none, and a wind that moves to the east', () => {
  assert.deepEqual(requestOf(drawn, values), {
    route: [{ latitude_deg: 47, longitude_deg: 8, altitude_m: 600 }, { latitude_deg: 47, longitude_deg: 8.1, altitude_m: 700 }],
    altitude_datum: 'amsl', airspeed_mps: 14, wind: { east_mps: 5, north_mps: 0, sd_mps: 1 }, aircraft: 'small' });
  const calm = requestOf(drawn, { ...values, wind_speed_mps: 0, wind_from_deg: null, wind_sd_mps: null });
  assert.deepEqual(calm.wind, { east_mps: 0, north_mps: 0 });
  const unknown = requestOf(drawn, { ...values, wind_speed_mps: null, aircraft: null });
  assert.ok(!('wind' in unknown) && !('aircraft' in unknown));
});

test('route: the first missing value is named with its field', () => {
  const fault = (changes, draft = drawn) => faultOf(draft, { ...values, ...changes })?.field;
  assert.equal(faultOf(drawn, values), null);
  assert.equal(fault({ altitude_m: null }), 'altitude_m');
  assert.equal(fault({ altitude_m: null }, { ...drawn, points: drawn.points.map((p) => ({ ...p, altitude_m: 500 })) }), undefined);
  assert.equal(fault({ altitude_m: null }, { points: [], plan: { name: 'a.plan', json: {} } }), undefined);
  assert.equal(fault({ airspeed_mps: null }), 'airspeed_mps');
  assert.equal(fault({ wind_from_deg: null }), 'wind_from_deg');
  assert.equal(fault({ wind_speed_mps: 0, wind_from_deg: null }), undefined);
  assert.equal(fault({ wind_speed_mps: null }), 'wind_speed_mps');
  assert.match(faultOf({ points: drawn.points.slice(1), plan: null }, values).detail, /at least two points/);
});

test('route: a plan is asked with its file as body, unless the aircraft is no profile', () => {
  const { json, airspeed_mps } = planOf('{"fileType": "Plan", "mission": {"cruiseSpeed": 15}}');
  assert.equal(airspeed_mps, 15);
  assert.throws(() => planOf('{"fileType": "Params"}'), /not a plan/);
  assert.throws(() => planOf('no JSON'), /not a plan/);
  const draft = { points: [], plan: { name: 'a.plan', json } };
  assert.deepEqual(planQueryOf(requestOf(draft, values)),
    { altitude_datum: 'amsl', airspeed_mps: 14, aircraft: 'small', wind_east_mps: 5, wind_north_mps: 0, wind_sd_mps: 1 });
  assert.equal(planQueryOf(requestOf(draft, { ...values, aircraft: { glide_ratio: 9 } })), null);
  assert.equal(planQueryOf(requestOf(drawn, values)), null);
});

test('route: lines meet where coverage changes, and no gap is rounded away', () => {
  const samples = [true, true, false, true].map((covered, i) => ({ covered, time_s: i }));
  assert.deepEqual(spansOf({ samples, end: 'end' }).map(({ isCovered, places }) => [isCovered, places.map((p) => p.time_s ?? p)]),
    [[true, [0, 1, 2]], [false, [2, 3]], [true, [3, 'end']]]);
  assert.deepEqual([0.9999, 1, 0.29].map((covered_ratio) => coveredText({ covered_ratio })), ['99 %', '100 %', '29 %']);
  assert.deepEqual([75, 3675, 0].map(clock), ['1:15', '1:01:15', '0:00']);
});

test('route: texts name the site as the page does, and never promise more than the answer', () => {
  const nameOf = (id) => ({ 'f-1-r1': 'site 2' })[id] ?? id;
  assert.equal(sentenceOf('2 m are missing to f-1-r1', nameOf), '2 m are missing to site 2.');
  assert.equal(sentenceOf('2 m are missing to f-1-r11', nameOf), '2 m are missing to f-1-r11.');
  const flights = [{ id: 'f-1', name: 'Alp' }, { id: 'f-2' }];
  assert.deepEqual([siteName('f-1-r1', 2, flights), siteName('f-1-r1', undefined, flights), siteName('f-2-e0n1', undefined, flights), siteName('f-3-r1', undefined, flights)],
    ['site 2', 'site r1 of Alp', 'site e0n1 of f-2', 'f-3-r1']);
  const sample = { time_s: 75, altitude_m: 580.2, heading_deg: 86, covered: true, covered_weight: 1, best_site: 'f-1-r1', arrival_margin_m: 2.9, failure_probability: 0.0472 };
  const covered = momentText(sample, nameOf);
  assert.match(covered.title, /✓ site 2, arrival margin \+2 m/);
  assert.match(covered.lines.join(), /1:15, 580 m AMSL, heading 086°, failure probability 4\.7 %/);
  const gap = momentText({ ...sample, covered: false, covered_weight: 0.667, arrival_margin_m: -16.1, reason: 'too_low', failure_probability: undefined }, nameOf);
  assert.match(gap.title, /✕ No site in reach: too low/);
  assert.match(gap.lines.join(), /In reach in 66 % of the winds.*−17 m at site 2/);
  assert.equal(draftText({ points: [at(0, 580), at(9, 630)], plan: null }), '2 points, 580 m to 630 m AMSL');
});

test('route: of a changed route, only the changed part is shown', () => {
  const samples = Array.from({ length: 21 }, (_, i) => at(i * 15, 580));
  const climb = [at(0, 580), at(60, 580), at(120, 630), at(180, 630), at(240, 580), at(300, 580)];
  const higher = changedPart(climb, samples);
  assert.deepEqual([higher.points, higher.highest.altitude_m], [climb.slice(1, 5), 630]);
  const [longitude_deg, latitude_deg] = offset([8, 47], 150, 200);
  const aside = [at(0, 580), at(100, 580), { latitude_deg, longitude_deg, altitude_m: 580 }, at(200, 580), at(300, 580)];
  assert.deepEqual(changedPart(aside, samples), { points: aside.slice(1, 4), highest: null });
});

// --- The view ---

async function open(t, route, options = {}) {
  const server = await startStandIn(t, url, { route });
  const opened = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}`, ...options });
  opened.page.on('console', (message) => {
    if (message.type() === 'error' && !isOptional(message.location().url)) opened.seen.errors.push(message.text());
  });
  await opened.page.locator('#sites button').first().waitFor(kWait);
  return { server, ...opened };
}

const insure = (body) => sampleInsurance(body, site.properties.id);

// Clicks at shares of the map's width and height.
async function clickMap(page, ...shares) {
  const box = await page.locator('#map').boundingBox();
  for (const [right, down] of shares) await page.mouse.click(box.x + right * box.width, box.y + down * box.height);
}

async function drawAndCheck(page) {
  await page.locator('#open-route').click();
  await clickMap(page, [0.3, 0.4], [0.45, 0.3], [0.7, 0.5]);
  await page.fill('#route-altitude_m', '580');
  await page.fill('#route-airspeed_mps', '14');
  await page.locator('#route-check').click();
  await page.locator('[data-take]').waitFor(kWait);
}

const overflow_px = (page) => page.evaluate(() => Math.max(document.documentElement.scrollWidth - innerWidth,
  document.getElementById('panel').scrollWidth - document.getElementById('panel').clientWidth));

for (const [name, options] of [['desktop', {}], ['phone', { ...phone, colorScheme: 'dark' }]]) {
  test(`route: drawn by clicks, checked, shown with gaps and the point of no return, ${name}`, async (t) => {
    const { page, seen, server } = await open(t, insure, options);
    await drawAndCheck(page);
    assert.deepEqual(server.routes.map(({ with_fixes }) => with_fixes), [false, undefined], 'gaps first, then changes');
    const [{ route, altitude_datum, airspeed_mps }] = server.routes;
    assert.deepEqual([route.map(({ altitude_m }) => altitude_m), altitude_datum, airspeed_mps], [[580, 580, 580], 'amsl', 14]);
    assert.ok(route[0].longitude_deg < route[1].longitude_deg && route[1].latitude_deg > route[2].latitude_deg);
    const look = await page.evaluate(() => ['covered', 'gap'].map((kind) => {
      const { stroke, strokeDasharray } = getComputedStyle(document.querySelector(`path.route-${kind}`));
      return [stroke, strokeDasharray === 'none'];
    }));
    assert.deepEqual(look, [['rgb(0, 121, 90)', true], ['rgb(176, 0, 32)', false]], 'a gap differs by more than its colour');
    assert.match(await page.locator('#route-outcome').innerText(), /✕ 50 % covered, 1 gap\s+No site in reach for 0:40 of 1:20/);
    assert.equal(await page.locator('.route-no-return em').textContent(), 'no return 0:39');
    assert.match(await page.locator('.route-gap-row').innerText(), /Gap 1: 0:40 to 1:20\s+No site is in reach; where least is missing, 11 m are missing to site \d+\./);
    assert.match(await page.locator('#route-warnings').innerText(), /^Terrain on the way .* cover it\.$/);
    await shoot(page, `route-${name}`);
    assert.equal(await overflow_px(page), 0);
    assert.deepEqual(await smallTargets(page), []);
    assert.deepEqual(await accessibilityFaults(page), []);
    assert.deepEqual(seen.errors, []);
  });
}

test('route: slider, chart and line tell about the same second', async (t) => {
  const { page, seen } = await open(t, insure);
  await drawAndCheck(page);
  const told = () => page.locator('#route-moment').innerText();
  assert.match(await told(), /✕ No site in reach: too low\s+In reach in 40 % of the winds. 1:00/);
  await page.locator('#route-time').focus();
  await page.keyboard.press('Home');
  await page.keyboard.press('ArrowRight');
  assert.match(await told(), /✓ site \d+, arrival margin \+41 m\s+0:01, 580 m AMSL, heading 090°, failure probability 4\.7 %/);
  assert.equal(await page.locator('.route-moment b').textContent(), '0:01 · +41 m');
  assert.match(await page.locator('#route-time').getAttribute('aria-valuetext'), /^0:01: ✓ site/);
  await page.locator('#route-chart .u-over').hover({ position: { x: 3, y: 20 } });
  const chart = await page.locator('#route-chart .u-over').boundingBox();
  await page.mouse.move(chart.x + 0.75 * chart.width, chart.y + 20);
  assert.match(await told(), /1:00/);
  const now = await page.locator('.route-now').boundingBox();
  assert.ok(Math.abs(now.x + now.width / 2 - chart.x - 0.75 * chart.width) < 4, 'the chart marks the second');
  // The whole route is in view: its line runs through the middle of its two signs.
  const line = await page.locator('path.route-covered').evaluate((path) => {
    const { x, y } = path.getPointAtLength(path.getTotalLength() / 2).matrixTransform(path.getScreenCTM());
    return { x, y };
  });
  await page.mouse.move(line.x, line.y + 8);
  assert.match(await told(), /✓ site \d+/);
  const second = Number(await page.locator('#route-time').inputValue());
  assert.ok(Math.abs(second - 20) <= 2, `the middle of the first leg is second 20, not ${second}`);
  await page.mouse.click(line.x, line.y + 8);
  await page.waitForTimeout(600);
  assert.equal(await page.locator('.leaflet-popup').count(), 0, 'a click on the line is no click on the ground');
  assert.deepEqual(seen.errors, []);
});

test('route: a change is shown, taken and checked again, and taken back', async (t) => {
  const { page, seen, server } = await open(t, insure);
  await drawAndCheck(page);
  await page.locator('[data-kind=climb] [data-show]').click();
  await page.locator('path.route-fix').waitFor({ state: 'attached' });
  assert.equal(await page.locator('.route-altitude').textContent(), '▲ 630 m');
  assert.ok(await page.locator('[data-kind=climb] [data-show]').evaluate((node) => node === document.activeElement), 'the focus stays');
  await page.locator('[data-kind=look] [data-show]').click();
  await page.locator('.route-look').waitFor();
  assert.equal(await page.locator('path.route-fix').count(), 0, 'one change at a time');
  assert.equal(await page.locator('[data-kind=look] [data-take]').count(), 0);
  await page.locator('[data-take]').click();
  await page.getByText('A site is in reach all the way').waitFor(kWait);
  assert.deepEqual(server.routes.at(-1).route.map(({ altitude_m }) => altitude_m), [580, 630, 630]);
  assert.equal(await page.locator('path.route-gap').count(), 0);
  assert.match(await page.locator('#route-points').textContent(), /3 points, 580 m to 630 m AMSL/);
  await page.locator('#route-restore').click();
  await page.locator('.route-gap-row').waitFor(kWait);
  assert.equal(await page.locator('#route-altitude_m').inputValue(), '580');
  assert.deepEqual(seen.errors, []);
});

test('route: a gap is zoomed to; a changed value marks the answer as old; another view hides the line', async (t) => {
  const { page } = await open(t, insure);
  await drawAndCheck(page);
  const width_px = () => page.locator('path.route-gap').evaluate((path) => path.getTotalLength());
  const whole_px = await width_px();
  await page.locator('.route-gap-name').click();
  await page.waitForFunction((before) => document.querySelector('path.route-gap').getTotalLength() > 1.1 * before, whole_px, kWait);
  assert.ok(await page.locator('#route-old').isHidden());
  await page.fill('#route-airspeed_mps', '20');
  assert.ok(await page.locator('#route-old').isVisible());
  assert.equal(await page.locator('#route-check').textContent(), 'Check again');
  await page.locator('[data-tab=flight]').click();
  assert.equal(await page.locator('path.route-gap').count(), 0);
  await page.locator('[data-tab=sites]').click();
  await page.locator('#open-route').click();
  assert.equal(await page.locator('path.route-gap').count(), 1, 'the answer is kept');
});

test('route: by keyboard, with undo, clear and a missing value; a refusal is told', async (t) => {
  const { page, server } = await open(t, () => { throw 'route: takes 90000 s; seconds times winds must be at most 40000'; });
  await page.locator('#open-route').focus();
  await page.keyboard.press('Enter');
  const points = () => page.locator('#route-points').textContent();
  const press = async (id) => {
    await page.locator(`#route-${id}`).focus();
    await page.keyboard.press('Enter');
  };
  await press('add-point');
  await page.locator('#map').focus();
  await page.keyboard.press('ArrowRight');
  await page.waitForTimeout(400);
  await page.keyboard.press('Enter');
  assert.equal(await points(), '2 points');
  await press('undo');
  assert.match(await points(), /next point/);
  await press('clear');
  assert.match(await points(), /first point/);
  await press('add-point');
  await press('add-point');
  await press('draw');
  assert.ok(await page.locator('#route-tools').isHidden());
  await page.fill('#route-altitude_m', '580');
  await page.fill('#route-airspeed_mps', '');
  await page.keyboard.press('Enter');
  assert.equal(await page.locator('#route-fault').textContent(), 'Enter the airspeed.');
  assert.equal(await page.evaluate(() => document.activeElement.id), 'route-airspeed_mps');
  assert.equal(server.routes.length, 0, 'nothing was asked');
  await page.keyboard.type('14');
  await page.keyboard.press('Enter');
  await page.getByText('Not checked: route: takes 90000 s').waitFor(kWait);
});

test('route: a dropped plan is checked at once, with its cruise speed, and is not uploaded', async (t) => {
  const places = [-400, 0, 900].map((east_m) => offset(site.place, east_m, 0)).map(([longitude_deg, latitude_deg]) => ({ latitude_deg, longitude_deg, altitude_m: 580 }));
  const { page, server, seen } = await open(t, (body) => insure({ route: places, ...body }));
  const drop = (name, text) => page.evaluate(([file, content]) => {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([content], file));
    document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
  }, [name, text]);
  await drop('loop.plan', '{"fileType": "Parameters"}');
  await page.getByText('This file is not a plan of QGroundControl.').waitFor(kWait);
  const plan = { fileType: 'Plan', mission: { cruiseSpeed: 17 } };
  await drop('loop.plan', JSON.stringify(plan));
  await page.locator('[data-take]').waitFor(kWait);
  assert.ok(await page.locator('[data-view=upload]').isHidden());
  assert.deepEqual([server.routes[0].plan, server.routes[0].airspeed_mps, 'route' in server.routes[0]], [plan, 17, false]);
  assert.equal(await page.locator('#route-points').textContent(), 'Plan loop.plan. Its altitudes count.');
  await page.locator('[data-take]').click();
  await page.getByText('A site is in reach all the way').waitFor(kWait);
  assert.equal(server.routes.at(-1).route.length, 3, 'a change turns the plan into points');
  assert.deepEqual(seen.errors, []);
});

test('route: a server without this call leaves no trace of it', async (t) => {
  const { page } = await open(t, null);
  await page.locator('#open-new-look').waitFor(kWait);
  await page.waitForTimeout(500);
  assert.ok(await page.locator('#open-route').isHidden());
});

// --- The real server ---

// A plan from 300 m west of the site to far in the east, where no site is.
function planOver([lon, lat], altitude_m) {
  const item = ([longitude, latitude], command, i) => ({ type: 'SimpleItem', command, frame: 0, autoContinue: true, doJumpId: i + 1,
    params: [0, 0, 0, null, latitude, longitude, altitude_m] });
  const places = [offset([lon, lat], -300, 0), offset([lon, lat], 0, 0), offset([lon, lat], 9000, 0)];
  return { fileType: 'Plan', version: 1, groundStation: 'QGroundControl', geoFence: {}, rallyPoints: {},
    mission: { version: 2, cruiseSpeed: 25, hoverSpeed: 5, firmwareType: 3, vehicleType: 1,
      plannedHomePosition: [lat, lon, altitude_m - 200], items: places.map((place, i) => item(place, 16, i)) } };
}

test('route: the server checks a plan, and the page shows where its sites are in reach', async (t) => {
  const { page, seen } = await openPage(t, browser, { address: `${url}/#flight=${site.flight}` });
  await page.locator('#sites button').first().waitFor(kWait);
  await page.locator('#open-route').click();
  const plan = planOver(site.place, site.properties.elevation_m + 200);
  await page.setInputFiles('#route-plan', { name: 'east.plan', mimeType: 'application/json', buffer: Buffer.from(JSON.stringify(plan)) });
  await page.locator('path.route-covered').first().waitFor({ state: 'attached', ...kLong });
  assert.equal(await page.locator('#route-airspeed_mps').inputValue(), '25');
  assert.match(await page.locator('#route-points').textContent(), /Plan east\.plan/);
  await page.waitForFunction(() => document.getElementById('route-check').textContent === 'Check', null, kLong);
  assert.ok(await page.locator('path.route-gap').count() > 0);
  assert.equal(await page.locator('.route-no-return').count(), 1);
  assert.match(await page.locator('#route-gaps').innerText(), /No site is in reach/);
  await page.evaluate(() => { navigator.clipboard.writeText = async (text) => { globalThis.copied = text; }; });
  await page.locator('#route-curl button').click();
  assert.match(await (await page.waitForFunction(() => globalThis.copied)).jsonValue(),
    /^curl -sS -H 'Content-Type: application\/json' --data-binary '@east\.plan' '[^']+\/v1\/routes\/check\?altitude_datum=amsl&airspeed_mps=25/);
  assert.deepEqual(seen.errors, []);
});
