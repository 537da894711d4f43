// Many uploads over a bad radio, with restarts and a second ground station: the autopilot never has a
// mission that is neither the old nor the new one while the link says that it knows it.

import assert from 'node:assert/strict';
import test from 'node:test';

import { packetsInDatagram } from '../../server/mavlink/framing.js';
import { Upload } from '../../server/mavlink/item_transfer.js';
import { fieldsOf, nameOf } from '../../server/mavlink/messages.js';
import { areSame } from '../../server/mavlink/mission_items.js';
import { Rig } from './mission_rig.js';
import { report } from './report.js';
import { stored } from './standin/items.js';
import { survey } from './standin/missions.js';
import { Random } from './standin/random.js';
import { Transport } from './standin/transport.js';
import { Sender } from './standin/wire.js';

// A short form for every run; all of it with FREELSD_UPLOADS=200.
const numUploads = Number(process.env.FREELSD_UPLOADS ?? 16);
const faults = { loss_ratio: 0.2, duplicate_ratio: 0.1, reorder_ratio: 0.1, delay_s: 0.05 };
// From the first sign of another station's upload to the alarm.
const maxUnnoticed_s = 35;
const longest_s = 600;
const hasHome = { hasHome: true };
const landing = 'landing';

// A second ground station with a mission of its own, on a radio of its own.
function secondStation(rig, seed, items, start_s) {
  const sender = new Sender({ systemId: 254, componentId: 190 });
  const up = new Transport((bytes) => rig.plane.take(bytes), { ...faults, seed: seed + 500 });
  const out = { send: (name, fields) => up.send(sender.bytes(name, { targetSystem: 1, targetComponent: 1, ...fields }), rig.plane.time_s) };
  let upload;
  const down = new Transport((bytes) => {
    for (const packet of packetsInDatagram(bytes).packets) {
      const fields = fieldsOf(packet);
      if (fields.targetSystem === 254) upload?.hear(nameOf(packet.messageId), fields, rig.plane.time_s);
    }
  }, { ...faults, seed: seed + 900 });
  const toLink = rig.plane.onSend;
  rig.plane.onSend = (bytes, name) => {
    toLink(bytes, name);
    down.send(bytes, rig.plane.time_s);
  };
  return () => {
    const now_s = rig.plane.time_s;
    if (now_s >= start_s && !upload) upload = new Upload(out, 0, items);
    up.step(now_s);
    down.step(now_s);
    // It tries again, as a person does.
    if (upload?.result?.error) upload = new Upload(out, 0, items);
    if (upload && !upload.result) upload.step(now_s);
  };
}

const cutBoth = (rig, duration_s) => [rig.up, rig.down].forEach((one) => one.cut(rig.plane.time_s, duration_s));

// Each: what happens at a moment of the upload, and what runs beside it.
const scenarios = {
  'loss, duplicates, reordering': {},
  'a cut of 3 s': { act: (rig) => cutBoth(rig, 3) },
  'a cut of 60 s': { act: (rig) => cutBoth(rig, 60) },
  'the autopilot restarted': { act: (rig) => rig.plane.restart(3) },
  'the service restarted': {
    prepare: (rig) => {
      const { approach } = rig.service;
      const back_s = rig.plane.time_s + 8;
      rig.service.approach = async () => {
        if (rig.plane.time_s < back_s) throw new Error('the service is away');
        return approach();
      };
      rig.again_s = back_s + 4;
    },
  },
  'two systems': { prepare: (rig, seed) => { rig.other = rig.addPlane({ seed: seed + 50, system_id: 2 }); } },
  'a second ground station': {
    prepare: (rig, seed, random) => {
      rig.foreign = survey(rig.plane, { west_m: -500, width_m: 240, spacing_m: 120, height_m: 150 }).map((one) => stored(0, one).item);
      return secondStation(rig, seed, rig.foreign, rig.plane.time_s + random.between(0, 35));
    },
  },
  'this program killed': { act: (rig) => rig.startProgram() },
};

// What the autopilot has.
function kindOf(rig, lists) {
  for (const [kind, list] of Object.entries(lists)) {
    if (list && areSame(rig.plane.mission, list, hasHome)) return kind;
  }
  return 'mixed';
}

