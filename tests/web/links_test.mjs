// Links to autopilots: the panel, alarms, and commands that a person confirms, against sample links in front of a running server
// that holds a finished flight; see page_test.mjs.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import {
  alarmsOf, alternatesOf, commandText, engineText, guidanceText, heardText, insuranceText, landingWarnings, landingWind, linkRows, missionText,
  picturesText, refusalText, windLine,
} from '../../web/link_shape.js';
import { accessibilityFaults, flownSite, isOptional, launch, openPage, smallTargets, url } from './browser.mjs';
import { overflow_px } from './ground_page.mjs';
import { sampleFailure, sampleLink } from './sample_links.mjs';
import { kWait, shoot } from './site_page.mjs';
import { startStandIn } from './stand_in.mjs';

const phone = { width: 390, height: 844 };
let browser;
let site;

before(async () => { [browser, site] = await Promise.all([launch(), flownSite()]); });
after(() => browser?.close());

// --- Texts ---

const nameOf = (id) => `site ${id.slice(3)}`;

test('links: what is not known reads unknown, and what is old says so', () => {
  const link = sampleLink([8, 47]);
  assert.equal(heardText(link), 'heard 0 s ago');
  assert.equal(heardText({ ...link, is_connected: false, heard_age_s: 130 }), 'the link has been silent for 2 min');
  assert.equal(heardText({ ...link, is_connected: false, age_s: 9 }), 'the autopilot has been silent for 9 s');
  assert.equal(windLine(undefined), 'unknown');
  assert.equal(windLine(link.wind), '3.3 m/s from 069° ±0.4 m/s, from drift, 2 s old');
  assert.equal(windLine({ east_mps: 3, north_mps: 0, age_s: null }), '3.0 m/s from 270°, source unknown, unknown old');
  assert.deepEqual([engineText({}), missionText({}, nameOf)], ['unknown', 'unknown']);
  assert.equal(missionText({ mission: { state: 'current', site: 'f-r2', current_item: 3, num_items: 7 } }, nameOf), 'landing at site 2, item 3 of 7');
  assert.match(commandText({ kind: 'mission', site_id: 'f-r2', issued_at: new Date().toISOString(), state: 'expired' }, nameOf), /Land here \(site 2\): not taken: it was too late/);
});

test('links: a failure, a broken mission and a guided aircraft that is silent alarm, a normal flight does not', () => {
  const link = sampleLink([8, 47]);
  assert.deepEqual(alarmsOf(link), []);
  const failed = { ...link, ...sampleFailure('f-r2') };
  assert.equal(alarmsOf(failed).length, 2);
  assert.match(alarmsOf(failed)[0], /^System 1: engine FAILED since \d\d:\d\d: climb and speed/);
  assert.match(alarmsOf({ ...failed, is_connected: false, heard_age_s: 8 })[2], /silent for 8 s while it was guided/);
});

test('links: insurance of the rest of the mission, in one line', () => {
  const link = (insurance, more) => ({ is_connected: true, insurance, ...more });
  assert.equal(insuranceText(link(undefined)), null);
  assert.equal(insuranceText(link({ state: 'none', why: 'it does not fly' })), 'it does not fly');
  const whole = { state: 'checked', covered_ratio: 1, time_s: 724, end: 'the landing', age_s: 3, num_gaps: 0 };
  assert.equal(insuranceText(link(whole)), 'a site, verified or not, is in reach on all of the next 12 min, to the landing');
  assert.equal(insuranceText(link({ ...whole, age_s: 150 })), 'a site, verified or not, is in reach on all of the next 12 min, to the landing. Checked 2 min ago');
  assert.equal(insuranceText(link({ ...whole, age_s: 200 })), 'unknown: the age of the last check is 3 min');
  assert.equal(insuranceText(link({ ...whole, age_s: undefined })), 'unknown: the age of the last check is unknown');
  const gap = { ...whole, covered_ratio: 0.9399, first_gap: { in_s: 130, lasts_s: 35, reason: 'too_low' }, num_gaps: 2, point_of_no_return_in_s: 540 };
  assert.equal(insuranceText(link(gap)), 'in reach for 93 % of the next 12 min, to the landing; none in 2 min, for 35 s (too low); none at all after 9 min');
  assert.match(insuranceText(link({ ...gap, first_gap: { in_s: 0, lasts_s: 35 } })), /NO SITE IN REACH NOW, for 35 s more/);
  assert.equal(insuranceText(link(gap, { is_connected: false })), 'unknown: nothing is heard of the aircraft');
  const isAlarm = (insurance) => linkRows(link(insurance), (id) => id).find(([name]) => name === 'Rest of the mission')[2];
  assert.deepEqual([isAlarm(whole), isAlarm(gap), isAlarm({ ...gap, first_gap: { in_s: 0, lasts_s: 9 } })], [false, false, true]);
});

