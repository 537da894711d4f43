// Connects the parts of the page: holds the selection and redraws on changes.

import * as api from './api.js';
import { createBaseMap } from './base_map.js';
import { createClickedPlace } from './clicked_place.js';
import { curlButton, curlOf } from './curl.js';
import { byId, notify } from './dom.js';
import { createEmergency } from './emergency.js';
import { drawMapDownloads } from './downloads.js';
import { drawFinal } from './final.js';
import { drawFlight } from './flight.js';
import { chosenFlight, drawFlightChoice } from './flight_choice.js';
import { createFlightMap } from './flight_map.js';
import { drawHistory } from './history.js';
import { createLayers } from './layers.js';
import { setKey } from './key.js';
import { createLinks } from './links.js';
import { createLive } from './live.js';
import { createMap } from './map.js';
import { createNewLook } from './new_look.js';
import { createNextLook } from './next_look.js';
import { obstacleKey } from './obstacle_overlay.js';
import { createObstacles } from './obstacles.js';
import { atBest, marksOf, movedBy, siteWithPlan, sitesWithPlan } from './plan.js';
import { drawProgress } from './progress.js';
import { createReach } from './reach.js';
import { reachKey } from './reach_overlay.js';
import { createRoute } from './route.js';
import { siteName } from './route_request.js';
import { drawSite } from './site.js';
import { createSiteLayers } from './site_layers.js';
import { drawSiteList } from './sites.js';
import { createStoredSites } from './stored_sites.js';
import { askToken } from './token.js';
import { createUpload } from './upload.js';
import { connectViews, showView } from './views.js';
import { createWind, replanNode } from './wind.js';
import { createWindRose } from './wind_rose.js';

const state = {
  flight: null, flightJson: null, flights: [], sites: { features: [] }, regions: { features: [] },
  siteId: null, site: null, approach: null, triedWind: null, triedAircraft: null, planned: null, recalled: null,
  drawn: '', drawnSite: '', trackVersion: null,
};

const map = createMap(byId('map'), {
  site: (id) => openSite(id),
  place: (latlng) => obstacles.takePlace(latlng) || route.takePlace(latlng) || clickedPlace.check(latlng),
  obstacle: (id) => obstacles.show(id),
  ground: () => layers.setNote(map.ground.state()),
});
const layers = createLayers();
const baseMap = createBaseMap(map.ground);
const flightMap = createFlightMap(map.ground, showFlightMap);
const clickedPlace = createClickedPlace(map, () => ({
  flight: flightMap.isThere ? state.flight : null, site: state.site, regions: state.regions,
  plan: { wind: state.triedWind, aircraft: state.triedAircraft ?? undefined }, aircraft: state.flightJson?.aircraft,
}), openRegion);
const rose = createWindRose((speed_mps, from_deg) => wind.take(speed_mps, from_deg));
const wind = createWind(replan, (barb, isTried, now) => {
  map.drawWind(barb, isTried);
  rose.mark(now);
});
const storedSites = createStoredSites((sites, isFirst) => {
  state.sites = sites;
  drawLists();
  return isFirst ? drawFirst() : null;
});
const live = createLive(refresh, (transport) => {
  byId('transport').textContent = transport === 'events' ? 'live' : 'updated every 2 s';
}, (event) => lookAtMap(event));

// --- Panel views ---

function keepInAddress() {
  const parts = new URLSearchParams();
  if (state.flight) parts.set('flight', state.flight);
  if (state.siteId && !byId('view-site').hidden) parts.set('site', state.siteId);
  history.replaceState(null, '', `#${parts}`);
}

// Focus returns to the row of the selected site.
function backToSites() {
  showView('sites');
  keepInAddress();
  const row = state.siteId && byId('sites').querySelector(`[data-site="${CSS.escape(state.siteId)}"]`);
  row?.focus();
}

// --- A site ---

const rankOf = (id) => state.sites.features.find((f) => f.properties.id === id)?.properties.rank;

