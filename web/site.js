// The panel of the selected site.

import { paths } from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el } from './dom.js';
import { drawDownloads } from './downloads.js';
import { obstacleText } from './obstacle_shape.js';
import { age, area, distance, fixed, groundAge_s, heading, isKnown, photographed, strip, verdictSign, windText, words } from './units.js';

const tile = (name, value, note) => el('div', { class: 'tile' },
  el('span', {}, name), el('strong', {}, value), note ? el('small', {}, note) : null);

function coverage(unseen_ratio) {
  if (!isKnown(unseen_ratio)) return 'unknown whether measured';
  return unseen_ratio > 0 ? `ground along ${fixed(100 * unseen_ratio, 0, '%')} not fully measured` : 'ground fully measured';
}

function obstacleTile({ tightest_obstacle: obstacle }) {
  if (!obstacle) return tile('Tightest obstacle', obstacle === null ? 'none' : 'unknown', 'below final and loiter circle');
  return tile('Tightest obstacle', fixed(obstacle.clearance_m, 1, 'm'),
    `below the ${obstacle.part === 'final' ? 'final' : 'loiter circle'}, ${distance(obstacle.distance_m)} from touchdown`);
}

export function tiles(p) {
  const { approach } = p;
  if (!approach) {
    return [tile('Nearest hazard', distance(p.hazard_distance_m)), tile('Usable strip', strip(p)),
      tile('Slope', fixed(p.slope_deg, 1, '°')), tile('Wind', windText(p.wind))];
  }
  return [
    tile('Final heading', heading(approach.heading_deg), `length ${distance(approach.distance_m)}` +
      (approach.crosswind_mps > 0 ? `, crosswind ${fixed(approach.crosswind_mps, 1, 'm/s')}` : '') +
      (isKnown(approach.ground_speed_mps) ? `, ground speed ${fixed(approach.ground_speed_mps, 1, 'm/s')}` : '')),
    tile('Usable strip', strip(p), `hazard at ${distance(p.hazard_distance_m)}, slope ${fixed(p.slope_deg, 1, '°')}`),
    obstacleTile(approach),
    tile('Loiter circle', approach.loiter_direction, `radius ${distance(approach.loiter_radius_m)}, ` +
      `${distance(approach.height_m)} above touchdown, ${coverage(p.unseen_ratio)}`),
  ];
}

// "1.3 % (ground 1.1 %, final 0.2 %, circle 0 %)". One flight may fail by several parts.
function riskText({ failure_probability, failure_parts }) {
  if (!isKnown(failure_probability)) return 'unknown';
  const percent = (share) => `${(100 * share).toFixed(1)} %`;
  const parts = ['ground', 'final', 'circle'].map((part) => `${part} ${percent(failure_parts[part])}`);
  return `${percent(failure_probability)} (${parts.join(', ')})`;
}

function numbersTable(p, [lon, lat]) {
  const evidence = `grass in ${p.num_grass_observations} of ${p.num_observations} views`;
  const rows = [
    ['Touchdown', `${lat.toFixed(6)}°, ${lon.toFixed(6)}°`],
    ['Elevation', `${fixed(p.elevation_m, 1, 'm')} (datum ${p.altitude_datum ?? 'unknown'})`],
    ['Slope', fixed(p.slope_deg, 1, '°')],
    ['Roughness', fixed(p.roughness_m, 2, 'm')],
    ['Usable strip', strip(p)],
    ['Hazard-free radius', distance(p.hazard_distance_m)],
    ['Risk of a failed landing', riskText(p)],
    ['Rectangle of the region', `${area(p.area_m2)}, hazards included`],
    ['Grade', `${p.grade.toFixed(2)} (${evidence})`],
    [p.is_trial ? 'Wind of this plan' : 'Wind of the flight', windText(p.wind)],
    ['Ground photographed', isKnown(groundAge_s(p)) ? `${age(groundAge_s(p))} ago` : 'date unknown'],
    ['Site ID', p.id],
  ];
  return el('table', { class: 'numbers' }, el('tbody', {}, rows.map(([name, value]) =>
    el('tr', {}, el('th', { scope: 'row' }, name), el('td', {}, value)))));
}

const unitOf = (name) => ({ m2: 'm²', mps: 'm/s', deg: '°', m: 'm' })[/_(m2|mps|deg|m)$/.exec(name)?.[1]] ?? '';

function aircraftTable(aircraft) {
  return el('table', { class: 'numbers' }, el('tbody', {}, Object.entries(aircraft ?? {}).map(([name, value]) =>
    el('tr', {}, el('th', { scope: 'row' }, words(name.replace(/_(m2|mps|deg|m)$/, ''))),
      el('td', {}, `${value} ${unitOf(name)}`)))));
}

// onPlace(index) shows the rejected touchdown and its obstacle on the map.
function rejectionItem(rejection, index, onPlace) {
  return el('li', {}, el('button', { type: 'button', class: 'rejection', onclick: () => onPlace(index) },
    el('span', { class: 'rank', 'aria-hidden': 'true' }, String.fromCharCode(97 + index % 26)),
    el('span', { class: 'site-text' },
      el('strong', {}, `✕ ${words(rejection.reason)}`), el('small', {}, rejection.detail))));
}

