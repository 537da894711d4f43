// What a place of the map was made of: its photographs as pictures; folded away its heights, cues, versions and options.

import * as api from './api.js';
import { el } from './dom.js';
import { likelihoodChart } from './likelihood_chart.js';
import { cueName, cuesByWeight, hasWeights, isBlank, kMostLogOdds, likelihoodText, logOddsText, noPatchesText, percent } from './proof_shape.js';
import { createQueue, tilePath } from './tile_queue.js';
import { fixed, isKnown } from './units.js';

const kPictures = 6;  // the most weighty photographs
const kAtOnce = 2;  // requests; tiles need the other connections
const inTurn = createQueue(kAtOnce);

// --- Photographs ---

async function load(box, { url }, signal = new AbortController().signal) {
  const image = box.querySelector('img');
  let picture = null;
  try {
    picture = URL.createObjectURL(await inTurn(() => api.getBlob(tilePath(url, {}), signal), signal));
    image.src = picture;
    await image.decode();
  } catch (error) {
    if (signal.aborted) return;
    box.classList.add('missing');
    box.replaceChildren(el('span', {}, error.status === 404 ? 'not stored any more' : 'not loaded'));
  } finally {
    if (picture) URL.revokeObjectURL(picture);
  }
}

function patchItem(patch, hasShares, signal) {
  const box = el('div', { class: 'patch', title: 'Black: beyond the photograph' }, el('img', { alt: `Photograph ${patch.frame_id}; the place is in the middle` }));
  load(box, patch, signal);
  return el('li', {}, box, el('span', {}, hasShares ? el('b', {}, percent(patch.weight)) : null, el('small', { title: patch.frame_id }, patch.frame_id)));
}

// A row that is scrolled; null where nothing is stored.
export function patchRow(evidence, signal) {
  if (isBlank(evidence)) return null;
  const missing = noPatchesText(evidence);
  if (missing) return el('p', { class: 'faint patch-row' }, missing);
  const { patches } = evidence;
  const more = patches.length - kPictures;
  return el('div', { class: 'patch-row' },
    el('ul', { tabindex: 0, 'aria-label': `${Math.min(patches.length, kPictures)} photographs of this place, 12 m wide each` },
      patches.slice(0, kPictures).map((patch) => patchItem(patch, hasWeights(patches), signal))),
    el('small', {}, `12 m of ground, this place in the middle.${hasWeights(patches) ? ' %: share in its height.' : ''}${more > 0 ? ` ${more} more below.` : ''}`));
}

// --- Heights and cues ---

function heights({ height_likelihood: likelihood, ...stored }) {
  if (!likelihood) {
    return [el('p', { class: 'faint' }, 'How well other heights explain the photographs is not known: photographs are no longer stored, or fewer than two show the place.')];
  }
  return [el('p', {}, likelihoodText(likelihood, stored)), likelihoodChart(likelihood, stored),
    el('div', { class: 'legend-line' }, el('span', { class: 'swatch' }, el('i', { class: 'line path' }), 'log-likelihood, 0 is best'),
      isKnown(stored.height_m) ? el('span', { class: 'swatch' }, el('i', { class: 'stored-key' }), 'stored height ± sd') : null),
    el('small', {}, `Widest distance of two cameras: ${fixed(likelihood.baseline_ratio, 2)} of their height.`)];
}

function cueRow({ cue, log_odds, denies }) {
  const share = denies ? 0 : Math.min(1, Math.abs(log_odds) / kMostLogOdds);
  const bar = el('i', { class: log_odds < 0 ? 'against' : 'for', style: { '--share': share.toFixed(3) } });
  return el('tr', { class: denies ? 'denies' : null }, el('th', { scope: 'row' }, cueName(cue)),
    denies ? el('td', { colspan: 2 }, '✕ denies grass') : [el('td', { class: 'cue-bar', 'aria-hidden': 'true' }, bar), el('td', {}, logOddsText(log_odds))]);
}

const named = (title, names) => (names.length ? el('p', { class: 'faint' }, `${title}: ${names.join(', ')}.`) : null);

function cues(list) {
  if (!list) return [el('p', { class: 'faint' }, 'What tells grass from other ground here is not stored.')];
  const { telling, silent, unknown } = cuesByWeight(list);
  return [
    telling.length ? el('table', { class: 'numbers cues' }, el('caption', {}, 'Log-odds: + for grass, − against it.'), el('tbody', {}, telling.map(cueRow))) : null,
    named('No objection', silent), named('Unknown', unknown)];
}

// --- Where it came from ---

function frameNames({ patches = [], context_frames: context }) {
  const others = patches.slice(kPictures).map(({ frame_id, weight }) => (hasWeights(patches) ? `${frame_id} (${percent(weight)})` : frame_id));
  return [
    named(`${others.length} more photograph${others.length === 1 ? '' : 's'} of this place`, others),
    context === null || context === undefined ? el('p', { class: 'faint' }, 'Which other photographs it depends on is not stored.')
      : named(`It also depends on ${context.length} other photograph${context.length === 1 ? '' : 's'}`, context)];
}

function versionTable({ versions, evidence_digest: digest }) {
  const rows = [
    ['Program', versions?.program], ['Grass model (SHA-256)', versions?.grass_model_sha256], ['Map', versions?.map],
    ['Evaluated', versions?.evaluated_at && new Date(versions.evaluated_at).toLocaleString([], { dateStyle: 'medium', timeStyle: 'short' })],
    ...(digest ? [['Digest of the evidence', digest]] : [])];
  return el('table', { class: 'numbers versions' }, el('tbody', {}, rows.map(([name, value]) =>
    el('tr', {}, el('th', { scope: 'row' }, name), el('td', {}, value)))));
}

function optionsOf(options) {
  if (!options) return null;
  const count = Object.keys(options).length;
  if (count === 0) return el('p', { class: 'faint' }, 'The flight was given no options: the defaults of the program were used.');
  return el('details', { class: 'fold' }, el('summary', {}, `Options given with the flight (${count})`),
    el('pre', { tabindex: 0, 'aria-label': 'Options of the flight' }, JSON.stringify(options, null, 1)));
}

const fold = (title, body) => el('details', { class: 'fold' }, el('summary', {}, title), ...body.flat().filter(Boolean));

// The folded parts. An older server has no versions.
export function proofFolds(judgement) {
  const { evidence } = judgement;
  const versions = () => [versionTable(judgement), optionsOf(judgement.options)];
  if (!('versions' in judgement)) return [];
  if (isBlank(evidence)) return [fold('Versions', versions())];
  return [fold('Height: how sure', heights(evidence)), fold('Grass: what says so', cues(evidence.cues)),
    fold('Photographs and versions', [...frameNames(evidence), ...versions()])];
}