// Drops the answer if another site was selected in the meantime. Returns whether it was drawn.
async function loadSite(siteId) {
  const [feature, list, approach] = await Promise.all(
    [api.getSite(siteId), flightMap.isThere ? null : api.getLayers(siteId), api.getApproach(siteId)]);
  if (state.siteId !== siteId) return false;
  feature.properties.rank = rankOf(siteId) ?? feature.properties.rank;
  Object.assign(state, { site: feature, approach: approach.collection ?? null, triedWind: null, triedAircraft: null, planned: null });
  state.drawnSite = feature.properties.updated_at;
  if (list && !flightMap.isThere) layers.show(createSiteLayers(map, siteId, list));
  drawShownSite();
  wind.show(feature.properties.wind);
  byId('replan').replaceChildren();
  drawApproach(approach, false);
  if (state.recalled?.siteId === siteId) await showRecalled();
  // The wind rose is expensive: the server computes it only for a visible site.
  rose.show(byId('view-site').hidden ? null : siteId);
  return true;
}

// The site with the plan that is shown: its own, or the one for a trial wind.
const shownSite = () => state.planned ?? state.site;

function drawShownSite() {
  drawSite(shownSite(), { place: showRejection, wind: () => state.triedWind, obstacles });
  links.drawSite();
  drawLists();
}

async function chooseSite(siteId) {
  Object.assign(state, { siteId, planned: null });
  drawLists();
  map.drawMarks([]);
  try {
    return await loadSite(siteId);
  } catch (error) {
    notify(`Site not loaded: ${error.message}`);
    return false;
  }
}

async function openSite(siteId) {
  showView('site');
  if (!await chooseSite(siteId)) return;
  map.fitApproach();
  byId('site-title').focus({ preventScroll: true });
  keepInAddress();
}

function drawApproach({ collection, refusal }, isReplanned) {
  const { aircraft } = state.site.properties;
  map.drawApproach(collection, { touchdownRadius_m: aircraft?.touchdown_uncertainty_m, isReplanned });
  drawFinal({ collection, refusal }, shownSite().properties.approach, aircraft);
}

// The plan of the emergency answer, and no other: same wind, same aircraft without power.
async function showRecalled() {
  const { wind: planned, aircraft, verdict } = state.recalled;
  wind.showPlanned(planned);
  await drawPlan(planned ?? 'unknown', new AbortController().signal, aircraft, verdict);
}

// tried: a wind, or null for the stored approach.
async function replan(tried, signal) {
  state.recalled = null;
  if (tried) {
    await drawPlan(tried, signal);
    return;
  }
  Object.assign(state, { triedWind: null, triedAircraft: null, planned: null });
  byId('replan').replaceChildren();
  map.closeAnswer();
  map.drawMarks([]);
  drawShownSite();
  drawApproach({ collection: state.approach }, false);
}

async function drawPlan(tried, signal, aircraft, verdict) {
  const siteId = state.siteId;
  Object.assign(state, { triedWind: tried, triedAircraft: aircraft ?? null });
  byId('replan').setAttribute('aria-busy', 'true');
  try {
    const answer = atBest(verdict, await api.getApproach(siteId, tried, signal, aircraft));
    if (siteId !== state.siteId || signal.aborted) return;
    map.closeAnswer();
    const { properties } = state.site;
    byId('replan').replaceChildren(replanNode(answer, properties.approach, movedBy(state.site, answer.collection)));
    state.planned = siteWithPlan(state.site, answer, tried);
    map.drawMarks([]);
    drawShownSite();
    drawApproach(answer, true);
  } catch (error) {
    if (error.name === 'AbortError' || siteId !== state.siteId) return;
    // A path planned for a former wind must not stay on the map.
    byId('replan').replaceChildren(replanNode({ refusal: error.message }));
    map.closeAnswer();
    state.planned = siteWithPlan(state.site, { refusal: error.message }, tried);
    drawShownSite();
    drawApproach({ refusal: error.message }, true);
  } finally {
    byId('replan').removeAttribute('aria-busy');
  }
}

