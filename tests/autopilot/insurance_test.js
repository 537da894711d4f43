// Insurance of the rest of the mission: the route that is checked, when it is, and what is told.

import assert from 'node:assert/strict';
import test from 'node:test';

import { distance_m } from '../../server/mavlink/flat_frame.js';
import { Alternates } from '../../server/mavlink/insurance/alternates.js';
import { MissionInsurance } from '../../server/mavlink/insurance/mission_insurance.js';
import { remainingRoute } from '../../server/mavlink/insurance/remaining_route.js';
import { Standin } from './standin/aircraft.js';
import { landing, survey } from './standin/missions.js';

const plane = new Standin({ home: { latitude_deg: 47.3977, longitude_deg: 8.5456, altitude_m: 430 } });
const position = { ...plane.frame.toGlobal({ east_m: 0, north_m: 0 }), altitude_m: 550 };
const mission = (repeats) => [...survey(plane, { width_m: 120, spacing_m: 60, repeats }), ...landing(plane)];
const routeOf = (items, more = {}) =>
  remainingRoute({ items, current_item: 1, isArdupilot: true, position, home_altitude_m: 430, longest_m: 30_000, ...more });
const lengthOf = (route) => route.slice(1).reduce((sum, place, i) => sum + distance_m(route[i], place), 0);

test('the rest of the mission begins at the aircraft, has heights above the sea and ends at the landing', () => {
  const { route, end } = routeOf(mission(0), { current_item: 3 });
  assert.equal(end, 'the landing');
  assert.deepEqual(route[0], position);
  // Three lines have six ends; two are behind it.
  assert.equal(route.length, 1 + 4);
  assert.ok(route.slice(1).every(({ altitude_m }) => altitude_m === 550));
});

test('jumps are flown as often as the item says, and for ever only as far as is looked', () => {
  assert.equal(routeOf(mission(0)).route.length, 1 + 6);
  assert.equal(routeOf(mission(2)).route.length, 1 + 3 * 6);
  const { route, end } = routeOf(mission(-1), { longest_m: 20_000 });
  assert.equal(end, 'more of the mission');
  assert.ok(lengthOf(route) > 20_000 && lengthOf(route) < 21_000);
});

test('a route of too many points is cut, and does not end with the mission', () => {
  const waypoint = mission(0)[1];
  const items = Array.from({ length: 600 }, (_, i) => ({ ...waypoint, x: waypoint.x + 200 * i }));
  const { route, end } = routeOf(items);
  assert.deepEqual([route.length, end], [500, 'more of the mission']);
});

test('a jump to itself ends, and a height above terrain is not guessed', () => {
  const waypoint = mission(0)[1];
  const jump = { ...waypoint, command: 177, param1: 2, param2: -1 };
  assert.equal(routeOf([waypoint, waypoint, jump]).end, 'more of the mission');
  assert.equal(routeOf([waypoint, waypoint, { ...waypoint, frame: 10 }]).end, 'item 2, whose height is above the terrain');
  assert.equal(routeOf([waypoint, waypoint, { ...waypoint, command: 20 }]).end, 'the return to launch');
});

test('a route ends before an item that may lead elsewhere, and passes one that does not', () => {
  const waypoint = mission(0)[1];
  const after = (number) => routeOf([waypoint, waypoint, { ...waypoint, command: number }, waypoint]);
  for (const number of [30, 92, 601]) {
    const { route, end, isWhole } = after(number);
    assert.deepEqual([route.length, end, isWhole], [2, `item 2, command ${number}, whose way is not known`, false]);
  }
  // A take-off, a change of speed.
  for (const number of [22, 178]) assert.equal(after(number).end, 'the end of the mission');
});

test('a jump to no item ends the route, and the check of it does not throw', async () => {
  const waypoint = mission(0)[1];
  const jumpTo = (param1) => [waypoint, waypoint, { ...waypoint, command: 177, param1, param2: 1 }, waypoint];
  for (const param1 of [-1, 0, 1.5, 4, NaN]) assert.equal(routeOf(jumpTo(param1)).end, 'item 2, a jump to no item', `${param1}`);
  assert.equal(routeOf(jumpTo(1)).end, 'the end of the mission');
  assert.equal(routeOf(jumpTo(0), { current_item: 0, isArdupilot: false }).end, 'the end of the mission');
  const insurance = new MissionInsurance({ check: async () => answer([]) });
  await insurance.step(0, vehicle({ items: jumpTo(-1) }));
  // What is not a mission at all.
  await insurance.step(40, vehicle({ items: [waypoint, undefined] }));
  assert.ok(insurance.state(40).last_error);
});

