// Ground in reach, obstacles, go-around, places worth a new look: against sample answers in front of a running
// server that holds a finished flight; see page_test.mjs.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { accessibilityFaults, flownSite, getJson, isOptional, launch, openPage, smallTargets, url } from './browser.mjs';
import { offset, sampleNewLook, sampleObstacles, sampleReach, withGoAround } from './sample_parts.mjs';
import { kWait, shoot } from './site_page.mjs';
import { startStandIn } from './stand_in.mjs';

const phone = { width: 360, height: 740 };
const kNoReturn_m = 20;
let browser;
let site;
let sites;

before(async () => {
  [browser, site] = await Promise.all([launch(), flownSite()]);
  sites = (await getJson(`/v1/flights/${site.flight}/sites`)).features;
});
after(() => browser?.close());

const margins_m = [86.9, -11.2];
const reachFrom = (parameters) => sampleReach([Number(parameters.get('longitude_deg')), Number(parameters.get('latitude_deg'))],
  sites.slice(0, 2).map((feature, i) => ({ id: feature.properties.id, place: feature.geometry.coordinates, arrival_margin_m: margins_m[i] })));

// The selected flight's last position, pose.age_s old, 300 m south-west of the site.
function poseOf(age_s) {
  const [longitude_deg, latitude_deg] = offset(site.place, -210, -210);
  return { latitude_deg, longitude_deg, altitude_m: site.properties.elevation_m + 150, altitude_datum: site.properties.altitude_datum, heading_deg: 45, age_s };
}

// pose: changed by the test while the page runs.
function withPose(pose) {
  return (path, json) => (path.endsWith('/alternates') ? { ...json, pose, wind: { east_mps: 3, north_mps: 0, age_s: 1 } } : json);
}

