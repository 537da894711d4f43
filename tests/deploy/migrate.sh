#!/usr/bin/env bash
# Moves a server's data from SQLite to PostgreSQL and back by freelsdctl migrate: also after kills in the middle, all rows
# come back equal and all servers give the same answers. A running server and a target with other data are refused.
#
#   tests/deploy/migrate.sh BUILD_FOLDER GRASS_MODEL FLIGHT_FOLDER
#
# Runs beside a cluster of its own; status 77 and a line "skipped: why" where there is no PostgreSQL with PostGIS.
# Needs curl, jq, psql and python3.
set -Eeuo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
if [ -z "${FREELSD_TEST_CLUSTER:-}" ]; then exec "$root/tests/storage/postgres_cluster.sh" "$0" "$@"; fi
build="$(realpath "$1")"
server="$build/server/freelsd-server"
model="$(realpath "$2")"
rendered="$(realpath "$3")"
num_photographs=16
work="$(mktemp -d)"
photos="$work/photos"
program="migrate.sh"
source "$root/deploy/steps.sh"
source "$root/tests/deploy/compared_servers.sh"
trap clear_away EXIT
export XDG_STATE_HOME="$work/state"
export PATH="$build/storage:$PATH"
migrate() { "$root/deploy/freelsdctl" migrate "$@" >"$work/migrate.txt" 2>&1; }
to_postgresql=(--from "$work/sqlite" --to "$FREELSD_TEST_DATABASE" --images "$work/images")
to_sqlite=(--from "$FREELSD_TEST_DATABASE" --to "$work/back" --images "$work/images")

refused() { # SENTENCE ARGUMENTS...
  if migrate "${@:2}"; then fail "not refused: $1"; fi
  grep -q -- "$1" "$work/migrate.txt" || fail "refused without \"$1\": $(cat "$work/migrate.txt")"
  echo "refused: $1"
}

# migrate_with_kills ARGUMENTS...: killed ever later, until it ends before the kill.
migrate_with_kills() {
  local number status
  for number in $(seq 40); do
    status=0
    timeout --foreground -s KILL "0.$(printf '%02d' $((number * 2)))" "$root/deploy/freelsdctl" migrate "$@" >"$work/migrate.txt" 2>&1 || status=$?
    sleep 0.1
    if [ "$status" -eq 0 ]; then echo "ended after $((number - 1)) kills" && return; fi
    [ "$status" -eq 137 ] || fail "after $number kills: $(cat "$work/migrate.txt")"
  done
  migrate "$@" || fail "after $number kills: $(cat "$work/migrate.txt")"
  echo "ended after $number kills"
}

# Rows of all tables as text, but for what a start changes.
rows_of() {
  python3 - "$1/freelsd.db" <<'END'
import sqlite3, sys
database = sqlite3.connect(f"file:{sys.argv[1]}?mode=ro", uri=True)
for table in ("flights", "frames", "telemetry", "jobs", "regions", "sites", "maps", "map_tiles", "photo_tiles", "obstacles",
              "site_boxes"):
    key = "1" if table == "site_boxes" else "1, 2, 3, 4"
    for row in database.execute(f"SELECT * FROM {table} ORDER BY {key}"):
        print(table, row)
for row in database.execute("SELECT site_id, is_recallable, is_landable, altitude_m, altitude_datum, score, aircraft_json, "
                            "checksum FROM site_numbers ORDER BY site_id"):
    print(row)
END
}

mkdir "$photos"
for photograph in $(find "$rendered" -name '*.jpg' | sort | head -n "$num_photographs"); do cp "$photograph" "$photos"; done
cp "$rendered/flight.json" "$rendered/poses.csv" "$photos"
start_server sqlite --data "$work/sqlite"
submit sqlite
control sqlite watch "${flight[sqlite]}"
best="$(get sqlite /v1/flights/FLIGHT/sites | jq -r '.features[0].id' | sed "s/FLIGHT/${flight[sqlite]}/")"
place="$(curl -fsS "${url[sqlite]}/v1/sites/$best" | jq -r '"latitude_deg=\(.geometry.coordinates[1])&" +
  "longitude_deg=\(.geometry.coordinates[0])&altitude_m=\(.properties.elevation_m + 200)&altitude_datum=amsl"')"
curl -fsS -X PUT -H 'Content-Type: application/geo+json' --data-binary '{"type": "Feature", "geometry": {"type": "Point",
  "coordinates": [8.5558, 47.4515]}, "properties": {"kind": "mast", "height_m": 20}}' "${url[sqlite]}/v1/obstacles/mast" \
  >"$work/answer" 2>&1 || fail "no obstacle: $(cat "$work/answer")"
telemetry='{"timestamp_us": 1717236000000000, "position": {"latitude_deg": 47.351, "longitude_deg": 8.4558, "altitude_m": 700}}'
curl -fsS --data-binary "$telemetry" -H 'Content-Type: application/x-ndjson' "${url[sqlite]}/v1/flights/${flight[sqlite]}/telemetry" >/dev/null
refused "another freelsd-server uses" "${to_postgresql[@]}"
paths=(/v1/sites /v1/flights/FLIGHT /v1/flights/FLIGHT/frames /v1/flights/FLIGHT/regions /v1/flights/FLIGHT/map/slope.tif
  /v1/obstacles "/v1/emergency?$place&heading_deg=45&aircraft=small" "/v1/reach?$place&aircraft=small")
for path in "${paths[@]}"; do get sqlite "$path"; done >"$work/before"
kill_server sqlite

migrate_with_kills "${to_postgresql[@]}"
cat "$work/migrate.txt"
migrate "${to_postgresql[@]}" || fail "a second move: $(cat "$work/migrate.txt")"
psql -qX "$FREELSD_TEST_DATABASE" -c "UPDATE flights SET name = name || '!'"
refused "a target with other data" "${to_postgresql[@]}"
psql -qX "$FREELSD_TEST_DATABASE" -c "UPDATE flights SET name = rtrim(name, '!')"
start_server postgresql --data "$work/spool" --database "$FREELSD_TEST_DATABASE" --images "$work/images"
flight[postgresql]="${flight[sqlite]}"
for path in "${paths[@]}"; do get postgresql "$path"; done >"$work/between"
cmp "$work/before" "$work/between" || fail "answers differ on PostgreSQL: $(diff "$work/before" "$work/between" | head)"
refused "another freelsd-server uses" "${to_sqlite[@]}"
stop_server "${process[postgresql]}"

migrate_with_kills "${to_sqlite[@]}"
migrate "${to_sqlite[@]}" || fail "a second move back: $(cat "$work/migrate.txt")"
rows_of "$work/sqlite" >"$work/rows.before"
rows_of "$work/back" >"$work/rows.after"
cmp "$work/rows.before" "$work/rows.after" || fail "rows differ: $(diff "$work/rows.before" "$work/rows.after" | cut -c1-2000 | head)"
start_server back --data "$work/back"
flight[back]="${flight[sqlite]}"
for path in "${paths[@]}"; do get back "$path"; done >"$work/after"
cmp "$work/before" "$work/after" || fail "answers differ on SQLite: $(diff "$work/before" "$work/after" | head)"
control back replay "${flight[back]}"
echo "$(wc -l <"$work/rows.after") rows and ${#paths[@]} answers are the same after both moves"
echo "migrate.sh: everything that ran has passed"
