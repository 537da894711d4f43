// The panel of a landing that was planned at a clicked place.

import { paths } from './api.js';
import { byId, el } from './dom.js';
import { goAroundText, noReturnOf } from './go_around.js';
import { drawProfile } from './profile.js';
import { tiles } from './site.js';
import { courseTo, distance, verdictSign } from './units.js';

const placeOf = ({ lat, lng }) => ({ latitude_deg: lat, longitude_deg: lng });

export const landingPath = (flight, latlng, { wind, aircraft } = {}) => paths.landing(flight, placeOf(latlng), wind, aircraft);

const propertiesOf = (collection, kind) => collection.features.find(({ properties }) => properties.kind === kind);

// The plan of an answer, in the form of a site's properties. A server may leave out `plan`: the final has its numbers.
export function planOf(collection) {
  const final = propertiesOf(collection, 'approach')?.properties;
  return { verdict: collection.verdict, ...collection.plan, approach: collection.plan?.approach ?? final ?? null };
}

function whereText(collection, latlng) {
  const touchdown = propertiesOf(collection, 'touchdown')?.geometry.coordinates;
  if (!touchdown) return '';
  const { distance_m } = courseTo(placeOf(latlng), { longitude_deg: touchdown[0], latitude_deg: touchdown[1] });
  return distance_m < 1 ? 'The touchdown is at the chosen place.' : `The touchdown is ${distance(distance_m)} from the chosen place.`;
}

// answer: {collection} or {refusal}. curl: a button. Without an approach the refusal takes its place.
export function drawLanding({ collection, refusal }, latlng, aircraft, curl) {
  const plan = collection ? planOf(collection) : { verdict: 'rejected', warnings: [] };
  byId('landing-curl').replaceChildren(curl);
  const title = byId('landing-title');
  title.textContent = collection ? `${verdictSign[plan.verdict]} Landing here: ${plan.verdict}` : '✕ No landing here';
  title.className = `landing-title verdict-${plan.verdict}`;
  byId('landing-text').textContent = [collection ? plan.summary : `${refusal}.`, collection ? whereText(collection, latlng) : null,
    collection ? goAroundText(plan.approach, collection) : null].filter(Boolean).join(' ');
  byId('landing-tiles').replaceChildren(...(collection ? tiles(plan) : []));
  byId('landing-warnings').replaceChildren(...(plan.warnings ?? []).map((warning) => el('li', {}, warning)));
  byId('landing-warning-box').hidden = (plan.warnings ?? []).length === 0;
  drawProfile(byId('landing-profile'), collection?.profile, aircraft, collection ? noReturnOf(collection) : null);
  title.focus({ preventScroll: true });
}
