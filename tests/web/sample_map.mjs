// A sample of a flight's map around a place [lon, lat]: fields, trees, a road, seen from above. Tiles are painted when they are asked
// for. What is `grown` shows how much of the map exists, west first.

import { createHash } from 'node:crypto';
import { crc32, deflateSync } from 'node:zlib';

const kTile = 256;
const kMinZoom = 14;
const kMaxZoom = 20;
const metresPerDegree = 111195;

function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type), data]);
  const frame = Buffer.alloc(8);
  frame.writeUInt32BE(data.length, 0);
  frame.writeUInt32BE(crc32(body), 4);
  return Buffer.concat([frame.subarray(0, 4), body, frame.subarray(4)]);
}

// rgba(x, y): [r, g, b, a] of a pixel.
export function png(width, height, rgba) {
  const rows = Buffer.alloc(height * (4 * width + 1));
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) rows.set(rgba(x, y), y * (4 * width + 1) + 1 + 4 * x);
  }
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 6, 0, 0, 0], 8);
  return Buffer.concat([Buffer.from('89504e470d0a1a0a', 'hex'), chunk('IHDR', head), chunk('IDAT', deflateSync(rows, { level: 1 })),
    chunk('IEND', Buffer.alloc(0))]);
}

// 0 to 1, the same for the same two integers.
function noise(i, k) {
  let h = Math.imul(i, 374761393) + Math.imul(k, 668265263) | 0;
  h = Math.imul(h ^ (h >>> 13), 1274126177);
  return ((h ^ (h >>> 16)) >>> 0) / 4294967296;
}

const isTree = (east, north) => {
  const [i, k] = [Math.floor(east / 11), Math.floor(north / 11)];
  return noise(i, k) > 0.965 && Math.hypot(east - 11 * i - 5.5, north - 11 * k - 5.5) < 4.5;
};
const isRoad = (east, north) => Math.abs(north - 0.18 * east + 70) < 4;
const field = (east, north) => [Math.floor((east + 900) / 130), Math.floor((north + 900) / 90)];

function photoColor(east, north) {
  const grain = 26 * (noise(Math.floor(2 * east), Math.floor(2 * north)) - 0.5);
  const kind = noise(...field(east, north));
  const base = isTree(east, north) ? [34, 58, 30] : isRoad(east, north) ? [214, 208, 196]
    : kind < 0.2 ? [226, 214, 168] : kind < 0.4 ? [122, 98, 70] : [96 + 60 * kind, 138 + 30 * kind, 64];
  return [...base.map((value) => Math.max(0, Math.min(255, value + grain))), 255];
}

const ramp = (share) => [Math.round(255 * share), Math.round(90 + 120 * share), Math.round(160 - 130 * share), 255];
const isUnseen = (east, north) => noise(Math.floor(east / 60) + 500, Math.floor(north / 60)) > 0.94;

function dataColor(name, east, north) {
  const unseen = isUnseen(east, north);
  if (name === 'hazard') return unseen ? [26, 26, 26, 255] : isTree(east, north) || isRoad(east, north) ? [200, 70, 0, 255] : [126, 211, 150, 255];
  return unseen ? [0, 0, 0, 0] : ramp(0.5 + 0.5 * Math.sin(east / 90) * Math.cos(north / 70));
}

const units = { photo: '', hazard: 'class', elevation: 'm', slope: 'deg', roughness: 'm', grass: 'class', distance: 'm', height_sd: 'm', coverage: 'photographs', risk: 'probability' };

// The tile as PNG, or null outside. half_m: half the side of the map; grown: 0 to 1.
function tile(name, { place, half_m, grown }, [z, x, y]) {
  const scale = kTile * 2 ** z;
  const toEast = metresPerDegree * Math.cos(place[1] * Math.PI / 180);
  const eastOf = (px) => ((x * kTile + px + 0.5) / scale * 360 - 180 - place[0]) * toEast;
  const northOf = (py) => (180 / Math.PI * Math.atan(Math.sinh(Math.PI * (1 - 2 * (y * kTile + py + 0.5) / scale))) - place[1]) * metresPerDegree;
  const last_m = -half_m + 2 * half_m * grown;
  if (eastOf(0) > last_m || eastOf(kTile) < -half_m || northOf(kTile) > half_m || northOf(0) < -half_m) return null;
  return png(kTile, kTile, (px, py) => {
    const [east, north] = [eastOf(px), northOf(py)];
    if (east > last_m || east < -half_m || Math.abs(north) > half_m) return [0, 0, 0, 0];
    return name === 'photo' ? photoColor(east, north) : dataColor(name, east, north);
  });
}

