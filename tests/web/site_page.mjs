// Steps on the page of one site that several tests share.

import assert from 'node:assert/strict';
import { mkdir } from 'node:fs/promises';

export const kWait = { timeout: 15000 };
const folder = process.env.FREELSD_SCREENSHOTS;

export const shoot = async (page, name) => {
  if (!folder) return;
  await mkdir(folder, { recursive: true });
  await page.screenshot({ path: `${folder}/${name}.jpg`, type: 'jpeg', quality: 65 });
};

// A layer: tiles of the flight's map, or else the picture of the selected site.
export const pictureIsDrawn = (page, layer) => page.waitForFunction((name) =>
  [...document.querySelectorAll('img.site-layer, .data-tiles img.leaflet-tile-loaded[src]')].some((image) =>
    image.closest('[data-layer]').dataset.layer === name && image.complete && image.naturalWidth > 10), layer, kWait);

// Clicks the map at an offset, in pixels, from the selected site.
export async function clickPlace(page, [lon, lat], [right, down]) {
  const marker = page.locator(`.disc-marker.chosen`);
  const box = await marker.boundingBox();
  assert.ok(box, `the marker at ${lat}, ${lon} is drawn`);
  await page.mouse.click(box.x + box.width / 2 + right, box.y + box.height / 2 + down);
}

// Runs in the page: at the server a request that the page gave up is still open for a while.
export function countTilesAtOnce() {
  const { fetch } = globalThis;
  globalThis.tileRequests = { now: 0, most: 0 };
  globalThis.fetch = async (request, ...more) => {
    if (!/\/\d+\/\d+\/\d+\.png/.test(request.url ?? request)) return fetch(request, ...more);
    tileRequests.most = Math.max(tileRequests.most, ++tileRequests.now);
    try { return await fetch(request, ...more); } finally { --tileRequests.now; }
  };
}
