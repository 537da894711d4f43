// Something new on a stored strip: the notice of an event, what remains after a reload, and when it goes: against sample events
// and obstacles in front of a running server that holds a finished flight; see page_test.mjs.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { alternateText, isOver, noticeText, shortText, sizeText, stripOf, stripOfAnswer, stripText } from '../../web/watch_shape.js';
import { accessibilityFaults, flownSite, getJson, isOptional, launch, openPage, smallTargets, url } from './browser.mjs';
import { overflow_px } from './ground_page.mjs';
import { obstacleIdOf, sampleStripEvent, sampleStripObstacle, soon } from './sample_watch.mjs';
import { kWait, shoot } from './site_page.mjs';
import { startStandIn } from './stand_in.mjs';

const phone = { width: 390, height: 844 };
let browser;
let site;
let other;  // another site of the same flight

before(async () => {
  [browser, site] = await Promise.all([launch(), flownSite()]);
  const { features } = await getJson(`/v1/flights/${site.flight}/sites`);
  other = features.map(({ properties }) => properties).find(({ id }) => id !== site.properties.id);
});
after(() => browser?.close());

// --- Texts ---

test('watch: texts of an event and of the stored obstacle', () => {
  const noon = new Date(2026, 10, 27, 12, 3).toISOString();
  const event = { ...sampleStripEvent({ flight: 'f', properties: { id: 'f-r2' }, place: [8, 47] }), seen_at: noon };
  const nameOf = (id) => `site ${id.slice(3)}`;
  assert.equal(noticeText(event, nameOf), 'Something new stands on site 2: about 4 m × 2 m, seen 12:03 by 2 photographs.');
  assert.equal(noticeText({ ...event, things: [], frames: ['a'] }, nameOf), 'Something new stands on site 2, seen 12:03 by 1 photograph.');
  assert.equal(sizeText([{ length_m: 0.8, width_m: 0.4 }, { length_m: 3, width_m: 2 }]), ': 2 things, the largest about 3 m × 2 m');
  assert.equal(alternateText({ alternate: 'f-r3' }, nameOf), 'Best other site in reach: site 3.');
  assert.equal(alternateText({ alternate: null }, nameOf), 'No other site is known to be in reach.');
  const strip = stripOf(sampleStripObstacle({ properties: { id: 'f-r2' }, place: [8, 47] }, { seen_at: noon, expires_at: new Date(2026, 10, 27, 12, 13).toISOString() }));
  assert.deepEqual([strip.siteId, strip.obstacleId, strip.place.latitude_deg.toFixed(4)], ['f-r2', 'strip-f-r2', '47.0000']);
  assert.equal(shortText(strip), 'Something new on the strip, seen 12:03');
  assert.match(stripText(strip), /seen 12:03\. Until 12:13, or until new photographs show it free, this site ranks last/);
  assert.deepEqual([stripOfAnswer({ site_id: 'f-r2', airspaces: ['strip-f-r2'] }), stripOfAnswer({ site_id: 'f-r2' })], [{}, undefined]);
  assert.equal(stripOf({ id: 'zone-1', properties: { kind: 'no_fly' } }), null);
  assert.ok(isOver({ expires_at: noon }, Date.parse(noon)) && !isOver({ expires_at: noon }, Date.parse(noon) - 1));
});

// --- The notice ---

async function open(t, options = {}, { obstacles = [], ...parts } = {}) {
  const server = await startStandIn(t, url, { hasEvents: true, obstacles, reach: null, newLook: null, ...parts });
  const opened = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}`, ...options });
  opened.page.on('console', (message) => {
    if (message.type() === 'error' && !isOptional(message.location().url)) opened.seen.errors.push(message.text());
  });
  await opened.page.locator('#sites button').first().waitFor(kWait);
  await opened.page.waitForFunction(() => document.getElementById('transport').textContent === 'live', null, kWait);
  return { server, obstacles, ...opened };
}

const notice = (page) => page.locator('.strip-notice');
const row = (page, id) => page.locator(`#sites [data-site="${id}"]`);

// As the server does: the obstacle first, then the event.
async function occupy({ page, server, obstacles }, more = {}) {
  obstacles.push(sampleStripObstacle(site, more));
  server.emit('strip', sampleStripEvent(site, { alternate: other?.id ?? null, ...more }));
  await notice(page).waitFor(kWait);
}

for (const [name, options] of [['desktop', {}], ['desktop-dark', { colorScheme: 'dark' }], ['phone', phone], ['phone-dark', { ...phone, colorScheme: 'dark' }]]) {
  test(`watch: a notice, marks at the things and at the site, and lines where the site is shown, ${name}`, async (t) => {
    const opened = await open(t, options);
    const { page, seen } = opened;
    assert.equal(await page.locator('#strip-notices').getAttribute('role'), 'alert');
    await occupy(opened);
    assert.match(await notice(page).innerText(), /Something new stands on site 1: about 4 m × 2 m, seen \d\d:\d\d by 2 photographs\. (Best other site in reach: site 2|No other site)/);
    await row(page, site.properties.id).locator('.new-on-strip').waitFor(kWait);
    assert.match(await row(page, site.properties.id).innerText(), /! Something new on the strip, seen \d\d:\d\d/);
    assert.equal(await page.locator('.new-on-strip').count(), 1);
    await page.locator('.obstacle-sign').waitFor(kWait);
    assert.deepEqual([await page.locator('#map .new-thing').count(), await page.locator('#map .new-thing.beside').count()], [2, 1]);
    await page.getByRole('button', { name: 'Show on map' }).click();
    await page.waitForTimeout(600);
    await shoot(page, `watch-${name}`);
    assert.ok(await overflow_px(page) <= 0);
    assert.deepEqual(await smallTargets(page), []);
    assert.deepEqual(await accessibilityFaults(page), []);
    await row(page, site.properties.id).click();
    await page.locator('#site-strip strong').waitFor(kWait);
    assert.match(await page.locator('#site-strip').innerText(), /Something new stands on this strip, seen \d\d:\d\d\. Until \d\d:\d\d/);
    await page.waitForTimeout(800);
    await shoot(page, `watch-site-${name}`);
    await page.locator('[data-tab=upload]').click();
    assert.ok(await notice(page).isVisible(), 'in every view');
    assert.deepEqual(seen.errors, []);
  });
}

