// Asks the server why the planner would, or would not, touch down at a clicked place. The page has no
// rule of its own.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { el } from './dom.js';
import { patchRow, proofFolds } from './proof.js';
import { nearestLimitText } from './proof_shape.js';
import { fixed, isKnown, verdictSign, words } from './units.js';

const title = { landable: 'Landable here', unverified: 'Unverified here', rejected: 'Not landable' };

// What it means that a rule fails.
const fault = {
  seen: 'unseen', grass: 'no grass', slope: 'too steep', roughness: 'too rough', object: 'an object',
  hazard_distance: 'too close to a hazard', outline: 'outside the region', region: 'region refused',
  wind: 'wind too strong', ground_roll: 'ground roll not free', final: 'final blocked', final_seen: 'final unseen',
  circle: 'loiter circle blocked', surroundings: 'blocked on another map',
  circle_seen: 'loiter circle not fully measured', wind_known: 'wind unknown',
};

export function headlineOf({ verdict, first_failed }) {
  const why = first_failed ? `: ${fault[first_failed] ?? words(first_failed)}` : '';
  return `${verdictSign[verdict]} ${title[verdict]}${why}`;
}

const ruleItem = ({ rule, passed, sentence }) => el('li', { class: passed ? 'pass' : 'fail', 'data-rule': rule },
  el('b', { 'aria-label': passed ? 'passed' : 'failed' }, passed ? '✓' : '✕'),
  el('span', {}, el('strong', {}, words(rule)), ` ${sentence}`));

const ruleList = (rules) => el('ul', { class: 'rules' }, rules.map(ruleItem));

function evidenceText({ height_m, height_sd_m, grass_probability }) {
  const known = [
    isKnown(height_m) ? `ground at ${fixed(height_m, 1, 'm')}` : null,
    isKnown(height_sd_m) ? `± ${fixed(height_sd_m, 2, 'm')}` : null,
    isKnown(grass_probability) ? `grass ${fixed(100 * grass_probability, 0, '%')}` : null,
  ].filter(Boolean);
  return known.length ? `Map: ${known.join(', ')}.` : 'Nothing is stored about this place.';
}

// "14 other rules: 3 failed", or "15 rules passed".
function summaryOf(others, hasFailed) {
  if (!hasFailed) return `${others.length} rule${others.length === 1 ? '' : 's'} passed`;
  const numFailed = others.filter((rule) => !rule.passed).length;
  return `${others.length} other rule${others.length === 1 ? '' : 's'}: ${numFailed || 'none'} failed`;
}

// signal: stops loading the pictures.
export function answerNode(judgement, signal) {
  const first = judgement.rules.find((rule) => !rule.passed);
  const others = judgement.rules.filter((rule) => rule !== first);
  const nearest = nearestLimitText(judgement.nearest_limit);
  return el('div', { class: `answer verdict-${judgement.verdict}` },
    el('h3', {}, headlineOf(judgement)),
    first ? ruleList([first]) : null,
    nearest ? el('p', { class: 'nearest-limit' }, nearest) : null,
    (judgement.warnings ?? []).map((warning) => el('p', { class: 'faint' }, `Warning: ${warning}`)),
    patchRow(judgement.evidence, signal),
    el('p', { class: 'faint evidence' }, evidenceText(judgement.evidence)),
    others.length ? el('details', { class: 'fold other-rules' },
      el('summary', {}, summaryOf(others, Boolean(first))), ruleList(others)) : null,
    proofFolds(judgement));
}

const nothing = (text) => el('div', { class: 'answer' }, el('h3', {}, headlineOf({ verdict: 'rejected', first_failed: 'seen' })),
  el('p', {}, `${text} Unseen ground is never safe.`));

// Returns the answer as a DOM node. from: {flight: whose map covers the place, or null, site: the selected site or null}.
// plan: {wind, aircraft} where the page shows another plan than the stored one.
export async function whyNot({ lat, lng }, { flight, site }, { wind, aircraft } = {}, signal = undefined) {
  if (!flight && !site) return nothing('No map covers this place.');
  const place = { latitude_deg: lat, longitude_deg: lng };
  const path = flight ? api.paths.flightWhy(flight, place, wind, aircraft) : api.paths.why(site.properties.id, place, wind, aircraft);
  const { judgement, refusal } = await api.getWhy(path, signal);
  if (refusal) return nothing(`Not checked: ${refusal}.`);
  const answer = answerNode(judgement, signal);
  answer.append(el('div', { class: 'card-foot' }, curlButton('this answer', () => curlOf(path))));
  return answer;
}