async function open(t, parts, options = {}) {
  const server = await startStandIn(t, url, { reach: null, obstacles: null, newLook: null, emergency: 'real', ...parts });
  const opened = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}`, ...options });
  opened.page.on('console', (message) => {
    if (message.type() === 'error' && !isOptional(message.location().url)) opened.seen.errors.push(message.text());
  });
  await opened.page.locator('#sites button').first().waitFor(kWait);
  return { server, ...opened };
}

const asksFor = (server, path) => server.asked.filter((entry) => typeof entry === 'string' && entry.startsWith(path));
const overflow_px = (page) => page.evaluate(() => Math.max(document.documentElement.scrollWidth - innerWidth,
  document.getElementById('panel').scrollWidth - document.getElementById('panel').clientWidth));

test('reach: a live flight shows it, unknown terrain looks different, margins stand beside the sites', async (t) => {
  const pose = poseOf(2);
  const { page, seen, server } = await open(t, { reach: reachFrom, rewrite: withPose(pose) });
  await page.locator('path.reach').waitFor({ state: 'attached', ...kWait });
  const look = await page.evaluate(() => ['path.reach', 'path.unknown-terrain', 'path.reach-unknown', 'path.reach-fill'].map((selector) => {
    const { stroke, strokeDasharray, fill } = getComputedStyle(document.querySelector(selector));
    return { stroke, dash: strokeDasharray, fill };
  }));
  assert.equal(look[0].dash, 'none');
  assert.notEqual(look[1].dash, 'none', 'the outline of unknown terrain is dashed');
  assert.match(look[2].fill, /unknown-terrain/, 'unknown terrain is hatched');
  const isOpaque = await page.evaluate(() => {
    const [fill, unknown] = ['path.reach-fill', 'path.reach-unknown'].map((selector) => document.querySelector(selector));
    const { fill: base, fillOpacity } = getComputedStyle(document.querySelector('#unknown-terrain rect'));
    const isAbove = fill.compareDocumentPosition(unknown) === Node.DOCUMENT_POSITION_FOLLOWING;
    return isAbove && /^rgb\(/.test(base) && fillOpacity === '1' && getComputedStyle(unknown).fillOpacity === '1';
  });
  assert.ok(isOpaque, 'unknown terrain hides the fill of the reach');
  const levels = await page.evaluate(() => ['path.reach-fill', 'path.reach-unknown'].map((selector) =>
    Number(getComputedStyle(document.querySelector(selector).closest('.leaflet-pane')).zIndex)));
  const layers = await page.evaluate(() => Number(getComputedStyle(document.querySelector('.leaflet-layers-pane')).zIndex));
  assert.ok(levels[0] < layers && layers < levels[1], 'no layer of the ground tints unknown terrain');
  // Rounded down: a margin never promises more than it is.
  assert.deepEqual((await page.locator('#map .arrival').allTextContents()).sort(), ['+86 m', '−12 m'].sort());
  await page.locator('#key', { hasText: 'in reach, terrain unknown' }).waitFor(kWait);
  assert.match(await page.locator('#key').textContent(), /Reach, position 2 s old/);
  await shoot(page, 'reach');
  const [asked] = asksFor(server, '/v1/reach');
  const sent = new URL(asked, url).searchParams;
  assert.deepEqual([sent.get('flight'), Number(sent.get('altitude_m')), sent.get('wind_east_mps'), sent.get('limit')],
    [site.flight, pose.altitude_m, null, '20'], 'the wind is the flight’s, with its age');
  // Each new position is asked for, at most one a second, never two at once.
  const before = asksFor(server, '/v1/reach').length;
  const moving = setInterval(() => { pose.longitude_deg += 1e-5; }, 100);
  t.after(() => clearInterval(moving));
  await page.waitForTimeout(4500);
  const count = asksFor(server, '/v1/reach').length - before;
  assert.ok(count >= 2 && count <= 5, `${count} requests in 4.5 s`);
  assert.equal(server.mostReach(), 1);
  // A silent aircraft may be anywhere.
  pose.age_s = 61;
  await page.locator('path.reach').waitFor({ state: 'detached', ...kWait });
  assert.equal(await page.locator('#map .arrival').count(), 0);
  assert.deepEqual(seen.errors, []);
});

test('reach: the emergency view has a map of it, also for an entered position, and margins as on the cards', async (t) => {
  // The flight is not live: after the view is closed, no reach is shown.
  const parts = { reach: reachFrom, obstacles: sampleObstacles(site.place), rewrite: withPose(poseOf(7200)) };
  const { page, seen, server } = await open(t, parts);
  await page.locator('.bar [data-emergency]').click();
  await page.locator('#em-more summary').click();
  await page.locator('#em-latitude_deg').fill(String(site.place[1]));
  await page.locator('#em-longitude_deg').fill(String(site.place[0]));
  await page.selectOption('#em-altitude_datum', site.properties.altitude_datum);
  await page.locator('#em-altitude_m').fill((site.properties.elevation_m + 250).toFixed(0));
  await page.locator('#em-message', { hasText: /^In reach/ }).waitFor(kWait);
  await page.locator('#em-more summary').click();
  await page.locator('#em-map path.reach').waitFor({ state: 'attached', ...kWait });
  await page.locator('#em-reach', { hasText: 'Reach, from the entered position' }).waitFor(kWait);
  const onCard = await page.locator('.em-card .em-margin').first().textContent();
  await page.locator('#em-map .arrival', { hasText: onCard }).first().waitFor({ state: 'attached', ...kWait });
  await page.locator('#em-map path.wire').waitFor({ state: 'attached', ...kWait });
  await page.locator('#em-key', { hasText: /in reach, terrain unknown.*wire/ }).waitFor(kWait);
  const sent = new URL(asksFor(server, '/v1/reach').at(-1), url).searchParams;
  assert.equal(sent.get('latitude_deg'), String(Number(site.place[1])));
  assert.equal(sent.get('limit'), '20');
  await shoot(page, 'emergency-reach');
  assert.deepEqual(await accessibilityFaults(page), []);
  await page.setViewportSize(phone);
  await page.locator('#em-map').scrollIntoViewIfNeeded();
  await shoot(page, 'emergency-reach-phone');
  assert.ok(await page.evaluate(() => document.getElementById('emergency').scrollWidth <= document.getElementById('emergency').clientWidth));
  await page.locator('#em-close').click();
  await page.locator('#map path.reach').waitFor({ state: 'detached', ...kWait });
  assert.deepEqual(seen.errors, []);
});

test('emergency: site, bearing and margin of the first card are in sight at once, at both sizes', async (t) => {
  for (const size of [{ width: 1280, height: 800 }, { width: 360, height: 640 }]) {
    const { page } = await open(t, { rewrite: withPose(poseOf(2)) }, size);
    await page.locator('[data-emergency]').locator('visible=true').first().click();
    await page.locator('#em-message', { hasText: /^In reach/ }).waitFor(kWait);
    for (const part of ['header strong', '.em-course strong', '.em-margin', '.arrow']) {
      const box = await page.locator(`.em-card >> nth=0 >> ${part} >> nth=0`).boundingBox();
      assert.ok(box.y >= 0 && box.y + box.height <= size.height && box.x >= 0 && box.x + box.width <= size.width,
        `${part} at ${JSON.stringify(box)} of ${size.width} px`);
    }
  }
});

test('obstacles: each kind has its sign, shape and legend; an expired one is not drawn', async (t) => {
  for (const colorScheme of ['light', 'dark']) {
    const past = { ...sampleObstacles(site.place)[3], id: 'people-0' };
    past.properties = { ...past.properties, expires_at: new Date(Date.now() - 1000).toISOString() };
    const { page, seen } = await open(t, { obstacles: [...sampleObstacles(site.place), past] }, { colorScheme });
    await page.locator('path.wire').waitFor({ state: 'attached', ...kWait });
    assert.equal(await page.locator('#map .obstacle-sign').count(), 4);
    const kinds = await page.locator('#map .obstacle-sign svg').evaluateAll((all) => all.map((sign) => sign.classList[0]).sort());
    assert.deepEqual(kinds, ['sign-mast', 'sign-no-fly', 'sign-people', 'sign-wire']);
    const fills = await page.evaluate(() => ['path.no-fly', 'path.people'].map((selector) => document.querySelector(selector).getAttribute('fill')));
    assert.deepEqual(fills, ['url(#no-fly-pattern)', 'url(#people-pattern)']);
    for (const name of ['wire', 'mast', 'no-fly area', 'people']) assert.ok((await page.locator('#key').textContent()).includes(name), name);
    await page.locator('#open-obstacles').click();
    assert.equal(await page.locator('.obstacle-row').count(), 4);
    await shoot(page, `obstacles-${colorScheme}`);
    assert.deepEqual(await accessibilityFaults(page), []);
    assert.deepEqual(seen.errors, []);
  }
});

test('obstacles: a wire is drawn with taps, refused at its field, saved, edited, and deleted after a question', async (t) => {
  const obstacles = [];
  const { page, server } = await open(t, { obstacles });
  await page.locator('#open-obstacles').click();
  await page.locator('#no-obstacles').waitFor(kWait);
  await page.locator('[data-kind="wire"]').click();
  const map = await page.locator('#map').boundingBox();
  await page.mouse.click(map.x + 0.5 * map.width, map.y + 0.3 * map.height);
  await page.locator('#ob-save').click();
  assert.match(await page.locator('#ob-points-fault').textContent(), /at least 2 points/);
  await page.mouse.click(map.x + 0.7 * map.width, map.y + 0.4 * map.height);
  await page.locator('#ob-save').click();
  assert.equal(await page.locator('#ob-height_m-fault').textContent(), 'Enter the height.');
  assert.equal(await page.locator('#ob-height_m').getAttribute('aria-describedby'), 'ob-height_m-fault');
  assert.equal(server.asked.filter((path) => /^\/v1\/obstacles\/./.test(path)).length, 0, 'nothing was sent yet');
  // The server's own refusal stands at the field too.
  await page.locator('#ob-height_m').fill('1200');
  await page.locator('#ob-name').fill('New line');
  await page.locator('#ob-save').click();
  await page.locator('#ob-height_m-fault', { hasText: 'must be at most 1000' }).waitFor(kWait);
  await shoot(page, 'obstacle-refused');
  await page.locator('#ob-height_m').fill('32');
  await page.locator('#ob-save').click();
  await page.locator('.obstacle-row', { hasText: 'New line' }).waitFor(kWait);
  assert.equal(obstacles.length, 1);
  assert.match(obstacles[0].id, /^[A-Za-z0-9._-]{1,128}$/);
  const { geometry, properties } = obstacles[0];
  assert.deepEqual([geometry.type, geometry.coordinates.length, properties], ['LineString', 2, { kind: 'wire', name: 'New line', height_m: 32 }]);
  await page.locator('path.wire').waitFor({ state: 'attached', ...kWait });
  await page.locator('[aria-label="Edit Wire New line"]').click();
  assert.equal(await page.locator('#ob-height_m').inputValue(), '32');
  await page.locator('#ob-height_m').fill('40');
  await page.locator('#ob-save').click();
  await page.locator('.obstacle-row', { hasText: '40 m' }).waitFor(kWait);
  assert.equal(obstacles.length, 1, 'under the same id');
  const remove = page.locator('[aria-label="Delete Wire New line"]');
  await remove.click();
  await page.locator('#confirm button[value="no"]').click();
  assert.equal(obstacles.length, 1, 'kept');
  await remove.click();
  await page.locator('#confirm-yes').click();
  await page.locator('#no-obstacles').waitFor(kWait);
  assert.equal(obstacles.length, 0);
  assert.equal(await page.locator('path.wire').count(), 0);
});

test('obstacles: by keyboard alone and on a phone: people in a circle that expires', async (t) => {
  const obstacles = [];
  const { page, seen } = await open(t, { obstacles }, phone);
  await page.locator('#open-obstacles').focus();
  await page.keyboard.press('Enter');
  await page.locator('[data-kind="people"]').focus();
  await page.keyboard.press('Enter');
  await page.locator('#obstacle-form-title:focus').waitFor(kWait);
  for (let i = 0; i < 8 && !await page.locator('#ob-add:focus').count(); ++i) await page.keyboard.press('Tab');
  await page.keyboard.press('Enter');
  await page.locator('#ob-radius_m').focus();
  await page.keyboard.type('60');
  await page.selectOption('#ob-expires_h', '2');
  assert.ok(await overflow_px(page) <= 0);
  assert.deepEqual(await smallTargets(page), []);
  assert.deepEqual(await accessibilityFaults(page), []);
  await shoot(page, 'obstacle-phone');
  await page.locator('#ob-radius_m').focus();
  await page.keyboard.press('Enter');
  await page.locator('.obstacle-row', { hasText: 'People' }).waitFor(kWait);
  assert.equal(obstacles[0].geometry.type, 'Polygon');
  const inHours = (Date.parse(obstacles[0].properties.expires_at) - Date.now()) / 3600000;
  assert.ok(inHours > 1.9 && inHours <= 2, `expires in ${inHours} h`);
  // Escape leaves the drawing, then the view.
  await page.locator('[data-kind="mast"]').click();
  await page.keyboard.press('Escape');
  await page.locator('#obstacle-form').waitFor({ state: 'hidden', ...kWait });
  await page.keyboard.press('Escape');
  await page.locator('[data-view="sites"]').waitFor(kWait);
  assert.ok(await overflow_px(page) <= 0);
  assert.deepEqual(await smallTargets(page), []);
  assert.deepEqual(seen.errors, []);
});

test('obstacles: a failed request is stated, and obstacles that were loaded stay', async (t) => {
  const { page } = await open(t, { obstacles: sampleObstacles(site.place) });
  await page.locator('path.wire').waitFor({ state: 'attached', ...kWait });
  await page.route('**/v1/obstacles?**', (route) => route.fulfill({ status: 503, contentType: 'application/problem+json', body: '{"detail":"busy"}' }));
  await page.locator('#key', { hasText: 'Obstacles not loaded: busy' }).waitFor(kWait);
  assert.ok(await page.locator('path.wire').count() > 0);
});

test('obstacles: a blocked site names what blocks it', async (t) => {
  const { page, seen } = await open(t, { obstacles: sampleObstacles(site.place), rewrite(path, json) {
    if (path === `/v1/sites/${site.properties.id}`) json.properties.blocked_by = ['wire-1'];
    return json;
  } });
  await page.locator('path.wire').waitFor({ state: 'attached', ...kWait });
  await page.locator(`#sites button[data-site="${site.properties.id}"]`).click();
  const link = page.locator('#site-blocked button');
  await link.waitFor(kWait);
  assert.equal(await link.textContent(), 'Wire Valley line, 32 m');
  await link.click();
  await page.locator('.obstacle-row [aria-current]', { hasText: 'Valley line' }).waitFor(kWait);
  assert.deepEqual(seen.errors, []);
});