test('links: where guidance will arrive, above or below', () => {
  const link = (arrival_margin_m) => ({ guidance: { phase: 'glide', site_id: 'f-r2', arrival_margin_m } });
  assert.deepEqual([41.7, 0, -1.3].map((margin_m) => guidanceText(link(margin_m), nameOf)),
    ['glide to site 2, arrives 41 m above the final', 'glide to site 2, arrives 0 m above the final', 'glide to site 2, arrives 2 m BELOW the final']);
});

test('links: sites in reach now, and what became of pictures', () => {
  const sites = [{ site_id: 'f-r2', verdict: 'landable', arrival_margin_m: 41.9 }, { site_id: 'f-r5', verdict: 'unverified', arrival_margin_m: 3 }];
  assert.deepEqual(alternatesOf({ is_connected: true, alternates: { sites, age_s: 3 } }, nameOf),
    [{ id: 'f-r2', text: '✓ site 2, +41 m' }, { id: 'f-r5', text: '? site 5, +3 m' }]);
  assert.deepEqual(linkRows({ is_connected: true, alternates: { sites: [], age_s: 3 } }, nameOf).find(([name]) => name === 'In reach now'), ['In reach now', 'NO SITE', true]);
  for (const [more, age_s] of [[{ is_connected: false }, 3], [{}, 16], [{ heard_age_s: 4 }, 12], [{}, undefined]]) {
    assert.equal(alternatesOf({ is_connected: true, alternates: { sites, age_s }, ...more }, nameOf), null);
  }
  assert.equal(picturesText({ pictures: { sent: 12, waiting: 3, unpaired: 1, refused: 0, incomplete: 0, text: 'it is not sure yet' } }),
    '12 sent, 3 waiting, 1 without a sure trigger, not sent. it is not sure yet');
  assert.equal(picturesText({}), null);
});

test('links: warnings before a landing: the verdict, another wind, no wind, a failed engine', () => {
  const p = { verdict: 'unverified', summary: 'Half of the circle is unseen.', wind: { east_mps: 3, north_mps: 0 }, altitude_datum: 'amsl', aircraft: { landing_airspeed_mps: 13 } };
  const link = sampleLink([8, 47]);
  const texts = landingWarnings(p, link, 60).join('\n');
  for (const text of [/UNVERIFIED: Half of the circle/, /The wind has changed/, /replaces the mission/]) assert.match(texts, text);
  assert.match(landingWarnings(p, { ...link, wind: undefined }, 60).join(), /wind is not known now/);
  assert.deepEqual([landingWind(link), landingWind({ wind: { ...link.wind, age_s: 61 } })], [{ east_mps: -3.1, north_mps: -1.2 }, null]);
  assert.match(landingWarnings(p, { ...link, ...sampleFailure('x') }, 60).join(), /engine has failed/);
  const calm = landingWarnings({ ...p, verdict: 'landable' }, { ...link, wind: { east_mps: 2.5, north_mps: 0, age_s: 1 } }, 60);
  assert.equal(calm.length, 1);
  assert.match(landingWarnings(p, link, NaN).join(), /When the ground was photographed is unknown/);
  assert.match(refusalText({ status: 403, message: 'no' }), /scope command/);
});

// --- The panel ---

