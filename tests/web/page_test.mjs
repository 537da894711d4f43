// Loads the page of a running server with a finished flight, clicks a site, and checks that what
// belongs to it is drawn and that no request left the machine.
// Run: node page_test.mjs http://127.0.0.1:8080 [picture.png]

import assert from 'node:assert/strict';
import test from 'node:test';

import { chromium } from 'playwright-core';

const url = process.env.FREELSD_URL ?? 'http://127.0.0.1:8080';
const picture = process.env.FREELSD_PICTURE;

async function openPage() {
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
      '--disable-background-networking', '--disable-component-update', '--disable-sync'],
  });
  const page = await browser.newPage({ viewport: { width: 1280, height: 860 } });
  const seen = { requests: [], errors: [] };
  page.on('request', (request) => seen.requests.push(request.url()));
  page.on('requestfailed', (request) => {
    // The page gives up a picture itself when another layer is chosen before it has come.
    if (request.failure()?.errorText === 'net::ERR_ABORTED') return;
    seen.errors.push(`failed: ${request.url()}`);
  });
  page.on('response', (response) => {
    // A site without approach answers 409: that is an answer, not a fault.
    if (response.status() >= 400 && response.status() !== 409) {
      seen.errors.push(`${response.status()}: ${response.url()}`);
    }
  });
  page.on('pageerror', (error) => seen.errors.push(String(error)));
  return { browser, page, seen };
}

const siteWithApproach = async () => {
  const { flights } = await (await fetch(`${url}/v1/flights`)).json();
  assert.ok(flights.length > 0, 'the server has no flight');
  const sites = await (await fetch(`${url}/v1/flights/${flights.at(-1).id}/sites`)).json();
  const feature = sites.features.find((f) => f.properties.approach);
  assert.ok(feature, 'the last flight has no site with an approach');
  return feature.properties;
};

test('page: a chosen site shows its layer, approach, circle and profile, all from this machine', async () => {
  const site = await siteWithApproach();
  const { browser, page, seen } = await openPage();
  try {
    await page.goto(url, { waitUntil: 'load' });
    const button = page.locator(`#sites button[data-site="${site.id}"]`);
    await button.waitFor({ timeout: 10000 });
    assert.ok((await page.locator('path.region').count()) > 0, 'regions are drawn');
    assert.ok((await page.locator('.rank-marker').count()) > 0, 'sites are drawn');
    await button.click();
    await page.locator('path.approach').waitFor({ state: 'attached', timeout: 10000 });
    await page.locator('path.loiter').waitFor({ state: 'attached' });
    await page.locator('path.touchdown').waitFor({ state: 'attached' });
    await page.waitForFunction(() => {
      const image = document.querySelector('img.site-layer');
      return image && image.complete && image.naturalWidth > 10;
    });
    await page.locator('#profile canvas').waitFor();
    const painted = await page.evaluate(() => {
      const canvas = document.querySelector('#profile canvas');
      const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      let red = 0;
      for (let i = 0; i < data.length; i += 4) {
        if (data[i] > 180 && data[i + 1] < 80 && data[i + 2] < 90 && data[i + 3] > 128) ++red;
      }
      return red;
    });
    assert.ok(painted > 50, `the path is plotted (${painted} red pixels)`);
    for (const name of await page.locator('#layer option').evaluateAll((all) => all.map((o) => o.value))) {
      await page.selectOption('#layer', name);
      await page.waitForFunction((layer) => {
        const image = document.querySelector('img.site-layer');
        return image && image.src.includes(`/layers/${layer}.png`) && image.complete && image.naturalWidth > 10;
      }, name);
    }
    await page.selectOption('#layer', 'hazard');
    await page.waitForTimeout(500);
    if (picture) await page.screenshot({ path: picture });
    assert.match(await page.locator('#site-title').textContent(), new RegExp(site.verdict));
    const outside = seen.requests.filter((r) => !r.startsWith(url) && !/^(data|blob):/.test(r));
    assert.deepEqual(outside, [], 'no request left the machine');
    assert.deepEqual(seen.errors, [], 'no request or script failed');
  } finally {
    await browser.close();
  }
});

test('page: a phone 360 px wide shows the list without sideways scrolling', async () => {
  const { browser, page, seen } = await openPage();
  try {
    await page.setViewportSize({ width: 360, height: 740 });
    await page.goto(url, { waitUntil: 'load' });
    await page.locator('#sites button').first().waitFor({ timeout: 10000 });
    const overflow = await page.evaluate(
      () => document.documentElement.scrollWidth - document.documentElement.clientWidth);
    assert.ok(overflow <= 0, `the page is ${overflow} px too wide`);
    assert.deepEqual(seen.errors, []);
  } finally {
    await browser.close();
  }
});
