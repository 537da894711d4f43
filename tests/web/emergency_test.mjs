// The emergency view in ten situations, read as a pilot reads it: no sentence excludes another, each colour and sign says what
// the words say. In front of a running server that holds a finished flight; see page_test.mjs.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { accessibilityFaults, flownSite, launch, openPage, url } from './browser.mjs';
import { contradictions, jsonKeys, readAloud } from './one_voice.mjs';
import { sampleEmergencies } from './sample_emergencies.mjs';
import { offset, sampleReach } from './sample_parts.mjs';
import { kWait, shoot } from './site_page.mjs';
import { startStandIn } from './stand_in.mjs';

let browser;
let site;
let situations;

before(async () => {
  site = await flownSite();
  browser = await launch();
  situations = sampleEmergencies(site, offset(site.place, -900, -500));
});
after(() => browser?.close());

const reachOf = ({ alternates: { pose }, answer }) => sampleReach([pose.longitude_deg, pose.latitude_deg],
  answer.sites.map(({ site_id: id, touchdown, arrival_margin_m }) =>
    ({ id, place: [touchdown.longitude_deg, touchdown.latitude_deg], arrival_margin_m })), answer.sites.length > 0 ? 1800 : 500);

// show(situation) opens the view in it.
async function openEmergency(t) {
  let now = situations[0];
  const server = await startStandIn(t, url, { emergency: () => now.answer, alternates: () => now.alternates, notices: () => now.notices ?? [],
    obstacles: null, newLook: null, baseMap: null, links: null, reach: () => reachOf(now) });
  const { page, seen } = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}` });
  await page.locator('#sites button').first().waitFor(kWait);
  return { server, page, seen, async show(situation) {
    now = situation;
    if (await page.locator('#em-close').isVisible()) await page.locator('#em-close').click();
    await page.locator('.bar [data-emergency]').click();
    await page.waitForFunction((sources) => {
      const text = document.getElementById('emergency').innerText.replace(/\s+/g, ' ');
      return sources.every((source) => new RegExp(source, 'i').test(text));
    }, situation.reads.map(({ source }) => source), kWait);
    // The reach of the former situation is gone.
    const kinds = [...situation.answer.sites, situation.answer.nearest_miss].filter(Boolean).length;
    await page.waitForFunction((count) => document.querySelectorAll('#em-map .arrival').length === count, kinds, kWait);
    await page.locator('#em-map path.reach').first().waitFor({ state: 'attached', ...kWait });
  } };
}

test('emergency: in each of ten situations the view says one thing, at 1280 and 360 px', async (t) => {
  const { page, seen, show } = await openEmergency(t);
  for (const situation of situations) {
    await page.setViewportSize({ width: 1280, height: 800 });
    await show(situation);
    for (const [width, height] of [[1280, 800], [360, 740]]) {
      await page.setViewportSize({ width, height });
      const { view, faults } = await readAloud(page);
      await shoot(page, `emergency-${situation.name.replaceAll(' ', '-')}-${width}`);
      assert.deepEqual(faults, [], `${situation.name} at ${width} px: ${view.all}`);
      for (const words of situation.reads) assert.match(view.all, words, situation.name);
    }
  }
  assert.deepEqual(await accessibilityFaults(page), []);
  assert.deepEqual(seen.errors, []);
});

test('emergency: the wind, heading and datum of a flight are asked for with their ages, what is entered is of now', async (t) => {
  const { server, page, show } = await openEmergency(t);
  await show(situations.find(({ name }) => name === 'old wind'));
  const last = () => Object.fromEntries(server.asked.filter((entry) => entry instanceof URLSearchParams).at(-1));
  const unaged = ['wind_east_mps', 'wind_north_mps', 'heading_deg', 'altitude_datum'];
  assert.deepEqual(unaged.filter((name) => name in last()), [], 'the server would take them for values of now');
  assert.equal(last().flight, site.flight);
  const asked = page.waitForRequest(/\/v1\/emergency\?.*wind_east_mps/, kWait);
  await page.locator('#em-wind_speed_mps').fill('4');
  await page.locator('#em-wind_from_deg').fill('250');
  assert.ok(!(await asked).url().includes('heading_deg'));
  await page.locator('#em-source', { hasText: 'Wind as entered.' }).waitFor(kWait);
  // Another place has another heading, wind and altitude.
  await page.locator('#em-more summary').click();
  await page.locator('#em-center').click();
  await page.locator('#em-message', { hasText: 'Enter altitude' }).waitFor(kWait);
  assert.equal(await page.locator('#em-heading_deg').inputValue(), '');
  assert.equal(await page.locator('#em-wind_speed_mps').inputValue(), '4', 'what was entered stays');
});

test('emergency: the real answers of a server name no key and do not contradict themselves', async () => {
  const [longitude_deg, latitude_deg] = site.place;
  const { elevation_m, altitude_datum } = site.properties;
  const asked = [
    { altitude_m: elevation_m + 250, altitude_datum, heading_deg: 40, wind_east_mps: 2, wind_north_mps: 1 },
    { altitude_m: elevation_m + 250 }, { altitude_m: elevation_m + 60, altitude_datum }, { altitude_m: elevation_m - 20 },
    { altitude_m: elevation_m + 400, wind_east_mps: 40, wind_north_mps: 0 },
  ];
  for (const more of asked) {
    const query = new URLSearchParams({ latitude_deg, longitude_deg, limit: 20, ...more });
    const answer = await (await fetch(`${url}/v1/emergency?${query}`)).json();
    for (const told of [...answer.sites, answer.nearest_miss ?? { reachable: undefined, warnings: [] }]) {
      const text = [answer.summary, ...answer.warnings, told.sentence ?? '', ...told.warnings].join('\n');
      assert.deepEqual([...contradictions(text), ...jsonKeys(text)], [], text);
      if (told.reachable) assert.ok(told.arrival_margin_m >= 0 && !(told.surplus_height_m > 2), JSON.stringify(told));
    }
  }
});

test('the checker finds each of the contradictions that were seen', () => {
  for (const text of ['no site is stored nearby. 1 stored site nearby has no approach', '18 m of height are missing. 20 m of surplus height',
    'No height of the ground is known here. Map: ground at 271.3 m', 'is subtracted there (datum_penalty_m, terrain_datum_penalty_m)']) {
    assert.ok(contradictions(text).length > 0, text);
  }
});
