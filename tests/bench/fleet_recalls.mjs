// Recalls alone, one after the other: the first one at each place, and the next ones there.
//
//   node tests/bench/fleet_recalls.mjs --recall URL --token FILE --places FILE --num N
import { readFileSync } from "node:fs";

const option = new Map();
for (let i = 2; i + 1 < process.argv.length; i += 2) option.set(process.argv[i].slice(2), process.argv[i + 1]);
const token = option.get("token") ? readFileSync(option.get("token"), "utf8").trim() : "";
const places = readFileSync(option.get("places"), "utf8").trim().split("\n").map((line) => line.split(" ").map(Number));
const first = [], again = [];
let numWithSites = 0;
for (let number = 0; number < Number(option.get("num")); ++number) {
  const [latitude, longitude] = places[(number * 37) % places.length];
  const query = `latitude_deg=${latitude + 0.003}&longitude_deg=${longitude}&altitude_m=900&altitude_datum=amsl` +
    "&aircraft=small&wind_east_mps=2&wind_north_mps=1";
  for (let turn = 0; turn < 4; ++turn) {
    const begin = performance.now();
    const answer = await fetch(`${option.get("recall")}/v1/emergency?${query}`,
      { headers: token ? { authorization: `Bearer ${token}` } : {} });
    const found = await answer.json();
    (turn === 0 ? first : again).push(performance.now() - begin);
    if (turn === 0 && found.sites?.length > 0) ++numWithSites;
  }
}
const at = (values, ratio) => Number(values.sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(ratio * values.length))].toFixed(1));
console.log(JSON.stringify({ places: first.length, with_sites: numWithSites, first_ms: { p50: at(first, 0.5), p99: at(first, 0.99) },
  again_ms: { p50: at(again, 0.5), p99: at(again, 0.99) } }));