function showRejection(index) {
  const rejection = shownSite().properties.rejections[index];
  map.drawMarks(marksOf(rejection, index));
  map.panTo(rejection.touchdown);
}

// --- The ground ---

// source: of the flight's map, or null. all: its layers, with the photograph.
function showFlightMap(source, all) {
  layers.show(source);
  const hasPhoto = all.some(({ name }) => name === 'photo');
  byId('show-photo').closest('label').hidden = !hasPhoto;
  flightMap.showPhoto(byId('show-photo').checked);
  drawMapDownloads(byId('map-downloads'), state.flight, all);
  byId('map-card').hidden = all.length === 0;
}

// A map that cannot be read must not stop the rest: what is drawn stays, and the next look repeats it.
const lookAtMap = (event) => flightMap.look(event).then(() => { nextLook.look(); }).catch(() => {});

async function openRegion({ properties }) {
  map.drawAnswer(null);
  showView('region');
  // By id: another site may lie in the rectangle of this region.
  const site = state.sites.features.find((f) => f.properties.id === `${state.flight}-r${properties.id}`)?.properties;
  try {
    await drawHistory(state.flight, properties, site, openSite);
  } catch (error) {
    notify(`History not loaded: ${error.message}`);
  }
}

// --- Server state ---

function drawLists() {
  const shown = sitesWithPlan(state.sites, state.planned);
  drawSiteList(shown, state.siteId, openSite, state.flightJson);
  map.drawSites(shown, state.siteId);
}

function chooseFlight(id) {
  Object.assign(state, { flight: id, siteId: null, site: null, approach: null, planned: null, drawn: '', drawnSite: '',
    trackVersion: null, flightJson: null, sites: { features: [] }, regions: { features: [] } });
  byId('flight').value = id ?? '';
  map.drawTrack(null);
  map.drawApproach(null);
  map.drawWind(null, false);
  map.drawMarks([]);
  map.drawAnswer(null);
  map.drawArea(null);
  drawProgress(null);
  layers.show(null);
  flightMap.follow(id);
  rose.show(null);
  reach.follow(id);
  live.follow(id);
}

// Opens the site named in the address, else selects the best one.
async function drawFirst() {
  const wanted = new URLSearchParams(location.hash.slice(1)).get('site');
  const isThere = (id) => state.sites.features.some((f) => f.properties.id === id);
  if (wanted && isThere(wanted)) return openSite(wanted);
  if (state.sites.features.length) await chooseSite(state.sites.features[0].properties.id);
  return map.fit();
}

// Requests the track only after more photographs were processed, or every 5 s while a link sends it. The map follows it until a site exists.
async function refreshTrack(flight, numProcessed) {
  const version = `${numProcessed} ${links.hears(flight) ? Math.floor(Date.now() / 5000) : ''}`;
  if (version === state.trackVersion) return;
  const track = await api.getTrack(flight);
  if (state.flight !== flight) return;
  state.trackVersion = version;
  map.drawTrack(track, { hasMark: !links.hears(flight) });
  if (!state.siteId) map.fitUnlessMoved();
}

async function refreshFlight(flight) {
  const [flightJson, regions, sites, jobs] = await Promise.all([
    api.getFlight(flight), api.getRegions(flight), api.getSites(flight), api.listJobs(), lookAtMap()]);
  if (state.flight !== flight) return;
  state.flightJson = flightJson;
  const progress = drawFlight(flightJson, jobs.filter((job) => !job.flight_id || job.flight_id === flight), live.now);
  map.drawArea(progress?.area ?? null);
  await refreshTrack(flight, flightJson.frames.processed);
  if (state.flight !== flight) return;
  // An age counts on: only its minutes are compared.
  const drawn = JSON.stringify([regions, sites, flightJson.state], (key, value) => (key === 'age_s' ? Math.floor(value / 60) : value));
  if (drawn === state.drawn) return;
  const isFirst = state.drawn === '';
  Object.assign(state, { drawn, regions, sites });
  map.drawRegions(regions);
  drawLists();
  const chosen = sites.features.find((f) => f.properties.id === state.siteId);
  if (isFirst || (!state.siteId && sites.features.length)) await drawFirst();
  else if (chosen && chosen.properties.updated_at !== state.drawnSite && !state.triedWind) await loadSite(state.siteId);
}

