// The view "Where to fly next": what it asks, and what it shows of a sample answer in front of a running server that holds
// a finished flight, and of the server's own; see page_test.mjs.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { after, before, test } from 'node:test';

import { altitudeText, bandOf, flown_m, gainText, legText, momentOf, placesOf, transitText } from '../../web/next_look_shape.js';
import { courseTo, verdictSign } from '../../web/units.js';
import { accessibilityFaults, flownSite, getJson, isOptional, launch, openPage, smallTargets, url } from './browser.mjs';
import { sampleLegs } from './sample_parts.mjs';
import { kWait, shoot } from './site_page.mjs';
import { startStandIn } from './stand_in.mjs';

const phone = { width: 390, height: 844 };
const kLong = { timeout: 60000 };  // a real answer takes seconds
let browser;
let site;

before(async () => { [browser, site] = await Promise.all([launch(), flownSite()]); });
after(() => browser?.close());

// --- Shapes and texts ---

const stored = { id: 'f-1-r2', verdict: 'unverified' };
const sample = (numLegs = 2) => sampleLegs([8, 47], stored, numLegs);

test('next look: the band is as wide as a photograph, and half a photograph longer at both ends', () => {
  const look = sample();
  const leg = { geometry: { coordinates: [[8, 47], [8.0039477, 47]] }, properties: { heading_deg: 90 } };
  const [a, b, c, d] = bandOf(leg, look).map(([longitude_deg, latitude_deg]) => ({ longitude_deg, latitude_deg }));
  assert.ok(Math.abs(courseTo(a, b).distance_m - 400) < 1, 'the leg of 300 m and 100 m of photograph');
  assert.ok(Math.abs(courseTo(b, c).distance_m - 160) < 1);
  assert.ok(a.latitude_deg > 47 && d.latitude_deg < 47, 'left of an eastern heading is north');
  assert.ok(a.longitude_deg < 8 && b.longitude_deg > 8.0039477);
});

test('next look: texts of a leg', () => {
  const look = sample();
  assert.deepEqual([6.191, 1, 0.288, 0.004].map(gainText), ['+6.2', '+1.0', '+0.29', '+0.00']);
  assert.equal(legText(look.features[0], look), 'heading 000°, 300 m long, 560\u00a0m AMSL');
  assert.equal(altitudeText(100, 'unknown'), '100\u00a0m (datum unknown)');
  assert.deepEqual(look.features.map(transitText), ['400 m to its start from the last photograph', '300 m to its start from leg 1']);
  assert.equal(flown_m(look), 1300);
  const { sites, others } = placesOf(look.features[0]);
  assert.deepEqual([sites.map(({ site_id }) => site_id), others.length], [['f-1-r2'], 2]);
});

test('next look: the time of the map has its date unless it is today', () => {
  const noon = new Date(2026, 10, 27, 12, 0, 5);
  assert.equal(momentOf(noon.toISOString(), new Date(2026, 10, 27, 23)), '12:00:05');
  assert.equal(momentOf(noon.toISOString(), new Date(2026, 10, 28, 1)), '27 Nov 2026, 12:00:05');
});

// --- The view ---

const legsHere = (parameters) => sampleLegs(site.place, { id: site.properties.id, verdict: site.properties.verdict }, Number(parameters.get('legs')));

