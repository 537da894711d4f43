// Texts of links to autopilots. No DOM.

import { age, clockOf, distance, fixed, heading, isKnown, margin, verdictSign, windFrom, windText, words } from './units.js';

export const linkName = (link) => (link.system_id && String(link.system_id) !== link.id
  ? `${link.id} (system ${link.system_id})` : `System ${link.id}`);

const autopilots = { ardupilotmega: 'ArduPilot', px4: 'PX4' };
const kindOf = ({ type, autopilot }) => [autopilots[autopilot] ?? autopilot, type && words(type)].filter(Boolean).join(', ');

export function modeText(link) {
  const armed = link.is_armed === true ? 'armed' : link.is_armed === false ? 'disarmed' : null;
  return [link.mode ?? 'mode unknown', armed].filter(Boolean).join(', ');
}

// The program may be silent, or hear no autopilot.
export function heardText(link) {
  if (link.is_connected) return `heard ${age(link.age_s)} ago`;
  if (link.heard_age_s >= 5) return `the link has been silent for ${age(link.heard_age_s)}`;
  return isKnown(link.age_s) ? `the autopilot has been silent for ${age(link.age_s)}` : 'no autopilot heard yet';
}

const sources = { autopilot: "the autopilot's estimate", drift: 'from drift', frame: 'sent with an image' };

export function windLine(wind) {
  if (!wind) return 'unknown';
  const deviation = isKnown(wind.sd_mps) ? ` ±${wind.sd_mps.toFixed(1)} m/s` : '';
  return `${windText(wind)}${deviation}, ${sources[wind.source] ?? 'source unknown'}, ${age(wind.age_s)} old`;
}

const sinceText = (time) => (time ? ` since ${clockOf(time)}` : '');

export function engineText({ engine }) {
  if (engine?.state !== 'failed') return engine?.state ?? 'unknown';
  const by = engine.declared_by ? `, declared by ${engine.declared_by}` : engine.reason ? `: ${engine.reason}` : '';
  return `FAILED${sinceText(engine.since)}${by}`;
}

// nameOf(site id): as the page calls the site.
export function missionText({ mission }, nameOf) {
  const state = mission?.state ?? 'unknown';
  const item = isKnown(mission?.current_item) ? `, item ${mission.current_item}${isKnown(mission.num_items) ? ` of ${mission.num_items}` : ''}` : '';
  if (mission?.alarm) return `${state}: ${mission.alarm}`;
  if (state === 'uploading') return 'being uploaded';
  if (state === 'unknown') return `unknown${item}`;
  return `${mission.site ? `landing at ${nameOf(mission.site)}` : mission.kind === 'other' ? "the autopilot's own" : 'current'}${item}`;
}

export function guidanceText({ guidance }, nameOf) {
  if (!guidance) return null;
  if (guidance.phase === 'ended') return guidance.text || 'ended';
  const where = guidance.site_id ? ` to ${nameOf(guidance.site_id)}` : '';
  const margin_m = Math.floor(guidance.arrival_margin_m);
  const arrival = isKnown(guidance.arrival_margin_m) ? `, arrives ${Math.abs(margin_m)} m ${margin_m < 0 ? 'BELOW' : 'above'} the final` : '';
  const time = isKnown(guidance.eta_s) ? `, ${age(guidance.eta_s)} left` : '';
  return `${guidance.phase ?? 'guided'}${where}${arrival}${time}${guidance.text ? `. ${guidance.text}` : ''}`;
}

const gapReasons = {
  too_low: 'too low', too_high: 'too high to lose the height in time', terrain: 'terrain or a known obstacle is in the way', no_approach: 'no safe approach in this wind',
  no_site: 'no site is stored near', not_evaluated: 'not evaluated',
};
const kOldCheck_s = 90;
const kTooOldCheck_s = 180;
const percent = (ratio) => `${Math.floor(100 * ratio + 1e-9)} %`;

function gapText({ in_s, lasts_s, reason }) {
  const why = gapReasons[reason] ? ` (${gapReasons[reason]})` : '';
  return in_s < 1 ? `NO SITE IN REACH NOW, for ${age(lasts_s)} more${why}` : `none in ${age(in_s)}, for ${age(lasts_s)}${why}`;
}

