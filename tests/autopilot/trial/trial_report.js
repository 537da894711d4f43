#!/usr/bin/env node
// Figures of a trial from its flights and their verdicts.
//
//   trial_report.js --tracks FILE [--tracks FILE ...] --verdicts FILE [--subject TEXT]
//
// Prints a table; appends it to the file that FREELSD_REPORT names, as the tests of the link do.

import { readFileSync } from 'node:fs';
import { parseArgs } from 'node:util';

import { report } from '../report.js';

const { values } = parseArgs({ options: {
  tracks: { type: 'string', multiple: true }, verdicts: { type: 'string' }, subject: { type: 'string', default: 'guidance' },
} });

const read = (path) => JSON.parse(readFileSync(path, 'utf8'));
const flights = values.tracks.flatMap((path) => read(path).tracks);
const verdicts = new Map(read(values.verdicts).verdicts.map((verdict) => [verdict.id, verdict]));

const quantile = (list, share) => {
  const sorted = list.filter(Number.isFinite).sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
};
const spread = (list, digits = 1) => [0.05, 0.5, 0.95].map((share) => quantile(list, share)?.toFixed(digits)).join(' / ');
const share = (count, all) => `${count} of ${all} (${((100 * count) / Math.max(1, all)).toFixed(1)} %)`;

function causeOf(flight) {
  const verdict = verdicts.get(flight.id);
  if (!flight.sites.length) return 'no site chosen';
  if (!verdict?.has_contact) return 'never came down';
  if (verdict.hit) return `${flight.final ? 'on the final' : 'before the final'}: ${verdict.hit}`;
  if (!verdict.is_in_disc) return flight.final ? `outside the disc: ${sideOf(verdict)}` : 'no final';
  return verdict.roll_fault ? `roll: ${verdict.roll_fault}` : undefined;
}

const sideOf = ({ along_m, across_m }) =>
  (Math.abs(across_m) > Math.abs(along_m) ? 'aside' : along_m < 0 ? 'short' : 'long');

function tell(figure, value) {
  console.log(`${figure}: ${value}`);
  report(values.subject, figure, value);
}

function tellLandings(name, part) {
  const judged = part.map((flight) => verdicts.get(flight.id)).filter(Boolean);
  const isGood = (verdict) => verdict.is_landing && verdict.is_in_disc;
  tell(`${name}: in the told disc, roll on a true field`, share(judged.filter(isGood).length, part.length));
  tell(`${name}: in the told disc`, share(judged.filter((one) => one.is_in_disc && !one.hit).length, part.length));
  tell(`${name}: on a true field, in the disc or not`, share(judged.filter((one) => one.is_landing).length, part.length));
}

tell('flights', String(flights.length));
tell('engine stopped to failure told, s (5 / 50 / 95 %)', spread(flights.map((flight) => flight.detection_s)));
const first = flights.map((flight) => flight.first_target_s);
tell('failure told to first target, s', `${spread(first)}, most ${Math.max(...first.filter(Number.isFinite)).toFixed(1)}`);
tellLandings('all', flights);
const isOwn = (flight) => flight.survey && flight.site_flight_id === flight.survey.flight_id;
tellLandings('sites that the altimeter fits', flights.filter(isOwn));
tellLandings('verified sites that it fits', flights.filter((flight) => isOwn(flight) && flight.verdict === 'landable'));
const all = flights.map((flight) => verdicts.get(flight.id)).filter(Boolean);
tell('collisions before the final', String(flights.filter((flight) => !flight.final && verdicts.get(flight.id)?.hit).length));
tell('collisions on the final', String(flights.filter((flight) => flight.final && verdicts.get(flight.id)?.hit).length));
tell('fences, poles and wires among the failures', String(all.filter((one) => one.is_thin).length));
tell('touchdown along the final, m', spread(all.map((one) => one.along_m)));
tell('touchdown beside it, m', spread(all.map((one) => one.across_m)));
tell('sink at touchdown, m/s', spread(flights.map((flight) => flight.sink_mps)));
tell('told arrival margin, m', spread(flights.map((flight) => flight.told_margin_m)));
tell('flown above the start of the final, m', spread(flights.map((flight) => flight.final?.arrival_margin_m)));
tell('messages sent on the final', String(flights.reduce((sum, flight) => sum + (flight.final?.num_sent ?? 0), 0)));

const causes = new Map();
for (const flight of flights) {
  const cause = causeOf(flight);
  if (cause) causes.set(cause, [...(causes.get(cause) ?? []), flight]);
}
for (const [cause, list] of [...causes].sort((a, b) => b[1].length - a[1].length)) {
  tell(`failed, ${cause}`, `${list.length} (${list.filter(isOwn).length} where the altimeter fits): ` +
    `${list.slice(0, 12).map((flight) => flight.id).join(', ')}`);
}
