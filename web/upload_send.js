// Sends files to a flight. Skips photographs that are already stored; waits while the connection is lost.

import * as api from './api.js';
import { byId, el } from './dom.js';
import { bytes } from './units.js';
import { chunksOf, frameId, sha256, sharesOf, splitPoses } from './upload_plan.js';

const kLongestWait_s = 30;
const stateText = {
  waiting: 'waiting', sending: 'sending', stored: 'stored', kept: 'already stored',
  rejected: 'rejected', failed: 'failed',
};

// One row of the list of files: {state, set(state, share, reason)}.
function fileRow(file) {
  const meter = el('progress', { max: 1, value: 0, 'aria-label': file.name });
  const state = el('span', { class: 'file-state' }, stateText.waiting);
  const row = el('li', { class: 'file file-waiting', 'data-file': file.name },
    el('span', { class: 'file-name' }, file.name), el('small', {}, bytes(file.size)), state, meter);
  byId('files').append(row);
  return {
    state: 'waiting',
    set(name, share = 1, reason = '') {
      this.state = name;
      row.className = `file file-${name}`;
      meter.value = share;
      state.textContent = name === 'sending' ? `${Math.round(100 * share)} %`
        : stateText[name] + (reason ? `: ${reason}` : '');
    },
  };
}

const pause = (seconds, signal) => new Promise((resolve, reject) => {
  const timer = setTimeout(resolve, 1000 * seconds);
  signal.addEventListener('abort', () => { clearTimeout(timer); reject(new DOMException('stopped', 'AbortError')); });
});

// One upload into one flight. on: {message(text), changed()}; signal aborts it.
export class Sender {
  #flight;
  #signal;
  #on;

  constructor(flight, signal, on) {
    this.#flight = flight;
    this.#signal = signal;
    this.#on = on;
  }

  // Returns a sentence for the user. poses: a file or null.
  async sendImages(images, poses) {
    const rows = images.map((file) => ({ file, row: fileRow(file) }));
    const missing = await this.#persist(() => this.#markStored(rows));
    if (missing.length === 0) return `All ${rows.length} photographs are already stored`;
    const text = poses ? await poses.text() : '';
    const split = text ? splitPoses(text, missing.map(({ file }) => file.name)) : { linesOf: () => '' };
    const chunks = split ? chunksOf(missing) : [missing];
    let numSent = rows.length - missing.length;
    for (const chunk of chunks) {
      this.#on.message(`${numSent} of ${rows.length} stored`);
      await this.#sendChunk(chunk, split ? split.linesOf(chunk.map(({ file }) => file.name)) : text);
      numSent += chunk.length;
    }
    const numRejected = rows.filter(({ row }) => row.state === 'rejected').length;
    return `${numSent - numRejected} of ${rows.length} photographs stored${numRejected ? `, ${numRejected} rejected` : ''}`;
  }

  // Returns a sentence for the user.
  async sendZip(zip) {
    const row = fileRow(zip);
    const job = await this.#persist(() => api.send(api.paths.batch(this.#flight), zip, {
      contentType: 'application/zip', signal: this.#signal,
      onProgress: (sent) => row.set('sending', sent / zip.size),
    }));
    row.set('stored');
    return `${job.detail?.num_accepted ?? 'All'} photographs of the archive stored`;
  }

  // Retries while the server is busy or unreachable. Any other error ends the upload.
  async #persist(attempt) {
    for (let wait_s = 1; ; wait_s = Math.min(2 * wait_s, kLongestWait_s)) {
      try {
        return await attempt();
      } catch (error) {
        const isBusy = error.status === 429 || error.status === 503;
        if (error.name === 'AbortError' || (!isBusy && !(error instanceof TypeError))) throw error;
        const next_s = error.retryAfter_s ?? wait_s;
        this.#on.message(`${isBusy ? 'Server busy' : 'No connection'}. Retry in ${next_s} s.`);
        await pause(next_s, this.#signal);
      }
    }
  }

  // Returns the rows of photographs that the flight lacks; marks the others as stored.
  async #markStored(rows) {
    const there = new Map((await api.getFrames(this.#flight)).map((frame) => [frame.id, frame.sha256]));
    const missing = [];
    for (const entry of rows) {
      const known = there.get(frameId(entry.file.name));
      const own = known ? await sha256(entry.file) : null;
      if (known && (own === null || own === known)) entry.row.set('kept');
      else missing.push(entry);
    }
    return missing;
  }

  async #sendChunk(entries, poses) {
    const files = entries.map(({ file }) => file);
    const form = new FormData();
    if (poses) form.append('poses', new Blob([poses]), 'poses.csv');
    for (const file of files) form.append('images', file, file.name);
    const show = (sent) => sharesOf(files, sent - (poses?.length ?? 0))
      .forEach((share, i) => entries[i].row.set('sending', share));
    show(0);
    const job = await this.#persist(
      () => api.send(api.paths.batch(this.#flight), form, { onProgress: show, signal: this.#signal }));
    entries.forEach(({ row }) => row.set('stored'));
    for (const { id, verdict, detail, reason } of job.detail?.images ?? []) {
      const entry = entries.find(({ file }) => frameId(file.name) === id);
      if (verdict === 'rejected') entry?.row.set('rejected', 1, detail ?? reason ?? '');
    }
    this.#on.changed();
  }
}
