// One emergency site as a card: readable at arm's length.

import { el, svg } from './dom.js';
import { arrival, doubts, groundAge, sentence } from './emergency_text.js';
import { distance, fixed, heading, isKnown, siteLetter, verdictSign } from './units.js';

const arrow = (bearing_deg) => svg('svg', { viewBox: '-20 -20 40 40', class: 'arrow', 'aria-hidden': 'true' },
  svg('path', { d: 'M0 -17L12 13L0 6L-12 13Z', transform: `rotate(${bearing_deg})` }));

const fact = (name, value, isBad = false) => el('div', {}, el('dt', {}, name), el('dd', { class: isBad ? 'bad' : null }, value));

const minutes = (time_s) => `${Math.floor(time_s / 60)}:${String(Math.round(time_s % 60)).padStart(2, '0')} min`;

function facts(site, flightName) {
  const ground = groundAge(site);
  return el('dl', {},
    fact('Final heading', site.approach ? heading(site.approach.heading_deg) : 'unknown'),
    isKnown(site.touchdown?.altitude_m) ? fact('Field elevation', fixed(site.touchdown.altitude_m, 0, 'm')) : null,
    isKnown(site.time_s) ? fact('Time to site', minutes(site.time_s)) : null,
    isKnown(site.ground_speed_mps) ? fact('Speed on final', fixed(site.ground_speed_mps, 1, 'm/s')) : null,
    fact('Photographed', ground.text, ground.isOld),
    flightName ? fact('Flight', flightName) : null);
}

// The three numbers that are flown: direction, distance, height to spare.
function course(site) {
  const { name, value, kind } = arrival(site);
  return el('div', { class: 'em-course' }, arrow(site.bearing_deg),
    el('div', {}, el('small', {}, 'Bearing'), el('strong', {}, heading(site.bearing_deg)), el('span', {}, distance(site.distance_m))),
    isKnown(site.arrival_margin_m)
      ? el('div', { class: `em-arrival ${kind}` }, el('small', {}, name), el('strong', { class: 'em-margin' }, value))
      : el('small', { class: 'chip' }, 'reach unchecked'));
}

// A site out of reach must not look like one that can be flown to, whatever its ground is like.
function verdictOf(site, wind) {
  const isMissed = site.reachable === false;
  const why = doubts(site, wind);
  return {
    className: `verdict-${isMissed ? 'rejected' : site.verdict}`,
    text: isMissed ? '✕ not in reach' : `${verdictSign[site.verdict]} ${site.verdict}`,
    why: isMissed ? sentence(site.sentence ?? 'not in reach') : why.length > 0 ? sentence(`Unverified: ${why.join(', ')}`) : null,
  };
}

// site: of the emergency answer. flightName: of its flight, if known. wind: see doubts. onShow() opens
// the site on the map.
export function emergencyCard(site, index, { flightName, wind, onShow }) {
  const letter = siteLetter(index);
  const { className, text, why } = verdictOf(site, wind);
  return el('article', { class: `em-card ${className}`, 'aria-label': `Site ${letter}` },
    el('header', {}, el('span', { class: 'rank' }, letter),
      el('strong', {}, `Site ${letter} `, el('span', { class: 'em-verdict' }, text)),
      el('button', { type: 'button', 'aria-label': `Show site ${letter} on the map`, onclick: onShow }, 'Show')),
    course(site), facts(site, flightName),
    why ? el('p', { class: 'em-why' }, why) : null,
    (site.warnings ?? []).map((warning) => el('p', { class: 'em-why' }, `! ${sentence(warning)}`)));
}
