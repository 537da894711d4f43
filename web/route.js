// The view "Route": draws a planned flight or takes a plan, asks where a site is in reach without power, shows the answer.

import * as api from './api.js';
import { curlButton, curlOf, quoted } from './curl.js';
import { byId } from './dom.js';
import { setKey } from './key.js';
import { offers } from './offers.js';
import { drawMoment, drawRouteAnswer } from './route_answer.js';
import { createRouteChart } from './route_chart.js';
import { createRouteForm } from './route_form.js';
import { changedPart, draftText, faultOf, planOf, planQueryOf, requestOf } from './route_request.js';
import { routeKey } from './route_overlay.js';
import { isVisible, showView } from './views.js';

const kAround_s = 20;  // shown on both sides of a gap
const isPlan = (file) => /\.plan$/i.test(file.name);
const lineOf = (places) => ({ type: 'Feature', properties: {}, geometry: { type: 'LineString',
  coordinates: places.map(({ longitude_deg, latitude_deg }) => [longitude_deg, latitude_deg]) } });
const json = "-H 'Content-Type: application/json'";

// The sample that is told about first: in the middle of the first gap, else where the margin is least.
function firstMarked({ gaps: [gap], samples }) {
  if (gap) return samples.findIndex(({ time_s }) => time_s >= Math.floor((gap.from_s + gap.to_s) / 2));
  const margins_m = samples.map(({ arrival_margin_m }) => arrival_margin_m ?? Infinity);
  return margins_m.indexOf(Math.min(...margins_m));
}

class Route {
  #map;
  #on;
  #draft = { points: [], plan: null };
  #former = null; // {draft, altitude_m} before a fix was taken
  #isDrawing = false;
  #wasDrawing = false;
  #answer = null;
  #index = null; // of the sample that the panel tells about
  #shown = null; // the fix on the map
  #noFix = ''; // of a gap without a fix: why it has none
  #isOld = false; // values were changed after the answer
  #running = null;
  #form;
  #chart = createRouteChart(byId('route-chart'), (index) => this.#mark(index));

