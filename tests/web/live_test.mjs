// The page while photographs come in, and a flight whose sites are all rejected.
// FREELSD_URL: of the server; FREELSD_PHOTOGRAPHS: a sample flight's folder (freelsd-render);
// FREELSD_SCREENSHOTS: a folder for pictures of the page.

import assert from 'node:assert/strict';
import { mkdir, readFile, readdir } from 'node:fs/promises';
import { after, before, test } from 'node:test';

import { words } from '../../web/units.js';
import { accessibilityFaults, getJson, launch, openPage, url } from './browser.mjs';

const kWait = { timeout: 15000 };
const kMinute_ms = 60000;
const photographs = process.env.FREELSD_PHOTOGRAPHS;
const folder = process.env.FREELSD_SCREENSHOTS;
let browser;

before(async () => {
  if (folder) await mkdir(folder, { recursive: true });
  browser = await launch();
});
after(() => browser?.close());

const file = (name, mimeType, text) => ({ name, mimeType, buffer: Buffer.from(text) });

// The sample flight, moved one degree east, away from the sites of other flights. Its aircraft needs a
// ground roll of 500 m, longer than any of its fields.
async function rejectedFlight() {
  const rows = (await readFile(`${photographs}/poses.csv`, 'utf8')).trim().split('\n').map((line) => line.split(','));
  const column = rows[0].indexOf('longitude_deg');
  const moved = rows.map((row, i) => (i === 0 ? row : row.with(column, (Number(row[column]) + 1).toFixed(8))).join(','));
  const settings = JSON.parse(await readFile(`${photographs}/flight.json`, 'utf8'));
  settings.aircraft = { profile: 'small', ground_roll_m: 500 };
  const images = (await readdir(photographs)).filter((name) => name.endsWith('.jpg'));
  return [
    ...await Promise.all(images.map(async (name) => ({
      name, mimeType: 'image/jpeg', buffer: await readFile(`${photographs}/${name}`) }))),
    file('poses.csv', 'text/csv', moved.join('\n')),
    file('flight.json', 'application/json', JSON.stringify(settings)),
  ];
}

const flightIds = async () => (await getJson('/v1/flights')).flights.map((flight) => flight.id);

async function send(page) {
  const before = await flightIds();
  await page.locator('[data-tab="upload"]').click();
  await page.setInputFiles('#upload-files', await rejectedFlight());
  await page.fill('#upload-name', 'Live flight');
  await page.click('#upload-start');
  await page.locator('#flight option:checked', { hasText: 'Live flight' }).waitFor({ state: 'attached', ...kWait });
  return (await flightIds()).find((id) => !before.includes(id));
}

// During the upload the track grows, and the map keeps the aircraft in view.
async function watchComing(page, flight) {
  await page.locator('[data-tab="flight"]').click();
  const numPlaces = () => page.evaluate(() => {
    const line = document.querySelector('path.track')?.getAttribute('d') ?? '';
    return line.split(/[ML]/).length - 1;
  });
  await page.waitForFunction(() => {
    const shown = /Photographs (\d+) of/.exec(document.getElementById('flight-state').textContent);
    return shown && Number(shown[1]) >= 4 && document.querySelector('.aircraft');
  }, null, { timeout: 2 * kMinute_ms });
  const early = await numPlaces();
  await page.waitForFunction(() => {
    const shown = /Photographs (\d+) of/.exec(document.getElementById('flight-state').textContent);
    return shown && Number(shown[1]) >= 48;
  }, null, { timeout: 3 * kMinute_ms });
  const { state } = await getJson(`/v1/flights/${flight}`);
  assert.notEqual(state, 'idle', 'the flight is still in progress');
  if (folder) await page.screenshot({ path: `${folder}/live-flight.jpg`, type: 'jpeg', quality: 65 });
  assert.ok(await numPlaces() > early, `${early} places, then ${await numPlaces()}`);
  // In one evaluation: each refresh replaces the mark.
  const [map, mark] = await page.evaluate(() => ['#map', '.aircraft'].map((selector) =>
    document.querySelector(selector).getBoundingClientRect().toJSON()));
  assert.ok(mark.left > map.left && mark.top > map.top && mark.right < map.right && mark.bottom < map.bottom,
    'the map follows the aircraft');
  assert.deepEqual(await accessibilityFaults(page), []);
}

// The best rejected site shows the server's reason.
async function readWhyNot(page, flight) {
  await page.locator('[data-tab="sites"]').click();
  await page.locator('#sites button').first().waitFor({ timeout: 4 * kMinute_ms });
  await page.locator('#flight-state', { hasText: 'Up to date' }).waitFor({ timeout: 4 * kMinute_ms });
  const { features } = await getJson(`/v1/flights/${flight}/sites`);
  assert.ok(features.length > 0 && features.every(({ properties }) => properties.verdict === 'rejected'));
  const { properties } = features.find((feature) => feature.properties.rejections.length > 0) ?? features[0];
  await page.locator(`#sites button[data-site="${properties.id}"]`).click();
  const own = page.locator('#why-not .outcome.rejected');
  await own.waitFor(kWait);
  assert.equal(await own.textContent(), `✕ ${words(properties.reject_reason)}${properties.reject_detail}`);
  assert.match(await page.locator('#site-title').textContent(), /Rejected/);
  const details = await page.locator('#why-not .rejection small').allTextContents();
  assert.deepEqual(details, properties.rejections.map((rejection) => rejection.detail));
  assert.ok(details.length > 0, 'better touchdowns were tried');
  const { verdict } = properties.approach ? await getJson(`/v1/sites/${properties.id}/approach`) : {};
  assert.equal(await page.locator('path.approach:not(.refused-path)').count(), 0, 'no path that looks like one to fly');
  assert.equal(await page.locator('path.approach.refused-path').count(), verdict === 'rejected' ? 1 : 0);
  const index = Math.max(0, properties.rejections.findIndex((rejection) => rejection.obstacle));
  await page.locator('#why-not .rejection').nth(index).click();
  await page.locator('.disc-marker.refused').waitFor({ state: 'attached', ...kWait });
  const hasObstacle = Boolean(properties.rejections[index].obstacle);
  assert.equal(await page.locator('.disc-marker.obstacle').count(), hasObstacle ? 1 : 0);
  if (folder) await page.screenshot({ path: `${folder}/rejected.jpg`, type: 'jpeg', quality: 65 });
  assert.deepEqual(await accessibilityFaults(page), []);
}

test('live: the page follows a flight; each rejected site states its reason', { skip: !photographs }, async (t) => {
  const { page, seen } = await openPage(t, browser);
  const flight = await send(page);
  try {
    await watchComing(page, flight);
    await readWhyNot(page, flight);
    assert.deepEqual(seen.errors, []);
  } finally {
    await page.goto('about:blank');
    await fetch(`${url}/v1/flights/${flight}?forget_sites=true`, { method: 'DELETE' });
  }
});
