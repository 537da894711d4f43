// The best sites in reach at this moment, as the service keeps them for the flight.

const period_s = 5;
const maxNumSites = 3;
// Since the aircraft was where they are in reach from.
const maxAge_s = 15;

const siteOf = ({ site_id, verdict, arrival_margin_m }) => ({ site_id, verdict, arrival_margin_m });

export class Alternates {
  #ask;
  #asked_s = -Infinity;
  #isAsking = false;
  #flight;
  #answer;

  // ask(flight id): answer of /v1/flights/{flight}/alternates.
  constructor(ask) { this.#ask = ask; }

  step(now_s, { isFlying, flight }) {
    const id = isFlying ? flight?.id : undefined;
    if (id !== this.#flight) this.#answer = undefined;
    this.#flight = id;
    if (id === undefined || this.#isAsking || now_s - this.#asked_s < period_s) return;
    this.#asked_s = now_s;
    this.#isAsking = true;
    // After a failure the last list stays until it is too old.
    this.#ask(id).then((answer) => { if (id === this.#flight) this.#take(answer, now_s); }).catch(() => {})
      .finally(() => { this.#isAsking = false; });
  }

  // Without a place, or without its age, it is not known what is in reach.
  #take({ sites, pose }, asked_s) {
    this.#answer = Number.isFinite(pose?.age_s)
      ? { sites: sites.slice(0, maxNumSites).map(siteOf), num_in_reach: sites.length, place_s: asked_s - Math.max(0, pose.age_s) }
      : undefined;
  }

  // As `alternates` of the link's state: nothing while they are not known. age_s: of the place.
  state(now_s) {
    if (!this.#answer) return undefined;
    const { place_s, ...told } = this.#answer;
    const age_s = now_s - place_s;
    return age_s <= maxAge_s ? { ...told, age_s } : undefined;
  }
}
