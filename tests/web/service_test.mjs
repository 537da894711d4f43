// The page against server behaviour: lost connections, tokens, events, emergency answers.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { Validator } from '@seriousme/openapi-schema-validator';

import { sentence } from '../../web/emergency_text.js';
import { age, distance, heading, margin } from '../../web/units.js';
import { accessibilityFaults, flownSite, getJson, launch, openPage, smallTargets, url } from './browser.mjs';
import { offset, sampleObstacles, sampleReach } from './sample_parts.mjs';
import { pictureIsDrawn } from './site_page.mjs';
import { startStandIn } from './stand_in.mjs';

const kWait = { timeout: 15000 };
const folder = process.env.FREELSD_SCREENSHOTS;
let browser;
let site;

before(async () => { [browser, site] = await Promise.all([launch(), flownSite()]); });
after(() => browser?.close());

// Small photographs with texture, drawn by the browser: [{name, mimeType, buffer}]
async function drawPhotographs(page, count) {
  const encoded = await page.evaluate(async (n) => Promise.all(Array.from({ length: n }, async (_, i) => {
    const canvas = new OffscreenCanvas(160, 120);
    const context = canvas.getContext('2d');
    for (let k = 0; k < 200; ++k) {
      context.fillStyle = `hsl(${(k * 47 + i * 11) % 360} 60% 50%)`;
      context.fillRect((k * 37) % 160, (k * 53) % 120, 12, 9);
    }
    const blob = await canvas.convertToBlob({ type: 'image/jpeg', quality: 0.9 });
    return [...new Uint8Array(await blob.arrayBuffer())];
  })), count);
  return encoded.map((bytes, i) => ({ name: `photo ${i + 1}.jpg`, mimeType: 'image/jpeg', buffer: Buffer.from(bytes) }));
}

function settings(photographs) {
  const rows = photographs.map(({ name }, i) => `${name},${47 + i * 1e-4},8,${600}`);
  const camera = { width_px: 160, height_px: 120, fx_px: 120, fy_px: 120, cx_px: 79.5, cy_px: 59.5 };
  return [
    { name: 'poses.csv', mimeType: 'text/csv', buffer: Buffer.from(['image,latitude_deg,longitude_deg,altitude_m', ...rows].join('\n')) },
    { name: 'flight.json', mimeType: 'application/json', buffer: Buffer.from(JSON.stringify({ name: 'x', camera })) },
  ];
}

test('contract: what the server serves is OpenAPI 3.1 by its own schema', async () => {
  const contract = await getJson('/openapi.json');
  assert.match(contract.openapi, /^3\.1\./);
  const { valid, errors } = await new Validator().validate(contract);
  assert.ok(valid, JSON.stringify(errors));
});

test('upload: survives a broken connection, shows each file, and sends nothing twice', async (t) => {
  const { page } = await openPage(t, browser);
  await page.locator('[data-tab="upload"]').click();
  const photographs = await drawPhotographs(page, 10);
  const name = `page test ${Date.now()}`;
  let numBatches = 0;
  await page.route('**/batch', (route) => (++numBatches === 2 ? route.abort('connectionreset') : route.continue()));
  await page.setInputFiles('#upload-files', [...photographs, ...settings(photographs)]);
  await page.fill('#upload-name', name);
  await page.uncheck('#upload-finish');
  await page.click('#upload-start');
  await page.getByText('10 of 10 photographs stored').waitFor(kWait);
  assert.equal(numBatches, 3, 'two requests, one of them twice');
  const flight = (await getJson('/v1/flights')).flights.find((f) => f.name === name);
  try {
    const { frames } = await getJson(`/v1/flights/${flight.id}/frames`);
    assert.deepEqual(frames.map((f) => f.id).sort(), photographs.map((p) => p.name.replace(' ', '_')).sort());
    assert.equal(await page.locator('.file-stored').count(), 10);
    await page.click('#upload-start');
    await page.waitForFunction(() => document.querySelectorAll('.file-kept').length === 10, null, kWait);
    assert.equal(numBatches, 3, 'nothing was sent again');
    assert.deepEqual(await smallTargets(page), []);
    assert.deepEqual(await accessibilityFaults(page), []);
  } finally {
    await page.goto('about:blank');
    await fetch(`${url}/v1/flights/${flight.id}?forget_sites=true`, { method: 'DELETE' });
  }
});

