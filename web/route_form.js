// The values of the view "Route": altitude, airspeed, wind, aircraft; filled in from what the page knows.

import * as api from './api.js';
import { byId } from './dom.js';
import { isKnown, windFrom } from './units.js';

const names = ['altitude_m', 'airspeed_mps', 'wind_speed_mps', 'wind_from_deg', 'wind_sd_mps', 'aircraft'];
const kOfFlight = 'flight';

const input = (name) => byId(`route-${name}`);
const number = (name) => (input(name).value === '' ? null : Number(input(name).value));
const fill = (name, value, digits) => { input(name).value = isKnown(value) ? String(Number(value.toFixed(digits))) : ''; };

const isProfile = (aircraft, profile) => Object.entries(profile).every(([key, value]) => aircraft[key] === value);

class RouteForm {
  #on;
  #own = new Set(); // names of fields that the user has changed
  #profiles = {};
  #sources = {}; // by the field that was filled in: where its value comes from

  constructor(on) {
    this.#on = on;
    byId('route-form').addEventListener('input', ({ target }) => {
      const name = names.find((candidate) => input(candidate) === target);
      this.#own.add(name);
      this.#forgetSource(name);
      this.showFault(null);
      on.changed(name);
    });
    byId('route-form').addEventListener('submit', (event) => { event.preventDefault(); on.submit(); });
  }

  showProfiles(profiles) {
    this.#profiles = profiles;
    const select = input('aircraft');
    select.replaceChildren(select.options[0], ...Object.keys(profiles).map((name) => new Option(name, name)));
  }

  values() {
    const { value } = input('aircraft');
    const aircraft = value === kOfFlight ? this.#on.flight()?.aircraft : value;
    return { ...Object.fromEntries(names.map((name) => [name, number(name)])), aircraft: aircraft || null };
  }

  // Altitude and wind of the flight's last position, wind that is tried, aircraft of the flight. A wind in the form is one
  // of now: an old one is left out.
  async prefill() {
    const flight = this.#on.flight();
    this.#fillAircraft(flight);
    const { pose = null, wind = null } = flight ? await api.getAlternates(flight.id).catch(() => ({})) : {};
    if (!this.#own.has('altitude_m') && pose?.altitude_datum === 'amsl') {
      fill('altitude_m', pose.altitude_m, 0);
      this.#sources.altitude_m = `Altitude: last position of ${flight.name || flight.id}.`;
    }
    const isOfFlight = wind?.counts_as === 'known';
    const known = windFrom(isOfFlight ? wind : this.#on.wind());
    if (known && !this.#own.has('wind_speed_mps') && !this.#own.has('wind_from_deg')) {
      fill('wind_speed_mps', known.speed_mps, 1);
      fill('wind_from_deg', known.from_deg, 0);
      this.#sources.wind_from_deg = this.#sources.wind_speed_mps = isOfFlight ? `Wind: of ${flight.name || flight.id}.` : 'Wind: as tried at the selected site.';
    }
    this.#drawSources();
  }

  #forgetSource(name) {
    delete this.#sources[name];
    this.#drawSources();
  }

  #drawSources() { byId('route-source').textContent = [...new Set(Object.values(this.#sources))].join(' '); }

  #fillAircraft(flight) {
    if (this.#own.has('aircraft') || !flight?.aircraft) return;
    const select = input('aircraft');
    const profile = Object.keys(this.#profiles).find((name) => isProfile(flight.aircraft, this.#profiles[name]));
    [...select.options].find(({ value }) => value === kOfFlight)?.remove();
    if (!profile) select.add(new Option(`as ${flight.name || flight.id}`, kOfFlight));
    select.value = profile ?? kOfFlight;
  }

  fillAirspeed(airspeed_mps) { if (airspeed_mps !== null) fill('airspeed_mps', airspeed_mps, 1); }

  // altitude_m: null if each point has its own.
  setAltitude(altitude_m) {
    fill('altitude_m', altitude_m, 1);
    this.#forgetSource('altitude_m');
  }

  // A plan has its own altitudes.
  showPlan(hasPlan) { input('altitude_m').closest('label').hidden = hasPlan; }

  // fault: {field, detail}, or null.
  showFault(fault) {
    for (const name of names) input(name).removeAttribute('aria-invalid');
    byId('route-fault').hidden = !fault;
    byId('route-fault').textContent = fault?.detail ?? '';
    if (!fault) return;
    input(fault.field).setAttribute('aria-invalid', 'true');
    input(fault.field).setAttribute('aria-describedby', 'route-fault');
    input(fault.field).focus();
  }
}

// on: {flight(), wind(): see route.js, changed(name of a field), submit()}
export const createRouteForm = (on) => new RouteForm(on);
