// Which site an aircraft without power flies to, and by which way. Pure.

export const defaultChoiceOptions = {
  // The way is flown as it is while the aircraft is so near it.
  maxHigh_m: 3,
  maxLow_m: 2,
  maxAside_m: 15,
  // A new way to the same site brings the aircraft so much nearer to the height of the final.
  gain_m: 1,
  // So shortly before the final no other way is taken: it would turn low above the ground.
  committed_s: 8,
  // Another site: the present one is about to be lost, and the other has so much more margin.
  lowMargin_m: 3,
  betterBy_m: 10,
  // Surplus height that the final can take.
  maxSurplus_m: 5,
};

const isClear = (site) => !site.airspaces?.length;
export const hasWay = (site) => site.path?.coordinates?.length >= 3;
// Height that the told way leaves above the start of the final.
const surplus_m = (site) => site.path.coordinates.at(-2)[2] - site.approach.start.altitude_m;

// Sites of an answer that can be flown to, best first. The service orders them. Those through
// forbidden airspace come last. Then come those that this flight has mapped: the error of its altimeter
// is in them too, and without power 1 m of height is 7 m of the final. Of these, first those whose
// way ends at the height of the final, then verified ones.
function flyable(answer, flightId, options = defaultChoiceOptions) {
  const worth = (site) => (isClear(site) ? 8 : 0) +
    (flightId !== undefined && site.flight_id === flightId ? 4 : 0) +
    (surplus_m(site) <= options.maxSurplus_m ? 2 : 0) + (site.verdict === 'landable' ? 1 : 0);
  return (answer?.sites ?? []).filter(hasWay).sort((a, b) => worth(b) - worth(a));
}

const told = (answer, siteId) =>
  [...(answer?.sites ?? []), ...(answer?.nearest_miss ? [answer.nearest_miss] : [])]
    .find((site) => site.site_id === siteId);

// way: the present ToldWay, or nothing. progress: where the aircraft is on it, with energy_m: the
// height above the way that it will have at the end, with what its airspeed is worth.
// Gives { site, reason } for a new way, or nothing where the present one is kept.
export function choose({ way, progress, answer, flightId, mayChangeSite = true }, options = defaultChoiceOptions) {
  const sites = flyable(answer, flightId, options);
  if (!way) return sites.length ? { site: sites[0], reason: 'best site in reach' } : undefined;
  if (way.timeToFinal_s(progress.along_m) < options.committed_s) return undefined;
  const same = told(answer, way.site.site_id);
  const other = mayChangeSite && better(sites, same, way, progress, options);
  if (other) return { site: other, reason: 'more margin than the present site' };
  const off = deviation(progress, options);
  if (!off || !same || !hasWay(same)) return undefined;
  const isAside = progress.away_m > options.maxAside_m;
  const gain_m = cost_m(progress.energy_m + way.surplus_m) - cost_m(surplus_m(same));
  return isAside || gain_m >= options.gain_m ? { site: same, reason: off } : undefined;
}

// Too low is worse: height can be lost on the final, but not won.
const cost_m = (height_m) => (height_m < 0 ? -2 * height_m : height_m);

function deviation({ energy_m, away_m }, options) {
  if (energy_m > options.maxHigh_m) return `${energy_m.toFixed(1)} m above the way`;
  if (energy_m < -options.maxLow_m) return `${(-energy_m).toFixed(1)} m below the way`;
  if (away_m > options.maxAside_m) return `${away_m.toFixed(0)} m beside the way`;
  return undefined;
}

// On the way, what is told of the worst wind no longer counts: the aircraft shows how it glides.
function better(sites, same, way, progress, options) {
  const isOther = (site) => site.site_id !== way.site.site_id;
  const [best] = sites.filter((site) => isOther(site) && isClear(site) && surplus_m(site) <= options.maxSurplus_m);
  if (!best || progress.energy_m > -options.maxLow_m) return undefined;
  const margin_m = same?.arrival_margin_m ?? progress.energy_m;
  if (margin_m >= options.lowMargin_m) return undefined;
  return best.arrival_margin_m >= margin_m + options.betterBy_m ? best : undefined;
}