// Whether a site stays in reach without power on the rest of the mission.
export function insuranceText({ insurance, is_connected }) {
  if (!insurance) return null;
  if (!is_connected) return 'unknown: nothing is heard of the aircraft';
  if (insurance.state !== 'checked') return insurance.why ?? insurance.last_error ?? 'not checked yet';
  const { covered_ratio, time_s, end, first_gap: gap, point_of_no_return_in_s: last_s, age_s } = insurance;
  if (!(age_s <= kTooOldCheck_s)) return `unknown: the age of the last check is ${age(age_s)}`;
  const old = age_s > kOldCheck_s ? `. Checked ${age(age_s)} ago` : '';
  const what = `the next ${age(time_s)}${end === 'more of the mission' ? '' : `, to ${end}`}`;
  if (covered_ratio >= 1) return `a site, verified or not, is in reach on all of ${what}${old}`;
  const after = isKnown(last_s) ? `; none at all ${last_s > 0 ? `after ${age(last_s)}` : 'any more'}` : '';
  return `in reach for ${percent(covered_ratio)} of ${what}${gap ? `; ${gapText(gap)}` : ''}${after}${old}`;
}

const kOldPlace_s = 15;

// The best sites at this moment: [{id, text}]; null if they are not known.
export function alternatesOf({ alternates, is_connected, heard_age_s = 0 }, nameOf) {
  if (!is_connected || !(alternates?.age_s + heard_age_s <= kOldPlace_s)) return null;
  return alternates.sites.map(({ site_id, verdict, arrival_margin_m }) =>
    ({ id: site_id, text: `${verdictSign[verdict] ?? ''} ${nameOf(site_id)}, ${margin(arrival_margin_m)}`.trim() }));
}

export function picturesText({ pictures }) {
  if (!pictures) return null;
  const parts = [`${pictures.sent} sent`];
  if (pictures.waiting) parts.push(`${pictures.waiting} waiting`);
  if (pictures.unpaired) parts.push(`${pictures.unpaired} without a sure trigger, not sent`);
  if (pictures.refused) parts.push(`${pictures.refused} refused: ${pictures.last_refusal}`);
  if (pictures.incomplete) parts.push(`${pictures.incomplete} not whole`);
  return [parts.join(', '), pictures.text].filter(Boolean).join('. ');
}

// What a person must know at once.
export function alarmsOf(link) {
  const name = linkName(link);
  return [
    link.engine?.state === 'failed' ? `${name}: engine ${engineText(link)}` : null,
    link.mission?.alarm ? `${name}: ${link.mission.alarm}` : null,
    !link.is_connected && (link.guidance && link.guidance.phase !== 'ended') ? `${name}: ${heardText(link)} while it was guided` : null,
  ].filter(Boolean);
}

const commandNames = { mission: 'Land here', engine_failure: 'Engine failed', release: 'Release', rally: 'Rally points' };
const commandStates = { queued: 'waits for the link', taken: 'taken by the link', done: 'done', failed: 'failed', expired: 'not taken: it was too late' };

export function commandText(command, nameOf) {
  const site = command.site_id ? ` (${nameOf(command.site_id)})` : '';
  const detail = command.detail ? `: ${command.detail}` : '';
  return `${clockOf(command.issued_at)} ${commandNames[command.kind] ?? words(command.kind)}${site}: ${commandStates[command.state] ?? command.state}${detail}`;
}

const optional = (name, text, isAlarm) => (text === null ? null : [name, text, Boolean(isAlarm)]);

// Positions come several times a second.
const longestGap_s = 5;
const oldText = ({ age_s }) => (age_s > longestGap_s ? `, ${age(age_s)} old` : '');

// [name, text, whether it is an alarm]
export function linkRows(link, nameOf) {
  const { position } = link;
  return [
    ['Autopilot', kindOf(link) || 'unknown'],
    ['Mode', modeText(link)],
    ['Position', position ? `${position.latitude_deg.toFixed(5)}°, ${position.longitude_deg.toFixed(5)}°, ${fixed(position.altitude_m, 0, 'm')} ${position.altitude_datum === 'amsl' ? 'AMSL' : ''}`.trim() + oldText(position) : 'unknown'],
    ['Height above home', fixed(position?.height_above_home_m, 0, 'm')],
    ['Wind', windLine(link.wind)],
    ['Engine', engineText(link), link.engine?.state === 'failed'],
    ['Mission', missionText(link, nameOf), Boolean(link.mission?.alarm)],
    link.guidance ? ['Guidance', guidanceText(link, nameOf)] : null,
    optional('In reach now', alternatesOf(link, nameOf)?.length === 0 ? 'NO SITE' : null, true),
    optional('Rest of the mission', insuranceText(link), link.insurance?.first_gap?.in_s < 1),
    optional('Pictures', picturesText(link), link.pictures?.refused > 0),
    link.is_signed === undefined ? null : ['Packets', link.is_signed ? 'signed' : 'not signed'],
  ].filter(Boolean);
}

