// The only file that sends requests to the server. Names and units are those of the JSON.

import { withWholeShapes } from './antimeridian.js';

export class Problem extends Error {
  constructor(status, body, retryAfter_s) {
    super(body.detail ?? body.title ?? `the server returned status ${status}`);
    this.status = status;
    this.code = body.code;
    this.errors = body.errors ?? [];
    this.retryAfter_s = retryAfter_s;
  }
}

// --- Token: in sessionStorage (this tab), or in localStorage (this device) if the user asks for it ---

const tokenKey = 'freelsd.token';
export const token = () => sessionStorage.getItem(tokenKey) ?? localStorage.getItem(tokenKey);
export function setToken(value, isKept) {
  sessionStorage.removeItem(tokenKey);
  localStorage.removeItem(tokenKey);
  if (value) (isKept ? localStorage : sessionStorage).setItem(tokenKey, value);
}
const authorization = () => (token() ? { Authorization: `Bearer ${token()}` } : {});

// The listener runs on every 401 response.
let onUnauthorized = () => {};
export function whenUnauthorized(listener) { onUnauthorized = listener; }

function problemOf(status, text, retryAfter) {
  let body = {};
  try { body = JSON.parse(text); } catch { body = { detail: text.slice(0, 200) || undefined }; }
  if (status === 401) onUnauthorized();
  return new Problem(status, body, Number(retryAfter) || null);
}

export async function call(path, { method = 'GET', headers = {}, body, signal, cache = 'no-store' } = {}) {
  const response = await fetch(path, {
    method, body, signal, headers: { ...authorization(), ...headers }, cache,
  });
  if (!response.ok) {
    throw problemOf(response.status, await response.text(), response.headers.get('Retry-After'));
  }
  return response;
}

// Others compute for long, and as many as may wait do so: asks again when the server says.
const maxNumRefused = 5;
async function callInTurn(path, options) {
  for (let numRefused = 1; ; ++numRefused) {
    try {
      return await call(path, options);
    } catch (problem) {
      if (problem.status !== 429 || numRefused > maxNumRefused) throw problem;
      await new Promise((resolve) => { setTimeout(resolve, 1000 * (problem.retryAfter_s ?? 1)); });
    }
  }
}

const getJson = async (path, options) => withWholeShapes(
  await (await callInTurn(path, { ...options, headers: { Accept: 'application/json, application/geo+json' } })).json());

// --- Paths, also used by the curl buttons ---

const part = encodeURIComponent;
export function query(values) {
  const known = Object.entries(values).filter(([, v]) => v !== null && v !== undefined && v !== '');
  return known.length ? `?${known.map(([k, v]) => `${k}=${part(v)}`).join('&')}` : '';
}

function windQuery(wind) {
  if (!wind) return {};
  if (wind === 'unknown') return { wind };
  return { wind_east_mps: wind.east_mps.toFixed(3), wind_north_mps: wind.north_mps.toFixed(3) };
}