test('go-around: drawn with the point of no return on map and profile, and one line in the panel', async (t) => {
  const noReturn_m = site.properties.approach.no_return_distance_m ?? kNoReturn_m;
  const { page, seen } = await open(t, { rewrite: (path, json) => (path.endsWith('/approach') ? withGoAround(json, noReturn_m) : json) });
  await page.locator(`#sites button[data-site="${site.properties.id}"]`).click();
  await page.locator('#profile canvas').waitFor(kWait);
  const line = page.locator('path.go-around');
  await line.waitFor({ state: 'attached', ...kWait });
  assert.notEqual(await line.evaluate((path) => getComputedStyle(path).strokeDasharray), 'none');
  assert.equal(await page.locator('.climb-arrow').count(), 1);
  assert.equal(await page.locator('#map .no-return').count(), 1);
  assert.match(await page.locator('#profile .legend-line').textContent(), /point of no return/);
  assert.equal(await page.locator('#go-around').textContent(),
    `Go-around clears all seen ground until ${noReturn_m.toFixed(0)} m before touchdown. 12 % of the climb is over unseen ground.`);
  await page.locator('#go-around').scrollIntoViewIfNeeded();
  await shoot(page, 'go-around');
  assert.deepEqual(seen.errors, []);
});

test('new look: a list with reasons and ages, marks on the map, and the way to the site', async (t) => {
  for (const size of [{}, phone]) {
    const { page, seen } = await open(t, { newLook: sampleNewLook(sites.slice(0, 3)) }, size);
    await page.locator('#open-new-look').click();
    const rows = page.locator('#new-look button');
    await rows.first().waitFor(kWait);
    assert.equal(await rows.count(), 3);
    assert.match(await rows.first().textContent(), /may make it landable.*40 d/);
    assert.deepEqual(await page.locator('.disc-marker.new-look').allTextContents(), ['1', '2', '3']);
    assert.ok(await overflow_px(page) <= 0);
    assert.deepEqual(await smallTargets(page), []);
    assert.deepEqual(await accessibilityFaults(page), []);
    await shoot(page, size.width ? 'new-look-phone' : 'new-look');
    await rows.first().click();
    await page.locator('#view-site:not([hidden]) #profile canvas').waitFor(kWait);
    assert.equal(await page.locator('.disc-marker.new-look').count(), 0, 'marks belong to the list');
    assert.deepEqual(seen.errors, []);
  }
});

test('parts: what a server lacks is not asked for and leaves no trace', async (t) => {
  const { page, seen, server } = await open(t, { rewrite: withPose(poseOf(2)) });
  await page.locator(`#sites button[data-site="${site.properties.id}"]`).click();
  await page.locator('#profile canvas').waitFor(kWait);
  await page.locator('[data-back]:visible').click();
  await page.locator('.bar [data-emergency]').click();
  await page.locator('#em-message:not(:empty)').waitFor(kWait);
  await page.waitForTimeout(2500);
  assert.deepEqual([...asksFor(server, '/v1/reach'), ...asksFor(server, '/v1/obstacles'), ...asksFor(server, '/v1/sites?order')], []);
  assert.equal(await page.locator('#em-key').textContent() + await page.locator('#em-reach').textContent(), '');
  await page.locator('#em-close').click();
  for (const button of ['#open-new-look', '#open-obstacles']) assert.ok(await page.locator(button).isHidden());
  assert.equal(await page.locator('#key').textContent(), '');
  assert.deepEqual(seen.errors, []);
});
