// The go-around of an approach: what the map, the profile and the site panel state of it.

import { fixed, isKnown } from './units.js';

const goAroundOf = (collection) => collection?.features.find(({ properties }) => properties.kind === 'go_around')?.properties;

// Metres before the touchdown from which a go-around last clears everything known. undefined if the server
// does not compute go-arounds, null if none clears.
export function noReturnOf(collection) {
  const final = collection?.features.find(({ properties }) => properties.kind === 'approach')?.properties;
  const stated = [goAroundOf(collection), collection?.plan?.approach, final]
    .map((holder) => holder?.no_return_distance_m).filter((value) => value !== undefined);
  return stated.length === 0 ? undefined : stated.find(isKnown) ?? null;
}

// One line of the site panel, or null. approach: of the site or plan; collection: its GeoJSON.
export function goAroundText(approach, collection) {
  const distance_m = approach?.no_return_distance_m === undefined ? noReturnOf(collection) : approach.no_return_distance_m;
  if (distance_m === undefined || collection.verdict === 'rejected') return null;
  if (!isKnown(distance_m)) return 'No go-around: no climb from the final clears all seen ground.';
  const until = distance_m < 1 ? 'touchdown' : `${fixed(distance_m, 0, 'm')} before touchdown`;
  const unseen = goAroundOf(collection)?.unseen_ratio;
  return `Go-around clears all seen ground until ${until}.` + (unseen > 0 ? ` ${fixed(100 * unseen, 0, '%')} of the climb is over unseen ground.` : '');
}