async function open(t, options = {}, more = {}) {
  const links = { list: [sampleLink(site.place, more)], posts: [], token: 'pilot' };
  const server = await startStandIn(t, url, { hasEvents: true, obstacles: [], reach: null, newLook: null, links });
  const opened = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}`, ...options });
  opened.page.on('console', (message) => {
    if (message.type() === 'error' && !isOptional(message.location().url)) opened.seen.errors.push(message.text());
  });
  await opened.page.locator('#sites button').first().waitFor(kWait);
  await opened.page.locator('#open-links').waitFor(kWait);
  return { links, ...opened };
}

async function check({ page, seen }) {
  assert.deepEqual(await accessibilityFaults(page), []);
  assert.deepEqual(await smallTargets(page), []);
  assert.ok(await overflow_px(page) <= 0);
  assert.deepEqual(seen.errors, []);
}

for (const [name, options] of [['desktop', {}], ['desktop-dark', { colorScheme: 'dark' }], ['phone', phone], ['phone-dark', { ...phone, colorScheme: 'dark' }]]) {
  test(`links: state, aircraft on the map and decisions; a failure is announced, ${name}`, async (t) => {
    const opened = await open(t, options);
    const { page, links } = opened;
    assert.equal(await page.locator('#open-links').innerText(), 'Autopilots (1)');
    await page.locator('.link-sign:not(.stale)').waitFor(kWait);
    await page.locator('#open-links').click();
    const card = page.locator('[data-link="1"]');
    const text = await card.innerText();
    for (const part of [/AUTO, armed/, /heard \d s ago/, /from drift/, /running/, /the autopilot's own, item 4 of 9/, /armed/]) assert.match(text, part);
    assert.equal(await page.locator('#link-alarms p').count(), 0);
    await check(opened);
    Object.assign(links.list[0], sampleFailure(site.properties.id));
    await page.locator('#link-alarms p').first().waitFor(kWait);
    assert.match(await page.locator('#link-alarms').innerText(), /engine FAILED/);
    await page.locator('.link-target-name', { hasText: /^1 to site \d/ }).waitFor(kWait);
    assert.match(await card.innerText(), /glide to site \d, arrives 41 m above the final, 1 min left/);
    await shoot(page, `links-${name}`);
    await check(opened);
  });

  test(`links: "Land here" shows what will be flown, and is sent after a yes, ${name}`, async (t) => {
    const opened = await open(t, options);
    const { page, links } = opened;
    await page.evaluate(() => sessionStorage.setItem('freelsd.token', 'pilot'));
    await page.locator(`#sites [data-site="${site.properties.id}"]`).click();
    await page.locator('#site-land').click();
    const dialog = page.locator('#land');
    await dialog.getByText('Circle').waitFor(kWait);
    const text = await dialog.innerText();
    for (const part of [/Land at site \d/, /Circle\s+(left|right), radius \d+ m, down to \d+ m/, /Final\s+\d{3}°, \d+ m long, from \d+ m/, /Touchdown\s+\d+ m/, /Least clearance\s+-?\d+\.\d m/, /Planned for wind\s+3\.3 m\/s from 069°/, /replaces the mission/]) assert.match(text, part);
    await shoot(page, `land-here-${name}`);
    await check(opened);
    if (await page.locator('#land-checked-row').isVisible()) {
      assert.ok(await page.locator('#land-yes').isDisabled());
      await page.locator('#land-checked').check();
    }
    await page.locator('#land-yes').click();
    await page.waitForFunction(() => !document.getElementById('land').open, null, kWait);
    assert.deepEqual(links.posts, [['/v1/links/1/mission', { site_id: site.properties.id, wind: { east_mps: -3.1, north_mps: -1.2 } }]]);
    await page.locator('[data-link="1"]').getByText(/Land here \(site \d\): waits for the link/).waitFor(kWait);
    assert.deepEqual(opened.seen.errors, []);
  });
}

test('links: "Engine failed" and "Release" ask first; Keep sends nothing', async (t) => {
  const { page, links } = await open(t);
  await page.evaluate(() => sessionStorage.setItem('freelsd.token', 'pilot'));
  await page.locator('#open-links').click();
  const card = page.locator('[data-link="1"]');
  await card.getByRole('button', { name: 'Engine failed' }).click();
  assert.match(await page.locator('#confirm-text').innerText(), /takes control/);
  await page.locator('#confirm button[value=no]').click();
  assert.deepEqual(links.posts, []);
  for (const name of ['Engine failed', 'Release']) {
    await card.getByRole('button', { name }).click();
    await page.locator('#confirm-yes').click();
    await card.getByText(`${name}: waits for the link`).waitFor(kWait);
  }
  assert.deepEqual(links.posts.map(([path]) => path), ['/v1/links/1/engine-failure', '/v1/links/1/release']);
});