async function runOne(seed, name) {
  const random = new Random(seed * 31);
  const rig = new Rig({ seed, faults });
  const old = structuredClone(rig.plane.mission);
  await rig.step(20);
  const begun_s = rig.plane.time_s;
  const { act, prepare } = scenarios[name];
  const every = prepare?.(rig, seed, random);
  // Three of four happen while it is written, the rest from the command on.
  const isInWriting = seed % 4 !== 0;
  const delay_s = random.between(0.1, isInWriting ? 8 : 14);
  let act_s = isInWriting ? Infinity : begun_s + delay_s;
  const lists = { old, foreign: rig.foreign };
  const seen = { unnoticed_s: 0, worst_s: 0, settled_s: 0, hadAlarm: false, hasActed: false, wasWriting: false };
  const watch = () => {
    if (rig.outgoing.counts.MISSION_COUNT) act_s = Math.min(act_s, rig.plane.time_s + delay_s);
    if (act && !seen.hasActed && rig.plane.time_s >= act_s) {
      seen.hasActed = true;
      seen.wasWriting = rig.plane.isReceivingItems;
      act(rig);
    }
    if (rig.plane.time_s >= rig.again_s) {
      rig.again_s = undefined;
      rig.landings.take({ id: 'c2', kind: 'mission', site_id: 's1' });
    }
    every?.();
    // What the link wants to write; missions_test.js compares it with the site.
    lists.new ??= rig.stored?.wanted.map((one) => stored(0, one).item);
    const { state, kind, alarm } = rig.mission;
    const has = kindOf(rig, lists);
    assert.ok(state !== 'unknown' || alarm || !rig.link.state(rig.plane.utc_us).is_connected || rig.mission.num_items === undefined, 'unknown without alarm');
    seen.hadAlarm ||= alarm !== undefined;
    const isWrong = state === 'current' && (has === 'mixed' || (kind === landing) !== (has === 'new'));
    // Nothing is told while the autopilot is not heard.
    const isHeard = rig.link.state(rig.plane.utc_us).is_connected;
    seen.unnoticed_s = isWrong && isHeard && !alarm ? seen.unnoticed_s + 0.1 : 0;
    seen.worst_s = Math.max(seen.worst_s, seen.unnoticed_s);
  };
  rig.landings.take({ id: 'c1', kind: 'mission', site_id: 's1' });
  await rig.step(150, watch);
  // Restoring takes its time on such a radio; until then it alarms.
  while (rig.landings.isBusy && rig.plane.time_s < longest_s) await rig.step(5, watch);
  return { rig, seen, has: kindOf(rig, lists) };
}

const names = Object.keys(scenarios);
const figures = Object.fromEntries(names.map((name) => [name, { new: 0, old: 0, foreign: 0, alarms: 0, writing: 0, worst_s: 0, num: 0 }]));

test(`${numUploads} uploads over a bad radio`, { timeout: 3_600_000 }, async () => {
  for (let seed = 1; seed <= numUploads; ++seed) {
    const name = names[seed % names.length];
    const { rig, seen, has } = await runOne(seed, name);
    const label = `${name}, seed ${seed}: ${has}, ${JSON.stringify(rig.mission)}`;
    assert.notEqual(has, 'mixed', label);
    assert.ok(seen.worst_s <= (name === 'a second ground station' ? maxUnnoticed_s : 0), `${label}; unnoticed for ${seen.worst_s} s`);
    // On the final nothing is sent, so a doubt stays.
    const isDoubtOnFinal = rig.plane.control.mission.isLanding && rig.mission.alarm;
    assert.ok(rig.mission.state === 'current' || isDoubtOnFinal, label);
    assert.equal(rig.mission.kind === landing, has === 'new', label);
    assert.ok(has === 'new' || rig.told.get('c1')?.state === 'failed' || name === 'this program killed' || has === 'foreign', label);
    if (has === 'foreign' && rig.told.get('c1')?.state === 'done') assert.ok(rig.mission.alarm, label);
    if (rig.other) assert.equal(rig.other.mission.length, 0, 'the other system was left alone');
    const figure = figures[name];
    ++figure[has];
    ++figure.num;
    figure.alarms += Number(seen.hadAlarm);
    figure.writing += Number(seen.wasWriting);
    figure.worst_s = Math.max(figure.worst_s, seen.worst_s);
  }
  for (const [name, { num, alarms, writing, worst_s, ...ends }] of Object.entries(figures)) {
    const text = Object.entries(ends).filter(([, count]) => count).map(([kind, count]) => `${count} ${kind}`).join(', ');
    report('uploads, 20 % loss, 10 % duplicates, 10 % reordered', name,
      `${num} uploads${writing ? `, ${writing} hit while items were sent` : ''}: ${text}; ${alarms} with an alarm meanwhile; neither old nor new without alarm: ${worst_s.toFixed(1)} s at most`);
  }
});
