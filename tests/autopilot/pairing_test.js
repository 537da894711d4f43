// Pairing of pictures with triggers, without files: whatever is missing, late, twice or extra, no
// picture gets another one's trigger.

import assert from 'node:assert/strict';
import test from 'node:test';

import { Pairing } from '../../server/mavlink/frames/pairing.js';
import { report } from './report.js';
import { Random } from './standin/random.js';

const numFlights = 30;
const noon_us = Date.UTC(2026, 5, 1, 12) * 1000;

// Seconds between exposures.
const intervals = {
  'irregular, 0.8 to 4 s': (random) => random.between(0.8, 4),
  // Legs with and against the wind, and turns.
  'by distance, legs and turns': (random, i) => {
    const leg = Math.floor(i / 12);
    return (i % 12 === 11 ? 9 : leg % 2 ? 1.4 : 2.3) + 0.05 * random.gauss();
  },
  'regular, 1.5 s': (random) => 1.5 + 0.002 * random.gauss(),
  'regular, 1.0 s': (random) => 1 + 0.002 * random.gauss(),
};

// How the pictures tell their time.
const kinds = {
  exif: (time_us, random) => time_us + 1e6 * 0.03 * random.gauss(),
  exif_seconds: (time_us) => 1e6 * Math.floor(time_us / 1e6) + 5e5,
  file: (time_us, random) => time_us + 1e6 * random.between(0.1, 0.3),
};

function flight(seed, { interval, kind, numTriggers = 100, offset_s, missing = 0.05, unheard = 0.05, numExtra = 3 }) {
  const random = new Random(seed);
  const triggers = [];
  const pictures = [];
  let time_us = noon_us;
  let order = 0;
  const timeOf = (true_us) => kinds[kind](true_us + 1e6 * offset_s, random);
  for (let i = 0; i < numTriggers; ++i) {
    time_us += 1e6 * interval(random, i);
    const trigger = { kind: 'CAMERA_FEEDBACK', index: i + 1, time_us, order: ++order };
    const isHeard = random.uniform() >= unheard;
    if (isHeard) triggers.push(trigger);
    if (random.uniform() < missing) continue;
    pictures.push({ name: `p${i}.jpg`, time_us: timeOf(time_us), time_kind: kind, order: ++order, truth: isHeard ? trigger : undefined });
  }
  for (let i = 0; i < numExtra; ++i) {
    pictures.push({ name: `x${i}.jpg`, time_us: timeOf(random.between(noon_us, time_us)), time_kind: kind, order: ++order, isExtra: true });
  }
  return { triggers, pictures };
}

// Seen at several moments of the flight, not only at its end.
function outcomeOf({ triggers, pictures }, limit_us) {
  const sum = { paired: 0, of: 0, wrong: 0, extra: 0 };
  for (const share of [0.05, 0.1, 0.2, 0.3, 0.6, 1]) {
    const seen = pictures.slice(0, Math.ceil(share * pictures.length));
    const heard = triggers.filter(({ order }) => order <= seen.at(-1).order);
    const { pairs } = new Pairing({ limit_us }).pair(seen, heard);
    for (const [picture, trigger] of pairs) if (!picture.isExtra && picture.truth !== trigger) ++sum.wrong;
    if (share < 1) continue;
    sum.paired = [...pairs].filter(([picture, trigger]) => picture.truth === trigger).length;
    sum.of = pictures.filter(({ truth }) => truth).length;
    // A picture nobody triggered, at the time of a trigger whose own picture is missing.
    sum.extra = [...pairs.keys()].filter(({ isExtra }) => isExtra).length;
  }
  return sum;
}

const added = (a, b) => Object.fromEntries(Object.keys(a).map((key) => [key, a[key] + b[key]]));
const clocks = [['clock unknown', 7263.4, 54_000e6], ['clock right to 0.45 s', 0.1, 450_000]];

for (const [intervalName, interval] of Object.entries(intervals)) {
  for (const kind of Object.keys(kinds)) {
    for (const [clock, offset_s, limit_us] of clocks) {
      test(`${intervalName}, ${kind}, ${clock}: no wrong pair`, () => {
        let sum = { paired: 0, of: 0, wrong: 0, extra: 0 };
        for (let seed = 1; seed <= numFlights; ++seed) {
          for (const faults of [{}, { missing: 0, unheard: 0, numExtra: 0 }, { missing: 0.3, unheard: 0.3, numExtra: 20 }]) {
            sum = added(sum, outcomeOf(flight(seed, { interval, kind, offset_s, ...faults }), limit_us));
          }
        }
        report('pairing', `${intervalName}, ${kind}, ${clock}`,
          `${sum.paired} of ${sum.of} pictures paired, ${sum.wrong} wrongly; of ${23 * numFlights} that nobody triggered ${sum.extra}`);
        assert.equal(sum.wrong, 0);
      });
    }
  }
}

