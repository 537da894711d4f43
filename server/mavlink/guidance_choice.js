// Which site an aircraft without power flies to, and by which way. Pure.

export const defaultChoiceOptions = {
  // The way is flown as it is while the aircraft is so near it.
  maxHigh_m: 3,
  maxLow_m: 2,
  maxAside_m: 15,
  // So little before the final no other way helps.
  committed_s: 7,
  // Another site: the present one is about to be lost, and the other has so much more margin.
  lowMargin_m: 3,
  betterBy_m: 10,
};

const isClear = (site) => !site.airspaces?.length;
const hasWay = (site) => site.path?.coordinates?.length >= 3;

// Sites of an answer that can be flown to, best first. The service orders them; of those the
// verified ones come first, and those through forbidden airspace last.
export function flyable(answer) {
  const worth = (site) => (isClear(site) ? 2 : 0) + (site.verdict === 'landable' ? 1 : 0);
  return (answer?.sites ?? []).filter(hasWay).sort((a, b) => worth(b) - worth(a));
}

const told = (answer, siteId) =>
  [...(answer?.sites ?? []), ...(answer?.nearest_miss ? [answer.nearest_miss] : [])]
    .find((site) => site.site_id === siteId);

// way: the present ToldWay, or nothing. progress: where the aircraft is on it.
// Gives { site, reason } for a new way, or nothing where the present one is kept.
export function choose({ way, progress, answer }, options = defaultChoiceOptions) {
  const sites = flyable(answer);
  if (!way) return sites.length ? { site: sites[0], reason: 'best site in reach' } : undefined;
  if (way.timeToFinal_s(progress.along_m) < options.committed_s) return undefined;
  const same = told(answer, way.site.site_id);
  const off = deviation(progress, options);
  const other = better(sites, same, way, progress, options);
  if (other) return { site: other, reason: 'more margin than the present site' };
  if (!off || !same || !hasWay(same)) return undefined;
  return { site: same, reason: off };
}

// energy_m: height above the way, with what the airspeed is worth.
function deviation({ energy_m: height_m, away_m }, options) {
  if (height_m > options.maxHigh_m) return `${height_m.toFixed(0)} m above the way`;
  if (height_m < -options.maxLow_m) return `${(-height_m).toFixed(0)} m below the way`;
  if (away_m > options.maxAside_m) return `${away_m.toFixed(0)} m beside the way`;
  return undefined;
}

// On the way, what is told of the worst wind no longer counts: the aircraft shows how it glides.
function better(sites, same, way, progress, options) {
  const [best] = sites.filter((site) => site.site_id !== way.site.site_id && isClear(site));
  if (!best || progress.energy_m > -options.maxLow_m) return undefined;
  const margin_m = same?.arrival_margin_m ?? progress.energy_m;
  if (margin_m >= options.lowMargin_m) return undefined;
  return best.arrival_margin_m >= margin_m + options.betterBy_m ? best : undefined;
}