async function refresh() {
  try {
    state.flights = await api.listFlights();
    const chosen = chosenFlight(state.flights, state.flight);
    if (chosen !== state.flight) chooseFlight(chosen);
    drawFlightChoice(state.flights, state.flight);
    if (state.flight) await refreshFlight(state.flight);
    else await storedSites.look();
    for (const part of [baseMap, reach, obstacles, newLook, route, nextLook]) part.look();
    byId('connection').hidden = true;
  } catch (error) {
    byId('connection').hidden = false;
    byId('connection').textContent = error.status
      ? `The server rejected the request: ${error.message}` : 'No connection to the server. Displayed data may be outdated.';
  }
}

// --- Start ---

connectViews({ changed: keepInAddress, back: backToSites, escape: () => obstacles.cancel() || route.cancel() || map.endMeasure() || map.closeAnswer() });
byId('flight').addEventListener('change', (event) => {
  chooseFlight(event.target.value);
  showView('sites');
  keepInAddress();
  live.now();
});
byId('sites-curl').replaceChildren(curlButton('the list of sites', () => curlOf(api.paths.flightSites(state.flight))));
byId('show-photo').addEventListener('change', () => flightMap.showPhoto(byId('show-photo').checked));

const upload = createUpload({
  flight: () => state.flight, created: (id) => { chooseFlight(id); live.now(); }, changed: live.now, open: () => showView('upload'),
});
// A site of any flight.
function openSiteOf(flightId, siteId) {
  if (flightId && flightId !== state.flight && state.flights.some(({ id }) => id === flightId)) {
    chooseFlight(flightId);
    location.hash = `flight=${flightId}&site=${encodeURIComponent(siteId)}`;
    live.now();
  } else openSite(siteId);
}

const flightName = (id) => state.flights.find((flight) => flight.id === id)?.name;
const emergency = createEmergency({
  show: ({ site_id, flight_id, aircraft, verdict }, planned) => {
    state.recalled = planned === undefined ? null : { siteId: site_id, wind: planned, aircraft, verdict };
    openSiteOf(flight_id, site_id);
  },
  center: map.center,
  drawBearings: map.drawBearings,
  flight: () => state.flight,
  flightName: () => state.flightJson?.name ?? state.flight,
  nameOf: flightName,
  useReach: (own) => reach.use(own),
});
const reach = createReach({
  draw(shown) {
    map.drawReach(shown?.collection ?? null);
    setKey('reach', reachKey(shown?.collection), shown?.text);
    emergency.showReach(shown);
  },
  glideRatio: () => emergency.glideRatio(),
});
const obstacles = createObstacles(map, {
  draw(features, chosen) {
    map.drawObstacles(features, chosen);
    setKey('obstacles', obstacleKey(features), chosen.note);
  },
  changed: () => { live.now(); reach.look(); nextLook.forget(); },
});
const newLook = createNewLook({
  open: ({ flight_id, id }) => openSiteOf(flight_id, id), mark: map.drawNewLook, fit: map.fitFeatures, flightName,
});
const nameOf = (id) => siteName(id, rankOf(id), state.flights);
const route = createRoute(map, {
  flight: () => state.flightJson, wind: () => (state.triedWind === 'unknown' ? null : state.triedWind), nameOf, openSite,
});
const links = createLinks(map, { nameOf, site: () => state.site, open(siteId, planned) { state.recalled = { siteId, wind: planned }; openSite(siteId); } });
const nextLook = createNextLook(map, {
  source: () => ({ flight: state.flight, map: flightMap.updatedAt, sites: state.sites.features }), nameOf, openSite,
});
api.whenUnauthorized(() => askToken(live.now));
live.start();
api.getInfo().then(({ aircraft_profiles = {} }) => [upload, route].forEach((part) => part.showProfiles(aircraft_profiles))).catch(() => {});