const named = (file, time_s, order) => ({ kind: 'CAMERA_IMAGE_CAPTURED', index: order, file, time_us: noon_us + 1e6 * time_s, order });
const picture = (name, time_s, order) => ({ name, time_us: noon_us + 1e6 * time_s, time_kind: 'file', order });
const pairsOf = (pictures, triggers, more) => [...new Pairing({ limit_us: 54_000e6 }).pair(pictures, triggers, more).pairs]
  .map(([{ name }, { order }]) => [name, order]);

test('a name that the camera tells pairs at once, by whatever offset the times differ', () => {
  const triggers = [named('/DCIM/100/a.jpg', 1, 1), named('/DCIM/100/b.jpg', 2, 2)];
  assert.deepEqual(pairsOf([picture('B.JPG', 700, 3), picture('c.jpg', 1, 4)], triggers), [['B.JPG', 2]]);
});

test('a name that comes again, or a file that was there before, pairs nothing', () => {
  const triggers = [named('a.jpg', 1, 1), named('/2/a.jpg', 2, 2), named('b.jpg', 3, 4)];
  assert.deepEqual(pairsOf([picture('a.jpg', 1, 5), picture('b.jpg', 3, 3)], triggers), []);
});

test('a camera that begins its names anew: a picture pairs with no trigger of another flight, another time or another picture', () => {
  const of = (session, trigger) => ({ ...trigger, session });
  const today = picture('DSC1.JPG', 600, 9);
  const yesterday = of('yesterday', named('DSC1.JPG', 1, 1));
  // The picture of yesterday's trigger never came; that of today was not heard, or was.
  for (const session of ['yesterday', undefined]) assert.deepEqual(pairsOf([today], [of('another', named('DSC1.JPG', 1, 1))], { session }), []);
  assert.deepEqual(pairsOf([today], [yesterday], { session: 'today' }), []);
  assert.deepEqual(pairsOf([today], [yesterday, of('today', named('DSC1.JPG', 500, 5))], { session: 'today' }), [['DSC1.JPG', 5]]);
  assert.deepEqual(pairsOf([picture('DSC1.JPG', 54_500, 9)], [named('DSC1.JPG', 1, 1)]), []);
  // The card is formatted in one flight.
  const used_us = new Set([named('DSC1.JPG', 1, 1).time_us]);
  assert.deepEqual(pairsOf([today], [named('DSC1.JPG', 1, 1)], { used_us }), []);
  const twice = [named('DSC1.JPG', 1, 1), named('DSC1.JPG', 500, 5)];
  assert.deepEqual(pairsOf([picture('DSC1.JPG', 2, 2), today], twice, { used_us }), [['DSC1.JPG', 5]]);
  assert.deepEqual(pairsOf([today], twice), []);
});

test('a trigger whose picture was sent pairs no other picture by time', () => {
  const { triggers, pictures } = flight(3, { interval: intervals['irregular, 0.8 to 4 s'], kind: 'exif', offset_s: 5 });
  const all = new Pairing({ limit_us: 54_000e6 }).pair(pictures, triggers);
  const used_us = new Set([...all.pairs.values()].slice(0, 20).map(({ time_us }) => time_us));
  const left = new Pairing({ limit_us: 54_000e6 }).pair(pictures, triggers, { used_us });
  assert.equal(left.pairs.size, all.pairs.size - 20);
  assert.ok([...left.pairs.values()].every(({ time_us }) => !used_us.has(time_us)));
});

test('a message of a better kind counts in its own flight only', () => {
  const { triggers, pictures } = flight(3, { interval: intervals['irregular, 0.8 to 4 s'], kind: 'exif', offset_s: 5 });
  const stray = { ...named('', -5000, -1), session: 'yesterday' };
  assert.ok(pairsOf(pictures, [stray, ...triggers.map((trigger) => ({ ...trigger, session: 'today' }))], { session: 'today' }).length > 50);
});

test('of one exposure that several messages tell, the best kind counts', () => {
  const { triggers, pictures } = flight(3, { interval: intervals['irregular, 0.8 to 4 s'], kind: 'exif', offset_s: 5 });
  const both = triggers.flatMap((trigger) => [{ ...trigger, kind: 'CAMERA_TRIGGER', time_us: trigger.time_us - 90_000 }, trigger]);
  const { pairs } = new Pairing({ limit_us: 54_000e6 }).pair(pictures, both);
  assert.ok(pairs.size > 50);
  assert.ok([...pairs].every(([one, trigger]) => one.isExtra || one.truth === trigger));
});

test('a search does not stop the link', () => {
  const { triggers, pictures } = flight(4, { interval: intervals['regular, 1.5 s'], kind: 'exif', offset_s: 5, numTriggers: 20_000 });
  const begun_ms = performance.now();
  new Pairing({ limit_us: 54_000e6 }).pair(pictures.slice(-5000), triggers);
  const taken_ms = performance.now() - begun_ms;
  report('pairing', '5000 pictures and 20 000 triggers, offset not found', `${taken_ms.toFixed(0)} ms, at most every 5 s`);
  assert.ok(taken_ms < 1000, `${taken_ms}`);
});