  constructor(map, on) {
    this.#map = map;
    this.#on = on;
    this.#form = createRouteForm({ ...on, changed: (name) => this.#valueChanged(name), submit: () => this.#toggleCheck() });
    byId('open-route').addEventListener('click', () => this.#open());
    const clicks = { draw: () => this.#setDrawing(!this.#isDrawing), 'add-point': () => this.takePlace(map.centerPoint()),
      undo: () => this.#setPoints(this.#draft.points.slice(0, -1)), clear: () => this.#clear(), restore: () => this.#restore() };
    for (const [name, click] of Object.entries(clicks)) byId(`route-${name}`).addEventListener('click', click);
    byId('route-plan').addEventListener('change', ({ target }) => { if (target.files.length) this.#takePlan(target.files[0]); target.value = ''; });
    byId('route-curl').append(curlButton('the check of this route', () => this.#curl()));
    // Before the upload, which takes any file.
    addEventListener('drop', (event) => this.#takeDrop(event), { capture: true });
    addEventListener('freelsd-view', () => this.#draw());
  }

  async look() {
    byId('open-route').hidden = !(await offers().catch(() => ({}))).routeCheck;
  }

  showProfiles(profiles) { this.#form.showProfiles(profiles); }

  // Returns whether the place became a point of the route.
  takePlace({ lat, lng }) {
    if (!this.#isDrawing || !isVisible('route')) return false;
    this.#setPoints([...this.#draft.points, { latitude_deg: lat, longitude_deg: lng }]);
    return true;
  }

  // Returns whether it ended the drawing or a request.
  cancel() {
    if (!isVisible('route') || !(this.#running || this.#isDrawing)) return false;
    this.#running?.abort();
    this.#setDrawing(false);
    return true;
  }

  #open() {
    this.#isDrawing ||= this.#draft.points.length === 0 && !this.#draft.plan;
    showView('route');
    byId('route-title').focus({ preventScroll: true });
    this.#form.prefill();
  }

  // --- The draft ---

  #setDrawing(isDrawing) {
    this.#isDrawing = isDrawing;
    if (isDrawing) {
      this.#draft.plan = null;
      this.#forget();
      this.#say('');
    }
    this.#draw();
  }

  #setPoints(points) {
    this.#draft = { points, plan: null };
    this.#forget();
    this.#draw();
  }

  #clear() {
    this.#isDrawing = true;
    this.#say('');
    this.#setPoints([]);
  }

  #move(index, { lat, lng }) {
    this.#setPoints(this.#draft.points.map((point, i) => (i === index ? { ...point, latitude_deg: lat, longitude_deg: lng } : point)));
  }

  #takeDrop(event) {
    const plan = [...event.dataTransfer?.files ?? []].find(isPlan);
    if (!plan || byId('open-route').hidden) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    byId('drop-hint').hidden = true;
    if (!isVisible('route')) this.#open();
    this.#takePlan(plan);
  }

  async #takePlan(file) {
    try {
      const { json: plan, airspeed_mps } = planOf(await file.text());
      this.#isDrawing = false;
      this.#draft = { points: [], plan: { name: file.name, json: plan } };
      this.#forget();
      this.#form.fillAirspeed(airspeed_mps);
      this.#draw();
      await this.#check();
    } catch (error) {
      this.#say(error.message, true);
    }
  }

  // --- The request ---

  // An altitude in the form is that of all points.
  #valueChanged(name) {
    if (name === 'altitude_m') this.#draft.points = this.#draft.points.map(({ altitude_m, ...point }) => point);
    this.#isOld = Boolean(this.#answer);
    this.#draw();
  }

  #curl() {
    const request = requestOf(this.#draft, this.#form.values());
    const query = planQueryOf(request);
    if (query) return curlOf(api.paths.routeCheck + api.query(query), `${json} --data-binary ${quoted(`@${this.#draft.plan.name}`)}`);
    return curlOf(api.paths.routeCheck, `${json} -d ${quoted(JSON.stringify(request))}`);
  }

  #toggleCheck() {
    if (this.#running) this.#running.abort();
    else this.#check();
  }

  async #check() {
    this.#running?.abort();
    this.#form.showFault(null);
    const values = this.#form.values();
    const fault = faultOf(this.#draft, values);
    if (fault) {
      if (!fault.field) this.#say(fault.detail, true);
      else this.#form.showFault(fault);
      return;
    }
    const running = new AbortController();
    const former = this.#answer;
    this.#running = running;
    this.#isDrawing = false;
    this.#say('Checking …');
    this.#draw();
    try {
      await this.#ask(requestOf(this.#draft, values), running.signal);
      if (!running.signal.aborted) this.#say('');
    } catch (error) {
      if (this.#running !== running) return;
      this.#noFix = 'The search for changes did not end.';
      this.#isOld = former !== null && this.#answer === former;
      this.#say(running.signal.aborted ? 'Stopped.' : `Not checked: ${error.message}`, true);
    } finally {
      if (this.#running === running) this.#running = null;
      this.#draw();
    }
  }

  // The gaps are known long before the changes that close them: they are asked for first.
  async #ask(request, signal) {
    const answer = await api.checkRoute({ ...request, with_fixes: false }, signal);
    this.#show(answer);
    this.#map.fitFeatures([lineOf(answer.samples)]);
    byId('route-answer').scrollIntoView({ block: 'start' });
    if (answer.gaps.length === 0) return;
    this.#say('Checked. Searching for changes that close the gaps …');
    const { fixes } = await api.checkRoute(request, signal);
    answer.fixes = fixes;
    this.#noFix = 'No change was found that closes this gap.';
  }

  #show(answer) {
    this.#answer = answer;
    this.#shown = null;
    this.#isOld = false;
    this.#noFix = 'Searching for changes that close the gap …';
    this.#draw();
    this.#chart.draw(answer);
    this.#mark(firstMarked(answer));
  }

  #forget() {
    this.#former = null;
    this.#running?.abort();
    this.#running = null;
    this.#answer = null;
    this.#shown = null;
    this.#isOld = false;
  }

  // --- The answer ---

  #mark(index) {
    const sample = this.#answer?.samples[index];
    if (!sample) return;
    this.#index = index;
    this.#map.route.mark(index);
    this.#chart.mark(index, drawMoment(sample, this.#on));
  }

  #showMoment({ time_s }) {
    const { samples } = this.#answer;
    this.#mark(samples.findIndex((sample) => sample.time_s >= time_s));
    this.#fitTimes(time_s, time_s);
  }

  #showGap({ from_s, to_s }) {
    this.#mark(this.#answer.samples.findIndex(({ time_s }) => time_s >= from_s));
    this.#fitTimes(from_s, to_s);
  }

  #fitTimes(from_s, to_s) {
    this.#map.fitFeatures([lineOf(this.#answer.samples.filter(({ time_s }) => time_s >= from_s - kAround_s && time_s <= to_s + kAround_s))]);
  }

  #showFix(fix) {
    this.#shown = fix;
    this.#draw();
    if (!fix) return;
    const { samples } = this.#answer;
    this.#map.fitFeatures([lineOf(fix.route ? changedPart(fix.route, samples).points : [fix.place, ...samples])]);
  }