test('token: the page asks for it, keeps it out of curl, and gets pictures with it', async (t) => {
  const server = await startStandIn(t, url, { token: 'secret-7' });
  const { page } = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}` });
  await page.locator('#token-value').fill('wrong');
  await page.locator('#token-form button').click();
  await page.locator('#token-refused').waitFor(kWait);
  await page.locator('#token-value').fill('secret-7');
  await page.locator('#token-form button').click();
  await pictureIsDrawn(page, 'hazard');
  await page.evaluate(() => { navigator.clipboard.writeText = async (text) => { globalThis.copied = text; }; });
  await page.locator('#sites-curl button').click();
  const copied = await page.waitForFunction(() => globalThis.copied);
  assert.match(await copied.jsonValue(), /\$FREELSD_TOKEN/);
  assert.doesNotMatch(await copied.jsonValue(), /secret-7/);
});

test('events: the page refreshes on an event, or by polling if the server has no events', async (t) => {
  const server = await startStandIn(t, url, { hasEvents: true });
  const { page } = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}` });
  await page.locator('#transport', { hasText: 'live' }).waitFor(kWait);
  await page.locator('#sites button').first().waitFor(kWait);
  await page.waitForTimeout(600);
  const numLooks = () => server.asked.filter((path) => path === '/v1/flights').length;
  const before = numLooks();
  await page.waitForTimeout(2600);
  assert.equal(numLooks(), before, 'it does not ask while nothing happens');
  const look = page.waitForRequest((request) => request.url().endsWith('/v1/flights'), { timeout: 1500 });
  server.emit('site', { id: site.properties.id });
  await look;
  const mute = await startStandIn(t, url);
  const poor = await openPage(t, browser, { address: `${mute.url}/#flight=${site.flight}` });
  await poor.page.waitForRequest((request) => request.url().endsWith('/v1/flights'), { timeout: 6000 });
  assert.deepEqual(poor.seen.errors, []);
});

test('track: asked for once, and again only when more photographs are through', async (t) => {
  const server = await startStandIn(t, url);
  const { page } = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}` });
  await page.locator('path.track').waitFor({ state: 'attached', ...kWait });
  let numMore = 0;
  await page.route(`**/v1/flights/${site.flight}`, async (route) => {
    const response = await route.fetch();
    const json = await response.json();
    json.frames.processed += numMore;
    await route.fulfill({ response, json });
  });
  const numAsked = (end) => server.asked.filter((path) => typeof path === 'string' && path.endsWith(end)).length;
  const looks = async (count) => {
    const wanted = numAsked('/v1/jobs') + count;
    while (numAsked('/v1/jobs') < wanted) await page.waitForTimeout(100);
  };
  await looks(2);
  assert.equal(numAsked('/track'), 1, 'nothing came, nothing is asked');
  numMore = 1;
  await looks(2);
  assert.equal(numAsked('/track'), 2);
  await page.unrouteAll({ behavior: 'ignoreErrors' });
});

// The server's answer for this altitude. Answers to earlier inputs may still be on their way, and under load have fewer sites.
async function emergencyAnswer(page, altitude_m) {
  const isAsked = (address) => address.includes('/v1/emergency?') && Number(new URL(address).searchParams.get('altitude_m')) === altitude_m;
  const [response] = await Promise.all([
    page.waitForResponse((r) => isAsked(r.url()), kWait), page.locator('#em-altitude_m').fill(String(altitude_m))]);
  return response.json();
}

test('emergency: the page shows the sites that the server reports in reach', async (t) => {
  const { page, seen } = await openPage(t, browser, { address: `${url}/#flight=${site.flight}` });
  await page.locator('#sites button').first().waitFor(kWait);
  await page.locator('.bar [data-emergency]').click();
  const [lon, lat] = site.place;
  const { elevation_m, altitude_datum } = site.properties;
  await page.locator('#em-more summary').click();
  await page.locator('#em-latitude_deg').fill(String(lat));
  await page.locator('#em-longitude_deg').fill(String(lon));
  await page.selectOption('#em-altitude_datum', altitude_datum);
  const high = await emergencyAnswer(page, Math.round(elevation_m + 250));
  assert.ok(high.sites.length > 0, 'over the site, high enough, something is in reach');
  await page.locator('#em-message', { hasText: /^In reach/ }).waitFor(kWait);
  const cards = await page.locator('.em-card').allTextContents();
  assert.equal(cards.length, Math.min(3, high.sites.length));
  high.sites.slice(0, 3).forEach((reached, i) => {
    for (const part of [reached.verdict, heading(reached.bearing_deg), distance(reached.distance_m),
      heading(reached.approach.heading_deg), margin(reached.arrival_margin_m)]) {
      assert.ok(cards[i].includes(part), `${part} in ${cards[i]}`);
    }
  });
  assert.deepEqual(await page.locator('#em-warnings li').allTextContents(), high.warnings.map(sentence));
  // Below the site: no glide reaches the start of a final.
  const low = await emergencyAnswer(page, Math.round(elevation_m - 20));
  assert.deepEqual(low.sites, []);
  await page.getByText('No site in reach').waitFor(kWait);
  if (low.nearest_miss) {
    const missing = margin(low.nearest_miss.arrival_margin_m);
    assert.ok((await page.locator('.em-card').textContent()).includes(missing), missing);
  }
  assert.deepEqual(seen.errors, []);
});