// map: {place, half_m, grown, version}; grown and version may change while the page runs.
export function sampleTileJson(base, flight, map) {
  const { place: [lon, lat], half_m, grown, version } = map;
  const toEast = metresPerDegree * Math.cos(lat * Math.PI / 180);
  const bounds = [lon - half_m / toEast, lat - half_m / metresPerDegree, lon + half_m * (2 * grown - 1) / toEast, lat + half_m / metresPerDegree];
  const root = `${base}/v1/flights/${flight}/map`;
  return {
    layers: Object.entries(units).map(([name, unit]) => ({
      tilejson: '3.0.0', tiles: [`${root}/${name}/{z}/{x}/{y}.png`], name, unit, min: 0, max: 12, legend: `${root}/${name}/legend.png`,
      geotiff: `${root}/${name}.tif`, bounds, minzoom: kMinZoom, maxzoom: kMaxZoom })),
    updated_at: new Date(1764000000000 + 1000 * version).toISOString(),
  };
}

// Answers GET of the map and its files. Returns whether the path is one of them. tiles: {asked: [{path, status}]}.
// map.failing: a pattern of paths that fail; map.delay_ms: until a tile is answered.
export function playMap(request, response, path, { map, base, tiles }) {
  const [, flight, rest] = /^\/v1\/flights\/([^/]+)\/map(\/.*)?$/.exec(path) ?? [];
  if (!flight) return false;
  if (!rest) {
    if (!map.isThere) return false;
    response.writeHead(200, { 'Content-Type': 'application/json' });
    response.end(JSON.stringify(sampleTileJson(base, flight, map)));
    return true;
  }
  playFile(request, response, rest, { map, tiles, path });
  return true;
}

async function playFile(request, response, rest, { map, tiles, path }) {
  const [, name, ...zxy] = /^\/(\w+)\/(\d+)\/(\d+)\/(\d+)\.png$/.exec(rest) ?? [];
  if (name) await new Promise((resolve) => { setTimeout(resolve, map.delay_ms ?? 0); });
  const isFile = /\.(tif|kmz)$/.test(rest);
  const body = name ? tile(name, map, zxy.map(Number)) : isFile ? Buffer.from('a file') : png(280, 24, (px) => ramp(px / 280));
  const etag = body && `"${createHash('sha1').update(body).digest('hex').slice(0, 12)}"`;
  const status = map.failing?.test(path) ? 503 : body === null ? 404 : request.headers['if-none-match'] === etag ? 304 : 200;
  if (name) tiles.asked.push({ path, status });
  const type = status >= 400 ? 'application/problem+json' : isFile ? 'application/octet-stream' : 'image/png';
  response.writeHead(status, { 'Content-Type': type, ...(etag ? { ETag: etag } : {}), 'Cache-Control': 'private, max-age=0' });
  response.end(status === 200 ? body : status >= 400 ? '{"detail":"no tile"}' : undefined);
}

const square = ([lon, lat], east_m, north_m, side_m) => {
  const at = (east, north) => [lon + east / metresPerDegree / Math.cos(lat * Math.PI / 180), lat + north / metresPerDegree];
  return { type: 'Polygon', coordinates: [[at(east_m, north_m), at(east_m + side_m, north_m), at(east_m + side_m, north_m + side_m),
    at(east_m, north_m + side_m), at(east_m, north_m)]] };
};

// A job that tells what it does.
export const sampleJob = (flight, place) => ({
  id: 'j-map', kind: 'finish', state: 'running', progress: 0.42, stage: 'stereo', stage_title: 'Measuring the ground', flight_id: flight,
  summary: 'Measuring the shape of the ground from 14 pairs of photographs in the north-east.', time_left_s: 95, area: square(place, 30, 0, 70),
});

export const sampleWhy = {
  verdict: 'rejected', first_failed: 'slope',
  rules: [{ rule: 'seen', passed: true, sentence: 'The ground is seen in 9 photographs.' },
    { rule: 'slope', passed: false, sentence: 'The slope is 11.2°; at most 8° is allowed.' },
    { rule: 'grass', passed: true, sentence: 'The ground is grass.' }],
  evidence: { height_m: 460.2, height_sd_m: 0.12, grass_probability: 0.93 }, warnings: [],
};
