// The ground on the map: photograph, layers, base map, measuring, progress: against a sample map
// in front of a running server that holds a finished flight; see page_test.mjs.

import assert from 'node:assert/strict';
import http from 'node:http';
import { after, before, test } from 'node:test';

import { accessibilityFaults, flownSite, launch, outside, smallTargets, url } from './browser.mjs';
import { clickMap, groundIsDrawn, groundSample, mapPoint, openGround, overflow_px, tilesOf } from './ground_page.mjs';
import { png, sampleJob } from './sample_map.mjs';
import { kWait, shoot } from './site_page.mjs';

const phone = { width: 360, height: 740 };
let browser;
let site;

before(async () => { [browser, site] = await Promise.all([launch(), flownSite()]); });
after(() => browser?.close());

const sampleMap = (more = {}) => groundSample(site, more);
const withJob = (job) => (path, json) => (path === '/v1/jobs' ? { jobs: [job, ...json.jobs] } : json);
const open = (t, parts, options) => openGround(t, { browser, site }, parts, options);

for (const [name, size] of [['desk', { width: 1280, height: 800 }], ['phone', phone]]) {
  for (const colorScheme of ['light', 'dark']) {
    test(`ground: photograph, translucent hazard, progress and area, ${name}, ${colorScheme}`, async (t) => {
      const { page, seen, server } = await open(t, { token: 's3cret', rewrite: withJob(sampleJob(site.flight, site.place)) }, { ...size, colorScheme });
      await groundIsDrawn(page);
      await page.locator('path.area').waitFor({ state: 'attached', ...kWait });
      const look = await page.evaluate(() => {
        const level = (selector) => Number(getComputedStyle(document.querySelector(selector).closest('.leaflet-pane[class*="-pane"]')).zIndex);
        return { levels: ['.photo-tiles', '.data-tiles', 'path.track', 'path.area', 'path.region', '.disc-marker'].map(level),
          opacity: Number(getComputedStyle(document.querySelector('.data-tiles')).opacity),
          dash: getComputedStyle(document.querySelector('path.area')).strokeDasharray,
          casing: getComputedStyle(document.querySelector('path.area-casing')).stroke };
      });
      assert.deepEqual(look.levels, look.levels.toSorted((a, b) => a - b), 'photograph, layer, then everything else');
      assert.equal(look.opacity, 0.5, 'the photograph is seen through the layer');
      assert.notEqual(look.dash, 'none');
      assert.equal(look.casing, 'rgb(255, 255, 255)');
      assert.match(await page.locator('#progress-text').textContent(), /14 pairs of photographs/);
      assert.equal(await page.locator('#progress-left').textContent(), 'about 2 min left');
      assert.equal(await page.locator('#progress-bar').getAttribute('value') ?? String(await page.locator('#progress-bar').evaluate((bar) => bar.value)), '0.42');
      assert.equal(await page.locator('img.site-layer').count(), 0, 'one layer at a time');
      assert.ok(await overflow_px(page) <= 0);
      await shoot(page, `ground-${name}-${colorScheme}`);
      assert.deepEqual(await smallTargets(page), []);
      assert.deepEqual(await accessibilityFaults(page), []);
      const { most } = await page.evaluate(() => tileRequests);
      assert.ok(most > 0 && most <= 4, `${most} tiles at once`);
      assert.deepEqual(outside(seen, server.url), [], 'no request left the machine');
      assert.ok(!seen.requests.some((request) => request.includes('s3cret')), 'the token is in no address');
      assert.deepEqual(seen.errors, []);
    });
  }
}