const rad = (deg) => deg * Math.PI / 180;
const touchdownAt = ([longitude_deg, latitude_deg]) => ({ latitude_deg, longitude_deg, altitude_m: 450 });

// from: [lon, lat] of the aircraft, or nothing: then the touchdown is that of the site.
const inReach = (rank, verdict, distance_m, arrival_margin_m, from) => ({
  site_id: site.properties.id, flight_id: site.flight, rank, reachable: true, verdict, unseen_ratio: verdict === 'landable' ? 0 : 0.4,
  distance_m, bearing_deg: 41 * rank, arrival_margin_m, time_s: 65 * rank, score: 0.8, age_s: 86400 * rank,
  touchdown: touchdownAt(from ? offset(from, distance_m * Math.sin(rad(41 * rank)), distance_m * Math.cos(rad(41 * rank))) : site.place),
  approach: site.properties.approach,
});

test('emergency: three sites, big, with bearing, distance, heading and age', async (t) => {
  const { pose } = await getJson(`/v1/flights/${site.flight}/alternates`);
  const from = [pose.longitude_deg, pose.latitude_deg];
  const emergency = {
    sites: [inReach(1, 'landable', 840, 34, from), inReach(2, 'landable', 1260, 12, from), inReach(3, 'unverified', 2310, 5, from),
      inReach(4, 'unverified', 9000, 1, from)],
    warnings: ['the altitude’s datum is unknown'],
  };
  const server = await startStandIn(t, url, { emergency, reach: () => sampleReach(from, [], 2700), obstacles: sampleObstacles(offset(from, 900, -300)) });
  const { page } = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}` });
  await page.locator('#sites button').first().waitFor(kWait);
  await page.locator('.bar [data-emergency]').click();
  await page.locator('#em-altitude_m').fill('700');
  await page.locator('#em-message', { hasText: /^In reach/ }).waitFor(kWait);
  assert.equal(await page.locator('.em-card').count(), 3);
  const first = await page.locator('.em-card').first().textContent();
  assert.match(first, /^ASite A/, 'a number would be read as the rank on the map behind, which is another site');
  assert.deepEqual(await page.locator('#em-map .disc-marker').allTextContents(), ['✈', 'A', 'B', 'C']);
  for (const part of ['041°', '840 m', '+34 m', '1:05', '1 d ago']) assert.ok(first.includes(part), `${part} in ${first}`);
  const asked = server.asked.filter((entry) => entry instanceof URLSearchParams).at(-1);
  assert.equal(asked.get('altitude_m'), '700');
  assert.equal(asked.get('limit'), '3');
  await page.locator('#em-map path.reach').waitFor({ state: 'attached', ...kWait });
  if (folder) await page.screenshot({ path: `${folder}/emergency.jpg`, type: 'jpeg', quality: 65 });
  assert.deepEqual(await smallTargets(page), []);
  assert.deepEqual(await accessibilityFaults(page), []);
  await page.setViewportSize({ width: 360, height: 740 });
  if (folder) await page.screenshot({ path: `${folder}/emergency-phone.jpg`, type: 'jpeg', quality: 65 });
  const tooWide = await page.evaluate(() => document.getElementById('emergency').scrollWidth - document.getElementById('emergency').clientWidth);
  assert.ok(tooWide <= 0, `${tooWide} px too wide`);
  await page.locator('.em-card button').first().click();
  await page.locator('#view-site:not([hidden]) #profile canvas').waitFor(kWait);
});

test('emergency: without an altitude the page shows the nearest sites as unchecked', async (t) => {
  const { page, seen } = await openPage(t, browser, { address: `${url}/#flight=${site.flight}` });
  await page.locator('#sites button').first().waitFor(kWait);
  await page.locator('.bar [data-emergency]').click();
  await page.locator('#em-source', { hasText: /^Position and altitude of flight/ }).waitFor(kWait);
  await page.locator('#em-altitude_m').fill('');
  await page.getByText('Enter altitude to check reach. Sites below are unchecked.').waitFor(kWait);
  assert.equal(await page.locator('.em-card .chip').first().textContent(), 'reach unchecked');
  await page.locator('#em-more summary').click();
  await page.locator('#em-latitude_deg').fill('');
  await page.getByText('Enter your position.').waitFor(kWait);
  assert.deepEqual(seen.errors, []);
});

