// The list of ranked sites.

import { byId, el } from './dom.js';
import { fixed, heading, photographed, strip, verdictSign, words } from './units.js';

const kinds = { landable: 'Landable', unverified: 'Unverified', rejected: 'Rejected' };

function numbersOf(p) {
  const trial = p.is_trial ? 'for another wind, ' : '';
  return trial + planNumbersOf(p);
}

function planNumbersOf(p) {
  if (p.verdict === 'rejected') return p.reject_reason ? words(p.reject_reason) : 'reason unknown';
  const land = p.approach ? `final ${heading(p.approach.heading_deg)}, ` : '';
  const unseen = p.verdict === 'unverified' && p.unseen_ratio ? `circle ${Math.round(100 * p.unseen_ratio)} % not fully measured, ` : '';
  return `${land}${unseen}hazard at ${fixed(p.hazard_distance_m, 0, 'm')}, strip ${strip(p)}`;
}

function row(p, isChosen, onSite) {
  return el('li', {}, el('button', {
    type: 'button', 'data-site': p.id, 'aria-pressed': isChosen, class: `site-row verdict-${p.verdict}`,
    onclick: () => onSite(p.id),
  },
  el('span', { class: 'rank', 'aria-hidden': 'true' }, p.rank),
  el('span', { class: 'site-text' },
    el('strong', {}, el('span', { class: 'sign', 'aria-hidden': 'true' }, verdictSign[p.verdict]), ` ${kinds[p.verdict]}`),
    el('small', {}, `${numbersOf(p)}, ${photographed(p)}`)),
  el('span', { class: 'score', title: 'Score, 0 to 1' }, p.verdict === 'rejected' ? '–' : p.score.toFixed(2))));
}

// flight: explains an empty list. null if there is no flight.
export function drawSiteList(collection, chosenId, onSite, flight) {
  const focused = document.activeElement?.dataset?.site;
  const list = byId('sites');
  list.replaceChildren(...collection.features.map(({ properties }) =>
    row(properties, properties.id === chosenId, onSite)));
  if (focused) list.querySelector(`[data-site="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
  const count = collection.features.length;
  const isBusy = flight && flight.state !== 'idle' && flight.state !== 'failed';
  const empty = byId('no-sites');
  empty.hidden = count > 0;
  empty.textContent = !flight ? 'No flight yet. Open Upload to send photographs.'
    : isBusy ? 'No site yet. Processing continues.'
      : flight.frames.received === 0 ? 'No photographs in this flight. Open Upload to send some.'
        : 'No site yet. Open Flight and press “Evaluate all regions”.';
}
