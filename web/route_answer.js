// What the panel tells about a checked route: the share covered, gaps with the changes that close them, warnings.

import { byId, el } from './dom.js';
import { clock, coveredText, momentText, sentenceOf, uncovered_s } from './route_request.js';

const signs = { climb: '▲', offset: '↷', look: '◎' };

function outcome(answer, on) {
  const { gaps, time_s, point_of_no_return: noReturn } = answer;
  if (gaps.length === 0) {
    return el('div', { class: 'outcome landable' }, el('strong', {}, `✓ A site is in reach all the way (${clock(time_s)})`));
  }
  return el('div', { class: 'outcome rejected' },
    el('strong', {}, `✕ ${coveredText(answer)} covered, ${gaps.length} ${gaps.length === 1 ? 'gap' : 'gaps'}`),
    el('span', {}, `No site in reach for ${clock(uncovered_s(answer))} of ${clock(time_s)}.`),
    noReturn ? el('button', { type: 'button', class: 'wide', id: 'route-no-return', onclick: () => on.showMoment(noReturn) },
      el('span', { class: 'key-no-return', 'aria-hidden': 'true' }, el('b', {}, 'R')),
      ` Point of no return at ${clock(noReturn.time_s)}. No site is in reach after it.`) : null);
}

function fixRow(fix, { answer, shown, on }) {
  const key = answer.fixes.indexOf(fix);
  const isShown = fix === shown;
  const text = sentenceOf(fix.sentence, on.nameOf);
  return el('li', { class: 'route-fix-row', 'data-kind': fix.kind },
    el('span', {}, el('b', { 'aria-hidden': 'true' }, fix.kind === 'offset' && fix.offset_m < 0 ? '↶' : signs[fix.kind] ?? '•'), ` ${text}`),
    el('button', { type: 'button', 'data-show': '', 'data-key': `show ${key}`, 'aria-pressed': String(isShown), 'aria-label': `Show: ${text}`,
      onclick: () => on.showFix(isShown ? null : fix) }, isShown ? 'Hide' : 'Show'),
    fix.route ? el('button', { type: 'button', class: 'primary', 'data-take': '', 'data-key': `take ${key}`, 'aria-label': `Take: ${text}`, onclick: () => on.takeFix(fix) }, 'Take') : null);
}

function fixesNode(fixes, state) {
  if (fixes.length > 0) return el('ul', { class: 'plain' }, fixes.map((fix) => fixRow(fix, state)));
  return el('p', { class: 'faint' }, state.noFix);
}

function gapRow(gap, index, state) {
  const { on, answer } = state;
  return el('li', { class: 'route-gap-row', 'data-gap': index },
    el('button', { type: 'button', class: 'quiet route-gap-name', 'data-key': `gap ${index}`, title: 'Show on the map', onclick: () => on.showGap(gap) },
      el('strong', {}, `✕ Gap ${index + 1}: ${clock(gap.from_s)} to ${clock(gap.to_s)}`),
      el('span', {}, sentenceOf(gap.sentence, on.nameOf))),
    fixesNode(answer.fixes.filter((fix) => fix.gap === index), state));
}

// state: {answer: or null, shown: a fix or null, noFix: why a gap has no fix, on: {nameOf(site id), showMoment(sample),
// showGap(gap), showFix(fix or null), takeFix(fix)}}
export function drawRouteAnswer(state) {
  const { answer, on } = state;
  const focused = document.activeElement?.dataset?.key;
  byId('route-answer').hidden = !answer;
  if (!answer) return;
  byId('route-outcome').replaceChildren(outcome(answer, on));
  byId('route-gap-title').hidden = answer.gaps.length === 0;
  byId('route-gaps').replaceChildren(...answer.gaps.map((gap, i) => gapRow(gap, i, state)));
  if (focused) byId('route-gaps').querySelector(`[data-key="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
  byId('route-warning-box').hidden = answer.warnings.length === 0;
  byId('route-warnings').replaceChildren(...answer.warnings.map((text) => el('li', {}, sentenceOf(text, on.nameOf))));
}

// The text below the chart.
export function drawMoment(sample, { nameOf, openSite }) {
  const { title, lines } = momentText(sample, nameOf);
  byId('route-moment').replaceChildren(
    el('div', {}, el('strong', { class: sample.covered ? 'in-reach' : 'bad' }, title), ...lines.map((text) => el('span', {}, text))),
    sample.best_site ? el('button', { type: 'button', onclick: () => openSite(sample.best_site), 'aria-label': `Open ${nameOf(sample.best_site)}` }, 'Open') : '');
  return `${clock(sample.time_s)}: ${title}`;
}