test('emergency: position and altitude are those of the selected flight, and say so', async (t) => {
  const { page, seen } = await openPage(t, browser, { address: `${url}/#flight=${site.flight}` });
  await page.locator('#sites button').first().waitFor(kWait);
  const { pose } = await getJson(`/v1/flights/${site.flight}/alternates`);
  await page.keyboard.press('e');
  await page.locator('#em-source', { hasText: /^Position and altitude of flight .*, \d+ \w+ old\. (Wind of the same flight, \d+ \w+ old(: it may have changed)?|Wind unknown(: the last one is \d+ \w+ old)?)\. Heading/ }).waitFor(kWait);
  assert.equal(await page.locator('#em-altitude_m').inputValue(), pose.altitude_m.toFixed(0));
  assert.equal(await page.locator('#em-latitude_deg').inputValue(), pose.latitude_deg.toFixed(6));
  // What is entered is not overwritten, and gone after a reload.
  await page.locator('#em-altitude_m').fill('4321');
  await page.locator('#em-message', { hasText: /4321|reach/i }).waitFor(kWait);
  await page.waitForTimeout(5500);
  assert.equal(await page.locator('#em-altitude_m').inputValue(), '4321');
  assert.match(await page.locator('#em-source').textContent(), /^Values as entered\. Position of flight .* at /, 'no age that stands still');
  await page.locator('#em-more summary').click();
  await page.locator('#em-flight').click();
  await page.locator('#em-source', { hasText: /^Position and altitude of flight/ }).waitFor(kWait);
  assert.equal(await page.locator('#em-altitude_m').inputValue(), pose.altitude_m.toFixed(0), 'the flight is followed again');
  await page.locator('#em-altitude_m').fill('4321');
  await page.reload();
  await page.locator('#sites button').first().waitFor(kWait);
  await page.keyboard.press('e');
  await page.locator('#em-source', { hasText: /^Position and altitude of flight/ }).waitFor(kWait);
  assert.equal(await page.locator('#em-altitude_m').inputValue(), pose.altitude_m.toFixed(0));
  assert.deepEqual(seen.errors, []);
});

