// The stored sites nearest to a place. A list of sites ends at the server's limit, by rank and not by
// distance. So boxes around the place grow until they hold enough, and a full list is asked in parts.

import { courseTo } from './units.js';

const kFirstHalfSide_m = 4000;
const kGrowth = 4;
const kHalfWay_m = 20038000; // around the Earth
const metresPerDegree = 111195;
// Least that a server lists; it says `next` where it lists more.
const kFullList = 1000;
const kMinSide_deg = 1e-5;

const wrapped = (longitude_deg) => ((longitude_deg + 180) % 360 + 360) % 360 - 180;

// East may lie beyond 180 degrees.
function boxAround({ latitude_deg, longitude_deg }, halfSide_m) {
  const reach_deg = halfSide_m / metresPerDegree;
  const south = Math.max(-90, latitude_deg - reach_deg);
  const north = Math.min(90, latitude_deg + reach_deg);
  const narrowest = Math.cos(Math.max(-south, north) * Math.PI / 180);
  const reachEast_deg = reach_deg / Math.max(1e-9, narrowest);
  if (south === -90 || north === 90 || reachEast_deg >= 180) return { west: -180, south, east: 180, north };
  return { west: longitude_deg - reachEast_deg, south, east: longitude_deg + reachEast_deg, north };
}

function boxText({ west, south, east, north }) {
  const sides = east - west >= 360 ? [-180, south, 180, north] : [wrapped(west), south, wrapped(east), north];
  return sides.map((side) => side.toFixed(7)).join(',');
}

function quarters({ west, south, east, north }) {
  const [lon, lat] = [(west + east) / 2, (south + north) / 2];
  return [{ west, south, east: lon, north: lat }, { west: lon, south, east, north: lat },
    { west, south: lat, east: lon, north }, { west: lon, south: lat, east, north }];
}

// All features in the box, by id.
async function featuresIn(box, list) {
  const { features, next } = await list(boxText(box));
  const isFull = next !== undefined || features.length >= kFullList;
  if (!isFull || box.north - box.south < kMinSide_deg) {
    return new Map(features.map((feature) => [feature.properties.id, feature]));
  }
  const parts = [];
  for (const quarter of quarters(box)) parts.push(...await featuresIn(quarter, list));
  return new Map(parts);
}

// [{feature, touchdown, distance_m, bearing_deg}], nearest first. list(bbox): the sites in a box as the
// server answers; isWanted(feature): whether it counts.
export async function nearestSites(from, count, { list, isWanted }) {
  for (let halfSide_m = kFirstHalfSide_m; ; halfSide_m *= kGrowth) {
    const isWorld = halfSide_m >= kHalfWay_m;
    const features = await featuresIn(boxAround(from, Math.min(halfSide_m, kHalfWay_m)), list);
    const sites = [...features.values()].filter((feature) => feature.geometry && isWanted(feature)).map((feature) => {
      const [longitude_deg, latitude_deg] = feature.geometry.coordinates;
      const touchdown = { latitude_deg, longitude_deg };
      return { feature, touchdown, ...courseTo(from, touchdown) };
    }).sort((a, b) => a.distance_m - b.distance_m).slice(0, count);
    // A site beyond the rim may be nearer than one in a corner of the box.
    const isSettled = sites.length === count && sites.at(-1).distance_m <= halfSide_m;
    if (isSettled || isWorld) return sites;
  }
}
