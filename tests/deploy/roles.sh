#!/usr/bin/env bash
# Servers with roles on one PostgreSQL database, beside one on SQLite: a worker is killed and another one is paused while
# they work; others take their flights within 15 s, the paused one writes nothing more and ends, and all flights get the
# sites that they get on SQLite.
#
#   tests/deploy/roles.sh FREELSD_SERVER MODEL FLIGHT_FOLDER
#
# A flight that three workers in a row did not survive fails, with that reason.
#
# Runs beside a cluster of its own; status 77 and a line "skipped: why" where there is no PostgreSQL with PostGIS.
# Needs curl, jq and psql.
set -Eeuo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
if [ -z "${FREELSD_TEST_CLUSTER:-}" ]; then exec "$root/tests/storage/postgres_cluster.sh" "$0" "$@"; fi
server="$(realpath "$1")"
model="$(realpath "$2")"
photos="$(realpath "$3")"
work="$(mktemp -d)"
program="roles.sh"
source "$root/deploy/steps.sh"
trap clear_away EXIT
export XDG_STATE_HOME="$work/state"
source "$root/tests/deploy/compared_servers.sh"

start_role() { # NAME ROLE
  start_server "$1" --role "$2" --data "$work/$1" --database "$FREELSD_TEST_DATABASE" --images "$work/images"
}

# ask_database SQL
ask_database() { psql -qAtX "$FREELSD_TEST_DATABASE" -c "$1"; }

# Milliseconds since 1970.
now_ms() { date +%s%3N; }

# await_claim FLIGHT TOKEN-THAT-IT-MUST-NOT-BE: the token of the worker that has it.
await_claim() {
  local _ token
  for _ in $(seq 300); do
    token="$(ask_database "SELECT token FROM claims WHERE flight_id = '$1' AND token <> $2")"
    if [ -n "$token" ]; then
      echo "$token"
      return
    fi
    sleep 0.1
  done
  fail "no worker has taken $1 within 30 s"
}

# taken_over FLIGHT TOKEN WHAT-HAPPENED: from that worker by another worker within 15 s.
taken_over() {
  local since token
  since="$(now_ms)"
  token="$(await_claim "$1" "$2")"
  local took_ms=$(($(now_ms) - since))
  echo "$3: another worker has the flight after $took_ms ms"
  if [ "$took_ms" -gt 15000 ]; then fail "a flight waited longer than 15 s"; fi
}

submit_new() {
  control api submit "$photos" --no-wait --new
  flight[api]="$(curl -fsS "${url[api]}/v1/flights" | jq -r '.flights[0].id')"
}

# The sites of the flight are those of SQLite, byte by byte.
same_sites() {
  flight[api]="$1"
  get sqlite /v1/flights/FLIGHT/sites >"$work/sqlite.answer"
  get api /v1/flights/FLIGHT/sites >"$work/api.answer"
  cmp "$work/sqlite.answer" "$work/api.answer" || {
    diff "$work/sqlite.answer" "$work/api.answer" | head -n 20 >&2
    fail "the sites of $1 are not those of SQLite"
  }
}

start_server sqlite --data "$work/sqlite"
submit sqlite
control sqlite watch "${flight[sqlite]}"

start_role api api
submit_new
killed="${flight[api]}"
sleep 3
[ "$(ask_database 'SELECT count(*) FROM claims')" = 0 ] || fail "the API's server works"
mkdir "$work/few"
cp "$photos"/frame_000[1-3].jpg "$photos/flight.json" "$photos/poses.csv" "$work/few"
control api submit "$work/few" --no-wait
deadly="$(curl -fsS "${url[api]}/v1/flights" | jq -r '.flights[0].id')"
ask_database "INSERT INTO claims (flight_id, num_lost) VALUES ('$deadly', 3)"
start_role one worker
token="$(await_claim "$killed" 0)"
sleep 4
kill_server one
start_role two worker
taken_over "$killed" "$token" "killed"
control api watch "$killed"
grep -Eq 'Comparing pairs|Judging the ground|Planning approaches|Drawing the picture' "$work/api.txt" ||
  fail "nothing was told of what the worker does: $(cat "$work/api.txt")"
same_sites "$killed"

submit_new
paused="${flight[api]}"
token="$(await_claim "$paused" 0)"
sleep 4
kill -STOP "${process[two]}"
start_role three worker
taken_over "$paused" "$token" "paused"
kill -CONT "${process[two]}"
status=0
wait "${process[two]}" || status=$?
[ "$status" = 75 ] || fail "the worker that was paused ended with status $status instead of 75"
control api watch "$paused"
same_sites "$paused"
get api /v1/sites >/dev/null
[ "$(curl -fsS "${url[api]}/v1/flights" |
  jq --arg deadly "$deadly" '[.flights[] | select(.id != $deadly and .state != "idle")] | length')" = 0 ] ||
  fail "a flight is not done"
control api watch "$deadly"
curl -fsS "${url[api]}/v1/flights/$deadly" | jq -e '.state == "failed" and (.warnings | tostring |
  contains("3 workers in a row ended while they had it"))' >/dev/null || fail "the deadly flight goes on"
echo "a flight that ended three workers has failed"
echo "roles.sh: everything that ran has passed"
