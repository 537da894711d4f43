// What the page says of a plan: for the stored wind, for another one, and for a clicked place.
// Of a running server that holds a finished flight; see page_test.mjs.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { accessibilityFaults, flownSite, getJson, launch, openPage, url } from './browser.mjs';
import { clickPlace, kWait, pictureIsDrawn, shoot } from './site_page.mjs';

let browser;
let site;

before(async () => { [browser, site] = await Promise.all([launch(), flownSite()]); });
after(() => browser?.close());

const siteAddress = () => `${url}/#flight=${site.flight}&site=${encodeURIComponent(site.properties.id)}`;

async function openSite(t, options) {
  const opened = await openPage(t, browser, { address: siteAddress(), ...options });
  await opened.page.locator('#profile canvas').waitFor(kWait);
  await pictureIsDrawn(opened.page, 'hazard');
  return opened;
}

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
  for (const offset of [[40, 0], [-140, 10], [-160, 60], [-120, -100], [120, 120]]) {
    if (await page.locator('.answer').count()) await page.keyboard.press('Escape');
    const asked = page.waitForResponse((r) => r.url().includes('/why?'), kWait);
    await clickPlace(page, site.place, offset);
    const judged = await (await asked).json();
    await page.locator('.answer .rules li').first().waitFor({ state: 'attached', ...kWait });
    assert.equal(await page.locator('.answer .rules li').count(), judged.rules.length);
    const failed = await page.locator('.answer .rules .fail').evaluateAll((all) => all.map((li) => li.dataset.rule));
    assert.deepEqual(failed, judged.rules.filter((rule) => !rule.passed).map((rule) => rule.rule));
    if (judged.verdict === 'rejected') break;
  }
  assert.match(await page.locator('.answer h3').textContent(), /^✕ Not landable: /);
  await shoot(page, 'why-not-here');
  assert.deepEqual(await accessibilityFaults(page), []);
  const history = page.locator('.answer button.wide', { hasText: /^Region/ });
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
