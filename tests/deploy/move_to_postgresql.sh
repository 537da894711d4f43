#!/usr/bin/env bash
# A server on SQLite that has sites, their map and an obstacle follows an empty one on PostgreSQL: this takes what it has
# there. Afterwards the one on PostgreSQL, alone, has the same sites, map and obstacle and recalls the same.
#
#   tests/deploy/move_to_postgresql.sh FREELSD_SERVER MODEL FLIGHT_FOLDER
#
# Runs beside a cluster of its own; status 77 and a line "skipped: why" where there is no PostgreSQL with PostGIS.
# Needs curl and jq.
set -Eeuo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
if [ -z "${FREELSD_TEST_CLUSTER:-}" ]; then exec "$root/tests/storage/postgres_cluster.sh" "$0" "$@"; fi
server="$(realpath "$1")"
model="$(realpath "$2")"
photos="$(realpath "$3")"
work="$(mktemp -d)"
program="move_to_postgresql.sh"
source "$root/deploy/steps.sh"
trap clear_away EXIT
export XDG_STATE_HOME="$work/state"
source "$root/tests/deploy/compared_servers.sh"

# ask NAME PATH: the answer of JSON, without what depends on when it was asked, and what the copy says of itself.
ask() { get "$1" "$2" | jq -S 'del(.copy) | if .warnings then
  .warnings |= map(select(startswith("answered from a copy") | not)) else . end'; }

sites_of() { curl -fsS "${url[$1]}/v1/sites?include=superseded" | jq -c '[.features[].properties.id] | sort'; }

is_moved() {
  local unsent
  unsent="$(curl -fsS "${url[sqlite]}/healthz" | jq '.copy | if has("age_s") then .num_unsent else "none" end')"
  [ "$unsent" = 0 ] && [ "$(sites_of postgresql)" = "$(sites_of sqlite)" ]
}

await_moved() {
  local begin=$SECONDS
  until is_moved; do
    if [ $((SECONDS - begin)) -gt 60 ]; then
      fail "not moved after 60 s: $(curl -fsS "${url[sqlite]}/healthz") $(sites_of postgresql)"
    fi
    sleep 0.5
  done
  echo "moved after $((SECONDS - begin)) s"
}

start_server sqlite --data "$work/sqlite"
submit sqlite
control sqlite watch "${flight[sqlite]}"
flight[postgresql]="${flight[sqlite]}"
best="$(get sqlite /v1/flights/FLIGHT/sites | jq -r '.features[0].id')"
place="$(get sqlite "/v1/sites/$best" | jq -r '"latitude_deg=\(.geometry.coordinates[1])&" +
  "longitude_deg=\(.geometry.coordinates[0])&altitude_m=\(.properties.elevation_m + 200)&altitude_datum=amsl"')"
curl -fsS -X PUT -H 'Content-Type: application/geo+json' --data-binary '{"type": "Feature", "geometry": {"type": "Point",
  "coordinates": [8.5558, 47.4515]}, "properties": {"kind": "mast", "height_m": 20}}' "${url[sqlite]}/v1/obstacles/mast" \
  >"$work/answer" 2>&1 || fail "no obstacle: $(cat "$work/answer")"
stop_server "${process[sqlite]}"

start_server postgresql --data "$work/spool" --database "$FREELSD_TEST_DATABASE" --images "$work/images"
start_server sqlite --data "$work/sqlite" --follow "${url[postgresql]}" --area=-180,-90,180,90
await_moved
paths=("/v1/sites?include=superseded" "/v1/sites/$best" "/v1/sites/$best/approach" "/v1/sites/$best/layers" /v1/obstacles
  "/v1/emergency?$place&heading_deg=45&aircraft=small")
for path in "${paths[@]}"; do ask sqlite "$path"; done >"$work/before"
map_id="$(curl -fsS "${url[sqlite]}/v1/changes" | jq -r '[.changes[] | select(.subject == "map") | .id][0]')"
curl -fsS "${url[sqlite]}/v1/maps/$map_id" >"$work/map.before"
stop_server "${process[sqlite]}"
for path in "${paths[@]}"; do ask postgresql "$path"; done >"$work/after"
curl -fsS "${url[postgresql]}/v1/maps/$map_id" >"$work/map.after"
cmp "$work/before" "$work/after" || fail "answers differ: $(diff "$work/before" "$work/after" | cut -c 1-300 | head -n 20)"
cmp "$work/map.before" "$work/map.after" || fail "the bytes of map $map_id differ"
num_landable="$(curl -fsS "${url[postgresql]}/v1/sites" |
  jq '[.features[] | select(.properties.verdict == "landable")] | length')"
[ "$num_landable" -gt 0 ] || fail "no site is landable"
echo "${#paths[@]} answers about $(sites_of postgresql | jq length) sites, $num_landable of them landable, are the same"
echo "move_to_postgresql.sh: everything that ran has passed"
