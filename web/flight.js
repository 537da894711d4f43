// The flight panel: progress, warnings, jobs, stages.

import { cancelJob, finishFlight, paths } from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el, notify } from './dom.js';
import { drawDownloads } from './downloads.js';
import { drawProgress, isOpen, progressOf, setBar, toldBy } from './progress.js';
import { words } from './units.js';

const stateText = {
  receiving: 'Receiving photographs', processing: 'Processing', idle: 'Up to date', failed: 'Failed',
};

function drawStatus(flight, progress) {
  const chip = byId('flight-state');
  chip.className = `chip state-${flight.state}`;
  chip.textContent = progress ? progress.text : stateText[flight.state] ?? flight.state;
  const bar = byId('flight-progress');
  bar.hidden = !progress;
  setBar(bar, progress?.value);
  drawProgress(progress);
}

function counts(flight) {
  const { received, processed, rejected } = flight.frames;
  return el('dl', { class: 'counts' },
    [['photographs', `${processed}/${received}`], ['rejected', rejected], ['regions', flight.num_regions],
      ['sites', flight.num_sites]].map(([name, value]) => el('div', {}, el('dt', {}, name), el('dd', {}, value))));
}

function jobRow(job, onChange) {
  const cancel = isOpen(job) ? el('button', {
    type: 'button', class: 'quiet', 'aria-label': `Cancel job ${job.id}`,
    onclick: async () => {
      await cancelJob(job.id).catch((error) => notify(error.message));
      onChange();
    },
  }, 'Cancel') : null;
  const told = isOpen(job) ? Object.values(toldBy(job)).filter(Boolean).join(', ') : '';
  const detail = typeof job.detail === 'string' ? job.detail : job.detail?.detail;
  return el('li', { class: `job job-${job.state}` },
    el('span', {}, el('strong', {}, words(job.kind ?? 'job')),
      ` ${job.state}${job.state === 'running' ? ` ${Math.round(100 * job.progress)} %` : ''}`,
      told ? el('small', {}, told) : null,
      job.state === 'failed' && detail ? el('small', {}, detail) : null),
    cancel);
}

function stagesTable(stages) {
  const rows = Object.entries(stages ?? {});
  if (rows.length === 0) return el('p', { class: 'faint' }, 'No stage has run yet.');
  return el('table', { class: 'numbers' },
    el('thead', {}, el('tr', {}, ['stage', 'runs', 'mean'].map((t) => el('th', { scope: 'col' }, t)))),
    el('tbody', {}, rows.map(([name, { count, mean_ms }]) => el('tr', {}, el('th', { scope: 'row' }, words(name)),
      el('td', {}, count ?? ''), el('td', {}, mean_ms === undefined ? '' : `${mean_ms.toFixed(1)} ms`)))));
}

let drawnDownloads = null;

// onChange() triggers a refresh. Returns the progress, as progressOf does.
export function drawFlight(flight, jobs, onChange) {
  const progress = progressOf(flight, jobs);
  drawStatus(flight, progress);
  byId('flight-title').textContent = flight.name || flight.id;
  byId('flight-curl').replaceChildren(curlButton('this flight', () => curlOf(paths.flight(flight.id))));
  byId('jobs-curl').replaceChildren(curlButton('the jobs', () => curlOf(paths.jobs)));
  byId('stages-curl').replaceChildren(curlButton('the stages', () => `${curlOf(paths.flight(flight.id))} | jq .stages`));
  byId('flight-counts').replaceChildren(counts(flight));
  byId('flight-warnings').hidden = (flight.warnings ?? []).length === 0;
  byId('warnings').replaceChildren(...(flight.warnings ?? []).map((w) =>
    el('li', {}, typeof w === 'string' ? w : w.detail ?? JSON.stringify(w))));
  byId('stages').replaceChildren(stagesTable(flight.stages));
  const shown = [...jobs.filter(isOpen), ...jobs.filter((job) => !isOpen(job)).slice(-5).reverse()];
  const focused = document.activeElement?.closest('#jobs') !== null;
  if (!focused) byId('jobs').replaceChildren(...shown.map((job) => jobRow(job, onChange)));
  byId('no-jobs').hidden = shown.length > 0;
  const finish = byId('finish');
  finish.disabled = flight.frames.received === 0 || jobs.some((job) => job.kind === 'finish' && isOpen(job));
  finish.onclick = async () => {
    finish.disabled = true;
    try {
      await finishFlight(flight.id);
      notify('Evaluating all regions');
    } catch (error) {
      notify(error.message);
    }
    onChange();
  };
  if (drawnDownloads !== flight.id) {
    drawnDownloads = flight.id;
    byId('flight-downloads').replaceChildren(drawDownloads(paths.flightSites(flight.id), paths.flight(flight.id), flight));
  }
  return progress;
}
