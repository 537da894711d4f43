// Sends photographs: what the flight has already is not sent again, a broken connection is waited for.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el, notify } from './dom.js';
import { bytes } from './units.js';
import { chunksOf, frameId, sha256, sharesOf, sortOut, splitPoses } from './upload_plan.js';

const kLongestWait_s = 30;
const stateText = {
  waiting: 'waiting', sending: 'sending', stored: 'stored', kept: 'already there',
  rejected: 'refused', failed: 'failed',
};

// One line for each file: {set(state, share, reason)}.
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

// Tries until it works, is stopped, or is refused for good.
async function persistently(attempt, signal, say) {
  for (let wait_s = 1; ; wait_s = Math.min(2 * wait_s, kLongestWait_s)) {
    try {
      return await attempt();
    } catch (error) {
      const isBusy = error.status === 429 || error.status === 503;
      if (error.name === 'AbortError' || (!isBusy && !(error instanceof TypeError))) throw error;
      const next_s = error.retryAfter_s ?? wait_s;
      say(isBusy ? `The server is busy; again in ${next_s} s` : `No connection; again in ${next_s} s`);
      await pause(next_s, signal);
    }
  }
}

// on: {flight(): chosen id or null, created(id), changed()}
export function createUpload(on) {
  let dropped = sortOut([]);
  let running = null;
  const say = (text, isBad = false) => {
    byId('upload-message').textContent = text;
    byId('upload-message').classList.toggle('bad', isBad);
  };

  function drawChoice() {
    const { images, poses, zip, flightJson, ignored } = dropped;
    const parts = [
      images.length && `${images.length} photographs (${bytes(images.reduce((sum, f) => sum + f.size, 0))})`,
      poses && `poses ${poses.name}`, zip && `archive ${zip.name}`, flightJson && `flight settings ${flightJson.name}`,
      ignored.length && `${ignored.length} files not understood: ${ignored.slice(0, 3).map((f) => f.name).join(', ')}`,
    ].filter(Boolean);
    byId('upload-choice').textContent = parts.join('; ');
    byId('upload-start').disabled = images.length === 0 && !zip;
    byId('files').replaceChildren();
    say('');
  }

  function take(files) {
    if (running) return notify('An upload is running');
    const all = [...dropped.images, dropped.poses, dropped.zip, dropped.flightJson, ...files].filter(Boolean);
    dropped = sortOut([...new Map(all.map((file) => [file.name, file])).values()]);
    drawChoice();
  }

  async function flightToFill() {
    if (byId('upload-into').value === 'chosen' && on.flight()) return on.flight();
    const given = dropped.flightJson ? JSON.parse(await dropped.flightJson.text()) : {};
    const profile = byId('upload-aircraft').value;
    const request = {
      ...given,
      name: byId('upload-name').value.trim() || given.name || `Flight of ${new Date().toISOString().slice(0, 16).replace('T', ' ')}`,
    };
    if (profile) request.aircraft = { profile };
    if (byId('upload-datum').value) request.altitude_datum = byId('upload-datum').value;
    const { id } = await api.createFlight(request);
    byId('upload-into').value = 'chosen';
    on.created(id);
    return id;
  }

  // Rows of what has still to be sent; marks what is there already.
  async function missingRows(flight, rows) {
    const there = new Map((await api.getFrames(flight)).map((frame) => [frame.id, frame.sha256]));
    const missing = [];
    for (const entry of rows) {
      const known = there.get(frameId(entry.file.name));
      const own = known ? await sha256(entry.file) : null;
      if (known && (own === null || own === known)) entry.row.set('kept');
      else missing.push(entry);
    }
    return missing;
  }

  async function sendChunk(flight, entries, poses, signal) {
    const files = entries.map(({ file }) => file);
    const form = new FormData();
    if (poses) form.append('poses', new Blob([poses]), 'poses.csv');
    for (const file of files) form.append('images', file, file.name);
    const show = (sent) => sharesOf(files, sent - (poses?.length ?? 0))
      .forEach((share, i) => entries[i].row.set('sending', share));
    show(0);
    const job = await persistently(
      () => api.send(api.paths.batch(flight), form, { onProgress: show, signal }), signal, say);
    entries.forEach(({ row }) => row.set('stored'));
    for (const { id, verdict, detail, reason } of job.detail?.images ?? []) {
      const entry = entries.find(({ file }) => frameId(file.name) === id);
      if (verdict === 'rejected') entry?.row.set('rejected', 1, detail ?? reason ?? '');
    }
    on.changed();
  }

  async function sendImages(flight, signal) {
    const rows = dropped.images.map((file) => ({ file, row: fileRow(file) }));
    const missing = await persistently(() => missingRows(flight, rows), signal, say);
    if (missing.length === 0) return `All ${rows.length} photographs are there already`;
    const text = dropped.poses ? await dropped.poses.text() : '';
    const names = missing.map(({ file }) => file.name);
    const split = text ? splitPoses(text, names) : { linesOf: () => '' };
    const chunks = split ? chunksOf(missing) : [missing];
    let numSent = rows.length - missing.length;
    for (const chunk of chunks) {
      say(`${numSent} of ${rows.length} stored`);
      const poses = split ? split.linesOf(chunk.map(({ file }) => file.name)) : text;
      await sendChunk(flight, chunk, poses, signal);
      numSent += chunk.length;
    }
    const numRefused = rows.filter(({ row }) => row.state === 'rejected').length;
    return `${numSent - numRefused} of ${rows.length} photographs are stored${numRefused ? `, ${numRefused} refused` : ''}`;
  }

  async function sendZip(flight, signal) {
    const row = fileRow(dropped.zip);
    const job = await persistently(() => api.send(api.paths.batch(flight), dropped.zip, {
      contentType: 'application/zip', signal, onProgress: (sent) => row.set('sending', sent / dropped.zip.size),
    }), signal, say);
    row.set('stored');
    return `${job.detail?.num_accepted ?? 'All'} photographs of the archive are stored`;
  }

  async function run() {
    running = new AbortController();
    byId('upload-start').disabled = true;
    byId('upload-stop').hidden = false;
    byId('files').replaceChildren();
    try {
      const flight = await flightToFill();
      const results = [];
      if (dropped.zip) results.push(await sendZip(flight, running.signal));
      if (dropped.images.length) results.push(await sendImages(flight, running.signal));
      if (byId('upload-finish').checked) await api.finishFlight(flight);
      say(`${results.join('. ')}.${byId('upload-finish').checked ? ' Every region is being evaluated.' : ''}`);
    } catch (error) {
      const detail = error.errors?.map((e) => `${e.pointer} ${e.detail}`).join('; ');
      say(error.name === 'AbortError' ? 'Stopped. Start again to go on where it stopped.'
        : `${error.message}${detail ? ` (${detail})` : ''}`, true);
    } finally {
      running = null;
      byId('upload-start').disabled = false;
      byId('upload-stop').hidden = true;
      on.changed();
    }
  }

  byId('upload-files').addEventListener('change', (event) => take(event.target.files));
  byId('upload-start').addEventListener('click', run);
  byId('upload-stop').addEventListener('click', () => running?.abort());
  const drawInto = () => { byId('upload-new').hidden = byId('upload-into').value !== 'new'; };
  byId('upload-into').addEventListener('change', drawInto);
  byId('upload-curl').replaceChildren(curlButton('an upload', () =>
    curlOf(api.paths.batch(on.flight() ?? 'FLIGHT'), '-F poses=@poses.csv -F images=@photo.jpg')));

  // Files may be dropped anywhere on the page.
  addEventListener('dragover', (event) => {
    if (!event.dataTransfer?.types.includes('Files')) return;
    event.preventDefault();
    byId('drop-hint').hidden = false;
  });
  addEventListener('dragleave', (event) => { if (!event.relatedTarget) byId('drop-hint').hidden = true; });
  addEventListener('drop', (event) => {
    event.preventDefault();
    byId('drop-hint').hidden = true;
    if (event.dataTransfer.files.length === 0) return;
    on.open();
    take(event.dataTransfer.files);
  });

  return {
    showProfiles(profiles) {
      byId('upload-aircraft').replaceChildren(new Option('as in the flight settings, else Techpod', ''),
        ...Object.entries(profiles).map(([name, a]) => new Option(`${name} (${a.landing_airspeed_mps} m/s)`, name)));
    },
  };
}