// What to tell of a command that was refused. 401 and 403: this token may not command.
export function refusalText({ status, message }) {
  const advice = status === 401 || status === 403 ? '. A command needs a token with the scope command' : '';
  return `Not sent: ${message}${advice}.`;
}

// --- What "Land here" makes the aircraft fly ---

const partOf = (collection, kind) => collection.features.find(({ properties }) => properties.kind === kind);
const altitude = (coordinates) => fixed(coordinates?.[2], 0, 'm');

const kOldWind_s = 60;

// The wind that a landing is planned for: the link's, in the numbers of a request; null if it is not known now.
export function landingWind({ wind }) {
  if (!wind || !isKnown(wind.age_s) || wind.age_s > kOldWind_s) return null;
  return { east_mps: Number(wind.east_mps.toFixed(3)), north_mps: Number(wind.north_mps.toFixed(3)) };
}

// p: properties of the site with the plan that will be flown. collection: its approach.
export function landingRows(p, collection) {
  const { approach } = p;
  const final = partOf(collection, 'approach')?.geometry.coordinates ?? [];
  const circle = partOf(collection, 'loiter')?.geometry.coordinates ?? [];
  const touchdown = partOf(collection, 'touchdown')?.geometry.coordinates;
  const datum = { amsl: ' AMSL', ellipsoid: ' above the ellipsoid' }[p.altitude_datum] ?? '';
  return [
    ['Circle', `${approach.loiter_direction}, radius ${fixed(approach.loiter_radius_m, 0, 'm')}, down to ${altitude(circle[0] ?? final[0])}${datum}`],
    ['Final', `${heading(approach.heading_deg)}, ${distance(approach.distance_m)} long, from ${altitude(final[0])}${datum} (${fixed(approach.height_m, 0, 'm')} above the touchdown)`],
    ['Touchdown', `${altitude(touchdown)}${datum}`],
    ['Least clearance', isKnown(approach.min_clearance_m) ? `${(Math.floor(10 * approach.min_clearance_m) / 10).toFixed(1)} m` : 'unknown'],
    ['Approach speed', fixed(p.aircraft?.landing_airspeed_mps, 0, 'm/s')],
    ['Planned for wind', windText(p.wind)],
    ['Ground speed on final', fixed(approach.ground_speed_mps, 0, 'm/s')],
  ];
}

const kWindChange_mps = 2;
const kOldGround_s = 30 * 86400;

const windChange_mps = (a, b) => Math.hypot(a.east_mps - b.east_mps, a.north_mps - b.north_mps);

// Sentences, the worst first.
export function landingWarnings(p, link, groundAge_s) {
  const now = link.wind;
  return [
    p.verdict === 'unverified' ? `This site is UNVERIFIED: ${p.summary}` : null,
    link.engine?.state === 'failed' ? 'The engine has failed: a mission does not check whether the site can be reached. Use “Engine failed” on the link instead.' : null,
    p.altitude_datum !== 'amsl' ? 'The altitudes of this site are not above mean sea level: the link converts them, or refuses.' : null,
    !landingWind(link) ? 'The wind is not known now: this is the stored plan.' : null,
    now && !p.wind ? `The final is planned for an unknown wind; now ${windText(now)}.` : null,
    now && p.wind && windChange_mps(now, p.wind) > kWindChange_mps ? `The wind has changed: planned for ${windText(p.wind)}, now ${windText(now)}. Close this and open it again.` : null,
    now && windFrom(now).speed_mps > 0.6 * (p.aircraft?.landing_airspeed_mps ?? Infinity) ? 'The wind is stronger than 60 % of the approach speed.' : null,
    isKnown(groundAge_s) ? null : 'When the ground was photographed is unknown.',
    groundAge_s > kOldGround_s ? `The ground was photographed ${age(groundAge_s)} ago.` : null,
    link.mission?.state === 'uploading' ? 'Another mission is being uploaded.' : null,
    ...(p.warnings ?? []),
    'The upload replaces the mission that is in the autopilot now.',
  ].filter(Boolean);
}
