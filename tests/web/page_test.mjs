// Drives the page of a running server that holds a finished flight.
// FREELSD_URL: of the server; FREELSD_SCREENSHOTS: a folder for pictures of the page.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { lastCourse } from '../../web/track.js';
import { heading } from '../../web/units.js';
import { accessibilityFaults, flownSite, getJson, launch, openPage, outside, smallTargets, url } from './browser.mjs';
import { clickPlace, kWait, pictureIsDrawn, shoot } from './site_page.mjs';

let browser;
let site;

before(async () => {
  [browser, site] = await Promise.all([launch(), flownSite()]);
});
after(() => browser?.close());

const address = () => `${url}/#flight=${site.flight}`;
const siteAddress = () => `${address()}&site=${encodeURIComponent(site.properties.id)}`;

async function openSite(t, options) {
  const opened = await openPage(t, browser, { address: siteAddress(), ...options });
  await opened.page.locator('#profile canvas').waitFor(kWait);
  await pictureIsDrawn(opened.page, 'hazard');
  return opened;
}

test('page: paints within a second, shows the best site and asks nobody but its server', async (t) => {
  const { page, seen } = await openPage(t, browser, { address: address() });
  const firstPaint_ms = () => page.evaluate(() => performance.getEntriesByName('first-contentful-paint')[0]?.startTime);
  await page.locator('#sites button').first().waitFor(kWait);
  const paints_ms = [await firstPaint_ms()];
  await page.reload({ waitUntil: 'load' });
  await page.locator('#sites button').first().waitFor(kWait);
  await pictureIsDrawn(page, 'hazard');
  paints_ms.push(await firstPaint_ms());
  assert.ok(Math.min(...paints_ms) <= 1000, `first paint after ${paints_ms} ms`);
  assert.ok(await page.locator('path.region').count() > 0, 'regions are drawn');
  assert.ok(await page.locator('.disc-marker').count() > 0, 'sites are drawn');
  await shoot(page, 'flight');
  assert.deepEqual(outside(seen, url), [], 'no request left the machine');
  assert.deepEqual(seen.errors, []);
});

test('page: a chosen site shows layers, approach, circle, profile and its risk', async (t) => {
  const { page, seen } = await openPage(t, browser, { address: address() });
  const button = page.locator(`#sites button[data-site="${site.properties.id}"]`);
  await button.waitFor(kWait);
  await button.focus();
  await page.keyboard.press('Enter');
  await page.locator('#profile canvas').waitFor(kWait);
  for (const kind of ['approach', 'loiter', 'touchdown']) await page.locator(`path.${kind}`).waitFor({ state: 'attached' });
  assert.match(await page.locator('#site-title').textContent(), new RegExp(site.properties.verdict, 'i'));
  const risk = `${(100 * site.properties.failure_probability).toFixed(1)} %`;
  assert.ok((await page.locator('#site-more').textContent()).includes(risk), `the risk, ${risk}, is told`);
  assert.match(await page.locator('.limit').textContent(), /before touchdown|was seen/);
  const layers = await page.locator('#layer option').evaluateAll((all) => all.map((o) => o.value).filter(Boolean));
  for (const name of ['elevation', 'slope', 'roughness', 'grass', 'hazard', 'distance']) {
    assert.ok(layers.includes(name), name);
    await page.selectOption('#layer', name);
    await pictureIsDrawn(page, name);
    await page.locator(name === 'hazard' ? '#legend .swatch' : '#legend img').first().waitFor(kWait);
  }
  await page.selectOption('#layer', 'hazard');
  await pictureIsDrawn(page, 'hazard');
  await shoot(page, 'site');
  assert.deepEqual(await smallTargets(page), []);
  assert.deepEqual(await accessibilityFaults(page), []);
  assert.deepEqual(seen.errors, []);
});

