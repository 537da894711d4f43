// The final of the selected site in its card: clearance along it, and the go-around.

import { byId } from './dom.js';
import { goAroundText, noReturnOf } from './go_around.js';
import { drawProfile } from './profile.js';

let shown = [];

// answer: {collection, or refusal} of an approach; approach: of the plan that is shown.
export function drawFinal({ collection, refusal }, approach, aircraft) {
  byId('no-profile').hidden = Boolean(collection);
  byId('no-profile').textContent = refusal ? `No approach: ${refusal}` : 'This site has no approach.';
  shown = [collection?.profile, aircraft, noReturnOf(collection)];
  drawProfile(byId('profile'), ...shown);
  const goAround = collection ? goAroundText(approach, collection) : null;
  byId('go-around').hidden = !goAround;
  byId('go-around').textContent = goAround ?? '';
}

addEventListener('freelsd-theme', () => drawProfile(byId('profile'), ...shown));
