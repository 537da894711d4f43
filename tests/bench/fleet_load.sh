#!/usr/bin/env bash
# Load on a fleet of this machine (deploy/fleet.sh): stored sites over a continent, live aircraft, recalls, and a flight
# that is evaluated in each worker. Takes half an hour; not part of the tests.
#
#   tests/bench/fleet_load.sh [--sites N] [--aircraft N] [--seconds N] [--root DIR] [--build DIR] [--flight DIR] [--internal-port N]
#                             [--step fill|live|sqlite|workers]
#
# Without --step, all in turn. Results are lines of JSON on standard output. Needs nginx, PostgreSQL, node, python3, jq.
set -Eeuo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
program="fleet_load.sh"
source "$root/deploy/steps.sh"
num_sites=1000000 num_aircraft=1000 seconds=60
place=/var/tmp/freelsd-load build="$root/build/release" flight="" internal=19300 steps="fill live sqlite workers"
while [ $# -gt 0 ]; do
  case "$1" in
    --sites) num_sites="$2" ;;
    --aircraft) num_aircraft="$2" ;;
    --seconds) seconds="$2" ;;
    --root) place="$2" ;;
    --build) build="$(realpath "$2")" ;;
    --flight) flight="$(realpath "$2")" ;;
    --step) steps="$2" ;;
    --internal-port) internal="$2" ;;
    *) sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0" >&2; exit 2 ;;
  esac
  shift 2
done
fleet() { "$root/deploy/fleet.sh" "$@" --root "$place/fleet" >>"$place/log" 2>&1 || { tail -n 20 "$place/log" >&2; fail "fleet.sh $*"; }; }
up() { fleet up --internal-port "$internal" --port $((internal + 443)) --server "$build/server/freelsd-server" "$@"; }
ask() {
  setpriv --reuid=postgres --regid=postgres --clear-groups env PGPASSFILE="$place/fleet/secrets/database.pass" \
    psql -qAtX -h 127.0.0.1 -p "$internal" -U postgres -d freelsd -v ON_ERROR_STOP=1 "$@"
}
api() { curl -fsS -H @- "${@:2}" "http://127.0.0.1:$((internal + 1))$1" <<<"Authorization: Bearer $(cat "$place/fleet/secrets/token")"; }
submit() { # prints the flight
  "$root/deploy/freelsdctl" submit "$flight" --new --no-wait --token "$place/fleet/secrets/token" \
    --url "http://127.0.0.1:$((internal + 1))" 2>>"$place/log" | tail -n 1
}
await_done() { until [ "$(api "/v1/flights/$1" | jq -r .state)" = idle ]; do sleep 0.5; done; }

# processor_s PATTERN: of all processes whose command line matches, with their children that ended.
processor_s() {
  local pid
  for pid in $(pgrep -f "$1"); do awk '{ print $14 + $15 + $16 + $17 }' "/proc/$pid/stat" 2>/dev/null || true; done |
    awk '{ sum += $1 } END { print sum / 100 }'
}
processors() { # as JSON: of API servers, of workers, of the database
  jq -nc --argjson api "$(processor_s "config $place/fleet/servers/api-")" \
    --argjson worker "$(processor_s "config $place/fleet/servers/worker-")" \
    --argjson database "$(cat "/proc/$(head -n 1 "$place/fleet/database/postmaster.pid")"/task/*/children 2>/dev/null |
      tr ' ' '\n' | while read -r pid; do awk '{ print $14 + $15 }' "/proc/$pid/stat" 2>/dev/null || true; done |
      awk '{ sum += $1 } END { print sum / 100 }')" '{api: $api, worker: $worker, database: $database}'
}
difference() { jq -nc --argjson a "$1" --argjson b "$2" '$b | with_entries(.value -= $a[.key])'; }

sizes() {
  ask -c "SELECT json_build_object('database_bytes', pg_database_size(current_database()), 'tables', (SELECT
    json_object_agg(relname, json_build_array(n_live_tup, pg_total_relation_size(relid))) FROM pg_stat_user_tables
    WHERE pg_total_relation_size(relid) > 1000000))"
}

fill() {
  up --workers 2
  await_done "$(submit)"
  local head begin=$SECONDS
  head="$(ask -c "SELECT head_json FROM maps WHERE is_in_force LIMIT 1")"
  python3 "$root/tests/bench/fleet_sites.py" "$num_sites" "$head" | ask >>"$place/log"
  ask -c "SELECT latitude_deg || ' ' || longitude_deg FROM sites WHERE flight_id LIKE 'many%' ORDER BY id LIMIT 100000" |
    awk 'NR % 90 == 5' >"$place/places"
  jq -nc --argjson sites "$(ask -c 'SELECT count(*) FROM sites')" --argjson s $((SECONDS - begin)) --argjson sizes "$(sizes)" \
    '{step: "fill", sites: $sites, seconds: $s, sizes: $sizes}'
}

