// A proxy in front of a real server. It simulates a token, events, emergency answers, and parts of the API that the
// server may lack.

import http from 'node:http';

import { playLinks } from './sample_links.mjs';
import { playMap } from './sample_map.mjs';
import { samplePatch } from './sample_proof.mjs';

const kGeoJson = { 'Content-Type': 'application/geo+json' };

function answer(response, status, body, headers = { 'Content-Type': 'application/json' }) {
  response.writeHead(status, status >= 400 ? { 'Content-Type': 'application/problem+json' } : headers);
  response.end(body === undefined ? undefined : JSON.stringify(body));
}

const problem = (status, detail, errors = []) =>
  ({ type: 'about:blank', title: 'Refused', status, code: status === 404 ? 'NotFound' : 'Invalid', detail, errors, retryable: false });

async function bodyOf(request) {
  let text = '';
  for await (const chunk of request) text += chunk;
  return text;
}

// The API description with and without the optional parts.
function described(contract, { reach, obstacles, newLook, map, baseMap, landing, route, legs, links, notices }) {
  const set = (path, part) => {
    if (part === null) delete contract.paths[path];
    else if (part !== undefined) contract.paths[path] ??= { get: {} };
  };
  set('/v1/reach', reach);
  set('/v1/obstacles', obstacles);
  set('/v1/links', links);
  set('/v1/notices', notices);
  for (const name of ['map', 'why']) set(`/v1/flights/{flight}/${name}`, map);
  set('/v1/flights/{flight}/landing', landing);
  set('/v1/base-map', baseMap);
  set('/v1/routes/check', route);
  set('/v1/flights/{flight}/next-look', legs);
  const list = contract.paths['/v1/sites'].get;
  if (newLook !== undefined) list.parameters = list.parameters.filter(({ name }) => name !== 'order');
  if (newLook) list.parameters.push({ name: 'order', in: 'query' });
  return contract;
}

// GET, PUT and DELETE of obstacles in memory. A mast higher than 999 m is refused.
async function playObstacles(request, response, path, obstacles) {
  const id = decodeURIComponent(path.split('/')[3] ?? '');
  const index = obstacles.findIndex((obstacle) => obstacle.id === id);
  if (request.method === 'GET') return answer(response, 200, { type: 'FeatureCollection', features: obstacles }, kGeoJson);
  if (request.method === 'DELETE') {
    if (index >= 0) obstacles.splice(index, 1);
    return answer(response, index >= 0 ? 204 : 404, index >= 0 ? undefined : problem(404, 'no such obstacle'));
  }
  const feature = JSON.parse(await bodyOf(request));
  if (feature.properties.height_m > 999) {
    return answer(response, 422, problem(422, 'height_m = 1200: must be at most 1000',
      [{ pointer: '/properties/height_m', detail: 'must be at most 1000' }]));
  }
  feature.id = id;
  if (index >= 0) obstacles.splice(index, 1, feature);
  else obstacles.push(feature);
  return answer(response, index >= 0 ? 200 : 201, feature, kGeoJson);
}