test('emergency: on a phone the altitude is in sight when the dialog opens, prefilled or not', async (t) => {
  const small = { width: 360, height: 640 };
  for (const hash of [`#flight=${site.flight}`, '']) {
    const { page } = await openPage(t, browser, { address: `${url}/${hash}`, ...small });
    await page.locator('[data-emergency]').locator('visible=true').first().click();
    if (hash) await page.locator('#em-source', { hasText: /^Position and altitude of flight/ }).waitFor(kWait);
    await page.locator('#em-message:not(:empty)').waitFor(kWait);
    const box = await page.locator('#em-altitude_m').boundingBox();
    assert.ok(box.y >= 0 && box.y + box.height < small.height, `the altitude stands at ${box.y} px`);
    if (folder) await page.screenshot({ path: `${folder}/emergency-360${hash ? '-prefilled' : ''}.jpg`, type: 'jpeg', quality: 65 });
  }
});

test('emergency: a live flight fills position, heading and wind, with their ages; a silent one is marked', async (t) => {
  const made = await fetch(`${url}/v1/flights`, { method: 'POST', body: JSON.stringify({ name: 'Live one', altitude_datum: 'amsl' }) });
  const { id } = await made.json();
  t.after(() => fetch(`${url}/v1/flights/${id}`, { method: 'DELETE' }));
  const [lon, lat] = site.place;
  let sent = 0;
  const begin_us = (Date.now() - 30000) * 1000;
  const sendFour = () => {
    const lines = Array.from({ length: 4 }, () => sent++).map((i) => JSON.stringify({
      timestamp_us: begin_us + i * 250000, wind: { east_mps: 3, north_mps: 0 },
      position: { latitude_deg: lat, longitude_deg: lon - 0.01 + i * 0.0002, altitude_m: 900 } })).join('\n');
    return fetch(`${url}/v1/flights/${id}/telemetry`, { method: 'POST', body: lines });
  };
  const { page, seen } = await openPage(t, browser, { address: `${url}/#flight=${id}` });
  await page.locator('#flight option:checked', { hasText: 'Live one' }).waitFor({ state: 'attached', ...kWait });
  assert.equal((await (await sendFour()).json()).accepted, 4);
  // A course counts for three seconds only, and a busy browser may take longer to ask.
  const flying = setInterval(sendFour, 1000);
  t.after(() => clearInterval(flying));
  await page.keyboard.press('e');
  await page.locator('#em-source', { hasText: /^Position and altitude of flight Live one, \d s old\. Wind of the same flight, \d s old\. Heading from its track\.$/ }).waitFor(kWait);
  for (const [name, value] of [['altitude_m', '900'], ['heading_deg', '90'], ['wind_speed_mps', '3.0'], ['wind_from_deg', '270']]) {
    assert.equal(await page.locator(`#em-${name}`).inputValue(), value, name);
  }
  // It is silent from now on: it may have turned.
  clearInterval(flying);
  await page.locator('#em-source', { hasText: /Heading unknown\.$/ }).waitFor(kWait);
  assert.equal(await page.locator('#em-heading_deg').inputValue(), '');
  assert.deepEqual(seen.errors, []);
});

test('emergency: a site has one age everywhere, since its ground was photographed', async (t) => {
  const { page } = await openPage(t, browser, { address: `${url}/#flight=${site.flight}` });
  await page.locator('#sites button').first().waitFor(kWait);
  await page.locator('.bar [data-emergency]').click();
  await page.locator('#em-more summary').click();
  const [lon, lat] = site.place;
  await page.locator('#em-latitude_deg').fill(String(lat));
  await page.locator('#em-longitude_deg').fill(String(lon));
  await page.selectOption('#em-altitude_datum', site.properties.altitude_datum);
  await page.locator('#em-altitude_m').fill('');
  await page.locator('.em-card .chip').first().waitFor(kWait);
  const aged = (text) => /Photographed(\d+ \w+) ago/.exec(text)?.[1];
  const unchecked = aged(await page.locator('.em-card').first().textContent());
  const answer = await emergencyAnswer(page, Math.round(site.properties.elevation_m + 250));
  await page.locator('#em-message', { hasText: /^In reach/ }).waitFor(kWait);
  const expected = age((Date.now() - Date.parse(site.properties.last_seen_at)) / 1000);
  assert.equal(unchecked, expected);
  const index = answer.sites.findIndex(({ site_id }) => site_id === site.properties.id);
  assert.ok(index >= 0, 'the site is in reach');
  assert.equal(aged(await page.locator('.em-card').nth(index).textContent()), expected);
  await page.locator('.em-card button').nth(index).click();
  await page.locator('#view-site:not([hidden]) #profile canvas').waitFor(kWait);
  assert.ok((await page.locator('#site-more').textContent()).includes(`Ground photographed${expected} ago`));
});

