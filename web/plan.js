// The site as it is with another plan than its stored one: for a trial wind, or of an emergency answer.

import { courseTo } from './units.js';

function placeOf({ coordinates: [longitude_deg, latitude_deg] }) {
  return { latitude_deg, longitude_deg };
}

const touchdownOf = (collection) => collection?.features.find((f) => f.properties.kind === 'touchdown')?.geometry;

// Metres between the touchdown of a plan and the stored one of the site; 0 if one of them is unknown.
export function movedBy({ geometry: stored }, collection) {
  const touchdown = touchdownOf(collection);
  return touchdown && stored ? courseTo(placeOf(stored), placeOf(touchdown)).distance_m : 0;
}

// Numbers of a path that was not found.
const kNoPath = {
  verdict: 'rejected', reject_reason: 'no_approach', approach: null, unseen_ratio: null, usable_length_m: null,
  usable_width_m: null, rejections: [], why: '',
};

// An answer ({collection} or {refusal}) whose plan is landable only if the answer that it was chosen from said so: that one
// knows how old the wind is.
export function atBest(verdict, { collection, refusal }) {
  if (verdict !== 'unverified' || collection?.plan?.verdict !== 'landable') return { collection, refusal };
  const plan = { ...collection.plan, verdict, summary: 'Unverified: the emergency answer does not rely on its wind' };
  return { collection: { ...collection, plan } };
}

const isOfUnknownWind = (warning) => warning.startsWith('the wind is unknown');

// The site as it would be with the plan of an answer ({collection} or {refusal}) for the tried wind.
export function siteWithPlan({ properties, geometry }, { collection, refusal }, tried) {
  const plan = collection?.plan ?? { ...kNoPath, reject_detail: refusal, summary: `Rejected: ${refusal}` };
  const stored = (properties.warnings ?? []).filter((warning) => tried === 'unknown' || !isOfUnknownWind(warning));
  const warnings = [...new Set([...stored, ...(plan.warnings ?? [])])];
  return { type: 'Feature', geometry: touchdownOf(collection) ?? geometry, properties: { ...properties, reject_reason: undefined,
    reject_detail: undefined, ...plan, wind: tried === 'unknown' ? null : tried, warnings, is_trial: true } };
}

// The list of sites, one of them with the plan that is shown. planned: of siteWithPlan, or null.
export function sitesWithPlan(sites, planned) {
  if (!planned) return sites;
  const features = sites.features.map((f) => (f.properties.id === planned.properties.id
    ? { ...planned, properties: { ...planned.properties, rank: f.properties.rank } } : f));
  return { ...sites, features };
}

// Marks on the map for the index-th rejected touchdown and its obstacle.
export function marksOf(rejection, index) {
  const letter = String.fromCharCode(97 + index % 26);
  const touchdown = { place: rejection.touchdown, sign: letter, className: 'refused', title: `Rejected touchdown: ${rejection.detail}` };
  return rejection.obstacle ? [touchdown, { place: rejection.obstacle, sign: '!', className: 'obstacle', title: 'Obstacle' }] : [touchdown];
}
