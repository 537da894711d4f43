// One emergency site as a card: readable at arm's length.

import { el, svg } from './dom.js';
import { age, distance, fixed, heading, isKnown, verdictSign } from './units.js';

const arrow = (bearing_deg) => svg('svg', { viewBox: '-20 -20 40 40', class: 'arrow', 'aria-hidden': 'true' },
  svg('path', { d: 'M0 -17L12 13L0 6L-12 13Z', transform: `rotate(${bearing_deg})` }));

const fact = (name, value, className = '') =>
  el('div', { class: className }, el('dt', {}, name), el('dd', {}, value));

const margin = (value_m) => `${value_m >= 0 ? '+' : '−'}${fixed(Math.abs(value_m), 0, 'm')}`;
const minutes = (time_s) => `${Math.floor(time_s / 60)}:${String(Math.round(time_s % 60)).padStart(2, '0')} min`;

function facts(site) {
  return el('dl', {},
    fact('Final heading', site.approach ? heading(site.approach.heading_deg) : 'unknown', 'big'),
    site.arrival_margin_m === undefined ? null : fact('Arrival margin', margin(site.arrival_margin_m), 'big'),
    isKnown(site.time_s) ? fact('Time to site', minutes(site.time_s)) : null,
    isKnown(site.ground_speed_mps) ? fact('Ground speed on final', fixed(site.ground_speed_mps, 1, 'm/s')) : null,
    fact('Photographed', `${age(site.age_s)} ago`),
    site.unseen_ratio > 0 ? fact('Circle unseen', fixed(100 * site.unseen_ratio, 0, '%')) : null);
}

// site: of the emergency answer. onShow(site) opens the site on the map.
export function emergencyCard(site, index, onShow) {
  return el('article', { class: `em-card verdict-${site.verdict}`, 'aria-label': `Site ${index + 1}` },
    el('header', {}, el('span', { class: 'rank' }, index + 1),
      el('strong', {}, `${verdictSign[site.verdict]} ${site.verdict}`),
      site.reach === 'unknown' ? el('span', { class: 'chip' }, 'reach unchecked') : null),
    el('div', { class: 'em-course' }, arrow(site.bearing_deg),
      el('div', {}, el('small', {}, 'Bearing, distance'),
        el('strong', {}, heading(site.bearing_deg)), el('span', {}, distance(site.distance_m)))),
    facts(site),
    el('button', { type: 'button', class: 'wide', onclick: () => onShow(site) }, 'Show on map'));
}