test('the first item of ArduPilot is its home, that of PX4 is flown', () => {
  const items = mission(0);
  assert.equal(routeOf(items, { current_item: 0 }).route.length, 1 + 6);
  assert.equal(routeOf(items.slice(1), { current_item: 0, isArdupilot: false }).route.length, 1 + 6);
});

const vehicle = (more = {}) => ({
  isConnected: true, isFlying: true, mode: 'AUTO', missionMode: 'AUTO', items: mission(0), current_item: 1, position,
  home_altitude_m: 430, airspeed_mps: 15, flight: { id: 'f1' }, wind: { east_mps: 3, north_mps: 0, sd_mps: 0.5, age_s: 1 }, ...more,
});
const answer = (gaps) => ({ covered_ratio: 0.8, time_s: 100, gaps, point_of_no_return: { time_s: 80 } });

test('it is checked at once, every 30 s, after another mission or wind, and not while it does not fly its mission', async () => {
  const requests = [];
  const insurance = new MissionInsurance({ check: async (request) => { requests.push(request); return answer([]); } });
  const items = mission(0);
  const stepped = (from_s, to_s, more) => (async () => {
    for (let now_s = from_s; now_s < to_s; ++now_s) await insurance.step(now_s, vehicle({ items, ...more }));
    return requests.length;
  })();
  assert.equal(await stepped(0, 29), 1);
  assert.equal(requests[0].flight, 'f1');
  assert.equal(requests[0].airspeed_mps, 15);
  assert.deepEqual(requests[0].wind, { east_mps: 3, north_mps: 0, sd_mps: 0.5 });
  assert.equal(await stepped(29, 61), 3);
  assert.equal(await stepped(70, 71, { wind: { east_mps: 6, north_mps: 0, age_s: 1 } }), 4);
  assert.equal(await stepped(80, 85, { wind: { east_mps: 6, north_mps: 0, age_s: 1 }, items: mission(1) }), 5);
  assert.equal(await stepped(90, 200, { mode: 'LOITER' }), 5);
  assert.match(insurance.state(200).why, /mode LOITER/);
});

test('a slow service is asked less often: at most a tenth of the time', async () => {
  let numAsked = 0;
  const insurance = new MissionInsurance({ check: async () => {
    ++numAsked;
    await new Promise((resolve) => { setTimeout(resolve, 400); });
    return answer([]);
  } });
  for (let now_s = 0; now_s < 4; now_s += 0.1) await insurance.step(now_s, vehicle({ items: mission(numAsked) }));
  assert.equal(numAsked, 1);
});

test('times are told from now, a gap that is behind is not told, a change is a decision', async () => {
  const log = [];
  let gaps = [{ from_s: 10, to_s: 20, reason: 'too_low' }, { from_s: 80, to_s: 100, reason: 'no_site' }];
  const insurance = new MissionInsurance({ check: async () => answer(gaps), log: (text) => log.push(text) });
  const items = mission(0);
  await insurance.step(0, vehicle({ items }));
  const { first_gap, num_gaps, point_of_no_return_in_s } = insurance.state(4);
  assert.deepEqual({ first_gap, num_gaps, point_of_no_return_in_s },
    { first_gap: { in_s: 6, lasts_s: 10, reason: 'too_low' }, num_gaps: 2, point_of_no_return_in_s: 76 });
  assert.deepEqual(insurance.state(12).first_gap, { in_s: 0, lasts_s: 8, reason: 'too_low' });
  assert.equal(insurance.state(25).first_gap.in_s, 55);
  assert.match(log.at(-1), /^no site, verified or not, is in reach for 20 s of the next 100 s, to the landing$/);
  await insurance.step(31, vehicle({ items }));
  assert.equal(log.length, 1);
  gaps = [];
  await insurance.step(62, vehicle({ items }));
  assert.match(log.at(-1), /^a site, verified or not, is in reach on all of the next 100 s, to the landing$/);
});

test('where the route ends before the mission, the decision says so, and no last second is told', async () => {
  const [home, waypoint] = mission(0);
  const away = { ...waypoint, x: waypoint.x + 1_000_000 };
  const cases = {
    'more of the mission': [home, ...Array.from({ length: 600 }, (_, i) => ({ ...waypoint, x: waypoint.x + 200 * i }))],
    'item 2, whose height is above the terrain': [home, away, { ...waypoint, frame: 10 }],
    'item 2, a jump to no item': [home, away, { ...waypoint, command: 177, param1: -1, param2: 1 }],
    'the end of the mission': [home, away],
  };
  for (const [end, items] of Object.entries(cases)) {
    const log = [];
    const insurance = new MissionInsurance({ check: async () => answer([{ from_s: 80, to_s: 100 }]), log: (text) => log.push(text) });
    await insurance.step(0, vehicle({ items, airspeed_mps: 40 }));
    assert.match(log[0], new RegExp(`100 s, to ${end}$`));
    assert.equal(insurance.state(0).point_of_no_return_in_s, end === 'the end of the mission' ? 80 : undefined, end);
  }
});