for (const colorScheme of ['light', 'dark']) {
  test(`page: the track lies under regions and sites, with the aircraft at its end, ${colorScheme}`, async (t) => {
    const { page, seen } = await openPage(t, browser, { colorScheme, address: address() });
    await pictureIsDrawn(page, 'hazard');
    const { features: [track] } = await getJson(`/v1/flights/${site.flight}/track`);
    const positions = track.geometry.coordinates;
    assert.ok(positions.length > 1 && positions.length === track.properties.num_positions);
    await page.locator('path.track').waitFor({ state: 'attached', ...kWait });
    const course = `Last photograph, course ${heading(lastCourse(positions))}`;
    assert.equal(await page.locator('.aircraft svg').getAttribute('aria-label'), course);
    const drawn = await page.evaluate(() => {
      const level = (node) => Number(getComputedStyle(node.closest('.leaflet-pane[class*="-pane"]')).zIndex);
      const box = document.querySelector('path.track').getBoundingClientRect();
      const mark = document.querySelector('.aircraft').getBoundingClientRect();
      return {
        levels: ['path.track', 'path.region', '.disc-marker'].map((name) => level(document.querySelector(name))),
        isMarkAtLine: mark.right > box.left && mark.left < box.right && mark.bottom > box.top && mark.top < box.bottom,
        stroke: getComputedStyle(document.querySelector('path.track')).stroke,
        casing: getComputedStyle(document.querySelector('path.track-casing')).stroke,
        isBelowDiscs: [...document.querySelectorAll('.disc-marker')].every((disc) =>
          Number(disc.style.zIndex) > Number(document.querySelector('.aircraft').style.zIndex)),
      };
    });
    assert.deepEqual(drawn.levels, drawn.levels.toSorted((a, b) => a - b));
    assert.ok(drawn.isMarkAtLine && drawn.isBelowDiscs);
    // Black and white: legible with any colour vision.
    assert.deepEqual([drawn.stroke, drawn.casing],
      colorScheme === 'light' ? ['rgb(11, 22, 32)', 'rgb(255, 255, 255)'] : ['rgb(242, 246, 250)', 'rgb(13, 20, 27)']);
    assert.deepEqual(seen.errors, []);
  });
}

test('page: the opacity of a layer is set with the slider, and kept for the next layer', async (t) => {
  const { page } = await openSite(t);
  const opacity = () => page.evaluate(() => Number(getComputedStyle(document.querySelector('img.site-layer, .data-tiles')).opacity));
  assert.equal(await opacity(), await page.locator('.photo-tiles').count() ? 0.5 : 1);
  await page.locator('#opacity').fill('0.4');
  assert.equal(await opacity(), 0.4);
  await page.locator('#opacity').press('ArrowLeft');
  assert.ok(Math.abs(await opacity() - 0.35) < 1e-6);
  await page.selectOption('#layer', 'slope');
  await pictureIsDrawn(page, 'slope');
  assert.ok(Math.abs(await opacity() - 0.35) < 1e-6);
});

test('page: by keyboard to a site, into it, back to its row; Escape closes what is open', async (t) => {
  const { page, seen } = await openPage(t, browser, { address: address() });
  await page.locator('#sites button').first().waitFor(kWait);
  const focused = () => page.evaluate(() => document.activeElement.dataset?.site ?? (document.activeElement.id || document.activeElement.className));
  await page.keyboard.press('Tab');
  assert.equal(await focused(), 'skip', 'the first stop skips the map');
  await page.keyboard.press('Enter');
  const rows = await page.locator('#sites button').evaluateAll((all) => all.map((button) => button.dataset.site));
  for (let i = 0; i < 5 && !rows.includes(await focused()); ++i) await page.keyboard.press('Tab');
  assert.equal(await focused(), rows[0], 'the first site is near');
  await page.keyboard.press('Enter');
  await page.locator('#view-site').waitFor(kWait);
  await page.locator('#site-title:focus').waitFor(kWait);
  await page.keyboard.press('Escape');
  await page.locator('#view-site').waitFor({ state: 'hidden', ...kWait });
  assert.equal(await focused(), rows[0], 'back where one was');
  // A marker on the map opens the site too.
  await page.locator('.disc-marker.chosen').focus();
  await page.keyboard.press('Enter');
  await page.locator('#site-title:focus').waitFor(kWait);
  await page.locator('.bar [data-emergency]').focus();
  await page.keyboard.press('Enter');
  await page.locator('#emergency').waitFor(kWait);
  await page.keyboard.press('Escape');
  await page.locator('#emergency').waitFor({ state: 'hidden', ...kWait });
  assert.ok(await page.locator('#view-site').isVisible(), 'only the dialog closed');
  await clickPlace(page, site.place, [40, 0]);
  await page.locator('.answer').waitFor(kWait);
  await page.keyboard.press('Escape');
  await page.locator('.answer').waitFor({ state: 'detached', ...kWait });
  assert.ok(await page.locator('#view-site').isVisible(), 'only the answer closed');
  assert.deepEqual(seen.errors, []);
});

