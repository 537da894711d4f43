// One emergency site as a card: readable at arm's length.

import { el, svg } from './dom.js';
import { age, distance, fixed, heading, isKnown, margin, siteLetter, verdictSign } from './units.js';
import { shortText } from './watch_shape.js';

const arrow = (bearing_deg) => svg('svg', { viewBox: '-20 -20 40 40', class: 'arrow', 'aria-hidden': 'true' },
  svg('path', { d: 'M0 -17L12 13L0 6L-12 13Z', transform: `rotate(${bearing_deg})` }));

const fact = (name, value) => el('div', {}, el('dt', {}, name), el('dd', {}, value));

const minutes = (time_s) => `${Math.floor(time_s / 60)}:${String(Math.round(time_s % 60)).padStart(2, '0')} min`;

const ageText = (age_s) => (isKnown(age_s) ? `${age(age_s)} ago` : 'date unknown');

function facts(site, flightName) {
  return el('dl', {},
    fact('Final heading', site.approach ? heading(site.approach.heading_deg) : 'unknown'),
    isKnown(site.touchdown?.altitude_m) ? fact('Field elevation', fixed(site.touchdown.altitude_m, 0, 'm')) : null,
    isKnown(site.time_s) ? fact('Time to site', minutes(site.time_s)) : null,
    isKnown(site.ground_speed_mps) ? fact('Speed on final', fixed(site.ground_speed_mps, 1, 'm/s')) : null,
    fact('Photographed', ageText(site.age_s)),
    flightName ? fact('Flight', flightName) : null,
    site.unseen_ratio > 0 ? fact('Circle not fully measured', fixed(100 * site.unseen_ratio, 0, '%')) : null);
}

// The three numbers that are flown: direction, distance, height to spare.
function course(site) {
  return el('div', { class: 'em-course' }, arrow(site.bearing_deg),
    el('div', {}, el('small', {}, 'Bearing'), el('strong', {}, heading(site.bearing_deg)), el('span', {}, distance(site.distance_m))),
    isKnown(site.arrival_margin_m)
      ? el('div', { class: site.arrival_margin_m < 0 ? 'bad' : '' }, el('small', {}, 'Arrival margin'),
        el('strong', { class: 'em-margin' }, margin(site.arrival_margin_m)))
      : el('small', { class: 'chip' }, 'reach unchecked'));
}

// site: of the emergency answer. flightName: of its flight, if known. strip: what new photographs show
// on it, or undefined. onShow() opens the site on the map.
export function emergencyCard(site, index, { flightName, strip, onShow }) {
  const letter = siteLetter(index);
  return el('article', { class: `em-card verdict-${site.verdict}`, 'aria-label': `Site ${letter}` },
    el('header', {}, el('span', { class: 'rank' }, letter),
      el('strong', {}, `Site ${letter} `, el('span', { class: 'em-verdict' }, `${verdictSign[site.verdict]} ${site.verdict}`)),
      el('button', { type: 'button', 'aria-label': `Show site ${letter} on the map`, onclick: onShow }, 'Show')),
    strip ? el('p', { class: 'new-on-strip' }, `! ${shortText(strip)}`) : null,
    course(site), facts(site, flightName));
}
