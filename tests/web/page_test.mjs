// Drives the page of a running server that holds a finished flight.
// FREELSD_URL: of the server; FREELSD_SCREENSHOTS: a folder for pictures of the page.

import assert from 'node:assert/strict';
import { mkdir } from 'node:fs/promises';
import { after, before, test } from 'node:test';

import { lastCourse } from '../../web/track.js';
import { heading } from '../../web/units.js';
import { accessibilityFaults, flownSite, getJson, launch, openPage, outside, smallTargets, url } from './browser.mjs';

const kWait = { timeout: 15000 };
const folder = process.env.FREELSD_SCREENSHOTS;
let browser;
let site;

before(async () => {
  if (folder) await mkdir(folder, { recursive: true });
  [browser, site] = await Promise.all([launch(), flownSite()]);
});
after(() => browser?.close());

const shoot = async (page, name) => {
  if (folder) await page.screenshot({ path: `${folder}/${name}.jpg`, type: 'jpeg', quality: 65 });
};
const address = () => `${url}/#flight=${site.flight}`;
const siteAddress = () => `${address()}&site=${encodeURIComponent(site.properties.id)}`;
const pictureIsDrawn = (page, layer) => page.waitForFunction((name) => {
  const image = document.querySelector('img.site-layer');
  return image && image.dataset.layer === name && image.complete && image.naturalWidth > 10;
}, layer, kWait);

async function openSite(t, options) {
  const opened = await openPage(t, browser, { address: siteAddress(), ...options });
  await opened.page.locator('#profile canvas').waitFor(kWait);
  await pictureIsDrawn(opened.page, 'hazard');
  return opened;
}

// Clicks the map at an offset, in pixels, from the selected site.
async function clickPlace(page, [lon, lat], [right, down]) {
  const marker = page.locator(`.disc-marker.chosen`);
  const box = await marker.boundingBox();
  assert.ok(box, `the marker at ${lat}, ${lon} is drawn`);
  await page.mouse.click(box.x + box.width / 2 + right, box.y + box.height / 2 + down);
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

test('page: a chosen site shows layers, approach, circle, profile and every term of its score', async (t) => {
  const { page, seen } = await openPage(t, browser, { address: address() });
  const button = page.locator(`#sites button[data-site="${site.properties.id}"]`);
  await button.waitFor(kWait);
  await button.focus();
  await page.keyboard.press('Enter');
  await page.locator('#profile canvas').waitFor(kWait);
  for (const kind of ['approach', 'loiter', 'touchdown']) await page.locator(`path.${kind}`).waitFor({ state: 'attached' });
  assert.match(await page.locator('#site-title').textContent(), new RegExp(site.properties.verdict, 'i'));
  const gains = await page.locator('.score-table tbody td:last-child').allTextContents();
  const sum = gains.reduce((total, gain) => total + Number(gain), 0);
  assert.ok(Math.abs(sum - site.properties.score) < 0.04, `the terms make ${sum}, the score is ${site.properties.score}`);
  assert.match(await page.locator('.limit').textContent(), /before touchdown|was seen/);
  const layers = await page.locator('#layer option').evaluateAll((all) => all.map((o) => o.value).filter(Boolean));
  assert.deepEqual(layers, ['elevation', 'slope', 'roughness', 'grass', 'hazard', 'distance']);
  for (const name of layers) {
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
  const opacity = () => page.evaluate(() => Number(getComputedStyle(document.querySelector('img.site-layer')).opacity));
  assert.equal(await opacity(), 1);
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
    const image = document.querySelector('img.site-layer');
    const canvas = new OffscreenCanvas(image.naturalWidth, image.naturalHeight);
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
    const found = new Set();
    for (let i = 0; i < data.length; i += 4) found.add(`rgb(${data[i]}, ${data[i + 1]}, ${data[i + 2]})`);
    const legend = [...document.querySelectorAll('#legend i:not(.hatch):not(.ramp)')].map((i) => getComputedStyle(i).backgroundColor);
    return [...found].filter((color) => !legend.includes(color));
  });
  assert.deepEqual(missing, [], 'every colour of the picture is in the legend');
});

test('page: another wind plans anew; where there is no approach none is left on the map', async (t) => {
  const { page, seen } = await openSite(t);
  const answer = page.waitForResponse((r) => r.url().includes('/approach?wind_east_mps='), kWait);
  await page.locator('#wind-from').press('ArrowRight');
  assert.equal((await answer).status(), 200);
  await page.locator('#replan .outcome').waitFor(kWait);
  await page.locator('path.approach.replanned').waitFor({ state: 'attached' });
  await page.locator('#wind-speed').press('End');
  await page.waitForFunction(() => document.querySelector('#replan .rejected'), null, kWait);
  assert.equal(await page.locator('path.approach').count(), 0, 'no path of another wind stays');
  assert.equal(await page.locator('#profile canvas').count(), 0, 'nor its profile');
  await page.locator('#wind-reset').click();
  await page.locator('path.approach:not(.replanned)').waitFor({ state: 'attached' });
  assert.deepEqual(seen.errors, []);
});