test('links: a token that may not command is refused in words, and the landing is not sent', async (t) => {
  const { page, links } = await open(t);
  await page.locator(`#sites [data-site="${site.properties.id}"]`).click();
  await page.locator('#site-land').click();
  await page.locator('#land').getByText('Circle').waitFor(kWait);
  if (await page.locator('#land-checked-row').isVisible()) await page.locator('#land-checked').check();
  await page.locator('#land-yes').click();
  await page.locator('#land-message').getByText('scope command').waitFor(kWait);
  assert.ok(await page.locator('#land').isVisible());
  assert.deepEqual(links.posts, []);
});

test('links: a site without a landing in the present wind, or whose wind is not known, says so', async (t) => {
  const { page, links } = await open(t, {}, { wind: { east_mps: 0, north_mps: 25, source: 'drift', age_s: 1 } });
  await page.locator(`#sites [data-site="${site.properties.id}"]`).click();
  await page.locator('#site-land').click();
  await page.locator('#land-verdict.rejected').waitFor(kWait);
  assert.ok(await page.locator('#land-yes').isDisabled());
  await page.locator('#land-cancel').click();
  delete links.list[0].wind;
  await page.waitForTimeout(1500);
  await page.locator('#site-land').click();
  await page.locator('#land-warnings').getByText('this is the stored plan').waitFor(kWait);
});

test('links: what is in reach now leads to its site, and the rest of the mission is told', async (t) => {
  const opened = await open(t, {}, {
    alternates: { sites: [{ site_id: site.properties.id, verdict: 'landable', arrival_margin_m: 41.9 }], num_in_reach: 1, age_s: 1 },
    insurance: { state: 'checked', covered_ratio: 0.9, time_s: 600, end: 'the landing', age_s: 2, num_gaps: 1, first_gap: { in_s: 0, lasts_s: 60, reason: 'too_low' } },
    pictures: { sent: 12, waiting: 0, unpaired: 2, refused: 0, incomplete: 0 },
  });
  const { page } = opened;
  await page.locator('#open-links').click();
  const card = page.locator('[data-link="1"]');
  assert.match(await card.innerText(), /NO SITE IN REACH NOW, for 1 min more \(too low\)[^]*12 sent, 2 without a sure trigger/);
  await check(opened);
  await card.getByRole('button', { name: '+41 m' }).click();
  await page.locator('#site-land').waitFor(kWait);
});

test('links: a silent link takes no command, its sign is old, and no other aircraft takes its place', async (t) => {
  const { page, links } = await open(t);
  links.list.push(sampleLink(site.place, { id: '2', system_id: 2 }));
  await page.locator(`#sites [data-site="${site.properties.id}"]`).click();
  await page.locator('#site-land').click();
  assert.equal(await page.locator('#land-link').inputValue(), '1');
  Object.assign(links.list[0], { is_connected: false, heard_age_s: 9 });
  await page.locator('#land-warnings').getByText('not heard any more').waitFor(kWait);
  assert.equal(await page.locator('#land-link').inputValue(), '1');
  assert.ok(await page.locator('#land-yes').isDisabled());
  await page.locator('#land-cancel').click();
  await page.locator('.link-sign.stale').waitFor(kWait);
  await page.getByRole('button', { name: 'All sites' }).first().click();
  await page.locator('#open-links').click();
  assert.ok(await page.locator('[data-link="1"]').getByRole('button', { name: 'Release' }).isDisabled());
  assert.ok(await page.locator('[data-link="2"]').getByRole('button', { name: 'Release' }).isEnabled());
});

test('links: a server without them leaves no trace', async (t) => {
  const server = await startStandIn(t, url, { hasEvents: true, obstacles: [], reach: null, newLook: null, links: null });
  const { page, seen } = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}` });
  await page.locator('#sites button').first().waitFor(kWait);
  assert.ok(!await page.locator('#open-links').isVisible());
  assert.ok(!server.asked.some((path) => String(path).startsWith('/v1/links')));
  assert.deepEqual(seen.errors, []);
});