test('watch: the other site opens, the curl line follows the events, and the emergency view tells it', async (t) => {
  const emergency = { sites: [{ site_id: site.properties.id, flight_id: site.flight, verdict: 'landable', bearing_deg: 40, distance_m: 300, arrival_margin_m: 30,
    touchdown: { longitude_deg: site.place[0], latitude_deg: site.place[1], altitude_m: 450 }, reach: 'reachable' }], nearest_miss: null, warnings: [] };
  const opened = await open(t, {}, { emergency });
  const { page, server, seen } = opened;
  await occupy(opened, { alternate: other?.id ?? site.properties.id });
  await page.evaluate(() => { navigator.clipboard.writeText = async (text) => { globalThis.copied = text; }; });
  await notice(page).locator('button.curl').click();
  assert.equal(await (await page.waitForFunction(() => globalThis.copied)).jsonValue(), `curl -sS -N '${server.url}/v1/events?flight=${site.flight}'`);
  await notice(page).getByRole('button', { name: /^Open site/ }).press('Enter');
  await page.waitForFunction((id) => location.hash.includes(`site=${id}`), other?.id ?? site.properties.id, kWait);
  await page.locator('.bar [data-emergency]').click();
  await page.locator('#em-strips p', { hasText: 'Something new stands on site 1' }).waitFor(kWait);
  await page.fill('#em-altitude_m', '600');
  await page.locator('.em-card .new-on-strip').waitFor(kWait);
  await shoot(page, 'watch-emergency');
  assert.deepEqual(await accessibilityFaults(page), []);
  assert.deepEqual(seen.errors, []);
});

test('watch: the notice and all marks go when the strip is free', async (t) => {
  const opened = await open(t);
  const { page, server, obstacles, seen } = opened;
  await occupy(opened);
  await page.locator('.obstacle-sign').waitFor(kWait);
  await page.evaluate(() => { globalThis.first = document.querySelector('.strip-notice'); });
  await page.waitForTimeout(6000);
  assert.ok(await page.evaluate(() => globalThis.first.isConnected), 'not announced again while nothing changes');
  obstacles.length = 0;
  server.emit('strip', { flight_id: site.flight, site_id: site.properties.id, obstacle_id: obstacleIdOf(site.properties.id), seen_at: soon(0), state: 'free' });
  await notice(page).waitFor({ state: 'detached', ...kWait });
  await page.locator('#notice', { hasText: 'Nothing new stands on site 1 any more.' }).waitFor(kWait);
  await page.locator('.obstacle-sign').waitFor({ state: 'detached', ...kWait });
  assert.deepEqual([await page.locator('.new-thing').count(), await page.locator('.new-on-strip').count()], [0, 0]);
  assert.deepEqual(seen.errors, []);
});

test('watch: an expired notice goes, unless the server has extended the obstacle', async (t) => {
  const opened = await open(t);
  const { page, obstacles, server } = opened;
  await occupy(opened, { expires_at: soon(3) });
  obstacles[0].properties.expires_at = soon(9);
  await page.waitForTimeout(4500);
  assert.ok(await notice(page).isVisible(), 'seen again meanwhile');
  await notice(page).waitFor({ state: 'detached', ...kWait });
  assert.ok(server.asked.some((path) => path === `/v1/obstacles/${obstacleIdOf(site.properties.id)}`));
  assert.equal(await page.locator('.new-thing').count(), 0);
});

test('watch: after a reload the stored obstacle marks the site, without a notice', async (t) => {
  const { page, seen } = await open(t, {}, { obstacles: [sampleStripObstacle(site)] });
  await page.locator('#map .new-thing.beside').waitFor(kWait);
  assert.match(await row(page, site.properties.id).innerText(), /! Something new on the strip, seen \d\d:\d\d/);
  assert.equal(await notice(page).count(), 0);
  await row(page, site.properties.id).click();
  await page.locator('#site-strip', { hasText: 'Something new stands on this strip' }).waitFor(kWait);
  await page.locator('[data-back]:visible').click();
  await page.locator('#open-obstacles').click();
  assert.match(await page.locator('#obstacles').innerText(), /something new stands on this strip, seen \d\d:\d\d\n/, 'a time of day');
  await shoot(page, 'watch-reload');
  assert.deepEqual(seen.errors, []);
});

test('watch: the event of another flight gives no notice here', async (t) => {
  const { page, server } = await open(t);
  server.emit('strip', sampleStripEvent(site, { flight_id: 'f-another' }));
  await page.locator('#map .new-thing.beside').waitFor(kWait);
  assert.equal(await notice(page).count(), 0);
});
