// The pure parts of guidance: from a state and an answer of recall to a choice and a target.

import assert from 'node:assert/strict';
import test from 'node:test';

import { FlatFrame } from '../../server/mavlink/flat_frame.js';
import { Guidance } from '../../server/mavlink/guidance/guidance.js';
import { choose } from '../../server/mavlink/guidance/guidance_choice.js';
import { FinalGate } from '../../server/mavlink/guidance/guidance_final.js';
import { ModeWatch } from '../../server/mavlink/guidance/guidance_modes.js';
import { targetOn } from '../../server/mavlink/guidance/guidance_target.js';
import { queryOf, WindHold } from '../../server/mavlink/guidance/recall_query.js';
import { ToldWay } from '../../server/mavlink/guidance/told_way.js';

const touchdown = { latitude_deg: 47.35, longitude_deg: 8.45, altitude_m: 450 };
const frame = new FlatFrame(touchdown);
const place = (east_m, north_m, altitude_m) => ({ ...frame.toGlobal({ east_m, north_m }), altitude_m });

// From 400 m south of the touchdown northwards, a circle at the start of the final, the final.
function site({ id = 'a', margin_m = 20, verdict = 'landable', circle = true } = {}) {
  const radius_m = 20;
  const points = [[0, -400, 520, 0], [0, -70, 473, 33]];
  for (let i = 1; circle && i <= 36; ++i) {
    const angle = (i / 36) * 2 * Math.PI;
    points.push([-radius_m + radius_m * Math.cos(angle), -70 + radius_m * Math.sin(angle), 473 - (13 * i) / 36, 33 + (12.5 * i) / 36]);
  }
  points.push([0, 0, 450, points.at(-1)[3] + 8]);
  const coordinates = points.map(([east, north, altitude_m]) => {
    const { latitude_deg, longitude_deg } = place(east, north, altitude_m);
    return [longitude_deg, latitude_deg, altitude_m];
  });
  return {
    site_id: id, verdict, arrival_margin_m: margin_m, touchdown, times_s: points.map((point) => point[3]),
    path: { type: 'LineString', coordinates }, aircraft: { landing_airspeed_mps: 10 },
    approach: { start: place(0, -70, 460), loiter_radius_m: radius_m, heading_deg: 0 },
  };
}

const on = (way, position, ...part) => {
  const nearest = way.nearest(position, ...part);
  return { ...nearest, energy_m: nearest.height_m };
};
const state = ({ position, airspeed_mps = 10, east_mps = 0, north_mps = 10 }) =>
  ({ position, airspeed_mps, ground_speed_mps: Math.hypot(east_mps, north_mps), velocity: { east_mps, north_mps } });

test('a told way knows its circles, its final and where an aircraft is on it', () => {
  const way = new ToldWay(site());
  assert.equal(way.numCircles, 1);
  assert.ok(Math.abs(way.arrival_m - 330) < 0.5);
  assert.ok(Math.abs(way.surplus_m) < 0.5);
  const { along_m, right_m, height_m } = way.nearest(place(3, -300, 510));
  assert.ok(Math.abs(along_m - 100) < 0.1);
  assert.ok(Math.abs(right_m - 3) < 0.1);
  assert.ok(Math.abs(height_m - (510 - (520 - 47 * (100 / 330)))) < 0.1);
});

test('where a way crosses itself, the part ahead is taken', () => {
  const way = new ToldWay(site());
  const first = way.nearest(place(0, -70, 473), 300, 340);
  const second = way.nearest(place(0, -70, 460), 400, 480);
  assert.ok(first.along_m < 335 && second.along_m > 440);
});

test('a target is ahead on the way and never above the aircraft', () => {
  const way = new ToldWay(site());
  for (const altitude_m of [470, 490, 505, 530]) {
    for (const airspeed_mps of [8, 10, 13, 18]) {
      const here = state({ position: place(0, -300, altitude_m), airspeed_mps });
      const target = targetOn(way, way.nearest(here.position), here);
      assert.ok(target.altitude_m <= altitude_m, `${target.altitude_m} at ${altitude_m}`);
      const { north_m } = frame.toLocal(target);
      assert.ok(north_m > -290 && north_m < -260);
    }
  }
});

test('above the way, the target is at the height of the way or lower', () => {
  const way = new ToldWay(site());
  const slow = state({ position: place(0, -300, 506.5) });
  const { altitude_m } = targetOn(way, way.nearest(slow.position), slow);
  assert.ok(altitude_m < 505.8 && altitude_m > 505);
  const high = state({ position: place(0, -300, 530) });
  const lowest_m = targetOn(way, way.nearest(high.position), high).altitude_m;
  assert.ok(lowest_m > 528.5 && lowest_m < 529.5, 'not faster than the limit');
});

