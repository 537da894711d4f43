// Simulated aircraft over stored sites: telemetry, standing alternates and recalls, timed.
//
//   node tests/bench/fleet_load.mjs --api URL,URL --recall URL,URL --token FILE --places FILE --aircraft N --seconds N
//     [--hz 1] [--recalls-per-second 5]
//
// Each aircraft sends one line of telemetry (position and wind) a second and reads its alternates every 10 s. Measuring
// begins when the lists are fresh. PLACES has a line "latitude longitude" for each. Prints one JSON object.
import { readFileSync } from "node:fs";
import http from "node:http";
import { performance } from "node:perf_hooks";

const option = new Map();
for (let i = 2; i + 1 < process.argv.length; i += 2) option.set(process.argv[i].slice(2), process.argv[i + 1]);
const apis = option.get("api").split(",");
const recalls = option.get("recall").split(",");
const token = option.get("token") ? readFileSync(option.get("token"), "utf8").trim() : "";
const places = readFileSync(option.get("places"), "utf8").trim().split("\n").map((line) => line.split(" ").map(Number));
const numAircraft = Number(option.get("aircraft"));
const seconds = Number(option.get("seconds"));
const hz = Number(option.get("hz") ?? 1);
const recallsPerSecond = Number(option.get("recalls-per-second") ?? 5);
const agent = new http.Agent({ keepAlive: true, maxSockets: 48 });
const recallAgent = new http.Agent({ keepAlive: true, maxSockets: 32 });
const speedDegPerS = 15 / 111195;
const alternatesPeriodS = 10;
// The start is cold. It is over when nearly all aircraft were last told a list of this age.
const settledAgeS = 10, settledShare = 0.95, longestWarmupS = 420;

function request(method, url, body, via = agent) {
  return new Promise((resolve) => {
    const begin = performance.now();
    const call = http.request(url, { method, agent: via, timeout: 30000, headers: {
      ...(token ? { authorization: `Bearer ${token}` } : {}),
      ...(body ? { "content-length": Buffer.byteLength(body) } : {}) } }, (answer) => {
      const parts = [];
      answer.on("data", (part) => parts.push(part));
      answer.on("end", () => resolve({ status: answer.statusCode, ms: performance.now() - begin,
        text: Buffer.concat(parts).toString() }));
    });
    call.on("timeout", () => call.destroy(new Error("timeout")));
    call.on("error", (error) => resolve({ status: 0, ms: performance.now() - begin, text: String(error) }));
    call.end(body);
  });
}

const statuses = {};
function count(kind, answer) {
  const key = `${kind} ${answer.status}`;
  statuses[key] = (statuses[key] ?? 0) + 1;
}

async function createAircraft(number) {
  const api = apis[number % apis.length];
  const answer = await request("POST", `${api}/v1/flights`, JSON.stringify(
    { name: `load ${number}`, altitude_datum: "amsl", aircraft: { profile: "small" } }));
  if (answer.status !== 201) throw new Error(`a new flight: ${answer.status} ${answer.text}`);
  const [latitude, longitude] = places[number % places.length];
  return { id: JSON.parse(answer.text).id, api, recall: recalls[number % recalls.length], latitude, longitude, begin: Date.now(), wind: [(number % 7) - 3, (number % 5) - 2] };
}

function positionOf(aircraft) {
  // To and fro over a kilometre: the same sites stay in reach.
  const flownS = (Date.now() - aircraft.begin) / 1000;
  const phase = (flownS * speedDegPerS) % 0.02;
  return { latitude_deg: aircraft.latitude - 0.005 + (phase < 0.01 ? phase : 0.02 - phase),
    longitude_deg: aircraft.longitude, altitude_m: 900 };
}

const sendMs = [], recallMs = [], agesS = [];
const lastAgeS = new Map();
let numRows = 0, numSites = 0, numWithSites = 0, stop = false;