test('headline numbers: strip and tightest obstacle, ground roll and direction of flight', async (t) => {
  const { page, seen } = await openSite(t);
  const { properties: p } = await getJson(`/v1/sites/${encodeURIComponent(site.properties.id)}`);
  const tiles = await page.locator('#site-tiles').textContent();
  assert.ok(tiles.includes(`${Math.floor(p.usable_length_m)} × ${Math.floor(p.usable_width_m)} m`), tiles);
  assert.match(tiles, /Tightest obstacle/);
  assert.doesNotMatch(await page.locator('#view-site').textContent(), /least clearance|measured in flight/i);
  await page.locator('path.ground-roll').waitFor({ state: 'attached', ...kWait });
  const turned = await page.locator('.flight-arrow path').getAttribute('transform');
  assert.equal(turned, `rotate(${p.approach.heading_deg})`);
  await shoot(page, 'headline');
  assert.deepEqual(seen.errors, []);
});

test('headline numbers: a trial wind switches every number and marker, and back', async (t) => {
  const { page, seen } = await openSite(t);
  const shown = () => page.evaluate(() => ['#site-title', '#site-summary', '#site-tiles', '#site-more']
    .map((id) => document.querySelector(id).textContent).join());
  const stored = await shown();
  const marker = page.locator('.disc-marker.chosen');
  const storedPlace = await marker.getAttribute('style');
  const answered = page.waitForResponse((r) => r.url().includes('/approach?wind_east_mps='), kWait);
  await page.locator('#wind-rose .rose-cell').first().waitFor(kWait);
  await page.locator('[aria-label^="5.0 m/s from 130°"]').click();
  const answer = await (await answered).json();
  await page.locator('#replan .outcome').waitFor(kWait);
  if (answer.plan) {
    const { plan } = answer;
    await page.locator('#site-summary', { hasText: plan.summary }).waitFor(kWait);
    assert.ok((await page.locator('#site-head').getAttribute('class')).includes(plan.verdict));
    assert.ok((await page.locator('#site-tiles').textContent()).includes(
      `${Math.floor(plan.usable_length_m)} × ${Math.floor(plan.usable_width_m)} m`));
    assert.match(await page.locator('#replan').textContent(), /Touchdown (moved \d+ m from the stored one|as stored)/);
    if (/moved/.test(await page.locator('#replan').textContent())) {
      assert.notEqual(await marker.getAttribute('style'), storedPlace, 'the marker moves');
    }
    await page.locator('path.ground-roll.replanned').waitFor({ state: 'attached', ...kWait });
  }
  await shoot(page, 'trial-wind');
  // In a storm there is no path, and no number of a path.
  await page.locator('#wind-speed').press('End');
  await page.waitForFunction(() => document.querySelector('#replan .rejected'), null, kWait);
  await page.locator('#site-head.verdict-rejected').waitFor(kWait);
  assert.doesNotMatch(await page.locator('#site-tiles').textContent(), /Tightest obstacle/);
  assert.equal(await page.locator('path.ground-roll').count(), 0);
  await page.locator('#wind-reset').click();
  await page.locator('path.ground-roll:not(.replanned)').waitFor({ state: 'attached', ...kWait });
  assert.equal(await shown(), stored, 'all numbers are the stored ones again');
  assert.equal(await marker.getAttribute('style'), storedPlace);
  assert.deepEqual(seen.errors, []);
});

test('page: the wind rose shows what the server says of each wind, and a cell plans for its own', async (t) => {
  const { page, seen } = await openSite(t);
  const cells = page.locator('#wind-rose .rose-cell');
  await cells.first().waitFor(kWait);
  const { entries } = await getJson(`/v1/sites/${encodeURIComponent(site.properties.id)}/wind-rose?speeds_mps=0,2.5,5,7.5,10`);
  const winds = entries.filter((e) => e.wind_speed_mps > 0 || e.wind_from_deg === 0);
  const shown = await cells.evaluateAll((all) => all.map((cell) => cell.classList[1]));
  assert.deepEqual(shown, winds.map((e) => e.verdict));
  const numLandable = winds.filter((e) => e.verdict === 'landable').length;
  assert.match(await page.locator('#wind-rose-text').textContent(), new RegExp(`^Landable in ${numLandable || 'none'} of 145 winds`));
  assert.equal(await page.locator('#wind-rose [tabindex="0"]').count(), 1, 'one stop for the Tab key');
  // By pointer: wind from 230°, so the air moves to the north-east.
  const answer = () => page.waitForResponse((r) => r.url().includes('/approach?wind_east_mps='), kWait);
  const [clicked] = await Promise.all([answer(), page.locator('[aria-label^="5.0 m/s from 230°"]').click()]);
  const asked = new URL(clicked.url()).searchParams;
  assert.deepEqual([asked.get('wind_east_mps'), asked.get('wind_north_mps')], ['3.830', '3.214']);
  assert.deepEqual([await page.locator('#wind-from').inputValue(), await page.locator('#wind-speed').inputValue()], ['230', '5']);
  const planned = winds.find((e) => e.wind_speed_mps === 5 && e.wind_from_deg === 230);
  const outcome = page.locator('#replan .outcome');
  await outcome.waitFor(kWait);
  assert.ok((await outcome.getAttribute('class')).includes(planned.verdict), 'both say the same');
  assert.match(await page.locator('#wind-rose [aria-current]').getAttribute('aria-label'), /^5\.0 m\/s from 230°/);
  await page.locator('.rose-now').first().waitFor();
  // By keyboard: one ring out, one direction clockwise.
  await page.locator('[aria-label^="5.0 m/s from 230°"]').focus();
  await page.keyboard.press('ArrowUp');
  await page.keyboard.press('ArrowRight');
  const [chosen] = await Promise.all([answer(), page.keyboard.press('Enter')]);
  assert.equal(chosen.ok() || chosen.status() === 409, true);
  assert.deepEqual([await page.locator('#wind-from').inputValue(), await page.locator('#wind-speed').inputValue()], ['240', '7.5']);
  await page.locator('#wind-reset').click();
  assert.deepEqual(await accessibilityFaults(page), []);
  await page.locator('#wind-rose').scrollIntoViewIfNeeded();
  await shoot(page, 'wind-rose');
  assert.deepEqual(seen.errors, []);
});

