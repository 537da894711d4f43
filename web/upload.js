// The upload panel: collects files, creates the flight, starts and stops the upload.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, notify } from './dom.js';
import { bytes } from './units.js';
import { sortOut } from './upload_plan.js';
import { Sender } from './upload_send.js';

function say(text, isBad = false) {
  byId('upload-message').textContent = text;
  byId('upload-message').classList.toggle('bad', isBad);
}

function choiceText({ images, poses, zip, flightJson, ignored }) {
  return [
    images.length && `${images.length} photographs (${bytes(images.reduce((sum, f) => sum + f.size, 0))})`,
    poses && `poses ${poses.name}`, zip && `archive ${zip.name}`, flightJson && `flight settings ${flightJson.name}`,
    ignored.length && `${ignored.length} unsupported files: ${ignored.slice(0, 3).map((f) => f.name).join(', ')}`,
  ].filter(Boolean).join('; ');
}

// The form overrides the fields of the settings file.
async function flightRequest(settingsFile) {
  const given = settingsFile ? JSON.parse(await settingsFile.text()) : {};
  const minute = new Date().toISOString().slice(0, 16).replace('T', ' ');
  const request = { ...given, name: byId('upload-name').value.trim() || given.name || `Flight ${minute} UTC` };
  const profile = byId('upload-aircraft').value;
  if (profile) request.aircraft = { profile };
  if (byId('upload-datum').value) request.altitude_datum = byId('upload-datum').value;
  return request;
}

function sayFailure(error) {
  if (error.name === 'AbortError') return say('Stopped. Press Send to resume.', true);
  const detail = error.errors?.map((e) => `${e.pointer} ${e.detail}`).join('; ');
  return say(`${error.message}${detail ? ` (${detail})` : ''}`, true);
}

// The whole page accepts dropped files.
function acceptDrops(take) {
  addEventListener('dragover', (event) => {
    if (!event.dataTransfer?.types.includes('Files')) return;
    event.preventDefault();
    byId('drop-hint').hidden = false;
  });
  addEventListener('dragleave', (event) => { if (!event.relatedTarget) byId('drop-hint').hidden = true; });
  addEventListener('drop', (event) => {
    event.preventDefault();
    byId('drop-hint').hidden = true;
    if (event.dataTransfer.files.length > 0) take(event.dataTransfer.files);
  });
}

class Upload {
  #on;
  #files = sortOut([]);
  #running = null;

  constructor(on) {
    this.#on = on;
    byId('upload-files').addEventListener('change', (event) => this.#take(event.target.files));
    byId('upload-start').addEventListener('click', () => this.#run());
    byId('upload-stop').addEventListener('click', () => this.#running?.abort());
    byId('upload-into').addEventListener('change', () => {
      byId('upload-new').hidden = byId('upload-into').value !== 'new';
    });
    byId('upload-curl').replaceChildren(curlButton('an upload', () =>
      curlOf(api.paths.batch(on.flight() ?? 'FLIGHT'), '-F poses=@poses.csv -F images=@photo.jpg')));
    acceptDrops((files) => { on.open(); this.#take(files); });
  }

  showProfiles(profiles) {
    byId('upload-aircraft').replaceChildren(byId('upload-aircraft').options[0],
      ...Object.entries(profiles).map(([name, a]) => new Option(`${name} (landing ${a.landing_airspeed_mps} m/s)`, name)));
  }

  // Adds files; a file of the same name replaces the former one.
  #take(files) {
    if (this.#running) return notify('Upload in progress');
    const { images, poses, zip, flightJson } = this.#files;
    const all = [...images, poses, zip, flightJson, ...files].filter(Boolean);
    this.#files = sortOut([...new Map(all.map((file) => [file.name, file])).values()]);
    byId('upload-choice').textContent = choiceText(this.#files);
    byId('upload-start').disabled = this.#files.images.length === 0 && !this.#files.zip;
    byId('files').replaceChildren();
    return say('');
  }

  // The id of the flight that receives the files; creates a flight if needed.
  async #flightToFill() {
    if (byId('upload-into').value === 'chosen' && this.#on.flight()) return this.#on.flight();
    const { id } = await api.createFlight(await flightRequest(this.#files.flightJson));
    byId('upload-into').value = 'chosen';
    this.#on.created(id);
    return id;
  }

  async #send(signal) {
    const { images, poses, zip } = this.#files;
    const flight = await this.#flightToFill();
    const sender = new Sender(flight, signal, { message: say, changed: this.#on.changed });
    const results = [];
    if (zip) results.push(await sender.sendZip(zip));
    if (images.length) results.push(await sender.sendImages(images, poses));
    if (byId('upload-finish').checked) {
      await api.finishFlight(flight);
      results.push('Evaluating all regions');
    }
    say(`${results.join('. ')}.`);
  }

  async #run() {
    this.#running = new AbortController();
    byId('upload-start').disabled = true;
    byId('upload-stop').hidden = false;
    byId('files').replaceChildren();
    try {
      await this.#send(this.#running.signal);
    } catch (error) {
      sayFailure(error);
    } finally {
      this.#running = null;
      byId('upload-start').disabled = false;
      byId('upload-stop').hidden = true;
      this.#on.changed();
    }
  }
}

// on: {flight(): selected id or null, created(id), changed(), open()}
export const createUpload = (on) => new Upload(on);