test('ground: one layer at a time over the photograph, with its legend and unit; the photograph can be switched off', async (t) => {
  const { page, seen } = await open(t, {});
  await groundIsDrawn(page);
  const names = await page.locator('#layer option').evaluateAll((all) => all.map((option) => option.value));
  assert.deepEqual(names, ['hazard', 'elevation', 'slope', 'roughness', 'grass', 'distance', 'height_sd', 'coverage', 'risk', '']);
  for (const [name, unit] of [['slope', '°'], ['height_sd', 'm'], ['coverage', 'photographs']]) {
    await page.selectOption('#layer', name);
    await groundIsDrawn(page, name);
    assert.equal(await page.locator('.data-tiles').count(), 1);
    await page.locator('#legend img').waitFor(kWait);
    assert.ok((await page.locator('#layer option:checked').textContent()).includes(unit));
    assert.match(await page.locator('#legend').textContent(), /no colour: unseen/);
  }
  await page.locator('#opacity').fill('0.8');
  await page.selectOption('#layer', 'elevation');
  await groundIsDrawn(page, 'elevation');
  assert.equal(await page.locator('.data-tiles').evaluate((node) => getComputedStyle(node).opacity), '0.8');
  await page.selectOption('#layer', '');
  await page.locator('.data-tiles').waitFor({ state: 'detached', ...kWait });
  await shoot(page, 'ground-photo');
  await page.locator('#show-photo').uncheck();
  await page.locator('.photo-tiles').waitFor({ state: 'detached', ...kWait });
  await page.locator('#show-photo').check();
  await groundIsDrawn(page, null);
  assert.deepEqual(seen.errors, []);
});

test('ground: nearer than the finest tiles they are enlarged; far out they are left out', async (t) => {
  const { page, server } = await open(t, {});
  await groundIsDrawn(page);
  for (let i = 0; i < 30; ++i) await page.keyboard.press('Tab').then(() => page.locator('#map').press('+'));
  await page.waitForTimeout(1500);
  const zooms = server.tiles.asked.map(({ path }) => Number(/\/(\d+)\/\d+\/\d+\.png/.exec(path)[1]));
  assert.equal(Math.max(...zooms), 20);
  assert.ok(Math.min(...zooms) >= 14);
  assert.ok(await tilesOf(page, 'photo').count() > 0);
  assert.equal(await page.evaluate(() => document.querySelector('.leaflet-control-zoom-in').classList.contains('leaflet-disabled')), true);
});

test('ground: a growing map is repainted where it changed, and never empties', async (t) => {
  const { page, server, map, seen } = await open(t, { map: sampleMap({ grown: 0.4 }) });
  await groundIsDrawn(page);
  await page.evaluate(() => {
    globalThis.watched = { emptied: 0, swapped: new Set(), removed: 0 };
    for (const tile of document.querySelectorAll('.ground-tiles img')) tile.wasThere = tile.hasAttribute('src');
    new MutationObserver((records) => {
      for (const { type, target, removedNodes } of records) {
        if (type === 'childList') watched.removed += [...removedNodes].filter((node) => node.wasThere).length;
        else if (!target.hasAttribute('src') && target.wasThere) ++watched.emptied;
        else if (target.wasThere) watched.swapped.add(target);
      }
    }).observe(document.getElementById('map'), { subtree: true, childList: true, attributes: true, attributeFilter: ['src'] });
  });
  const numBefore = await tilesOf(page, 'photo').count();
  server.tiles.asked.length = 0;
  Object.assign(map, { grown: 0.75, version: 2 });
  server.emit('map', { flight_id: site.flight, updated_at: 'later' });
  await page.waitForFunction((count) => document.querySelectorAll('.photo-tiles img.leaflet-tile-loaded[src]').length > count, numBefore, kWait);
  await groundIsDrawn(page);
  const watched = await page.evaluate(() => ({ ...globalThis.watched, swapped: globalThis.watched.swapped.size }));
  const by = (status) => server.tiles.asked.filter((tile) => tile.status === status).length;
  assert.equal(watched.emptied, 0, 'no tile was empty in between');
  assert.equal(watched.removed, 0, 'no tile was thrown away');
  assert.ok(by(304) > 0, 'unchanged tiles are not sent again');
  assert.ok(watched.swapped > 0 && watched.swapped <= by(200), `${watched.swapped} of ${by(200)} changed tiles swapped`);
  // The same map again: nothing is asked.
  server.tiles.asked.length = 0;
  const { updated_at } = await (await fetch(`${server.url}/v1/flights/${site.flight}/map`)).json();
  server.emit('map', { flight_id: site.flight, updated_at });
  await page.waitForTimeout(800);
  assert.equal(server.tiles.asked.length, 0);
  assert.deepEqual(seen.errors, []);
});

