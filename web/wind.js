// The wind barb, and the control that replans the approach for a trial wind.

import { svg, byId, el } from './dom.js';
import { fixed, heading, isKnown, verdictSign, windFrom, windTo } from './units.js';

const knotsPerMps = 1.9438;
const kReplanDelay_ms = 120;

// Symbols of weather charts: half feather 5 kt, feather 10 kt, flag 50 kt. The staff points to where the
// wind comes from.
export function windBarb(speed_mps, from_deg, size = 56) {
  const root = svg('svg', { viewBox: '-30 -30 60 60', width: size, height: size, class: 'barb', role: 'img',
    'aria-label': `Wind ${fixed(speed_mps, 1, 'm/s')} from ${heading(from_deg)}` });
  let knots = Math.round(speed_mps * knotsPerMps / 5) * 5;
  root.append(svg('circle', { r: 4, class: 'barb-disc' }));
  if (knots === 0) {
    root.append(svg('circle', { r: 8, class: 'barb-calm' }));
    return root;
  }
  const staff = svg('g', { transform: `rotate(${from_deg})` }, svg('path', { d: 'M0 -4V-28' }));
  let y = -28;
  if (knots === 5) y += 5;
  for (; knots >= 50; knots -= 50, y += 8) staff.append(svg('path', { d: `M0 ${y}L11 ${y + 1}L0 ${y + 6}Z`, class: 'flag' }));
  for (; knots >= 10; knots -= 10, y += 5) staff.append(svg('path', { d: `M0 ${y}L12 ${y - 5}` }));
  if (knots >= 5) staff.append(svg('path', { d: `M0 ${y}L6 ${y - 2.5}` }));
  root.append(staff);
  return root;
}

function drawValues(speed_mps, from_deg) {
  byId('wind-speed-value').textContent = fixed(speed_mps, 1, 'm/s');
  byId('wind-from-value').textContent = heading(from_deg);
}

function sourceText(isStored, stored, isOfEmergency) {
  if (isOfEmergency) return 'Wind of the emergency answer. Stored plan unchanged.';
  if (!isStored) return 'Trial wind. Stored plan unchanged.';
  return stored ? 'Wind given with the flight' : 'Wind unknown. All headings checked.';
}

// replan(wind, signal): plans for a trial wind; null restores the stored approach.
// showOnMap(barb, isTried, {speed_mps, from_deg}): puts the barb on the map; nulls if no wind is known.
export function createWind(replan, showOnMap) {
  const speed = byId('wind-speed');
  const from = byId('wind-from');
  let stored = null;
  let timer = 0;
  let running = new AbortController();

  function drawBarb(isStored, isOfEmergency = false) {
    const [speed_mps, from_deg] = [Number(speed.value), Number(from.value)];
    byId('wind-barb').replaceChildren(windBarb(speed_mps, from_deg));
    if (isStored && !stored) showOnMap(null, false, null);
    else showOnMap(windBarb(speed_mps, from_deg, 48), !isStored, { speed_mps, from_deg });
    drawValues(speed_mps, from_deg);
    byId('wind-source').textContent = sourceText(isStored, stored, isOfEmergency);
    byId('wind-reset').hidden = isStored;
  }

  function changed() {
    drawBarb(false);
    clearTimeout(timer);
    timer = setTimeout(() => {
      running.abort();
      running = new AbortController();
      replan(windTo(Number(speed.value), Number(from.value)), running.signal);
    }, kReplanDelay_ms);
  }

  function reset() {
    clearTimeout(timer);
    running.abort();
    const known = windFrom(stored);
    speed.value = known ? known.speed_mps : 0;
    from.value = known ? Math.round(known.from_deg) % 360 : 0;
    drawBarb(true);
  }

  // The stored wind of a site, null if unknown.
  function show(wind) {
    stored = wind;
    reset();
  }

  // A trial wind.
  function take(speed_mps, from_deg) {
    speed.value = speed_mps;
    from.value = Math.round(from_deg) % 360;
    changed();
  }

  // The wind of a plan that is drawn already; null if it is unknown.
  function showPlanned(planned) {
    const known = windFrom(planned);
    speed.value = known ? known.speed_mps : 0;
    from.value = known ? Math.round(known.from_deg) % 360 : 0;
    drawBarb(false, true);
  }

  for (const input of [speed, from]) input.addEventListener('input', changed);
  for (const button of document.querySelectorAll('[data-turn]')) {
    button.addEventListener('click', () =>
      take(speed.value, Number(from.value) + Number(button.dataset.turn) + 360));
  }
  byId('wind-reset').addEventListener('click', () => {
    reset();
    replan(null, null);
  });
  return { show, showPlanned, take };
}

// The outcome of a trial wind. answer: {collection} or {refusal}; stored: the stored approach;
// moved_m: from the stored touchdown.
// Without a verdict of the server the outcome is unverified.
export function replanNode(answer, stored, moved_m) {
  if (answer.refusal) {
    return el('div', { class: 'outcome rejected', role: 'status' },
      el('strong', {}, '✕ No approach for this wind'), el('span', {}, answer.refusal));
  }
  const kind = (name) => answer.collection.features.find((f) => f.properties.kind === name)?.properties;
  const final = kind('approach');
  const unseen = kind('loiter')?.unseen_ratio;
  const verdict = answer.collection.plan?.verdict ?? 'unverified';
  const turn = stored ? Math.round(((final.heading_deg - stored.heading_deg + 540) % 360) - 180) : 0;
  return el('div', { class: `outcome ${verdict}`, role: 'status' },
    el('strong', {}, `${verdictSign[verdict]} Final ${heading(final.heading_deg)}: ${verdict}`),
    el('span', {}, `Length ${fixed(final.distance_m, 0, 'm')}.` +
      (unseen === 0 ? '' : ` Ground along ${isKnown(unseen) ? fixed(100 * unseen, 0, '%') : 'part'} of the circle not fully measured.`) +
      (turn ? ` ${Math.abs(turn)}° ${turn > 0 ? 'right' : 'left'} of the stored final.` : '') +
      (moved_m >= 1 ? ` Touchdown moved ${fixed(moved_m, 0, 'm')} from the stored one.` : ' Touchdown as stored.')));
}
