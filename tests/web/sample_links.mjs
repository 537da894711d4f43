// Links to autopilots, and a server that has them.

const ago = (seconds) => new Date(Date.now() - 1000 * seconds).toISOString();

// place: [lon, lat]. more: what differs.
export const sampleLink = ([longitude_deg, latitude_deg], more = {}) => ({
  id: '1', run: 'r1', system_id: 1, is_connected: true, age_s: 0.4, heard_age_s: 0.3, type: 'fixed wing', autopilot: 'ArduPilot',
  mode: 'AUTO', is_armed: true, is_signed: true,
  position: { latitude_deg, longitude_deg, altitude_m: 561.2, altitude_datum: 'amsl', height_above_home_m: 131.2 },
  wind: { east_mps: -3.1, north_mps: -1.2, sd_mps: 0.4, source: 'drift', age_s: 2 },
  engine: { state: 'running' }, mission: { state: 'current', kind: 'other', current_item: 4, num_items: 9 },
  log: [{ id: 1, at: ago(300), kind: 'link', text: 'system 1 is heard at 127.0.0.1:14555' }, { id: 2, at: ago(280), kind: 'link', text: 'armed' }],
  commands: [], ...more,
});

// What an engine failure adds.
export const sampleFailure = (siteId) => ({
  engine: { state: 'failed', since: ago(4), reason: 'climb and speed do not follow the throttle' },
  guidance: { phase: 'glide', site_id: siteId, arrival_margin_m: 41.7, told_margin_m: 44.0, eta_s: 73, since: ago(3), text: '' },
  mission: { state: 'unknown', alarm: 'the mission that was read back differs from the one that was sent' },
});

// links: {list, posts: the commands that were sent, token: the one that may command}
export async function playLinks(request, response, path, links) {
  const json = (status, body) => response.writeHead(status, { 'Content-Type': status < 400 ? 'application/json' : 'application/problem+json' })
    .end(JSON.stringify(body));
  if (request.method === 'GET') return json(200, { links: links.list });
  let text = '';
  for await (const chunk of request) text += chunk;
  if (request.headers.authorization !== `Bearer ${links.token}`) {
    return json(403, { title: 'Refused', status: 403, code: 'Forbidden', detail: "the token's scopes do not allow this", errors: [] });
  }
  links.posts.push([path, JSON.parse(text)]);
  const kind = { mission: 'mission', 'engine-failure': 'engine_failure', release: 'release' }[path.split('/').at(-1)];
  const command = { id: `c-${links.posts.length}`, kind, site_id: JSON.parse(text).site_id, issued_at: ago(0), state: 'queued' };
  links.list.find(({ id }) => id === path.split('/')[3]).commands.push(command);
  return json(202, { command });
}
