// "Why here, why not here?" for a clicked place: its verdict, what it was made of, and "plan a landing here": against a sample
// map in front of a running server that holds a finished flight; see page_test.mjs.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { cueName, cuesByWeight, isBlank, likelihoodText, logOddsText, nearestLimitText, niceStep, noPatchesText, percent } from '../../web/proof_shape.js';
import { accessibilityFaults, flownSite, getJson, launch, openPage, smallTargets, url } from './browser.mjs';
import { clickMap, groundIsDrawn, groundSample, openGround, overflow_px } from './ground_page.mjs';
import { sampleLikelihood, sampleProof } from './sample_proof.mjs';
import { clickPlace, kWait, shoot } from './site_page.mjs';

const phone = { width: 360, height: 740 };
const desk = { width: 1280, height: 800 };
let browser;
let site;

before(async () => { [browser, site] = await Promise.all([launch(), flownSite()]); });
after(() => browser?.close());

const open = (t, parts, options) => openGround(t, { browser, site }, parts, options);

// --- Texts ---

test('proof: the nearest limit is one sentence', () => {
  const limit = { part: 'ground', value: 0.024, limit: 0.1, margin: 0.076, whole: 0.024 };
  assert.equal(nearestLimitText(limit), 'Nearest limit of the risk: the ground, 0.024 of 0.1 allowed, 0.076 left.');
  assert.equal(nearestLimitText({ ...limit, part: 'circle', value: 0.13, margin: -0.03, whole: 0.2 }),
    'Nearest limit of the risk: the loiter circle, 0.13 of 0.1 allowed, 0.03 too much. All risks together: 0.2.');
  assert.match(nearestLimitText(null), /unknown, because no landing could be computed here/);
  assert.equal(nearestLimitText(undefined), '', 'an older server tells none');
});

test('proof: weights, log-odds and cues as texts', () => {
  assert.deepEqual([0, 0.004, 0.096, 1].map(percent), ['0\u00a0%', '< 1\u00a0%', '10\u00a0%', '100\u00a0%']);
  assert.deepEqual([2.25, -1.5, 7.875, -7.875].map(logOddsText), ['+2.3', '−1.5', '≥ +7.9', '≤ −7.9']);
  const { telling, silent, unknown } = cuesByWeight(sampleProof('f').evidence.cues);
  assert.deepEqual([telling.map(({ cue }) => cue), silent, unknown], [['fence', 'views', 'look_alike'], ['small object'], ['a new cue']]);
  assert.equal(cueName('a_new_cue'), 'a new cue');
});

test('proof: heights as a sentence; a scale has few, round steps', () => {
  assert.equal(likelihoodText(sampleLikelihood, { height_m: 460.2, height_sd_m: 0.12 }),
    '5 photographs agree best at 460.20 m, with a correlation of 0.87. Stored: 460.20 ± 0.12 m.');
  assert.equal(likelihoodText(sampleLikelihood, { height_m: null }), '5 photographs agree best at 460.20 m, with a correlation of 0.87.');
  assert.deepEqual([niceStep(4, 5), niceStep(90, 3), niceStep(0.3, 5)], [1, 50, 0.1]);
});

test('proof: what is not stored is told, and nothing about a place that no photograph shows', () => {
  assert.equal(noPatchesText({ frames: null }), 'Which photographs show this place is not stored.');
  assert.equal(noPatchesText({ frames: [], patches: [] }), 'No photograph shows this place.');
  assert.equal(noPatchesText({ frames: ['a'] }), 'In 1 photograph. Where in them is not stored.');
  assert.ok(isBlank({ frames: null, height_m: null }) && !isBlank({ frames: null, height_m: 460 }));
});

// --- The answer ---

const withProof = (options, more = {}) => ({ map: groundSample(site, { why: sampleProof(site.flight, options), ...more }) });
async function clicked(page) {
  await groundIsDrawn(page);
  await clickMap(page, 0.6, 0.75);
  await page.locator('.answer').waitFor(kWait);
}
const pictures = (page) => page.waitForFunction(() => [...document.querySelectorAll('.patch img')].every((image) => image.naturalWidth > 0), null, kWait);
const unfold = async (page) => {
  for (const summary of await page.locator('.answer > .fold:not(.other-rules) > summary').all()) await summary.press('Enter');
};