test('the first choice is a verified site, and one that is flown to is kept', () => {
  const answer = { sites: [site({ id: 'u', verdict: 'unverified', margin_m: 50 }), site({ id: 'a', margin_m: 30 })] };
  assert.equal(choose({ answer }).site.site_id, 'a');
  const way = new ToldWay(answer.sites[1]);
  const progress = on(way, place(0, -300, 506));
  const better = { sites: [site({ id: 'b', margin_m: 60 }), site({ id: 'a', margin_m: 25 })] };
  assert.equal(choose({ way, progress, answer: better }), undefined);
});

test('off the way, the new way to the same site is taken', () => {
  const way = new ToldWay(site());
  const answer = { sites: [site({ margin_m: 12 })] };
  for (const off of [place(0, -300, 515), place(0, -300, 500), place(30, -300, 506)]) {
    assert.equal(choose({ way, progress: on(way, off), answer }).site, answer.sites[0]);
  }
});

test('a new way is not taken if it leaves more surplus height than the aircraft has on this one', () => {
  const way = new ToldWay(site());
  const surplus = site();
  surplus.approach = { ...surplus.approach, start: place(0, -70, 430) };
  const progress = on(way, place(0, -300, 503));
  assert.equal(choose({ way, progress, answer: { sites: [surplus] } }), undefined);
});

test('one more circle begins and ends at the start of the final, lower', () => {
  const way = new ToldWay(site({ circle: false }));
  way.site.approach.loiter_center = place(-20, -70, 460);
  way.site.approach.loiter_direction = 'left';
  const longer = way.withCircle(7, 10);
  assert.equal(longer.numCircles, way.numCircles + 1);
  assert.ok(Math.abs(longer.heading_deg(longer.arrival_m + 2)) < 8, 'it leaves in the direction of the final');
  assert.ok(way.surplus_m - longer.surplus_m > 15 && way.surplus_m - longer.surplus_m < 30);
});

test('another site is taken only where the margin has gone and the other has much more', () => {
  const way = new ToldWay(site());
  const low = on(way, place(0, -300, 498));
  const high = on(way, place(0, -300, 506));
  const answer = (other_m) => ({ sites: [site({ id: 'b', margin_m: other_m })] });
  assert.equal(choose({ way, progress: low, answer: answer(15) }).site.site_id, 'b');
  assert.equal(choose({ way, progress: low, answer: answer(1) }), undefined);
  assert.equal(choose({ way, progress: high, answer: answer(40) }), undefined);
});

test('shortly before the final nothing is chosen any more', () => {
  const way = new ToldWay(site({ circle: false }));
  const progress = on(way, place(0, -100, 460));
  assert.equal(choose({ way, progress, answer: { sites: [site({ id: 'b', margin_m: 90 })] } }), undefined);
});

test('the final begins at its start, in its direction, after the circles', () => {
  const gate = new FinalGate();
  const way = new ToldWay(site());
  const at = (from_m, to_m, more) => {
    const here = state({ position: place(0, -70, 460), ...more });
    return gate.isOpen(way, way.nearest(here.position, from_m, to_m), here);
  };
  assert.equal(at(300, 340), false);
  assert.equal(at(420, 480), true);
  assert.equal(at(420, 480, { east_mps: 8, north_mps: 6 }), false);
});

test('a mode that a person sets ends guidance; its own modes do not', () => {
  const autopilot = 'ardupilotmega';
  const watch = new ModeWatch({ autopilot, mode: 'AUTO' });
  assert.equal(watch.interference({ mode: 'AUTO' }, 0), undefined);
  watch.sendsGuided(0);
  assert.equal(watch.interference({ mode: 'AUTO' }, 1), undefined);
  assert.equal(watch.mayChange, true);
  assert.equal(watch.interference({ mode: 'GUIDED' }, 2), undefined);
  assert.equal(watch.mayChange, false);
  assert.match(watch.interference({ mode: 'AUTO' }, 3), /AUTO/);
  const final = new ModeWatch({ autopilot, mode: 'GUIDED' });
  final.sendsGuided(0);
  final.interference({ mode: 'GUIDED' }, 1);
  final.sendsMission(1);
  assert.equal(final.interference({ mode: 'GUIDED' }, 2), undefined);
  assert.equal(final.interference({ mode: 'AUTO' }, 3), undefined);
  assert.match(final.interference({ mode: 'MANUAL' }, 4), /MANUAL/);
});