async function open(t, legs, options = {}, parts = {}) {
  const server = await startStandIn(t, url, { legs, ...parts });
  const opened = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}`, ...options });
  opened.page.on('console', (message) => {
    if (message.type() === 'error' && !isOptional(message.location().url)) opened.seen.errors.push(message.text());
  });
  await opened.page.locator('#sites button').first().waitFor(kWait);
  return { server, ...opened };
}

async function openView(page) {
  await page.locator('[data-tab=flight]').click();
  await page.locator('#open-next-look').click();
}

const overflow_px = (page) => page.evaluate(() => Math.max(document.documentElement.scrollWidth - innerWidth,
  document.getElementById('panel').scrollWidth - document.getElementById('panel').clientWidth));
const message = (page) => page.locator('#next-look-message').textContent();

for (const [name, options] of [['desktop', {}], ['desktop-dark', { colorScheme: 'dark' }], ['phone', phone], ['phone-dark', { ...phone, colorScheme: 'dark' }]]) {
  test(`next look: numbered legs with their ground, gain and sites, ${name}`, async (t) => {
    const { page, seen, server } = await open(t, legsHere, options);
    await openView(page);
    assert.match(await message(page), /^Choosing legs …/);
    await page.locator('.next-leg-row').nth(1).waitFor(kWait);
    assert.deepEqual(server.looks, [{ legs: '2' }]);
    assert.match(await page.locator('#next-look-outcome').innerText(), /Expected gain \+3\.5 with 2 legs\s+To fly: 1300 m, with turns\. Landing value now:\s0\.5\.\s+A gain is a forecast/);
    assert.match(await page.locator('[data-leg="1"]').innerText(), /Leg 1\s+Heading 000°, 300 m long, 560\sm AMSL\s+400 m to its start from the last photograph\s+\+2\.3\s+gain/);
    const places = await page.locator('[data-leg="1"] .next-site span').allInnerTexts();
    assert.deepEqual(places, [`${verdictSign[site.properties.verdict]} Site ${site.properties.rank}, ${site.properties.verdict}`,
      '2 more places without a site yet']);
    assert.match(await message(page), /^From the flight's map of /);
    assert.deepEqual(await page.locator('.next-leg-sign').allInnerTexts(), ['leg 1', 'leg 2']);
    assert.deepEqual([await page.locator('path.next-leg').count(), await page.locator('path.next-band').count(), await page.locator('path.next-place').count()], [2, 2, 5]);
    assert.match(await page.locator('#key').textContent(), /leg to fly next.*ground it photographs.*may become landable/);
    await shoot(page, `next-look-${name}`);
    assert.equal(await overflow_px(page), 0);
    assert.deepEqual(await smallTargets(page), []);
    assert.deepEqual(await accessibilityFaults(page), []);
    assert.deepEqual(seen.errors, []);
  });
}

test('next look: a leg is chosen in the list or on the map; a click on it is no click on the ground', async (t) => {
  const { page, seen } = await open(t, legsHere);
  await openView(page);
  await page.locator('.next-leg-name').nth(1).click();
  assert.equal(await page.locator('.next-leg-name').nth(1).getAttribute('aria-pressed'), 'true');
  assert.deepEqual([await page.locator('path.next-leg.chosen').count(), await page.locator('path.next-leg.aside').count()], [1, 1]);
  assert.ok(await page.locator('.next-leg-name').nth(1).evaluate((node) => node === document.activeElement), 'the focus stays');
  assert.equal(await page.locator('path.next-place').count(), 2, 'only its own places');
  await page.locator('.next-leg-sign').first().focus();
  await page.keyboard.press('Enter');
  assert.equal(await page.locator('.next-leg-name').first().getAttribute('aria-pressed'), 'true');
  await page.locator('.next-leg-name').first().click();
  assert.equal(await page.locator('path.next-leg.chosen').count(), 0);
  await page.waitForTimeout(400);
  const line = await page.locator('path.next-leg').nth(1).evaluate((path) => {
    const { x, y } = path.getPointAtLength(0.3 * path.getTotalLength()).matrixTransform(path.getScreenCTM());
    return { x, y };
  });
  await page.mouse.click(line.x + 6, line.y);
  assert.equal(await page.locator('.next-leg-name').nth(1).getAttribute('aria-pressed'), 'true');
  await page.waitForTimeout(400);
  assert.equal(await page.locator('.leaflet-popup').count(), 0);
  await page.locator('[data-leg="2"] .next-site').click();
  assert.equal(await page.locator('path.next-place-shown').count(), 1);
  assert.deepEqual(seen.errors, []);
});

test('next look: a site opens, back and Escape lead to the flight, another view hides the legs', async (t) => {
  const { page, seen } = await open(t, legsHere);
  await openView(page);
  await page.locator('[data-leg="1"] .next-site').first().click();
  await page.locator('#site-title').waitFor(kWait);
  await page.waitForFunction((id) => location.hash.includes(`site=${id}`), site.properties.id, kWait);
  assert.equal(await page.locator('path.next-leg').count(), 0);
  await page.locator('[data-tab=flight]').click();
  await page.locator('#open-next-look').press('Enter');
  assert.equal(await page.evaluate(() => document.activeElement.id), 'next-look-title');
  assert.equal(await page.locator('path.next-leg').count(), 2, 'the former answer stands until the new one');
  await page.keyboard.press('Escape');
  assert.ok(await page.locator('[data-view=flight]').isVisible());
  assert.equal(await page.evaluate(() => document.activeElement.id), 'open-next-look');
  assert.equal(await page.locator('path.next-leg').count(), 0);
  assert.ok(!(await page.locator('#key').textContent()).includes('leg to fly next'));
  assert.deepEqual(seen.errors, []);
});

test('next look: another number of legs is asked at once; the plan has as many', async (t) => {
  const { page, server, seen } = await open(t, legsHere);
  await openView(page);
  await page.locator('.next-leg-row').nth(1).waitFor(kWait);
  await page.locator('#next-look-legs').selectOption('4');
  await page.locator('#next-look-legs').selectOption('3');
  await page.locator('.next-leg-row').nth(2).waitFor(kWait);
  await page.evaluate(() => { navigator.clipboard.writeText = async (text) => { globalThis.copied = text; }; });
  await page.locator('#next-look-curl button').click();
  assert.equal(await (await page.waitForFunction(() => globalThis.copied)).jsonValue(),
    `curl -sS '${server.url}/v1/flights/${site.flight}/next-look?legs=3'`);
  await page.fill('#next-look-downloads input', '412.5');
  const [file] = await Promise.all([page.waitForEvent('download'), page.locator('#next-look-downloads [data-format=plan]').click()]);
  assert.equal(file.suggestedFilename(), `${site.flight}-next-look.plan`);
  assert.deepEqual(server.looks.map(({ legs }) => legs), ['2', '3', '3']);
  assert.deepEqual([server.looks.at(-1).f, server.looks.at(-1).home_altitude_m], ['plan', '412.5']);
  assert.deepEqual(seen.errors, []);
});

test('next look: a plan of altitudes that are not above mean sea level asks for the launch altitude', async (t) => {
  const { page, server, seen } = await open(t, (parameters) => ({ ...legsHere(parameters), altitude_datum: 'unknown' }));
  await openView(page);
  await page.locator('#next-look-downloads [data-format=plan]').click();
  assert.equal(await page.locator('#next-look-downloads [role=alert]').innerText(), 'Enter the launch altitude.');
  assert.ok(await page.locator('#next-look-downloads input').evaluate((node) => node === document.activeElement));
  assert.equal(server.looks.length, 1, 'the server was not asked');
  assert.deepEqual(seen.errors, []);
});

test('next look: the list follows the map of a flight that streams in, and keeps the chosen leg', async (t) => {
  const state = { updated_at: '2026-11-27T10:00:00Z', isLater: false };
  const rewrite = (path, json) => (/\/flights\/[^/]+\/map$/.test(path) ? { ...json, updated_at: state.updated_at } : json);
  const later = (parameters) => {
    const look = legsHere(parameters);
    if (state.isLater) look.features[1].properties.expected_gain = 0.5;
    return look;
  };
  const { page, server, seen } = await open(t, later, {}, { rewrite, hasEvents: true });
  await openView(page);
  await page.locator('.next-leg-name').nth(1).click();
  await page.waitForTimeout(1000);
  assert.equal(server.looks.length, 1, 'the same map is asked about once');
  Object.assign(state, { updated_at: '2026-11-27T10:01:00Z', isLater: true });
  server.emit('map', { flight_id: site.flight, updated_at: state.updated_at });
  await page.locator('[data-leg="2"] .next-gain', { hasText: '+0.50' }).waitFor(kWait);
  assert.equal(await page.locator('.next-leg-name').nth(1).getAttribute('aria-pressed'), 'true');
  assert.match(await message(page), /map of .*1:00/);
  assert.equal(server.looks.length, 2);
  // Nobody looks: nothing is asked.
  await page.locator('[data-tab=sites]').click();
  state.updated_at = '2026-11-27T10:02:00Z';
  server.emit('map', { flight_id: site.flight, updated_at: state.updated_at });
  await page.waitForTimeout(6000);
  assert.equal(server.looks.length, 2);
  assert.deepEqual(seen.errors, []);
});

test('next look: without a map nothing is asked; the view says why and what it waits for', async (t) => {
  const { page, server, seen } = await open(t, legsHere, {}, { map: null });
  await openView(page);
  assert.match(await message(page), /has no map yet\. Legs appear here after its first evaluation/);
  assert.ok(await page.locator('#next-look-answer').isHidden());
  await page.waitForTimeout(500);
  assert.equal(server.looks.length, 0);
  assert.deepEqual(seen.errors, []);
});

test('next look: no leg to suggest is an answer with its reason', async (t) => {
  const { page, seen } = await open(t, () => ({ ...sampleLegs(site.place, stored, 0), landing_value: 3 }));
  await openView(page);
  await page.getByText('No leg to suggest').waitFor(kWait);
  assert.match(await page.locator('#next-look-outcome').innerText(), /up to 100 m beyond its edge, is expected to make another place landable/);
  assert.ok(await page.locator('#next-look-more').isHidden());
  await shoot(page, 'next-look-none');
  assert.deepEqual(seen.errors, []);
});

test('next look: a refusal is told in the words of the server, and an older answer stays', async (t) => {
  const state = { refusal: { status: 503, code: 'Busy', detail: 'all map writers are at work' } };
  const { page } = await open(t, (parameters) => {
    if (state.refusal) throw state.refusal;
    return legsHere(parameters);
  });
  await openView(page);
  await page.getByText('No answer: all map writers are at work. The page tries again by itself.').waitFor(kWait);
  await shoot(page, 'next-look-refused');
  state.refusal = null;
  await page.locator('#next-look-legs').selectOption('1');
  await page.locator('.next-leg-row').first().waitFor(kWait);
  assert.match(await message(page), /^From the flight's map/);
  state.refusal = { status: 409, code: 'NoMapYet', detail: 'the flight has no map yet' };
  await page.locator('#next-look-legs').selectOption('2');
  await page.getByText('Not updated: the flight has no map yet.').waitFor(kWait);
  assert.equal(await page.locator('.next-leg-row').count(), 1);
});

test('next look: a server without this call leaves no trace of it', async (t) => {
  const { page } = await open(t, null);
  await page.locator('[data-tab=flight]').click();
  await page.waitForTimeout(500);
  assert.ok(await page.locator('#open-next-look').isHidden());
});

// --- The real server ---

test('next look: the server chooses legs, and the plan surveys the same ones', async (t) => {
  const { page, seen } = await openPage(t, browser, { address: `${url}/#flight=${site.flight}` });
  await page.locator('#sites button').first().waitFor(kWait);
  await openView(page);
  const { features } = await getJson(`/v1/flights/${site.flight}/next-look?legs=2`);
  await page.locator('#next-look-outcome strong').waitFor(kLong);
  assert.equal(await page.locator('.next-leg-row').count(), features.length);
  assert.equal(await page.locator('path.next-leg').count(), features.length);
  await page.waitForTimeout(1000);
  await shoot(page, 'next-look');
  await page.fill('#next-look-downloads input', '400');
  const [file] = await Promise.all([page.waitForEvent('download', kLong), page.locator('#next-look-downloads [data-format=plan]').click()]);
  const plan = JSON.parse(await readFile(await file.path(), 'utf8'));
  assert.deepEqual([plan.fileType, plan.mission.items.length], ['Plan', features.length]);
  assert.deepEqual(seen.errors, []);
});