const curlOfPart = (p, name) => `${curlOf(paths.site(p.id))} | jq .properties.${name}`;

function section(title, body, { what, command, isOpen = true, id }) {
  return el('details', { class: 'card', open: isOpen, id },
    el('summary', {}, el('h3', {}, title)),
    body, what ? el('div', { class: 'card-foot' }, curlButton(what, command)) : null);
}

function whyNotSection(p, onPlace) {
  const rejections = p.rejections ?? [];
  const own = p.verdict === 'rejected' ? [el('p', { class: 'outcome rejected' },
    el('strong', {}, `✕ ${words(p.reject_reason ?? 'rejected')}`), el('span', {}, p.reject_detail ?? p.summary))] : [];
  if (rejections.length === 0 && own.length === 0) return null;
  const title = p.verdict === 'rejected' ? 'Why rejected' : 'Rejected better touchdowns';
  const list = el('ul', { class: 'rejections' }, rejections.map((r, i) => rejectionItem(r, i, onPlace)));
  return section(title, [...own, rejections.length ? list : null],
    { isOpen: p.verdict === 'rejected', id: 'why-not', what: 'the rejections', command: () => curlOfPart(p, 'rejections') });
}

export function drawSiteHead(p) {
  byId('site-head').className = `site-head verdict-${p.verdict}`;
  byId('site-rank').textContent = p.rank ?? '';
  byId('site-title').textContent = `${verdictSign[p.verdict]} ${p.verdict[0].toUpperCase()}${p.verdict.slice(1)}`;
  byId('site-score').textContent = p.verdict === 'rejected' ? '' : `score ${p.score.toFixed(2)}`;
  byId('site-summary').replaceChildren(p.summary, ' ', el('span', { class: 'faint' }, `Ground ${photographed(p)}.`));
  byId('site-curl').replaceChildren(curlButton('this site', () => curlOf(paths.site(p.id))));
}

// The obstacles that stand in the way. obstacles.find(id): the obstacle as a feature, undefined if it is not loaded.
function drawBlocked({ blocked_by: ids = [] }, obstacles) {
  byId('site-blocked').hidden = ids.length === 0;
  byId('site-blocked').replaceChildren(el('strong', {}, 'Blocked by an obstacle'), ...ids.map((id) => el('button',
    { type: 'button', class: 'wide', 'data-obstacle': id, onclick: () => obstacles.show(id) }, obstacles.find(id) ? obstacleText(obstacles.find(id)) : id)));
}

// The summaries of the open sections, null if no site was drawn: a redraw keeps what the user opened.
function openTitles(node) {
  const sections = [...node.querySelectorAll('details')];
  return sections.length ? sections.filter((each) => each.open).map((each) => each.querySelector('summary').textContent) : null;
}

function keepOpen(node, titles) {
  if (!titles) return;
  for (const each of node.querySelectorAll('details:not(#why-not)')) {
    each.open = titles.includes(each.querySelector('summary').textContent);
  }
}

// feature: the site as stored, or with the plan for a trial wind (is_trial) in place of its own.
// on: {place(index): shows a rejection, wind(): the trial wind or null,
// obstacles: {find(id), show(id)}}
export function drawSite(feature, on) {
  const { properties: p, geometry } = feature;
  drawSiteHead(p);
  drawBlocked(p, on.obstacles);
  byId('site-tiles').replaceChildren(...tiles(p));
  byId('approach-curl').replaceChildren(curlButton('this approach', () => curlOf(paths.approach(p.id, on.wind()))));
  const warnings = p.warnings ?? [];
  const opened = openTitles(byId('site-more'));
  byId('site-more').replaceChildren(...[
    whyNotSection(p, on.place),
    section('Reason for the rank', el('p', {}, p.why ?? ''), { what: 'the reason', command: () => curlOfPart(p, 'why') }),
    warnings.length ? section('Warnings', el('ul', { class: 'plain' }, warnings.map((w) => el('li', {}, w))),
      { what: 'the warnings', command: () => curlOfPart(p, 'warnings') }) : null,
    section('Export', [p.is_trial ? el('p', {}, 'Files hold the stored plan, not the plan shown.') : null,
      drawDownloads(paths.site(p.id), paths.site(p.id), p)].filter(Boolean), { id: 'site-downloads' }),
    section('All values', numbersTable(p, geometry.coordinates),
      { isOpen: false, what: 'all values', command: () => `${curlOf(paths.site(p.id))} | jq .` }),
    section('Aircraft', aircraftTable(p.aircraft),
      { isOpen: false, what: 'the aircraft', command: () => curlOfPart(p, 'aircraft') }),
  ].filter(Boolean));
  if (byId('site-more').dataset.site === p.id) keepOpen(byId('site-more'), opened);
  byId('site-more').dataset.site = p.id;
}