test('page: the legend has the colours of the picture', async (t) => {
  const { page } = await openSite(t);
  const missing = await page.evaluate(async () => {
    const found = new Set();
    for (const image of document.querySelectorAll('img.site-layer, .data-tiles img[src]')) {
      const canvas = new OffscreenCanvas(image.naturalWidth, image.naturalHeight);
      const context = canvas.getContext('2d');
      context.drawImage(image, 0, 0);
      const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
      for (let i = 0; i < data.length; i += 4) if (data[i + 3] > 0) found.add(`rgb(${data[i]}, ${data[i + 1]}, ${data[i + 2]})`);
    }
    const legend = [...document.querySelectorAll('#legend i:not(.hatch):not(.ramp)')].map((i) => getComputedStyle(i).backgroundColor);
    return [...found].filter((color) => !legend.includes(color));
  });
  assert.deepEqual(missing, [], 'every colour of the picture is in the legend');
});

test('page: a site comes in the formats of other programs, a refusal is shown', async (t) => {
  const { page } = await openSite(t);
  for (const format of ['html', 'kml', 'geojson', 'csv']) {
    const [download] = await Promise.all([page.waitForEvent('download', kWait),
      page.locator(`#site-downloads [data-format="${format}"]`).click()]);
    assert.match(download.suggestedFilename(), new RegExp(`\\.(${format}|json)$`));
  }
  const [report] = await Promise.all([page.waitForEvent('download', kWait),
    page.locator('#flight-downloads [data-format="html"]').evaluate((button) => button.click())]);
  assert.match(report.suggestedFilename(), /\.html$/, 'the flight has a report too');
  await page.locator('#site-downloads [data-format="rally"]').click();
  await page.locator('#site-downloads .bad:not([hidden])').waitFor(kWait);
  assert.match(await page.locator('#site-downloads .bad').textContent(), /home_altitude_m|altitude/i);
});

test('page: a panel gives the command of what it shows', async (t) => {
  const { page } = await openSite(t);
  await page.evaluate(() => { navigator.clipboard.writeText = async (text) => { globalThis.copied = text; }; });
  const panels = {
    '#site-curl': '/sites/', '#approach-curl': '/approach', '#wind-rose-curl': '/wind-rose', '#layer-curl': 'hazard', '#sites-curl': '/sites',
    '#flight-curl': '/v1/flights/', '#jobs-curl': '/v1/jobs', '#stages-curl': 'jq .stages', '#site-downloads': 'f=plan',
  };
  for (const [panel, part] of Object.entries(panels)) {
    // Some buttons are in a hidden view.
    await page.locator(`${panel} .curl`).evaluate((button) => button.click());
    const copied = await page.waitForFunction(() => globalThis.copied);
    assert.ok((await copied.jsonValue()).includes(part), `${panel}: ${await copied.jsonValue()}`);
    await page.evaluate(() => { globalThis.copied = null; });
  }
  const bare = await page.locator('#site-more > details:not(:has(.curl)) h3').allTextContents();
  assert.deepEqual(bare, [], 'every panel of a site has a command');
});

test('page: the wind of the site stands on the map, a tried one is marked', async (t) => {
  const { page } = await openSite(t);
  assert.equal(await page.locator('.map-barb .barb').count(), 1);
  assert.equal(await page.locator('.map-barb.tried').count(), 0);
  await page.locator('#wind-from').press('ArrowRight');
  await page.locator('.map-barb.tried .barb').waitFor(kWait);
});