for (const [name, options] of [['desk', desk], ['desk-dark', { ...desk, colorScheme: 'dark' }], ['phone', phone], ['phone-dark', { ...phone, colorScheme: 'dark' }]]) {
  test(`proof: photographs, heights, cues and versions of a place, ${name}`, async (t) => {
    const { page, seen, server } = await open(t, { ...withProof(), token: 's3cret' }, options);
    await clicked(page);
    await pictures(page);
    assert.deepEqual(await page.locator('.patch-row li > span').allInnerTexts(),
      ['40\u00a0%\nIMG_7.JPG', '28\u00a0%\nIMG_8.JPG', '23\u00a0%\nIMG_9.JPG', '10\u00a0%\nIMG_10.JPG']);
    assert.equal(await page.locator('.patch img').first().getAttribute('alt'), 'Photograph IMG_7.JPG; the place is in the middle');
    assert.equal(await page.locator('.nearest-limit').innerText(), 'Nearest limit of the risk: the ground, 0.024 of 0.1 allowed, 0.076 left.');
    assert.equal(await page.locator('.likelihood').isVisible(), false, 'folded');
    await shoot(page, `why-proof-${name}`);
    await unfold(page);
    assert.match(await page.locator('.likelihood').getAttribute('aria-label'), /5 photographs agree best at 460\.20 m/);
    assert.deepEqual(await page.locator('.cues tr').allInnerTexts().then((rows) => rows.map((row) => row.replace(/\s+/g, ' ').trim())),
      ['fence ✕ denies grass', 'grass in the photographs ≥ +7.9', 'crop that looks like grass −1.5']);
    assert.match(await page.locator('.answer').innerText(), /No objection: small object\.\s+Unknown: a new cue\./);
    assert.match(await page.locator('.versions').innerText(), /Program\s+0\.1\.0\s+Grass model \(SHA-256\)\s+b4cc5bf82e25cbcd95f43996a5f1837d/);
    assert.ok(!(await page.locator('.versions').innerText()).includes('Digest'), 'only a site has a digest');
    assert.ok(await page.locator('.answer pre').isHidden(), 'options are folded away');
    const top = await page.evaluate(() => document.querySelector('.answer-popup').getBoundingClientRect().top - document.getElementById('map').getBoundingClientRect().top);
    assert.ok(top >= 0, 'an unfolded answer stays on the map');
    await page.locator('.likelihood').evaluate((chart) => chart.closest('.fold').scrollIntoView({ block: 'start' }));
    await shoot(page, `why-proof-${name}-heights`);
    await page.locator('.cues').evaluate((table) => table.closest('.fold').scrollIntoView({ block: 'start' }));
    await shoot(page, `why-proof-${name}-cues`);
    assert.equal(server.patches.length, 4);
    assert.ok(await overflow_px(page) <= 0);
    assert.deepEqual(await smallTargets(page), []);
    assert.deepEqual(await accessibilityFaults(page), []);
    assert.deepEqual(seen.errors, []);
  });
}

test('proof: six photographs are loaded, the others are named; lost photographs say so', async (t) => {
  const { page, server } = await open(t, withProof({ weights: [0.3, 0.2, 0.15, 0.1, 0.1, 0.08, 0.05, 0.02] }, { lost: ['IMG_8.JPG'] }));
  await clicked(page);
  await page.locator('.patch.missing', { hasText: 'not stored any more' }).waitFor(kWait);
  await pictures(page);
  assert.equal(await page.locator('.patch').count(), 6);
  assert.equal(server.patches.length, 6);
  await unfold(page);
  assert.match(await page.locator('.answer').innerText(), /2 more photographs of this place: IMG_13\.JPG \(5\u00a0%\), IMG_14\.JPG \(2\u00a0%\)\./);
  assert.match(await page.locator('.answer').innerText(), /It also depends on 2 other photographs: IMG_3\.JPG, IMG_4\.JPG\./);
  await shoot(page, 'why-proof-lost');
});

test('proof: what the map does not store is said', async (t) => {
  const { page, seen } = await open(t, withProof({ weights: [0, 0], nearest_limit: null, options: {}, evidence_digest: 'd7738b13',
    versions: { program: '0.1.0', grass_model_sha256: 'd7', map: 'f/1', evaluated_at: '2026-11-27T09:55:18Z' },
    evidence: { height_likelihood: null, cues: null, context_frames: null } }));
  await clicked(page);
  await pictures(page);
  await unfold(page);
  assert.deepEqual(await page.locator('.patch-row li > span').allInnerTexts(), ['IMG_7.JPG', 'IMG_8.JPG'], 'unknown weights are not shown as zero');
  const text = await page.locator('.answer').innerText();
  for (const told of [/How well other heights explain the photographs is not known/, /What tells grass from other ground here is not stored/,
    /Which other photographs it depends on is not stored/, /given no options/, /Digest of the evidence\s+d7738b13/]) assert.match(text, told);
  assert.equal(await page.locator('.likelihood').count(), 0);
  await shoot(page, 'why-proof-earlier');
  assert.deepEqual(seen.errors, []);
});

