// The list of sites and the numbers of the chosen one.

import { verdictColor } from './colors.js';

const byId = (id) => document.getElementById(id);

function element(name, text) {
  const node = document.createElement(name);
  if (text !== undefined) node.textContent = text;
  return node;
}

const fixed = (value, digits, unit) =>
  value === null || value === undefined ? 'unknown' : `${value.toFixed(digits)} ${unit}`;

export function drawSiteList(collection, chosenId, onSite) {
  byId('no-sites').hidden = collection.features.length > 0;
  byId('sites').replaceChildren(...collection.features.map((feature) => {
    const p = feature.properties;
    const button = element('button');
    button.type = 'button';
    button.dataset.site = p.id;
    button.setAttribute('aria-pressed', String(p.id === chosenId));
    button.style.setProperty('--verdict', verdictColor[p.verdict]);
    const reason = p.reject_reason ? ` (${p.reject_reason.replaceAll('_', ' ')})` : '';
    button.append(element('strong', `${p.rank}. ${p.verdict}${reason}`));
    button.append(element('br'));
    button.append(element('small',
      `score ${p.score.toFixed(2)}, ${Math.round(p.area_m2)} m², ` +
      `hazard ${fixed(p.hazard_distance_m, 0, 'm')} away`));
    button.addEventListener('click', () => onSite(p.id));
    const item = element('li');
    item.append(button);
    return item;
  }));
}

function numbersOf(p) {
  const rows = [
    ['Score', p.score.toFixed(2)],
    ['Distance to hazard', fixed(p.hazard_distance_m, 1, 'm')],
    ['Slope', fixed(p.slope_deg, 1, '°')],
    ['Roughness', fixed(p.roughness_m, 2, 'm')],
    ['Area', fixed(p.area_m2, 0, 'm²')],
    ['Grade', `${p.grade.toFixed(2)} (${p.num_grass_observations} of ${p.num_observations})`],
    ['Elevation', fixed(p.elevation_m, 1, 'm')],
    ['Wind to', p.wind
      ? `${p.wind.east_mps.toFixed(1)} east, ${p.wind.north_mps.toFixed(1)} north m/s`
      : 'unknown'],
  ];
  if (p.approach) {
    rows.push(
      ['Heading on final', fixed(p.approach.heading_deg, 0, '°')],
      ['Final', fixed(p.approach.distance_m, 0, 'm')],
      ['Loiter', `${p.approach.loiter_direction}, ${fixed(p.approach.loiter_radius_m, 0, 'm')}`],
      ['Least clearance', fixed(p.approach.min_clearance_m, 1, 'm')],
      ['Circle unseen', fixed(100 * (p.unseen_ratio ?? 0), 0, '%')],
    );
  }
  return rows;
}

export function drawSite(feature) {
  byId('site-panel').hidden = !feature;
  if (!feature) return;
  const p = feature.properties;
  byId('site-title').textContent = `Site ${p.rank ?? ''}: ${p.verdict}`;
  byId('site-summary').textContent = p.summary;
  byId('site-numbers').replaceChildren(...numbersOf(p).map(([name, value]) => {
    const row = element('tr');
    const head = element('th', name);
    head.scope = 'row';
    row.append(head, element('td', value));
    return row;
  }));
  const rejections = p.rejections ?? [];
  byId('rejections-title').hidden = rejections.length === 0;
  byId('rejections').replaceChildren(
    ...rejections.slice(0, 6).map((r) => element('li', `${r.reason.replaceAll('_', ' ')}: ${r.detail}`)));
}

export function drawFlight(flight, jobs) {
  const { received, processed, rejected } = flight.frames;
  const job = jobs.find((j) => j.state === 'running' || j.state === 'queued');
  byId('flight-state').textContent =
    `${flight.state}: ${processed} of ${received} frames` +
    `${rejected ? `, ${rejected} rejected` : ''}, ${flight.num_regions} regions, ` +
    `${flight.num_sites} sites${job ? `; ${job.stage || job.state}` : ''}`;
  const progress = byId('flight-progress');
  progress.hidden = !job && processed >= received;
  progress.value = job ? job.progress : received ? processed / received : 0;
  byId('warnings-panel').hidden = flight.warnings.length === 0;
  byId('warnings').replaceChildren(...flight.warnings.map((w) => element('li', String(w))));
}
