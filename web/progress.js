// What the server works on, in plain words: a line with a bar below the header, and the ground that it looks at.

import { byId } from './dom.js';
import { isKnown, words } from './units.js';

export const isOpen = (job) => job.state === 'running' || job.state === 'queued';

// Rounded up, because a wait that is longer than announced is worse than a shorter one.
export function waitText(seconds) {
  if (!isKnown(seconds) || seconds < 0) return '';
  if (seconds < 60) return `about ${Math.max(10, 10 * Math.ceil(seconds / 10))} s left`;
  const minutes = Math.ceil(seconds / 60);
  if (minutes < 60) return `about ${minutes} min left`;
  return `about ${Math.floor(minutes / 60)} h ${minutes % 60} min left`;
}

// What a job waits for; null if it waits for nothing.
function waitingText({ waiting_for: other }) {
  if (!other) return null;
  const left = waitText(other.time_left_s);
  return `Waiting for ${other.flight_name || other.flight_id || 'another flight'}${left ? `, ${left}` : ''}`;
}

// What a job tells about itself: {summary, left}. A summary that ends with the time left says it already.
export function toldBy(job) {
  const summary = job.summary ?? waitingText(job);
  return { summary, left: / left\.?$/.test(summary ?? '') ? '' : waitText(job.time_left_s) };
}

const shareOf = ({ progress }) => (isKnown(progress) && progress > 0 ? progress : null);

// {value: 0 to 1, or null if unknown, text, summary?, left?, area?: GeoJSON}; null if nothing runs. text is short.
export function progressOf(flight, jobs) {
  if (flight.state === 'failed') return null;
  const running = jobs.find((job) => job.state === 'running');
  // A batch that waits tells less than the photographs that are counted meanwhile.
  const job = running ?? jobs.find((other) => isOpen(other) && other.kind !== 'batch') ?? jobs.find(isOpen);
  const { received, processed } = flight.frames;
  const told = job ? toldBy(job) : {};
  const isTold = job && (job === running || job.kind !== 'batch' || processed >= received);
  const more = isTold && (told.summary || told.left || job.area) ? { ...told, area: job.area ?? null } : {};
  if (running?.kind === 'finish') {
    const text = running.stage_title ?? `Evaluating regions${running.stage ? `: ${words(running.stage)}` : ''}`;
    return { value: shareOf(running), text, ...more };
  }
  if (processed < received) return { value: processed / received, text: `Photographs ${processed} of ${received}`, ...more };
  if (running) return { value: running.progress, text: running.stage_title ?? words(running.stage || running.kind || 'working'), ...more };
  return job ? { value: null, text: job.waiting_for ? 'Waiting' : 'Queued', ...more } : null;
}

export function setBar(bar, value) {
  if (isKnown(value)) bar.value = value;
  else bar.removeAttribute('value');
}

// The line below the header. A server that tells no summary gets none.
export function drawProgress(progress) {
  const line = byId('progress');
  line.hidden = !progress?.summary && !progress?.left;
  if (line.hidden) return;
  byId('progress-text').textContent = progress.summary ?? progress.text;
  byId('progress-left').textContent = progress.left;
  setBar(byId('progress-bar'), progress.value);
}