// Closes after the test t. emergency: the answer of /v1/emergency or a function that gives it, null for 404, or 'real' for that of the server. reach (a function of the query's
// parameters), obstacles (an array of features), newLook (a collection), map (see sample_map.mjs; also `why`, and `lost`: frames without a photograph), landing (a collection, or a
// text: the refusal), route (a function of the request's body; throws a text: the refusal), links (see sample_links.mjs), legs (a function of the query's parameters of
// next-look; throws {status, code, detail}: the refusal), alternates and notices (functions: an answer, an array), baseMap (a TileJSON), outside (the origin of a base map elsewhere): undefined passes the request on, null is a
// server without this part. rewrite(path, json): changes an answer of the real server.
export async function startStandIn(t, target, {
  token = null, hasEvents = false, emergency = null, sitesAfter_ms = 0, rewrite = null, ...parts
} = {}) {
  const state = { streams: new Set(), asked: [], numReach: 0, mostReach: 0, tiles: { asked: [] }, routes: [], looks: [], patches: [] };
  const to = new URL(target);

  async function playReach(request, response) {
    state.mostReach = Math.max(state.mostReach, ++state.numReach);
    await new Promise((resolve) => { setTimeout(resolve, 200); });
    --state.numReach;
    answer(response, 200, parts.reach(new URL(request.url, target).searchParams), kGeoJson);
  }

  // Why and landing of the flight's map; its tiles; the base map, whose tiles are those of the photograph.
  function playGround(request, response, path) {
    const { map, landing, baseMap } = parts;
    const base = `http://${request.headers.host}`;
    if (path === '/v1/base-map' && baseMap !== undefined) {
      const tiles = [`${base}/v1/flights/base/map/photo/{z}/{x}/{y}.png`];
      answer(response, baseMap ? 200 : 404, baseMap ? { tilejson: '3.0.0', tiles, ...baseMap } : problem(404, 'no base map'));
      return true;
    }
    if (/^\/v1\/flights\/[^/]+\/landing$/.test(path) && landing) {
      if (typeof landing === 'string') answer(response, 409, problem(409, landing));
      else answer(response, 200, landing, kGeoJson);
      return true;
    }
    if (/^\/v1\/flights\/[^/]+\/why$/.test(path) && map) {
      answer(response, map.why ? 200 : 404, map.why ?? { ...problem(404, 'no map of the flight shows this place'), code: 'NoMap' });
      return true;
    }
    const [, frame] = /\/frames\/([^/]+)\/patch\.png$/.exec(path) ?? [];
    if (frame && map) {
      state.patches.push(request.url);
      if (map.lost?.includes(frame)) answer(response, 404, { ...problem(404, 'the flight has no photograph of this frame'), code: 'NoSuchFrame' });
      else response.writeHead(200, { 'Content-Type': 'image/png' }).end(samplePatch(frame));
      return true;
    }
    if (map && playMap(request, response, path, { map, base, tiles: state.tiles })) return true;
    if (/^\/v1\/flights\/[^/]+\/map$/.test(path) && map !== undefined) {
      answer(response, 404, problem(404, 'no map yet'));
      return true;
    }
    return false;
  }

  async function playRoute(request, response) {
    const body = JSON.parse(await bodyOf(request));
    state.routes.push(body);
    try {
      answer(response, 200, parts.route(body));
    } catch (refusal) {
      answer(response, 422, problem(422, refusal));
    }
  }

  async function playLegs(request, response) {
    const parameters = new URL(request.url, target).searchParams;
    state.looks.push(Object.fromEntries(parameters));
    await new Promise((resolve) => { setTimeout(resolve, 300); });
    try {
      answer(response, 200, parts.legs(parameters), kGeoJson);
    } catch ({ status, ...refusal }) {
      answer(response, status, { ...problem(status, ''), ...refusal });
    }
  }

  // Returns whether the optional part answered.
  function playPart(request, response, path) {
    if (playGround(request, response, path)) return true;
    if (path.endsWith('/next-look') && parts.legs) {
      playLegs(request, response);
      return true;
    }
    const isNewLook = path === '/v1/sites' && request.url.includes('order=new_look');
    const part = path.startsWith('/v1/links') ? parts.links : path === '/v1/reach' ? parts.reach : path.startsWith('/v1/obstacles') ? parts.obstacles
      : path === '/v1/routes/check' ? parts.route : isNewLook ? parts.newLook : undefined;
    if (part === undefined) return false;
    if (part === null) answer(response, 404, problem(404, 'nothing here'));
    else if (part === parts.reach) playReach(request, response);
    else if (part === parts.route) playRoute(request, response);
    else if (part === parts.links) playLinks(request, response, path, part);
    else if (part === parts.obstacles) playObstacles(request, response, path, part);
    else answer(response, 200, part, kGeoJson);
    return true;
  }

  function play(request, response) {
    const path = request.url.split('?')[0];
    if (token && path.startsWith('/v1/') && request.headers.authorization !== `Bearer ${token}`) {
      response.writeHead(401, { 'Content-Type': 'application/problem+json', 'WWW-Authenticate': 'Bearer' });
      response.end(JSON.stringify({ type: 'about:blank', title: 'Unauthorized', status: 401, code: 'Unauthorized',
        detail: 'a token is needed', errors: [], retryable: false }));
      return true;
    }
    if (path === '/v1/events' && hasEvents) {
      response.writeHead(200, { 'Content-Type': 'text/event-stream' });
      response.write(': hello\n\n');
      state.streams.add(response);
      response.on('close', () => state.streams.delete(response));
      return true;
    }
    if (path === '/v1/events') {
      answer(response, 404, problem(404, 'no events here'));
      return true;
    }
    if (/^\/v1\/flights\/[^/]+\/alternates$/.test(path) && parts.alternates) {
      answer(response, 200, parts.alternates());
      return true;
    }
    if (path === '/v1/notices' && parts.notices) {
      answer(response, 200, { notices: parts.notices() });
      return true;
    }
    if (path === '/v1/emergency' && emergency !== 'real') {
      state.asked.push(new URL(request.url, target).searchParams);
      const played = typeof emergency === 'function' ? emergency() : emergency;
      answer(response, played ? 200 : 404, played ?? problem(404, 'nothing here'));
      return true;
    }
    return playPart(request, response, path);
  }

  async function passOn(asked, request, response) {
    const path = request.url.split('?')[0];
    const isDescription = path === '/openapi.json';
    const isJson = /json/.test(asked.headers['content-type'] ?? '') && asked.statusCode === 200;
    if (!isJson || !(isDescription || rewrite)) {
      const headers = { ...asked.headers };
      const policy = headers['content-security-policy'];
      if (policy && parts.outside) headers['content-security-policy'] = policy.replace('blob:', `blob: ${parts.outside}`);
      response.writeHead(asked.statusCode, headers);
      asked.pipe(response);
      return;
    }
    const json = JSON.parse(await bodyOf(asked));
    const changed = isDescription ? described(json, parts) : rewrite(path, json) ?? json;
    answer(response, 200, changed, { 'Content-Type': asked.headers['content-type'] });
  }

  const server = http.createServer(async (request, response) => {
    state.asked.push(request.url);
    if (play(request, response)) return;
    if (/^\/v1\/sites(\?|$)/.test(request.url)) await new Promise((resolve) => { setTimeout(resolve, sitesAfter_ms); });
    const headers = { ...request.headers, host: to.host };
    delete headers.origin;
    delete headers.authorization;
    const asked = http.request({ host: to.hostname, port: to.port, path: request.url, method: request.method, headers },
      (found) => passOn(found, request, response)).on('error', () => response.destroy());
    response.on('close', () => asked.destroy());
    request.pipe(asked);
  });
  await new Promise((resolve) => { server.listen(0, '127.0.0.1', resolve); });
  t.after(() => {
    server.close();
    server.closeAllConnections();
  });
  return {
    url: `http://127.0.0.1:${server.address().port}`,
    asked: state.asked,
    mostReach: () => state.mostReach,
    tiles: state.tiles,
    routes: state.routes,
    looks: state.looks,
    patches: state.patches,
    emit(event, data) {
      for (const stream of state.streams) stream.write(`event: ${event}\ndata: ${JSON.stringify(data)}\n\n`);
    },
  };
}
