// The state that the service is told, and the commands that it answers.

import assert from 'node:assert/strict';
import test from 'node:test';

import { Decisions } from '../../server/mavlink/decisions.js';
import { Reporter } from '../../server/mavlink/reporter.js';

function fakeService(answers) {
  const bodies = [];
  return {
    bodies,
    putLink: async (linkId, body) => {
      bodies.push({ linkId, body });
      const answer = answers.shift() ?? {};
      if (answer instanceof Error) throw answer;
      return answer;
    },
  };
}

const command = { id: 'c1', kind: 'mission', site_id: 's1' };

test('a command that the service repeats is handed over once', async () => {
  const service = fakeService([{ commands: [command] }, { commands: [command] }, {}]);
  const taken = [];
  const reporter = new Reporter({ service, state: () => ({ id: '1' }), onCommand: (one) => taken.push(one) });
  for (let i = 0; i < 3; ++i) await reporter.step(10_000 + 1000 * i);
  assert.deepEqual(taken, [command]);
  assert.deepEqual(service.bodies[1].body.commands, [{ id: 'c1', state: 'taken', detail: undefined }]);
});

test('the service hears at once what became of a command, and no longer after ten minutes', async () => {
  const service = fakeService([]);
  const reporter = new Reporter({ service, name: 'wing', state: () => ({}) });
  await reporter.step(10_000);
  await reporter.step(10_100);
  assert.equal(service.bodies.length, 1);
  reporter.told('c1', 'failed', 'no such site', 10_100);
  await reporter.step(10_200);
  assert.equal(service.bodies[1].linkId, 'wing');
  assert.deepEqual(service.bodies[1].body.commands, [{ id: 'c1', state: 'failed', detail: 'no such site' }]);
  await reporter.step(700_000);
  assert.deepEqual(service.bodies[2].body.commands, []);
});

test('a service that is away is asked less and less often', async () => {
  const away = () => new Error('connection refused');
  const service = fakeService([away(), away(), {}]);
  const reporter = new Reporter({ service, state: () => ({ id: '1' }) });
  await reporter.step();
  assert.equal(reporter.isReachable, false);
  assert.match(reporter.lastError, /refused/);
  reporter.changed();
  await reporter.step();
  assert.equal(service.bodies.length, 1);
  await reporter.step(Date.now() + 600);
  await reporter.step(Date.now() + 10_000);
  assert.equal(reporter.isReachable, true);
});

test('before an autopilot is heard there is no link', async () => {
  const service = fakeService([]);
  await new Reporter({ service, state: () => ({}) }).step();
  assert.equal(service.bodies.length, 0);
});

test('the newest fifty decisions, numbered', () => {
  const decisions = new Decisions();
  for (let i = 0; i < 60; ++i) decisions.add('link', `line ${i}`);
  assert.equal(decisions.newest.length, 50);
  assert.equal(decisions.newest.at(-1).id, 60);
  assert.equal(decisions.newest[0].text, 'line 10');
  assert.notEqual(decisions.run, new Decisions().run);
});