test('emergency: the map shows the plan of the answer, not the stored one', async (t) => {
  const { page, seen } = await openPage(t, browser, { address: `${url}/#flight=${site.flight}` });
  await page.locator('#sites button').first().waitFor(kWait);
  await page.locator('.bar [data-emergency]').click();
  const [lon, lat] = site.place;
  await page.locator('#em-more summary').click();
  await page.locator('#em-latitude_deg').fill(String(lat));
  await page.locator('#em-longitude_deg').fill(String(lon));
  await page.selectOption('#em-altitude_datum', site.properties.altitude_datum);
  await page.locator('#em-wind_speed_mps').fill('4');
  await page.locator('#em-wind_from_deg').fill('200');
  const answer = await emergencyAnswer(page, Math.round(site.properties.elevation_m + 300));
  assert.ok(answer.sites.length > 0, 'something is in reach');
  await page.locator('#em-message', { hasText: /^In reach/ }).waitFor(kWait);
  const planned = page.waitForRequest((r) => r.url().includes('/approach?wind_east_mps='), kWait);
  await page.locator('.em-card button').first().click();
  const drawn = await getJson((await planned).url().slice(url.length));
  const [best] = answer.sites;
  for (const name of ['heading_deg', 'distance_m', 'height_m', 'loiter_radius_m']) {
    assert.equal(drawn.plan.approach[name], best.approach[name], name);
  }
  await page.locator('#wind-source', { hasText: 'Wind of the emergency answer' }).waitFor(kWait);
  await page.locator('#site-tiles', { hasText: heading(best.approach.heading_deg) }).waitFor(kWait);
  assert.deepEqual(seen.errors, []);
});

test('emergency: a late answer does not replace a newer one', async (t) => {
  const late_ms = 700;
  const server = await startStandIn(t, url, {
    emergency: { sites: [inReach(1, 'landable', 840, 34)], warnings: [] }, sitesAfter_ms: late_ms });
  const { page } = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}` });
  await page.locator('.bar [data-emergency]').click();
  await page.locator('#em-altitude_m').fill('700');
  await page.locator('#em-message', { hasText: /^In reach/ }).waitFor(kWait);
  await page.waitForTimeout(2 * late_ms);
  assert.match(await page.locator('#em-message').textContent(), /In reach/);
  assert.match(await page.locator('.em-card').first().textContent(), /840 m/);
});

test('emergency: without a site in reach the page shows the closest miss', async (t) => {
  const server = await startStandIn(t, url, { emergency: {
    sites: [], nearest_miss: { ...inReach(1, 'landable', 5000, -42), reachable: false }, warnings: [] } });
  const { page } = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}` });
  await page.locator('.bar [data-emergency]').click();
  await page.locator('#em-altitude_m').fill('500');
  await page.getByText('No site in reach').waitFor(kWait);
  assert.match(await page.locator('.em-card').textContent(), /−42 m/);
});

test('emergency: without a reach computation the page shows the nearest sites as unchecked', async (t) => {
  const server = await startStandIn(t, url, {});
  const { page } = await openPage(t, browser, { address: `${server.url}/#flight=${site.flight}` });
  await page.locator('#sites button').first().waitFor(kWait);
  await page.locator('.bar [data-emergency]').click();
  await page.locator('#em-altitude_m').fill('700');
  await page.getByText('cannot check reach').waitFor(kWait);
  assert.ok(await page.locator('.em-card').count() > 0);
  assert.equal(await page.locator('.em-card .chip').first().textContent(), 'reach unchecked');
});