test('recall is asked in a wind that is held until it changes by more than it wanders', () => {
  const hold = new WindHold();
  const told = [];
  assert.deepEqual(hold.take({ east_mps: 3, north_mps: 0, age_s: 2 }), { east_mps: 3, north_mps: 0, age_s: 2 });
  assert.deepEqual(hold.take({ east_mps: 4, north_mps: 0, age_s: 1 }, (text) => told.push(text)), { east_mps: 3, north_mps: 0, age_s: 1 });
  assert.equal(told.length, 0);
  assert.deepEqual(hold.take({ east_mps: 5, north_mps: 0, age_s: 1 }, (text) => told.push(text)), { east_mps: 5, north_mps: 0, age_s: 1 });
  assert.equal(told.length, 1);
  const query = queryOf({ position: { ...place(0, 0, 500), altitude_datum: 'amsl' }, velocity: { east_mps: 10, north_mps: 0 } }, { east_mps: 5, north_mps: 0, age_s: 1 });
  assert.equal(query.heading_deg, 90);
  assert.equal(query.wind_east_mps, 5);
  assert.ok(!('touchdown_uncertainty_m' in query));
  assert.equal(hold.take(undefined), undefined, 'without a wind the service takes the flight\'s');
});

test('a wind of any age is not the wind of now: recall takes an old one from the flight, with its age', () => {
  const state = { position: { ...place(0, 0, 500), altitude_datum: 'amsl' }, velocity: { east_mps: 10, north_mps: 0 }, flight: { id: 'f-1' } };
  for (const [age_s, isGiven] of [[1, true], [599, true], [601, false], [21600, false]]) {
    const query = queryOf(state, new WindHold().take({ east_mps: 5, north_mps: 0, age_s }));
    assert.equal('wind_east_mps' in query, isGiven, `${age_s} s`);
    assert.equal(query.flight, 'f-1');
  }
});

// A field with room for a touchdown within so much; recall tells it to whoever asks for no more.
function guidanceOver(room_m) {
  const asked = [];
  const log = [];
  const told = site();
  const guidance = new Guidance({
    recall: async (query) => {
      const { touchdown_uncertainty_m: wanted_m = 8 } = query;
      asked.push(query.touchdown_uncertainty_m);
      const aircraft = { landing_airspeed_mps: 10, glide_ratio: 7, touchdown_uncertainty_m: Math.max(8, wanted_m) };
      return { sites: aircraft.touchdown_uncertainty_m <= room_m ? [{ ...told, aircraft }] : [] };
    },
    autopilot: { goTo: () => {}, setSpeed: () => {}, beginFinal: () => {} },
    mission: { prepare: async () => {}, abandon: () => {}, hasLanding: () => true },
    log: (text) => log.push(text),
  });
  const flying = { ...state({ position: place(0, -390, 519) }), mode: 'GUIDED', is_armed: true };
  return { asked, log, guidance, flying };
}

async function flyFor(guidance, flying, seconds) {
  for (let now_s = 0; now_s <= seconds; now_s += 0.5) {
    guidance.step(flying, now_s);
    await new Promise((resolve) => { setImmediate(resolve); });
  }
}

test('a site is planned for as much scatter as autopilots have; where none has room, for the aircraft\'s, which is told', async () => {
  const wide = guidanceOver(20);
  wide.guidance.engage(wide.flying, 'test', 0);
  await flyFor(wide.guidance, wide.flying, 4);
  assert.ok(wide.guidance.way, wide.log.join('; '));
  assert.equal(wide.guidance.way.site.aircraft.touchdown_uncertainty_m, 14);
  assert.ok(wide.asked.every((asked_m) => asked_m === 14), String(wide.asked));
  assert.ok(!wide.log.some((text) => /autopilots need/.test(text)));

  const narrow = guidanceOver(10);
  narrow.guidance.engage(narrow.flying, 'test', 0);
  await flyFor(narrow.guidance, narrow.flying, 4);
  assert.equal(narrow.guidance.way.site.aircraft.touchdown_uncertainty_m, 8);
  // On the way, recall is asked for what is flown.
  assert.deepEqual(narrow.asked.slice(0, 3), [14, undefined, 8]);
  assert.ok(narrow.log.some((text) => /within 8 m, autopilots need 14 m/.test(text)), narrow.log.join('; '));
});
