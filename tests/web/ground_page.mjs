// The page over a sample map of the flight, in front of a running server that holds a finished flight; see page_test.mjs.

import { isOptional, openPage, url } from './browser.mjs';
import { sampleWhy } from './sample_map.mjs';
import { countTilesAtOnce, kWait } from './site_page.mjs';
import { startStandIn } from './stand_in.mjs';

export const groundSample = (site, more = {}) => ({ place: site.place, half_m: 320, grown: 1, version: 1, isThere: true, why: sampleWhy, ...more });

// parts: of the stand-in, and the token of the page.
export async function openGround(t, { browser, site }, parts, options = {}) {
  const map = parts.map === undefined ? groundSample(site) : parts.map;
  const server = await startStandIn(t, url, { reach: null, obstacles: null, newLook: null, baseMap: null, landing: null, hasEvents: true, ...parts, map });
  const opened = await openPage(t, browser, { address: 'about:blank', ...options });
  await opened.page.addInitScript(countTilesAtOnce);
  if (parts.token) await opened.page.addInitScript((value) => sessionStorage.setItem('freelsd.token', value), parts.token);
  opened.page.on('console', (message) => {
    if (message.type() === 'error' && !isOptional(message.location().url)) opened.seen.errors.push(message.text());
  });
  await opened.page.goto(`${server.url}/#flight=${site.flight}`);
  await opened.page.locator('#sites button').first().waitFor(kWait);
  return { server, map, ...opened };
}

export const tilesOf = (page, kind) => page.locator(`.${kind}-tiles img.leaflet-tile-loaded[src]`);
export async function groundIsDrawn(page, layer = 'hazard') {
  await tilesOf(page, 'photo').first().waitFor(kWait);
  if (layer) await page.locator(`.data-tiles[data-layer="${layer}"] img.leaflet-tile-loaded[src]`).first().waitFor(kWait);
  await page.waitForFunction(() => document.getElementById('layer-note').textContent === '', null, kWait);
}
export const overflow_px = (page) => page.evaluate(() => Math.max(document.documentElement.scrollWidth - innerWidth,
  document.getElementById('panel').scrollWidth - document.getElementById('panel').clientWidth));
export const mapPoint = async (page, right, down) => {
  const box = await page.locator('#map').boundingBox();
  return [box.x + right * box.width, box.y + down * box.height];
};
export const clickMap = async (page, right, down) => page.mouse.click(...await mapPoint(page, right, down));
