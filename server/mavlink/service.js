// The only file that sends requests to freelsd-server.

import { withWholeLines } from './antimeridian.js';

const longest_ms = 20_000;
// A command must not wait behind an answer that does not come.
const linkTimeout_ms = 3000;
// A plan for another wind may take its time.
const landingTimeout_ms = 8000;
// In the air a late answer is none.
const emergencyTimeout_ms = 2500;
const pictureTimeout_ms = 60_000;
const routeTimeout_ms = 60_000;

export class ServiceProblem extends Error {
  constructor(status, body) {
    super(body.detail ?? body.title ?? `the service returned status ${status}`);
    this.status = status;
    this.code = body.code;
  }
}

async function problemOf(response) {
  const text = await response.text();
  try {
    return new ServiceProblem(response.status, JSON.parse(text));
  } catch {
    return new ServiceProblem(response.status, {});
  }
}

export class Service {
  #url;
  #headers;

  constructor(url, token) {
    this.#url = new URL(url);
    if (!/^https?:$/.test(this.#url.protocol)) throw new Error(`--url ${url}: must be http or https`);
    this.#headers = token ? { Authorization: `Bearer ${token}` } : {};
  }

  // request: what else the flight is created with.
  async createFlight(name, request) {
    const flight = await this.#post('v1/flights', { altitude_datum: 'amsl', ...request, name });
    return flight.id;
  }

  // A creation whose answer was lost must not be repeated. Names carry a time, so they are unique.
  async flightNamed(name) {
    const { flights } = await this.#json('v1/flights?limit=100');
    return flights.find((flight) => flight.name === name)?.id;
  }

  // { accepted, rejected: [{ line, detail }] }
  sendTelemetry(flightId, lines) {
    return this.#json(`v1/flights/${encodeURIComponent(flightId)}/telemetry`, {
      method: 'POST',
      headers: { 'Content-Type': 'application/x-ndjson' },
      body: lines.map((line) => `${JSON.stringify(line)}\n`).join(''),
    });
  }

  // meta: as FrameMeta. Repeating it changes nothing.
  putFrame(flightId, frameId, jpeg, meta) {
    const body = new FormData();
    body.append('image', new Blob([jpeg], { type: 'image/jpeg' }), 'image.jpg');
    body.append('meta', JSON.stringify(meta));
    return this.#json(`v1/flights/${encodeURIComponent(flightId)}/frames/${encodeURIComponent(frameId)}`,
      { method: 'PUT', body, timeout_ms: pictureTimeout_ms });
  }

  // The landing insurance of a route: answer of /v1/routes/check.
  checkRoute(request) { return this.#post('v1/routes/check', request, routeTimeout_ms); }

  // The sites in reach now, as the service keeps them for the flight.
  alternates(flightId) {
    return this.#json(`v1/flights/${encodeURIComponent(flightId)}/alternates`, { timeout_ms: linkTimeout_ms });
  }

  // { commands: [{ id, kind, site_id?, issued_at }] }
  putLink(linkId, state) {
    return this.#json(`v1/links/${encodeURIComponent(linkId)}`, {
      method: 'PUT',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify(state),
      timeout_ms: linkTimeout_ms,
    });
  }

  // Query and answer of /v1/emergency.
  async emergency(query, limit_ms = emergencyTimeout_ms) {
    return withWholeLines(await this.#json(`v1/emergency?${new URLSearchParams(query)}`, { timeout_ms: limit_ms }));
  }

  // A site as a GeoJSON feature.
  site(siteId) {
    return this.#json(`v1/sites/${encodeURIComponent(siteId)}`, { timeout_ms: linkTimeout_ms });
  }

  // Path of a site, planned for a wind if it is known.
  async approach(siteId, wind) {
    const query = wind ? `?${new URLSearchParams({ wind_east_mps: wind.east_mps, wind_north_mps: wind.north_mps })}` : '';
    return withWholeLines(await this.#json(`v1/sites/${encodeURIComponent(siteId)}/approach${query}`, { timeout_ms: landingTimeout_ms }));
  }

  #post(path, value, timeout_ms = longest_ms) {
    return this.#json(path, {
      method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(value), timeout_ms });
  }

  async #json(path, { headers = {}, timeout_ms = longest_ms, ...options } = {}) {
    const base = this.#url.href.endsWith('/') ? this.#url : new URL(`${this.#url.href}/`);
    const response = await fetch(new URL(path, base), {
      signal: AbortSignal.timeout(timeout_ms),
      ...options,
      headers: { ...this.#headers, ...headers },
      redirect: 'error',
    });
    if (!response.ok) throw await problemOf(response);
    return response.json();
  }
}