  #takeFix({ route }) {
    this.#former = { draft: this.#draft, altitude_m: this.#form.values().altitude_m };
    this.#draft = { points: route, plan: null };
    this.#form.setAltitude(null);
    this.#check();
  }

  #restore() {
    const { draft, altitude_m } = this.#former;
    this.#former = null;
    this.#draft = draft;
    this.#form.setAltitude(altitude_m);
    this.#check();
  }

  // --- Drawing ---

  #say(text, isBad = false) {
    byId('route-message').textContent = text;
    byId('route-message').classList.toggle('bad', isBad);
    if (isBad) byId('route-message').scrollIntoView({ block: 'nearest' });
  }

  #drawMap() {
    const isShown = isVisible('route');
    const isDrawing = isShown && this.#isDrawing;
    const points = this.#draft.points;
    if (isDrawing) this.#map.drawDraft(points.map((p) => [p.longitude_deg, p.latitude_deg]), null, (i, at) => this.#move(i, at));
    else if (this.#wasDrawing) this.#map.drawDraft(null);
    this.#wasDrawing = isDrawing;
    this.#map.route.draw(isShown ? { points, isDrawing, answer: this.#answer, fix: this.#shown, isOld: this.#isOld } : {}, (i) => this.#mark(i));
    setKey('route', isShown ? routeKey(this.#answer) : []);
    if (isShown && this.#answer) this.#map.route.mark(this.#index);
  }

  #draw() {
    this.#drawMap();
    const { points, plan } = this.#draft;
    const isEmpty = points.length === 0 && !plan;
    byId('route-points').textContent = this.#isDrawing && points.length < 2 ? `Tap the ${isEmpty ? 'first' : 'next'} point on the map.` : draftText(this.#draft);
    byId('route-draw').textContent = this.#isDrawing ? 'Finish' : plan || isEmpty ? 'Draw on the map' : 'Change points';
    byId('route-draw').disabled = this.#isDrawing && points.length < 2;
    byId('route-tools').hidden = !this.#isDrawing;
    byId('route-undo').disabled = points.length === 0;
    byId('route-clear').disabled = isEmpty;
    byId('route-check').textContent = this.#running ? 'Stop' : this.#isOld ? 'Check again' : 'Check';
    byId('route-restore').hidden = !this.#former;
    byId('route-old').hidden = !this.#isOld;
    this.#form.showPlan(Boolean(plan));
    const on = { nameOf: this.#on.nameOf, showMoment: (sample) => this.#showMoment(sample), showGap: (gap) => this.#showGap(gap),
      showFix: (fix) => this.#showFix(fix), takeFix: (fix) => this.#takeFix(fix) };
    drawRouteAnswer({ answer: this.#answer, shown: this.#shown, noFix: this.#noFix, on });
  }
}

// map: {route: see route_overlay.js, drawDraft, fitFeatures, centerPoint}; on: {flight(): as JSON, or null, wind(): tried at
// the selected site, or null, nameOf(site id), openSite(site id)}
export const createRoute = (map, on) => new Route(map, on);
