// What the service tells of a link, and commands, between a recording and a real service that wants tokens.

import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import test from 'node:test';

import { isReady, path, setUp, skip, sleep, until } from './processes.js';
import { replay } from './replay.js';
import { readTlog } from './tlog.js';

const as = (token) => ({ Authorization: `Bearer ${token}` });

async function withTokens(t) {
  const setup = await setUp(t);
  const scopes = { link: ['read', 'ingest'], pilot: ['read', 'command'], reader: ['read'] };
  const tokens = Object.entries(scopes).map(([token, ofToken]) =>
    ({ sha256: createHash('sha256').update(token).digest('hex'), scopes: ofToken }));
  const tokenFile = join(setup.folder, 'tokens.json');
  writeFileSync(tokenFile, JSON.stringify(tokens), { mode: 0o600 });
  writeFileSync(join(setup.folder, 'link.token'), 'link\n', { mode: 0o600 });
  return {
    setup,
    startServer: () => setup.startServer('--token-file', tokenFile),
    startLink: (...more) => setup.startLink('--token-file', join(setup.folder, 'link.token'), ...more),
    get: (where) => setup.get(where, as('reader')),
    post: (where, token, body) => fetch(`${setup.url}${where}`, { method: 'POST', headers: as(token), body }),
  };
}

test('the service tells what the link hears, and hands commands over', { skip, timeout: 120_000 }, async (t) => {
  const { setup, startServer, startLink, get, post } = await withTokens(t);
  startServer();
  await isReady(setup);
  startLink('--name', 'wing');
  await until('the link', () => setup.state());
  const records = readTlog(path);
  const flying = replay(records.slice(0, 12_000), { port: setup.udpPort, speed: 1 });
  const link = await until('the link at the service', async () => {
    const { links } = await get('/v1/links');
    return links[0]?.is_connected && links[0].wind ? links[0] : undefined;
  }, 90_000);
  assert.equal(link.id, 'wing');
  assert.equal(link.system_id, 1);
  assert.ok(link.heard_age_s < 2);
  assert.match(link.log[0].text, /system 1 is heard/);

  for (const token of ['link', 'reader']) assert.equal((await post('/v1/links/wing/release', token)).status, 403);
  const answer = await post('/v1/links/wing/release', 'pilot', JSON.stringify({ confirmed_by: 'a test' }));
  assert.equal(answer.status, 202);
  const { command } = await answer.json();
  const outcome = await until('an outcome', async () => {
    const { commands } = await get('/v1/links/wing');
    return commands.find(({ id, state }) => id === command.id && state !== 'queued');
  });
  assert.ok(['taken', 'done', 'failed'].includes(outcome.state));

  const flight = await until('the flight', async () => {
    const { flight: { id } = {} } = await get('/v1/links/wing');
    const known = id && await get(`/v1/flights/${id}`);
    return known?.wind ? known : undefined;
  }, 60_000);
  assert.equal(flight.wind.source, link.wind.source);
  await flying;
});

test('another program under the same name is refused, and a service that starts anew has the link at once', { skip, timeout: 120_000 }, async (t) => {
  const { setup, startServer, startLink, get } = await withTokens(t);
  let service = startServer();
  await isReady(setup);
  startLink('--name', 'wing');
  const flying = replay(readTlog(path).slice(0, 5000), { port: setup.udpPort, speed: 0.5 });
  await until('the link', async () => (await get('/v1/links')).links[0]?.is_connected);
  const intruder = await fetch(`${setup.url}/v1/links/wing`, {
    method: 'PUT', headers: as('link'), body: JSON.stringify({ run: 'another', is_connected: true }),
  });
  assert.equal(intruder.status, 409);
  assert.equal((await intruder.json()).code, 'LinkInUse');
  service.kill('SIGKILL');
  await sleep(500);
  service = startServer();
  await isReady(setup);
  const link = await until('the link again', async () => (await get('/v1/links')).links[0]);
  assert.equal(link.id, 'wing');
  assert.ok(link.log.length > 0);
  await flying;
});
