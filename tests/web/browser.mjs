// Starts Debian's Chromium and collects the faults of a page.

import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';

import { chromium } from 'playwright-core';

export const url = (process.env.FREELSD_URL ?? 'http://127.0.0.1:8080').replace(/\/$/, '');

export const launch = () => chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync'],
});

// Expected errors: a site without an approach (409), a server without events, a flight without a map, a place or a tile outside of it, no base map (404).
export const isOptional = (address) => /\/v1\/(events|base-map|flights\/[^/]+\/(map|why|landing))\b/.test(address);
const isExpected = (response) => response.status() === 409 || (response.status() === 404 && isOptional(response.url()));

// {page, seen}; the page closes after the test t. seen.errors lists all faults.
export async function openPage(t, browser, { width = 1280, height = 800, colorScheme = 'light', address = `${url}/` } = {}) {
  const context = await browser.newContext({
    viewport: { width, height }, colorScheme, reducedMotion: 'reduce', acceptDownloads: true,
  });
  t.after(() => context.close());
  const page = await context.newPage();
  const seen = { requests: [], errors: [] };
  page.on('request', (request) => seen.requests.push(request.url()));
  page.on('response', (response) => {
    if (response.status() >= 400 && !isExpected(response)) seen.errors.push(`${response.status()}: ${response.url()}`);
  });
  page.on('requestfailed', (request) => {
    // The page itself aborts a request when a newer one replaces it.
    if (request.failure()?.errorText !== 'net::ERR_ABORTED') seen.errors.push(`failed: ${request.url()}`);
  });
  page.on('pageerror', (error) => seen.errors.push(String(error)));
  await page.goto(address, { waitUntil: 'load' });
  return { page, seen };
}

export const outside = (seen, base) =>
  seen.requests.filter((request) => !request.startsWith(base) && !/^(data|blob):/.test(request));

const axeSource = await readFile(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

// Serious and critical findings of axe-core as text.
export async function accessibilityFaults(page) {
  await page.evaluate(axeSource);
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ['violations'] }));
  return violations.filter((v) => ['serious', 'critical'].includes(v.impact))
    .map((v) => `${v.id}: ${v.nodes.map((n) => n.target.join(' ')).slice(0, 4).join(', ')}`);
}

// Visible controls below 44 px.
export const smallTargets = (page) => page.evaluate(() =>
  [...document.querySelectorAll('button, select, summary, input:not([type=file]), .leaflet-bar a, .disc-marker')]
    .filter((node) => node.checkVisibility())
    .filter((node) => !node.matches('[type=checkbox]'))
    .map((node) => ({ node, box: node.getBoundingClientRect() }))
    .filter(({ box }) => box.width > 0 && (box.height < 43.5 || box.width < 43.5))
    .map(({ node, box }) => `${node.tagName} ${node.id || node.className} ${box.width.toFixed(0)} x ${box.height.toFixed(0)}`));

export async function getJson(path) {
  const response = await fetch(url + path);
  if (!response.ok) throw new Error(`${path}: ${response.status}`);
  return response.json();
}

// The newest flight that has a site with an approach, and that site.
export async function flownSite() {
  const { flights } = await getJson('/v1/flights');
  for (const flight of flights.reverse()) {
    const { features } = await getJson(`/v1/flights/${flight.id}/sites`);
    const feature = features.find(({ properties }) => properties.approach);
    if (feature) return { flight: flight.id, properties: feature.properties, place: feature.geometry.coordinates };
  }
  throw new Error('no flight of this server has a site with an approach');
}