test('page: the API reference comes from the server alone, call by call', async (t) => {
  const { page, seen } = await openPage(t, browser, { address: `${url}/docs`, width: 360, height: 740 });
  await page.locator('.call').first().waitFor(kWait);
  const { paths, components } = await (await fetch(`${url}/openapi.json`)).json();
  const numCalls = Object.values(paths).flatMap(Object.keys).filter((key) => key !== 'parameters').length;
  assert.equal(await page.locator('.call').count(), numCalls);
  assert.equal(await page.locator('#schemas details').count(), Object.keys(components.schemas).length);
  await page.fill('#find', '/v1/emergency');
  const post = page.locator('.call:visible', { has: page.getByText('POST', { exact: true }) }).filter({ has: page.getByText('/v1/emergency', { exact: true }) });
  assert.equal(await post.count(), 1);
  await post.locator('summary').click();
  await post.getByRole('link', { name: 'EmergencyRequest' }).first().waitFor(kWait);
  assert.equal(await page.locator('.call:visible', { hasText: '/v1/jobs' }).count(), 0);
  const overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(overflow <= 0, `${overflow} px too wide`);
  assert.deepEqual(await accessibilityFaults(page), []);
  assert.deepEqual(await smallTargets(page), []);
  assert.deepEqual(outside(seen, url), [], 'no request left the machine');
  assert.deepEqual(seen.errors, []);
});

test('page: a rejected site says why not, and shows what stands in the way', async (t) => {
  const { page, seen } = await openPage(t, browser, { address: 'about:blank' });
  const touchdown = { latitude_deg: site.place[1], longitude_deg: site.place[0], altitude_m: 0 };
  const asRejected = (properties) => Object.assign(properties, {
    verdict: 'rejected', reject_reason: 'approach_blocked', reject_detail: 'a tree 14 m high', approach: null,
    rejections: [{ touchdown, reason: 'approach_blocked', detail: 'a tree 40 m before touchdown', obstacle: touchdown }],
  });
  await page.route('**/v1/**', async (route) => {
    const path = new URL(route.request().url()).pathname;
    if (path.endsWith('/approach')) return route.fulfill({ status: 409, contentType: 'application/problem+json', body: '{"detail":"the site has no approach"}' });
    const isList = path.endsWith(`${site.flight}/sites`);
    if (!isList && !path.endsWith(`/sites/${encodeURIComponent(site.properties.id)}`)) return route.continue();
    const response = await route.fetch();
    const json = await response.json();
    (isList ? json.features : [json]).forEach((feature) => asRejected(feature.properties));
    return route.fulfill({ response, json });
  });
  await page.goto(siteAddress());
  await page.locator('#why-not .rejection').first().waitFor(kWait);
  assert.match(await page.locator('#why-not').textContent(), /approach blocked.*a tree 14 m high/);
  assert.equal(await page.locator('path.approach').count(), 0);
  await page.locator('#why-not .rejection').first().click();
  await page.locator('.disc-marker.obstacle').waitFor({ state: 'attached' });
  assert.deepEqual(seen.errors, []);
});

const kSizes = [['phone', 360, 740, 'light'], ['phone', 360, 740, 'dark'], ['tablet', 820, 1180, 'light']];
for (const [device, width, height, colorScheme] of kSizes) {
  test(`page: a ${device} ${width} px wide, ${colorScheme}: no sideways scrolling, nothing too small to touch`, async (t) => {
    const { page, seen } = await openSite(t, { width, height, colorScheme });
    await page.locator('#site-tiles .tile').first().waitFor(kWait);
    await shoot(page, `${device}-${colorScheme}`);
    for (const tab of ['site', 'flight', 'upload', 'sites']) {
      if (tab !== 'site') await page.locator(`[data-tab="${tab}"]`).click();
      const overflow = await page.evaluate(() => Math.max(
        document.documentElement.scrollWidth - innerWidth,
        document.getElementById('panel').scrollWidth - document.getElementById('panel').clientWidth));
      assert.ok(overflow <= 0, `${tab} is ${overflow} px too wide`);
      assert.deepEqual(await smallTargets(page), [], tab);
      assert.deepEqual(await accessibilityFaults(page), [], tab);
    }
    assert.deepEqual(seen.errors, []);
  });
}

test('page: in the dark it is dark, and the theme can be changed', async (t) => {
  const { page } = await openSite(t, { colorScheme: 'dark' });
  const paper = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  assert.equal(await paper(), 'rgb(13, 20, 27)');
  await shoot(page, 'dark');
  await page.locator('#theme').click();
  assert.equal(await paper(), 'rgb(255, 255, 255)');
});