export const paths = {
  jobs: '/v1/jobs',
  flight: (flight) => `/v1/flights/${part(flight)}`,
  map: (flight) => `/v1/flights/${part(flight)}/map`,
  mapFile: (flight, layer, ending) => `/v1/flights/${part(flight)}/map/${part(layer)}.${ending}`,
  // What the planner says about any place of the flight's map, and the best landing there.
  flightWhy: (flight, place, wind, aircraft = {}) =>
    `/v1/flights/${part(flight)}/why${query({ ...place, ...windQuery(wind), ...aircraft })}`,
  landing: (flight, place, wind, aircraft = {}) =>
    `/v1/flights/${part(flight)}/landing${query({ ...place, ...windQuery(wind), ...aircraft })}`,
  baseMap: '/v1/base-map',
  track: (flight) => `/v1/flights/${part(flight)}/track`,
  regions: (flight) => `/v1/flights/${part(flight)}/regions`,
  history: (flight, region) => `/v1/flights/${part(flight)}/regions/${part(region)}/history`,
  frames: (flight) => `/v1/flights/${part(flight)}/frames`,
  batch: (flight) => `/v1/flights/${part(flight)}/batch`,
  finish: (flight) => `/v1/flights/${part(flight)}/finish`,
  flightSites: (flight) => `/v1/flights/${part(flight)}/sites`,
  site: (site) => `/v1/sites/${part(site)}`,
  // wind: 'unknown', a wind, or nothing for the site's own; aircraft: fields that differ from the site's.
  approach: (site, wind, aircraft = {}) => `/v1/sites/${part(site)}/approach${query({ ...windQuery(wind), ...aircraft })}`,
  why: (site, place, wind, aircraft = {}) =>
    `/v1/sites/${part(site)}/why${query({ ...place, ...windQuery(wind), ...aircraft })}`,
  alternates: (flight) => `/v1/flights/${part(flight)}/alternates`,
  windRose: (site, speeds_mps) => `/v1/sites/${part(site)}/wind-rose?speeds_mps=${speeds_mps.join(',')}`,
  layers: (site) => `/v1/sites/${part(site)}/layers`,
  layerPicture: (site, layer) => `/v1/sites/${part(site)}/layers/${part(layer)}.png`,
  layerTiff: (site, layer) => `/v1/sites/${part(site)}/layers/${part(layer)}.tif`,
  legend: (site, layer) => `/v1/sites/${part(site)}/layers/${part(layer)}/legend.png`,
  emergency: (request) => `/v1/emergency${query(request)}`,
  events: (flight) => `/v1/events${query({ flight })}`,
  reach: (request) => `/v1/reach${query(request)}`,
  obstacles: (bbox) => `/v1/obstacles${query({ bbox })}`,
  obstacle: (id) => `/v1/obstacles/${part(id)}`,
  routeCheck: '/v1/routes/check',
  // options: {legs, f, home_altitude_m}
  nextLook: (flight, options) => `/v1/flights/${part(flight)}/next-look${query(options)}`,
  links: '/v1/links',
  notices: '/v1/notices',
  link: (link, command) => `/v1/links/${part(link)}/${command}`,
  newLook: (limit) => `/v1/sites${query({ order: 'new_look', limit })}`,
};

// --- Reading ---

export const getInfo = () => getJson('/v1/info');
export const listFlights = async () => (await getJson('/v1/flights')).flights;
export const listJobs = async () => (await getJson(paths.jobs)).jobs;
export const getFlight = (flight) => getJson(paths.flight(flight));
export const getTrack = (flight) => getJson(paths.track(flight));
export const getRegions = (flight) => getJson(paths.regions(flight));
export const getSites = (flight) => getJson(paths.flightSites(flight));
export const getSitesIn = (bbox, signal) => getJson(`/v1/sites${query({ bbox })}`, { signal });
export const getAllSites = (limit) => getJson(`/v1/sites${query({ limit })}`);
export const getSite = (site) => getJson(paths.site(site));
export const getHistory = async (flight, region) => (await getJson(paths.history(flight, region))).history;
export const getFrames = async (flight) => (await getJson(paths.frames(flight))).frames;
export const getLayers = async (site) => (await getJson(paths.layers(site))).layers;
export const getAlternates = (flight, signal) => getJson(paths.alternates(flight), { signal });
export const getEmergency = (request, signal) => getJson(paths.emergency(request), { signal });

export const getReach = (request, signal) => getJson(paths.reach(request), { signal });
export const getObstacles = (bbox, signal) => getJson(paths.obstacles(bbox), { signal });
export const getNewLook = (limit) => getJson(paths.newLook(limit));
// path: of paths.nextLook.
export const getNextLook = (path, signal) => getJson(path, { signal });
export const getLinks = async () => (await getJson(paths.links)).links;
export const getOpenApi = () => getJson('/openapi.json');

export const getWindRose = (site, speeds_mps, signal) => getJson(paths.windRose(site, speeds_mps), { signal });

// {[name]: answer}, or {refusal} if the server answers 409, or that no map shows the place.
async function getUnlessRefused(name, path, signal) {
  try {
    return { [name]: await getJson(path, { signal }) };
  } catch (error) {
    if (error.status === 409 || error.code === 'NoMap') return { refusal: error.message };
    throw error;
  }
}