test('a service that fails is told, and the last answer is told with its age, for what is left of it and not for ever', async () => {
  for (const [time_s, longest_s] of [[100, 100], [1000, 180]]) {
    let isAway = false;
    const insurance = new MissionInsurance({ check: async () => {
      if (isAway) throw new Error('away');
      return { ...answer([{ from_s: 20, to_s: 50, reason: 'too_low' }]), time_s };
    } });
    const items = mission(0);
    await insurance.step(0, vehicle({ items }));
    isAway = true;
    await insurance.step(31, vehicle({ items }));
    const state = insurance.state(40);
    assert.deepEqual([state.state, state.last_error, state.age_s, state.time_s], ['checked', 'away', 40, time_s - 40]);
    assert.equal(state.covered_ratio, 1 - 10 / (time_s - 40));
    assert.equal(insurance.state(longest_s - 1).state, 'checked');
    const old = insurance.state(longest_s);
    assert.deepEqual([old.state, old.why, old.last_error], ['none', `the last check is ${longest_s} s old`, 'away']);
  }
});

test('after a change of the mission neither the old result nor an answer for the old mission is told', async () => {
  const answers = [];
  const insurance = new MissionInsurance({ check: () => new Promise((resolve) => { answers.push(() => resolve(answer([]))); }) });
  const [old, changed] = [mission(0), mission(1)];
  const asked = insurance.step(0, vehicle({ items: old }));
  insurance.step(1, vehicle({ items: changed }));
  answers[0]();
  await asked;
  assert.equal(insurance.state(2).state, 'waiting');
  const askedAgain = insurance.step(10, vehicle({ items: changed }));
  answers[1]();
  await askedAgain;
  assert.equal(insurance.state(11).state, 'checked');
  insurance.step(12, vehicle({ items: mission(2) }));
  assert.deepEqual(insurance.state(12), { state: 'waiting', why: undefined, last_error: undefined });
});

const settled = () => new Promise((resolve) => { setImmediate(resolve); });
const inReach = (pose) => ({ sites: [{ site_id: 'a', verdict: 'landable', arrival_margin_m: 12, path: {} }], pose });
const inFlight = { isFlying: true, flight: { id: 'f1' } };

test('alternates: asked every 5 s in flight, told with the age of the place, forgotten on the ground', async () => {
  let numAsked = 0;
  const alternates = new Alternates(async () => {
    ++numAsked;
    return inReach({ age_s: 0.5 });
  });
  for (let now_s = 0; now_s < 12; ++now_s) {
    alternates.step(now_s, inFlight);
    await settled();
  }
  assert.equal(numAsked, 3);
  assert.deepEqual(alternates.state(12), { sites: [{ site_id: 'a', verdict: 'landable', arrival_margin_m: 12 }], num_in_reach: 1, age_s: 2.5 });
  alternates.step(13, { ...inFlight, isFlying: false });
  assert.equal(alternates.state(13), undefined);
});

test('alternates: none of an old or unknown place, of an answer that fails for long, or of another flight', async () => {
  let answer = async () => inReach({ age_s: 12 });
  const alternates = new Alternates(() => answer());
  const asked = async (now_s, vehicle = inFlight) => {
    alternates.step(now_s, vehicle);
    await settled();
    return alternates.state(now_s);
  };
  assert.equal((await asked(0)).age_s, 12);
  assert.equal(alternates.state(3).age_s, 15);
  assert.equal(alternates.state(3.1), undefined);
  for (const [i, pose] of [{ age_s: 16 }, { age_s: null }, undefined].entries()) {
    answer = async () => inReach(pose);
    assert.equal(await asked(10 + 5 * i), undefined, JSON.stringify(pose));
  }
  answer = async () => inReach({ age_s: 0 });
  assert.ok(await asked(30));
  answer = async () => { throw new Error('away'); };
  assert.equal((await asked(35)).age_s, 5);
  answer = async () => null;
  assert.equal((await asked(40)).age_s, 10);
  assert.equal(await asked(46), undefined);
  let arrive;
  answer = () => new Promise((resolve) => { arrive = () => resolve(inReach({ age_s: 0 })); });
  await asked(60);
  await asked(61, { isFlying: true, flight: { id: 'f2' } });
  arrive();
  await settled();
  assert.equal(alternates.state(62), undefined);
  answer = async () => inReach({ age_s: 0 });
  assert.ok(await asked(70, { isFlying: true, flight: { id: 'f2' } }));
  assert.equal(await asked(71), undefined);
});
