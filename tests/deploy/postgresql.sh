#!/usr/bin/env bash
# A server on PostgreSQL beside one on SQLite: the same flight gives the same sites and the same answers, also after a
# kill while it is evaluated. A database belongs to one server at a time, and may restart under it.
#
#   tests/deploy/postgresql.sh FREELSD_SERVER MODEL FLIGHT_FOLDER
#
# Runs beside a cluster of its own; status 77 and a line "skipped: why" where there is no PostgreSQL with PostGIS.
# Needs curl and jq.
set -Eeuo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
if [ -z "${FREELSD_TEST_CLUSTER:-}" ]; then exec "$root/tests/storage/postgres_cluster.sh" "$0" "$@"; fi
server="$(realpath "$1")"
model="$(realpath "$2")"
photos="$(realpath "$3")"
read -r -a cluster <<<"$FREELSD_TEST_CLUSTER"
work="$(mktemp -d)"
program="postgresql.sh"
source "$root/deploy/steps.sh"
trap clear_away EXIT
export XDG_STATE_HOME="$work/state"

source "$root/tests/deploy/compared_servers.sh"

on_sqlite=(--data "$work/sqlite")
on_postgresql=(--database "$FREELSD_TEST_DATABASE" --images "$work/images")

# The best site's place, at 200 m above it.
test_answers() {
  local best place paths num_sites
  best="$(get sqlite /v1/flights/FLIGHT/sites | jq -r '.features[0].id')"
  place="$(get sqlite "/v1/sites/$best" | jq -r '"latitude_deg=\(.geometry.coordinates[1])&" +
    "longitude_deg=\(.geometry.coordinates[0])&altitude_m=\(.properties.elevation_m + 200)&altitude_datum=amsl"')"
  paths=(
    /v1/sites "/v1/sites?bbox=5,45,11,48&include=superseded" /v1/flights/FLIGHT /v1/flights/FLIGHT/sites
    /v1/flights/FLIGHT/regions /v1/flights/FLIGHT/frames /v1/flights/FLIGHT/map /v1/flights/FLIGHT/map/slope.tif
    "/v1/flights/FLIGHT/sites?f=plan&home_altitude_m=400" "/v1/sites/$best" "/v1/sites/$best/approach"
    "/v1/sites/$best/layers" "/v1/sites/$best/layers/elevation.tif"
    "/v1/emergency?$place&heading_deg=45&aircraft=small" "/v1/reach?$place&aircraft=small")
  same_answers "${paths[@]}"
  num_sites="$(get sqlite /v1/sites | jq '[.features[] | select(.properties.verdict == "landable")] | length')"
  [ "$num_sites" -gt 0 ] || fail "no site is landable"
  echo "${#paths[@]} answers about $num_sites landable sites are the same, byte by byte"
}

# No second server beside the first, and the first goes on.
test_ownership() {
  local status=0
  "$server" --data "$work/second" --listen 127.0.0.1:0 --model "$model" "${on_postgresql[@]}" \
    >"$work/second.log" 2>&1 || status=$?
  [ "$status" = 75 ] || fail "a second server ended with status $status instead of 75"
  grep -q 'another freelsd-server uses it' "$work/second.log" || fail "a second server says: $(cat "$work/second.log")"
  echo "a second server is refused"
}

# Readiness follows the database, without a restart of the server. One that the crash cost the database says so.
test_database_restart() {
  local _ status=""
  "${cluster[@]}" -m immediate stop >/dev/null
  status="$(curl -s -o "$work/answer" -w '%{http_code}' "${url[postgresql]}/readyz")"
  [ "$status" = 503 ] || fail "ready without a database: $status $(cat "$work/answer")"
  "${cluster[@]}" start >/dev/null
  for _ in $(seq 100); do
    status="$(curl -s -o "$work/answer" -w '%{http_code}' "${url[postgresql]}/readyz")"
    if [ "$status" = 200 ]; then break; fi
    sleep 0.1
  done
  [ "$status" = 200 ] || fail "not ready again: $status $(cat "$work/answer")"
  same_answers /v1/sites
  curl -fsS -d '{"name": "after the crash"}' "${url[postgresql]}/v1/flights" >/dev/null
  echo "the database crashed and came back under the server"
}

start_server sqlite "${on_sqlite[@]}"
start_server postgresql --data "$work/first" "${on_postgresql[@]}"
[ "$(curl -fsS "${url[postgresql]}/v1/info" | jq -r .database)" = postgresql ] || fail "it is not on PostgreSQL"
submit sqlite
submit postgresql
control sqlite watch "${flight[sqlite]}"
# Whatever it was doing, another takes it up, with a folder of its own for uploads.
kill_server postgresql
start_server postgresql --data "$work/next" "${on_postgresql[@]}"
control postgresql watch "${flight[postgresql]}"
test_answers
control postgresql replay "${flight[postgresql]}"
grep -q 'sites have the same digest again' "$work/postgresql.txt" || fail "$(tail -n 3 "$work/postgresql.txt")"
test_ownership
test_database_restart
echo "postgresql.sh: everything that ran has passed"