test('proof: another place stops loading the pictures of the first one', async (t) => {
  const { page, seen } = await open(t, withProof());
  await clicked(page);
  await pictures(page);
  await page.keyboard.press('Escape');
  assert.equal(await page.locator('.patch').count(), 0);
  await clickMap(page, 0.6, 0.75);
  await clickMap(page, 0.62, 0.5);
  await page.waitForFunction(() => document.querySelectorAll('.answer').length === 1 && document.querySelectorAll('.patch').length === 4, null, kWait);
  await pictures(page);
  assert.deepEqual(seen.errors, []);
});

test('why: a place of the flight\'s map is judged by the flight, and a landing there is planned and drawn', async (t) => {
  const landing = await getJson(`/v1/sites/${encodeURIComponent(site.properties.id)}/approach`);
  for (const size of [{}, phone]) {
    const { page, seen, server } = await open(t, { landing }, size);
    await groundIsDrawn(page);
    await clickMap(page, 0.6, 0.75);
    await page.locator('.answer h3', { hasText: 'Not landable: too steep' }).waitFor(kWait);
    const asked = server.asked.findLast((path) => typeof path === 'string' && path.includes('/why?'));
    assert.match(asked, new RegExp(`^/v1/flights/${site.flight}/why\\?latitude_deg=-?\\d`));
    assert.deepEqual(await smallTargets(page), []);
    await shoot(page, size.width ? 'why-ground-phone' : 'why-ground');
    await page.locator('.answer button', { hasText: 'Plan a landing here' }).click();
    await page.locator('#landing-title:focus', { hasText: 'Landing here: landable' }).waitFor(kWait);
    await page.locator('#landing-profile canvas').waitFor(kWait);
    assert.match(await page.locator('#landing-text').textContent(), /The touchdown is (\d+ m|at)/);
    assert.ok(await page.locator('#landing-tiles .tile').count() === 4);
    assert.equal(await page.locator('path.approach.replanned').count(), 1, 'the planned path, not the path of the site');
    assert.equal(await page.locator('path.approach').count(), 1);
    assert.ok(await overflow_px(page) <= 0);
    assert.deepEqual(await accessibilityFaults(page), []);
    await shoot(page, size.width ? 'landing-phone' : 'landing');
    await page.keyboard.press('Escape');
    await page.locator('path.approach.replanned').waitFor({ state: 'detached', ...kWait });
    assert.equal(await page.locator('path.approach').count(), 1, 'the path of the site is back');
    assert.deepEqual(seen.errors, []);
  }
});

test('landing: a refusal is shown in place of a path', async (t) => {
  const { page } = await open(t, { landing: 'every place within 100 m is too steep' });
  await groundIsDrawn(page);
  await clickMap(page, 0.6, 0.75);
  await page.locator('.answer button', { hasText: 'Plan a landing here' }).click();
  await page.locator('#landing-title', { hasText: 'No landing here' }).waitFor(kWait);
  assert.equal(await page.locator('#landing-text').textContent(), 'every place within 100 m is too steep.');
  assert.equal(await page.locator('#landing-profile canvas').count(), 0);
});

test('why: a place that no map shows is unseen, never safe', async (t) => {
  const { page, map } = await open(t, {});
  await groundIsDrawn(page);
  map.why = null;
  await clickMap(page, 0.1, 0.3);
  await page.locator('.answer h3', { hasText: 'Not landable: unseen' }).waitFor(kWait);
  assert.match(await page.locator('.answer').textContent(), /no map of the flight shows this place\. Unseen ground is never safe\./);
});


// --- The real server ---

test('proof: the server tells what a place of its map was made of', async (t) => {
  const { page, seen } = await openPage(t, browser, { address: `${url}/#flight=${site.flight}&site=${encodeURIComponent(site.properties.id)}` });
  await page.locator('#profile canvas').waitFor(kWait);
  const answered = page.waitForResponse((response) => response.url().includes('/why?'), kWait);
  await clickPlace(page, site.place, [0, 34]);
  const { evidence } = await (await answered).json();
  await page.locator('.answer').waitFor(kWait);
  await pictures(page);
  assert.equal(await page.locator('.patch').count(), Math.min(6, evidence.patches?.length ?? 0));
  assert.equal(await page.locator('.likelihood').count(), evidence.height_likelihood ? 1 : 0);
  await shoot(page, 'why-proof-real');
  assert.deepEqual(seen.errors, []);
});