# Two workers have a flight to evaluate all along.
live() {
  local before pid
  up --workers 2
  node "$root/tests/bench/fleet_load.mjs" --api "http://127.0.0.1:$((internal + 1)),http://127.0.0.1:$((internal + 2))" \
    --recall "http://127.0.0.1:$((internal + 3)),http://127.0.0.1:$((internal + 4))" --token "$place/fleet/secrets/token" \
    --places "$place/places" --aircraft "$num_aircraft" --seconds "$seconds" >"$place/live.json" 2>"$place/live.err" &
  pid=$!
  until grep -q measuring "$place/live.err"; do kill -0 "$pid" || fail "$(cat "$place/live.err")"; sleep 0.2; done
  before="$(processors)"
  { submit && submit; } >/dev/null &
  wait "$pid"
  jq -c --argjson spent "$(difference "$before" "$(processors)")" --argjson sizes "$(sizes)" --arg load "$(cut -d' ' -f1-3 /proc/loadavg)" \
    '. + {step: "live", processor_s: $spent, load_average: $load, database_bytes: $sizes.database_bytes,
      telemetry_table: $sizes.tables.telemetry}' "$place/live.json"
}

# One server on SQLite, with as many sites.
sqlite() {
  local data="$place/sqlite" port=$((internal + 25)) pid url
  url="http://127.0.0.1:$port"
  rm -rf "$data"
  "$build/server/freelsd-server" --data "$data" --listen "127.0.0.1:$port" >"$place/sqlite.log" 2>&1 &
  pid=$!
  await_server "$url" "$pid" "$place/sqlite.log"
  "$root/deploy/freelsdctl" submit "$flight" --new --url "$url" >>"$place/log" 2>&1
  stop_server "$pid"
  python3 "$root/tests/bench/fleet_sites_sqlite.py" "$data" "$num_sites" "$place/sqlite.places"
  "$build/server/freelsd-server" --data "$data" --listen "127.0.0.1:$port" --emergency-listen "127.0.0.1:$((port + 1))" \
    --config <(echo '{"num_http_threads": 512}') >"$place/sqlite.log" 2>&1 &
  pid=$!
  # It compares a million sites of both databases first.
  until curl -fs "$url/healthz" >/dev/null; do kill -0 "$pid" || fail "$(tail -n 3 "$place/sqlite.log")"; sleep 1; done
  node "$root/tests/bench/fleet_load.mjs" --api "$url" --recall "http://127.0.0.1:$((port + 1))" --places "$place/sqlite.places" \
    --aircraft "$num_aircraft" --seconds "$seconds" >"$place/sqlite.json" 2>"$place/sqlite.err" || fail "$(cat "$place/sqlite.err")"
  jq -c --argjson bytes "$(du -sb "$data" | cut -f1)" --arg load "$(cut -d' ' -f1-3 /proc/loadavg)" --argjson s "$(
    awk '{ print ($14 + $15) / 100 }' "/proc/$pid/stat")" \
    '. + {step: "sqlite", data_bytes: $bytes, load_average: $load, processor_s_since_start: $s}' "$place/sqlite.json"
  stop_server "$pid"
}

# Flights a minute with 1, 2 and 4 workers, and who spends the processor.
workers() {
  local number before begin flights id
  for number in 1 2 4; do
    up --workers "$number"
    sleep 10
    flights=()
    before="$(processors)"
    begin="$(date +%s%N)"
    for _ in $(seq 4); do flights+=("$(submit)"); done
    for id in "${flights[@]}"; do await_done "$id"; done
      jq -nc --argjson workers "$number" --argjson s "$(($(date +%s%N) - begin))e-9" \
      --argjson spent "$(difference "$before" "$(processors)")" --arg load "$(cut -d' ' -f1-3 /proc/loadavg)" \
      '{step: "workers", workers: $workers, flights: 4, seconds: $s, flights_a_minute: (240 / $s), processor_s: $spent,
        database_ratio: ($spent.database / ($spent.api + $spent.worker + $spent.database)), load_average: $load}'
  done
}

mkdir -p "$place"
if [ -z "$flight" ]; then
  flight="$place/flight"
  [ -e "$flight/poses.csv" ] || "$build/tests/freelsd-render" --out "$flight" --seed 1 --frames 24
fi
for step in $steps; do "$step"; done
