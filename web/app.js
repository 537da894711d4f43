// Ties the page together: polls the server, remembers what is chosen.

import * as api from './api.js';
import { createMap } from './map.js';
import { drawFlight, drawSite, drawSiteList } from './panel.js';
import { drawProfile } from './profile.js';

const POLL_MS = 2000;
const byId = (id) => document.getElementById(id);

const state = { flight: null, site: null, layers: [], sites: { features: [] }, drawn: '' };
const map = createMap('map', chooseSite);

async function chooseSite(siteId) {
  state.site = siteId;
  drawSiteList(state.sites, siteId, chooseSite);
  const [feature, layers, approach] = await Promise.all(
    [api.getSite(siteId), api.getLayers(siteId), api.getApproach(siteId)]);
  const listed = state.sites.features.find((f) => f.properties.id === siteId);
  feature.properties.rank = listed?.properties.rank;
  drawSite(feature);
  state.layers = layers;
  const chosen = byId('layer').value || 'hazard';
  byId('layer').replaceChildren(...layers.map((layer) => new Option(
    layer.unit ? `${layer.name} (${layer.unit})` : layer.name, layer.name)));
  if (layers.some((layer) => layer.name === chosen)) byId('layer').value = chosen;
  drawChosenLayer();
  map.drawApproach(approach);
  byId('no-profile').hidden = Boolean(approach);
  drawProfile(byId('profile'), approach?.profile);
}

function drawChosenLayer() {
  const layer = state.layers.find((l) => l.name === byId('layer').value);
  const legend = byId('legend');
  legend.hidden = !layer;
  if (layer) legend.src = api.legendUrl(state.site, layer.name);
  map.drawLayer(
    layer && api.layerUrl(state.site, layer.name), layer, Number(byId('opacity').value));
}

async function refreshFlights() {
  const flights = await api.listFlights();
  const select = byId('flight');
  const known = [...select.options].map((option) => option.value).join();
  if (known !== flights.map((f) => f.id).join()) {
    select.replaceChildren(...flights.map((f) => new Option(f.name || f.id, f.id)));
    if (!flights.some((f) => f.id === state.flight)) {
      state.flight = flights.at(-1)?.id ?? null;
      state.drawn = '';
    }
    if (state.flight) select.value = state.flight;
  }
}

async function refreshFlight() {
  if (!state.flight) return;
  const [flight, regions, sites, jobs] = await Promise.all([
    api.getFlight(state.flight), api.getRegions(state.flight), api.getSites(state.flight),
    api.listJobs(),
  ]);
  drawFlight(flight, jobs.filter((job) => !job.flight_id || job.flight_id === state.flight));
  const drawn = JSON.stringify([regions, sites]);
  if (drawn === state.drawn) return;
  const isFirst = state.drawn === '';
  state.drawn = drawn;
  state.sites = sites;
  map.drawRegions(regions);
  map.drawSites(sites);
  drawSiteList(sites, state.site, chooseSite);
  if (isFirst) map.fit();
}

async function poll() {
  try {
    await refreshFlights();
    await refreshFlight();
    byId('connection').hidden = true;
  } catch (error) {
    byId('connection').hidden = false;
    byId('connection').textContent = `No answer from the server: ${error.message}`;
  }
  setTimeout(poll, POLL_MS);
}

byId('flight').addEventListener('change', async (event) => {
  Object.assign(state, { flight: event.target.value, site: null, layers: [], drawn: '' });
  drawSite(null);
  map.drawApproach(null);
  map.drawLayer(null, null, 0);
  await refreshFlight();
});
byId('layer').addEventListener('change', drawChosenLayer);
byId('opacity').addEventListener('input', (event) => map.setOpacity(Number(event.target.value)));
poll();