test('ground: a tile that does not come is hatched and counted, never bare, and asked for again', async (t) => {
  const { page, map, server, seen } = await open(t, { map: sampleMap({ failing: /\/hazard\// }) });
  await page.locator('#layer-note', { hasText: /^\d+ tiles not loaded$/ }).waitFor(kWait);
  await page.locator('.data-tiles img:not(.missing)').first().waitFor({ state: 'detached', ...kWait });
  const backgrounds = await page.locator('.data-tiles img').evaluateAll((all) => all.map((tile) => getComputedStyle(tile).backgroundImage));
  assert.ok(backgrounds.length > 0 && backgrounds.every((image) => /repeating-linear-gradient/.test(image)));
  await page.locator('.data-tiles img.leaflet-tile-loaded').first().waitFor(kWait);
  await shoot(page, 'ground-missing');
  map.failing = null;
  await page.waitForFunction(() => document.getElementById('layer-note').textContent === '', null, { timeout: 30000 });
  assert.equal(await page.locator('.ground-tiles img.missing').count(), 0);
  // A tile that changed and does not come is not shown as it was; an old photograph is.
  Object.assign(map, { failing: /\/(hazard|photo)\//, version: 2 });
  server.emit('map', { flight_id: site.flight, updated_at: 'later' });
  await page.locator('.data-tiles img.missing').first().waitFor(kWait);
  await page.waitForTimeout(1000);
  assert.equal(await page.locator('.data-tiles img.missing[src]').count(), 0);
  assert.ok(await page.locator('.photo-tiles img.missing[src]').count() > 0);
  assert.ok(seen.errors.every((error) => /503/.test(error)), String(seen.errors));
});

test('ground: another flight, or a layer that is left, ends its requests', async (t) => {
  const { page, server } = await open(t, { map: sampleMap({ delay_ms: 300 }) });
  await tilesOf(page, 'photo').first().waitFor(kWait);
  await page.selectOption('#layer', 'elevation');
  await page.selectOption('#layer', 'slope');
  await groundIsDrawn(page, 'slope');
  const asked = server.tiles.asked.filter(({ path }) => path.includes('/elevation/')).length;
  assert.ok(asked <= 4, `${asked} tiles of a layer that nobody sees`);
});

test('ground: a flight without a map keeps the layers of its sites, until its map appears', async (t) => {
  const { page, map, server, seen } = await open(t, { map: sampleMap({ isThere: false }) });
  await page.locator('img.site-layer').waitFor({ state: 'attached', ...kWait });
  assert.equal(await page.locator('.ground-tiles').count(), 0);
  assert.ok(await page.locator('#show-photo').isHidden());
  assert.equal(await page.locator('#opacity').inputValue(), '1');
  map.isThere = true;
  server.emit('map', { flight_id: site.flight, updated_at: 'now' });
  await groundIsDrawn(page);
  assert.equal(await page.locator('img.site-layer').count(), 0);
  assert.equal(await page.locator('#opacity').inputValue(), '0.5');
  await page.locator('#sites button').nth(1).click();
  await page.locator('#profile canvas').waitFor(kWait);
  assert.equal(await page.locator('img.site-layer').count(), 0, 'the map of the flight stays');
  await groundIsDrawn(page);
  assert.deepEqual(seen.errors, []);
});

test('ground: an older server is asked for no map', async (t) => {
  const { page, server } = await open(t, { map: null });
  await page.locator('img.site-layer').waitFor({ state: 'attached', ...kWait });
  const asked = server.asked.filter((path) => typeof path === 'string' && /\/map(\/|$)|base-map|\/(landing|why)\?/.test(path));
  assert.deepEqual(asked, []);
  assert.ok(await page.locator('#progress').isHidden());
  assert.equal(await page.locator('path.area').count(), 0);
  assert.ok(await page.locator('#map-card').isHidden());
});

test('base map: below the photograph, with its credit as text and a switch that is remembered', async (t) => {
  const attribution = '<b>© Survey</b> 2026 <img src="https://evil.example/x.png" onerror="globalThis.hit = true">';
  const { page, seen, server } = await open(t, { baseMap: { name: 'Country', attribution, minzoom: 0, maxzoom: 20 } });
  await groundIsDrawn(page);
  await tilesOf(page, 'base').first().waitFor(kWait);
  assert.equal(await page.locator('.map-credit').textContent(), '© Survey 2026');
  const levels = await page.evaluate(() => ['.base-tiles', '.photo-tiles'].map((selector) =>
    Number(getComputedStyle(document.querySelector(selector).parentElement).zIndex)));
  assert.ok(levels[0] < levels[1]);
  await shoot(page, 'base-map');
  assert.deepEqual(await smallTargets(page), []);
  assert.deepEqual(await accessibilityFaults(page), []);
  await page.locator('#show-base').uncheck();
  await page.locator('.base-tiles').waitFor({ state: 'detached', ...kWait });
  assert.ok(await page.locator('.map-credit').isHidden());
  await page.reload();
  await groundIsDrawn(page);
  assert.ok(!await page.locator('#show-base').isChecked());
  assert.equal(await page.locator('.base-tiles').count(), 0);
  assert.equal(await page.evaluate(() => globalThis.hit), undefined);
  assert.deepEqual(outside(seen, server.url), []);
  // The reload ends the stream of events.
  assert.deepEqual(seen.errors.filter((error) => !error.includes('/v1/events')), []);
});

test('base map: of another server it is loaded as plain pictures, without the token; it is the only other server', async (t) => {
  const asked = [];
  const elsewhere = http.createServer((request, response) => {
    asked.push(request.headers);
    response.writeHead(200, { 'Content-Type': 'image/png' });
    response.end(png(256, 256, (x, y) => [220, 230 - (x >> 3), 240 - (y >> 3), 255]));
  });
  await new Promise((resolve) => { elsewhere.listen(0, '127.0.0.1', resolve); });
  t.after(() => {
    elsewhere.close();
    elsewhere.closeAllConnections();
  });
  const origin = `http://127.0.0.1:${elsewhere.address().port}`;
  const { page, seen, server } = await open(t, { token: 's3cret', outside: origin,
    baseMap: { tiles: [`${origin}/{z}/{x}/{y}.png`], attribution: '© Elsewhere', minzoom: 0, maxzoom: 19 } });
  await groundIsDrawn(page);
  await tilesOf(page, 'base').first().waitFor(kWait);
  assert.equal(await page.locator('.map-credit').textContent(), '© Elsewhere');
  assert.ok(asked.length > 0 && asked.every(({ authorization }) => authorization === undefined));
  assert.ok(outside(seen, server.url).every((request) => request.startsWith(`${origin}/`)));
  const before = asked.length;
  await page.locator('#show-base').uncheck();
  await page.locator('#map').press('-');
  await page.waitForTimeout(500);
  assert.equal(asked.length, before, 'switched off, it asks nobody');
  assert.deepEqual(seen.errors, []);
});

test('cursor: coordinates under the pointer, copied with C; by keyboard those of the crosshair', async (t) => {
  const { page } = await open(t, {});
  await groundIsDrawn(page);
  await page.evaluate(() => { navigator.clipboard.writeText = async (text) => { globalThis.copied = text; }; });
  await page.mouse.move(...await mapPoint(page, 0.6, 0.3));
  const shown = await page.locator('.place-button').textContent();
  assert.match(shown, /^4\d\.\d{6}, 8\.\d{6}$/);
  assert.match(await page.locator('.place-button').evaluate((node) => getComputedStyle(node).fontVariantNumeric), /tabular-nums/);
  await page.locator('#map').focus();
  await page.mouse.move(...await mapPoint(page, 0.6, 0.31));
  await page.keyboard.press('c');
  assert.equal(await page.evaluate(() => globalThis.copied), await page.locator('.place-button').textContent());
  await page.keyboard.press('ArrowLeft');
  await page.waitForTimeout(600);
  const centre = await page.locator('.place-button').textContent();
  assert.notEqual(centre, shown);
  await page.keyboard.press('Enter');
  await page.locator('.answer').waitFor(kWait);
  assert.equal(await page.locator('.answer .place').textContent(), centre, 'Enter checks the crosshair');
  assert.ok(await page.locator('.answer:focus').count() === 1, 'the answer is read');
  await page.keyboard.press('Escape');
  await page.locator('.answer').waitFor({ state: 'detached', ...kWait });
  assert.equal(await page.evaluate(() => document.activeElement.id), 'map');
});

test('measure: distance and bearing from point to point, by mouse and by keyboard; Escape ends it', async (t) => {
  for (const size of [{}, phone]) {
    const { page, seen } = await open(t, {}, size);
    await groundIsDrawn(page);
    await page.locator('.map-button').click();
    await clickMap(page, 0.5, 0.25);
    await clickMap(page, 0.5, 0.55);
    await page.locator('.measure-box output', { hasText: /^\d+ m, bearing 180°$/ }).waitFor(kWait);
    await clickMap(page, 0.75, 0.55);
    await page.locator('.measure-box output', { hasText: /^\d+ m, bearing 090°. Total \d+ m$/ }).waitFor(kWait);
    assert.deepEqual((await page.locator('.measure-point b').allTextContents()).map((text) => text.split(' · ')[1]), ['180°', '090°']);
    assert.equal(await page.locator('.answer').count(), 0, 'measured places are not checked');
    assert.deepEqual(await smallTargets(page), []);
    assert.deepEqual(await accessibilityFaults(page), []);
    await shoot(page, size.width ? 'measure-phone' : 'measure');
    await page.locator('.measure-box button', { hasText: 'Undo' }).click();
    assert.equal(await page.locator('.measure-point').count(), 2);
    await page.keyboard.press('Escape');
    await page.locator('.measure-box').waitFor({ state: 'hidden', ...kWait });
    assert.equal(await page.locator('.measure-point').count(), 0);
    await page.locator('#map').focus();
    for (const key of ['m', 'Enter', 'ArrowRight']) await page.keyboard.press(key);
    await page.waitForTimeout(600);
    await page.keyboard.press('Enter');
    await page.locator('.measure-box output', { hasText: /bearing 090°/ }).waitFor(kWait);
    await page.keyboard.press('m');
    await page.locator('.measure-box').waitFor({ state: 'hidden', ...kWait });
    assert.deepEqual(seen.errors, []);
  }
});

test('export: the layers of the map as GeoTIFF, photograph and hazard as KMZ', async (t) => {
  const { page, seen } = await open(t, { token: 's3cret' });
  await groundIsDrawn(page);
  await page.locator('[data-tab="flight"]').click();
  await page.locator('#map-card summary').click();
  const files = await page.locator('#map-downloads [data-file]').evaluateAll((all) => all.map((button) => button.dataset.file));
  assert.deepEqual(files.filter((file) => file.endsWith('.kmz')), ['photo.kmz', 'hazard.kmz']);
  assert.equal(files.filter((file) => file.endsWith('.tif')).length, 10);
  const [download] = await Promise.all([page.waitForEvent('download', kWait), page.locator('[data-file="photo.tif"]').click()]);
  assert.equal(download.suggestedFilename(), `${site.flight}-photo.tif`);
  assert.deepEqual(await smallTargets(page), []);
  await shoot(page, 'map-export');
  assert.deepEqual(seen.errors, []);
});

test('no flight: the map shows where stored sites are, and they can be opened', async (t) => {
  const { page, seen } = await open(t, { rewrite: (path, json) => (path === '/v1/flights' ? { flights: [] } : json) });
  assert.ok(await page.locator('#map .disc-marker').count() > 0);
  await page.waitForFunction(([lon, lat]) => {
    const shown = document.querySelector('.place-button').textContent.split(',').map(Number);
    return Math.abs(shown[0] - lat) < 0.1 && Math.abs(shown[1] - lon) < 0.1;
  }, site.place, kWait);
  await shoot(page, 'no-flight');
  await page.locator('#sites button').first().click();
  await page.locator('#profile canvas').waitFor(kWait);
  assert.deepEqual(seen.errors, []);
});