// {collection}, or {refusal} if the site has no approach for this wind.
export const getApproach = (site, wind, signal, aircraft) =>
  getUnlessRefused('collection', paths.approach(site, wind, aircraft), signal);
// {collection}, or {refusal} if there is no landing near the place. path: of paths.landing.
export const getLanding = (path, signal) => getUnlessRefused('collection', path, signal);
// {judgement}, or {refusal} if there is no map. path: of paths.why or paths.flightWhy.
export const getWhy = (path, signal) => getUnlessRefused('judgement', path, signal);

// The answer, or null where the server has none (404).
async function getIfThere(path, options) {
  try {
    return await getJson(path, options);
  } catch (error) {
    if (error.status === 404) return null;
    throw error;
  }
}

// {layers: TileJSON of each, updated_at}; null while the flight has no map.
export const getMap = (flight) => getIfThere(paths.map(flight));
// TileJSON; null if the user installed no base map.
export const getBaseMap = () => getIfThere(paths.baseMap);

// {blob, etag}, or null where the map has no tile. The browser keeps tiles and asks whether they changed.
export async function getTile(path, signal) {
  try {
    const response = await call(path, { signal, cache: 'no-cache' });
    const blob = await response.blob();
    return blob.size > 0 ? { blob, etag: response.headers.get('ETag') } : null;
  } catch (error) {
    if (error.status === 404) return null;
    throw error;
  }
}

export const getBlob = async (path, signal) => (await callInTurn(path, { signal })).blob();

// {blob, name}; the name comes from Content-Disposition.
export async function getFile(path, fallbackName) {
  const response = await callInTurn(path, {});
  const named = /filename="?([^";]+)"?/.exec(response.headers.get('Content-Disposition') ?? '');
  const blob = await response.blob();
  if (blob.size === 0) throw new Problem(response.status, { detail: 'the server sent an empty file' });
  return { blob, name: named?.[1] ?? fallbackName };
}

// --- Writing ---

const postJson = async (path, object, signal) => (await call(path, {
  method: 'POST', body: JSON.stringify(object), signal, headers: { 'Content-Type': 'application/json' },
})).json();
// wind: what the confirmed approach is planned for, or null.
export const landAt = (link, site_id, wind) => postJson(paths.link(link, 'mission'), wind ? { site_id, wind } : { site_id });
export const declareEngineFailure = (link) => postJson(paths.link(link, 'engine-failure'), {});
export const getNotices = async () => (await getJson(paths.notices)).notices;
export const releaseLink = (link) => postJson(paths.link(link, 'release'), {});
export const acknowledgeNotice = (id) => postJson(`${paths.notices}/${part(id)}/acknowledge`, {});
export const createFlight = (request) => postJson('/v1/flights', request);
export const checkRoute = (request, signal) => postJson(paths.routeCheck, request, signal);
export const finishFlight = async (flight) => (await call(paths.finish(flight), { method: 'POST' })).json();
export const putObstacle = (id, feature) => call(paths.obstacle(id), {
  method: 'PUT', body: JSON.stringify(feature), headers: { 'Content-Type': 'application/geo+json' },
});
export const deleteObstacle = (id) => call(paths.obstacle(id), { method: 'DELETE' });
export const cancelJob = (job) => call(`/v1/jobs/${part(job)}`, { method: 'DELETE' });

// XMLHttpRequest, because fetch reports no upload progress.
export function send(path, body, { contentType, onProgress, signal }) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open('POST', path);
    for (const [name, value] of Object.entries(authorization())) request.setRequestHeader(name, value);
    if (contentType) request.setRequestHeader('Content-Type', contentType);
    request.upload.onprogress = (event) => onProgress(event.loaded);
    request.onload = () => {
      if (request.status < 300) resolve(JSON.parse(request.responseText));
      else {
        reject(problemOf(request.status, request.responseText, request.getResponseHeader('Retry-After')));
      }
    };
    request.onerror = () => reject(new TypeError('connection lost'));
    request.onabort = () => reject(new DOMException('stopped', 'AbortError'));
    signal?.addEventListener('abort', () => request.abort());
    request.send(body);
  });
}
