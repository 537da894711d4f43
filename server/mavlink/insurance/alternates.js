// The best sites in reach at this moment, as the service keeps them for the flight.

const period_s = 5;
const maxNumSites = 3;

const siteOf = ({ site_id, verdict, arrival_margin_m }) => ({ site_id, verdict, arrival_margin_m });

export class Alternates {
  #ask;
  #asked_s = -Infinity;
  #isAsking = false;
  #answer;

  // ask(flight id): answer of /v1/flights/{flight}/alternates.
  constructor(ask) { this.#ask = ask; }

  step(now_s, { isFlying, flight }) {
    if (!isFlying || !flight?.id) {
      this.#answer = undefined;
      return;
    }
    if (this.#isAsking || now_s - this.#asked_s < period_s) return;
    this.#asked_s = now_s;
    this.#isAsking = true;
    this.#ask(flight.id).then(({ sites, pose }) => { this.#answer = { sites, pose, now_s }; }, () => {})
      .finally(() => { this.#isAsking = false; });
  }

  // As `alternates` of the link's state: nothing while none were told.
  state(now_s) {
    if (!this.#answer) return undefined;
    const { sites, now_s: asked_s } = this.#answer;
    return { sites: sites.slice(0, maxNumSites).map(siteOf), num_in_reach: sites.length, age_s: now_s - asked_s };
  }
}
