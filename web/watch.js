// Stored strips that are occupied: events tell of them, and after a reload the obstacles that cover them. Shows a notice
// for the selected flight, and marks on the map.

import * as api from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el, notify } from './dom.js';
import { isKnown } from './units.js';
import { alternateText, isOver, noticeText, shortText, stripOf } from './watch_shape.js';

const kLongest_ms = 2 ** 31 - 1;  // of a timer

class Watch {
  #on;
  #strips = new Map();  // by site: {siteId, obstacleId, seen_at, expires_at, place, event, isListed}
  #timer = 0;
  #drawn = '';

  constructor(on) { this.#on = on; }

  // event: see /v1/events.
  takeEvent(event) {
    const former = this.#strips.get(event.site_id);
    if (event.state === 'occupied') {
      this.#strips.set(event.site_id, { ...former, siteId: event.site_id, obstacleId: event.obstacle_id, seen_at: event.seen_at,
        expires_at: event.expires_at, place: former?.place ?? event.things?.[0], event });
    } else if (this.#strips.delete(event.site_id)) notify(`Nothing new stands on ${this.#on.nameOf(event.site_id)} any more.`);
    this.#changed();
  }

  // features: the obstacles that are loaded. covers(place): whether all obstacles there are loaded.
  takeObstacles(features, covers) {
    const listed = features.map(stripOf).filter(Boolean);
    for (const strip of listed) this.#strips.set(strip.siteId, { ...this.#strips.get(strip.siteId), ...strip, isListed: true });
    for (const { siteId, isListed, place } of [...this.#strips.values()]) {
      // A list that was asked for before the event does not know its obstacle yet.
      if (isListed && covers(place) && !listed.some((strip) => strip.siteId === siteId)) this.#strips.delete(siteId);
    }
    this.#changed();
  }

  // {seen_at, expires_at} of an occupied strip, or undefined.
  find(siteId) { return this.#strips.get(siteId); }

  // New photographs of the same thing extend the obstacle without another event.
  async #checkOver() {
    for (const strip of [...this.#strips.values()].filter((each) => isOver(each))) {
      const stored = await api.getObstacle(strip.obstacleId).catch(() => null);
      const found = stored && stripOf(stored);
      if (this.#strips.get(strip.siteId) !== strip) continue;
      if (found && !isOver(found)) this.#strips.set(strip.siteId, { ...strip, ...found });
      else this.#strips.delete(strip.siteId);
    }
    this.#changed();
  }

  #changed() {
    clearTimeout(this.#timer);
    const ends = [...this.#strips.values()].map(({ expires_at }) => Date.parse(expires_at)).filter(Number.isFinite);
    if (ends.length) this.#timer = setTimeout(() => this.#checkOver(), Math.min(kLongest_ms, Math.max(0, Math.min(...ends) - Date.now())));
    this.draw();
  }

  // --- Drawing ---

  // Also after another flight was selected, or after sites got other names.
  draw() {
    const strips = [...this.#strips.values()];
    const noted = strips.filter(({ event }) => event?.flight_id === this.#on.flight());
    const text = ({ event }) => [noticeText(event, this.#on.nameOf), alternateText(event, this.#on.nameOf)];
    const drawn = JSON.stringify([strips.map(({ isListed, ...strip }) => strip), noted.map(text)]);
    if (drawn === this.#drawn) return;
    this.#drawn = drawn;
    byId('strip-notices').replaceChildren(...noted.map((strip) => this.#notice(strip, text(strip))));
    byId('em-strips').replaceChildren(...noted.map((strip) => el('p', {}, text(strip).join(' '))));
    this.#on.draw(strips.flatMap((strip) => this.#marks(strip)));
  }

  #notice({ event }, [text, alternate]) {
    const flight = event.flight_id;
    return el('article', { class: 'strip-notice', 'data-site': event.site_id },
      el('b', { class: 'strip-sign', 'aria-hidden': 'true' }, '!'),
      el('p', {}, el('strong', {}, text), ` ${alternate}`),
      el('div', { class: 'strip-buttons' },
        el('button', { type: 'button', onclick: () => this.#on.look(event) }, 'Show on map'),
        event.alternate ? el('button', { type: 'button', class: 'primary', onclick: () => this.#on.open(event.alternate) }, `Open ${this.#on.nameOf(event.alternate)}`) : null,
        curlButton('the events of this flight', () => curlOf(api.paths.events(flight), '-N'))));
  }

  // At the site, and where the things stand.
  #marks(strip) {
    const [longitude_deg, latitude_deg] = this.#on.siteOf(strip.siteId)?.geometry.coordinates ?? [];
    const place = isKnown(latitude_deg) ? { latitude_deg, longitude_deg } : strip.place;
    const title = `${shortText(strip)}: ${this.#on.nameOf(strip.siteId)}`;
    return [...(place ? [{ place, sign: '!', className: 'new-thing beside', title }] : []),
      ...(strip.event?.things ?? []).map((thing) => ({ place: thing, sign: '!', className: 'new-thing', title }))];
  }
}

// on: {flight(): id, nameOf(site id), siteOf(site id): its feature, or undefined, draw(marks): strips became occupied or free,
// look(event): show the things on the map, open(site id)}
export const createWatch = (on) => new Watch(on);