async function fly(aircraft, offsetMs) {
  await new Promise((resolve) => setTimeout(resolve, offsetMs));
  let next = Date.now();
  while (!stop) {
    const line = JSON.stringify({ timestamp_us: Date.now() * 1000, position: positionOf(aircraft),
      wind: { east_mps: aircraft.wind[0], north_mps: aircraft.wind[1] } }) + "\n";
    const answer = await request("POST", `${aircraft.api}/v1/flights/${aircraft.id}/telemetry`, line);
    count("telemetry", answer);
    if (answer.status === 200) numRows += 2;
    sendMs.push(answer.ms);
    next = Math.max(next + 1000 / hz, Date.now());
    await new Promise((resolve) => setTimeout(resolve, next - Date.now()));
  }
}

async function readAlternates(aircraft, offsetMs) {
  await new Promise((resolve) => setTimeout(resolve, offsetMs + 10000));
  while (!stop) {
    const answer = await request("GET", `${aircraft.api}/v1/flights/${aircraft.id}/alternates`);
    count("alternates", answer);
    if (answer.status === 200) {
      const list = JSON.parse(answer.text);
      // From sending the pose that the list is computed from to reading it.
      lastAgeS.set(aircraft.id, Date.now() / 1000 - list.pose.timestamp_us * 1e-6);
      agesS.push(lastAgeS.get(aircraft.id));
    }
    await new Promise((resolve) => setTimeout(resolve, alternatesPeriodS * 1000));
  }
}

async function recall(fleet) {
  let next = Date.now();
  while (!stop) {
    const aircraft = fleet[Math.floor(Math.random() * fleet.length)];
    const { latitude_deg, longitude_deg, altitude_m } = positionOf(aircraft);
    const query = `latitude_deg=${latitude_deg}&longitude_deg=${longitude_deg}&altitude_m=${altitude_m}&flight=${aircraft.id}`;
    request("GET", `${aircraft.recall}/v1/emergency?${query}`, undefined, recallAgent).then((answer) => {
      count("recall", answer);
      if (answer.status !== 200) return;
      recallMs.push(answer.ms);
      const found = JSON.parse(answer.text).sites.length;
      numSites += found;
      if (found > 0) ++numWithSites;
    });
    next += 1000 / recallsPerSecond;
    await new Promise((resolve) => setTimeout(resolve, Math.max(0, next - Date.now())));
  }
}

function percentiles(values) {
  const sorted = [...values].sort((a, b) => a - b);
  const at = (ratio) => sorted.length === 0 ? null : Number(sorted[Math.min(sorted.length - 1, Math.floor(ratio * sorted.length))].toFixed(2));
  return { num: sorted.length, p50: at(0.5), p99: at(0.99), max: at(1) };
}

const fleet = [];
for (let number = 0; number < numAircraft; number += 16) {
  const some = Array.from({ length: Math.min(16, numAircraft - number) }, (_, i) => createAircraft(number + i));
  fleet.push(...await Promise.all(some));
}
const begin = performance.now();
const loops = fleet.flatMap((aircraft, number) =>
  [fly(aircraft, (1000 * number) / numAircraft), readAlternates(aircraft, (10000 * number) / numAircraft)]);
loops.push(recall(fleet));
const numFresh = () => [...lastAgeS.values()].filter((age) => age <= settledAgeS).length;
while (numFresh() < settledShare * numAircraft && performance.now() - begin < longestWarmupS * 1000) {
  await new Promise((resolve) => setTimeout(resolve, 200));
}
const warmupS = (performance.now() - begin) / 1000, numFreshAfterWarmup = numFresh();
sendMs.length = recallMs.length = agesS.length = 0;
numRows = numSites = numWithSites = 0;
for (const key of Object.keys(statuses)) delete statuses[key];
const usage = process.cpuUsage();
process.stderr.write("measuring\n");
await new Promise((resolve) => setTimeout(resolve, seconds * 1000));
console.log(JSON.stringify({ aircraft: numAircraft, warmup_s: warmupS, fresh_after_warmup: numFreshAfterWarmup, seconds, telemetry_rows_per_s: numRows / seconds,
  telemetry_ms: percentiles(sendMs), recall_ms: percentiles(recallMs), recalls_with_sites: numWithSites,
  sites_told: numSites, alternates_age_s: percentiles(agesS), statuses,
  client_processor_s: (process.cpuUsage(usage).user + process.cpuUsage(usage).system) / 1e6 }));
process.exit(0);