test('page: the wind rose of a site without a map says so and draws none', async (t) => {
  const { page } = await openPage(t, browser, { address: 'about:blank' });
  await page.route('**/wind-rose?**', (route) => route.fulfill({ status: 409,
    contentType: 'application/problem+json', body: '{"detail":"the site has no map to plan on"}' }));
  await page.goto(siteAddress());
  await page.getByText('No wind rose: the site has no map to plan on').waitFor(kWait);
  assert.equal(await page.locator('#wind-rose .rose-cell').count(), 0);
  assert.ok(await page.locator('#wind-rose-legend').isHidden());
});

test('page: a click answers why not here; off the map the ground is unseen', async (t) => {
  const { page, seen } = await openSite(t);
  // Clicks around the touchdown until a rule fails. Each answer is the server's own.
  for (const offset of [[40, 0], [-240, 10], [-160, 60], [-260, -150], [120, 120]]) {
    const asked = page.waitForResponse((r) => r.url().includes('/why?'), kWait);
    await clickPlace(page, site.place, offset);
    const judged = await (await asked).json();
    await page.locator('.answer .rules li').first().waitFor(kWait);
    assert.equal(await page.locator('.answer .rules li').count(), judged.rules.length);
    const failed = await page.locator('.answer .rules .fail').evaluateAll((all) => all.map((li) => li.dataset.rule));
    assert.deepEqual(failed, judged.rules.filter((rule) => !rule.passed).map((rule) => rule.rule));
    if (judged.verdict === 'rejected') break;
  }
  assert.match(await page.locator('.answer h3').textContent(), /^✕ Not landable: /);
  await shoot(page, 'why-not-here');
  assert.deepEqual(await accessibilityFaults(page), []);
  const history = page.locator('.answer button.wide');
  if (await history.count()) {
    await history.click();
    await page.locator('#region-plots canvas').first().waitFor(kWait);
    assert.equal(await page.locator('#region-plots canvas').count(), 3);
  }
  for (let i = 0; i < 5; ++i) await page.locator('.leaflet-control-zoom-out').click();
  const map = await page.locator('#map').boundingBox();
  await page.mouse.click(map.x + 60, map.y + 60);
  await page.getByText('Not landable: unseen').waitFor(kWait);
  assert.deepEqual(seen.errors, []);
});

test('page: a site comes in the formats of other programs, a refusal is shown', async (t) => {
  const { page } = await openSite(t);
  for (const format of ['html', 'kml', 'geojson', 'csv']) {
    const [download] = await Promise.all([page.waitForEvent('download', kWait),
      page.locator(`#site-downloads [data-format="${format}"]`).click()]);
    assert.match(download.suggestedFilename(), new RegExp(`\\.(${format}|json)$`));
  }
  await page.locator('#site-downloads [data-format="rally"]').click();
  await page.locator('#site-downloads .bad:not([hidden])').waitFor(kWait);
  assert.match(await page.locator('#site-downloads .bad').textContent(), /home_altitude_m|altitude/i);
});

test('page: a panel gives the command of what it shows', async (t) => {
  const { page } = await openSite(t);
  await page.evaluate(() => { navigator.clipboard.writeText = async (text) => { globalThis.copied = text; }; });
  const panels = {
    '#site-curl': '/sites/', '#approach-curl': '/approach', '#wind-rose-curl': '/wind-rose', '#layer-curl': '/layers/hazard.png', '#sites-curl': '/sites',
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
  const post = page.locator('.call:visible', { has: page.getByText('POST', { exact: true }) });
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
