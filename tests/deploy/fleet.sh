#!/usr/bin/env bash
# A fleet as deploy/README.md sets it up: two flights are sent, a worker and an API server are killed, both finish. Then
# a backup, more work, and back to a point in time: sites, flights and images are those of that time.
#
#   tests/deploy/fleet.sh FREELSD_SERVER FLIGHT_FOLDER
#
# compose.fleet.yaml is checked, but not run. Status 77 and a line "skipped: why" where there is no PostgreSQL with PostGIS or no nginx. Needs curl, jq and
# python3.
set -Eeuo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
for needed in /usr/lib/postgresql/15/bin/initdb /usr/share/postgresql/15/extension/postgis.control /usr/sbin/nginx; do
  if [ ! -e "$needed" ]; then
    echo "skipped: there is no $needed"
    exit 77
  fi
done
server="$(realpath "$1")"
photos="$(realpath "$2")"
num_photographs=16
work="$(mktemp -d)"
chmod 755 "$work"
program="tests/deploy/fleet.sh"
source "$root/deploy/steps.sh"

fleet() { "$root/deploy/fleet.sh" "$@" --root "$work/fleet" >"$work/fleet.txt" 2>&1; }
end() {
  fleet stop || true
  rm -rf "$work"
}
trap end EXIT

control() { "$root/deploy/freelsdctl" --url "$url" --token "$work/fleet/secrets/token" "$@" >"$work/control.txt" 2>&1 ||
  fail "freelsdctl $*: $(tail -n 5 "$work/control.txt")"; }
ask() { curl -fsS -m 20 -H @- "$url$1" <<<"Authorization: Bearer $(cat "$work/fleet/secrets/token")"; }
new_flight() { # FOLDER: sends it; prints its id.
  control submit "$1" --no-wait --new
  tail -n 1 "$work/control.txt"
}
kill_process() { kill -KILL "$(cat "$work/fleet/run/$1.pid")"; }
sites() { ask /v1/sites | jq -S '[.features[] | .properties |= del(.age_s)]'; }
digest_of_images() { (cd "$work/fleet/images" && find . -type f | sort | xargs sha256sum | sha256sum); }

python3 "$root/tests/deploy/compose_fleet.py" "$server"
fleet up --port "$(free_port 19443)" --internal-port "$(free_port 19100)" --server "$server" ||
  fail "the fleet does not start: $(tail -n 20 "$work/fleet.txt")"
url="https://localhost:$(sed -n 's/^port=//p' "$work/fleet/settings")"
export CURL_CA_BUNDLE="$work/fleet/secrets/tls/certificate.pem"
export XDG_STATE_HOME="$work/state"
echo "the fleet is up after $SECONDS s"
find "$work/fleet/secrets" -type f ! -name certificate.pem -perm /077 | grep . && fail "others can read these secrets"
for word in "$work"/fleet/secrets/*.word "$work/fleet/secrets/token"; do
  if grep -qaFf "$word" /proc/[0-9]*/cmdline /proc/[0-9]*/environ 2>/dev/null; then fail "ps shows $word"; fi
done
echo "no secret is on a command line or in an environment"

mkdir "$work/photos"
for photograph in $(find "$photos" -name '*.jpg' | sort | head -n "$num_photographs"); do cp "$photograph" "$work/photos"; done
cp "$photos/flight.json" "$photos/poses.csv" "$work/photos"
first="$(new_flight "$work/photos")"
second="$(new_flight "$work/photos")"
sleep 1
kill_process worker-1
kill_process api-1
control watch "$first"
control watch "$second"
for flight in "$first" "$second"; do
  ask "/v1/flights/$flight" | jq -e ".state == \"idle\" and .frames.processed == $num_photographs" >/dev/null ||
    fail "$flight: $(ask "/v1/flights/$flight")"
done
fleet status || fail "not all runs again: $(cat "$work/fleet.txt")"
echo "both flights are finished after $SECONDS s, although a worker and an API server were killed"

# The killed worker counts until its lease is over.
for _ in $(seq 20); do
  ask /metrics >"$work/metrics"
  if grep -q '^freelsd_workers 3' "$work/metrics"; then break; fi
  sleep 1
done
for gauge in 'workers 3' 'waiting_flights 0' 'oldest_queued_frame_seconds 0' 'database_connections_in_use{pool="readers"} [0-9]'; do
  grep -q "^freelsd_$gauge" "$work/metrics" || fail "no line freelsd_$gauge in the metrics"
done

fleet backup || fail "no backup: $(cat "$work/fleet.txt")"
backup="$(tail -n 1 "$work/fleet.txt")"
third="$(new_flight "$work/photos")"
control watch "$third"
sites >"$work/sites.then"
[ "$(jq length "$work/sites.then")" -gt 0 ] || fail "no sites were found"
sleep 1
then="$(date -u +'%Y-%m-%d %H:%M:%S.%3N+00')"
sleep 1
control submit "$work/photos" --new --no-wait --name "after that time"
for flight in "$first" "$second"; do
  curl -fsS -X DELETE -H @- "$url/v1/flights/$flight" <<<"Authorization: Bearer $(cat "$work/fleet/secrets/token")" >/dev/null
done
fleet restore "$backup" --to "$then" || fail "not restored: $(cat "$work/fleet.txt")"
grep ' 0 missing' "$work/fleet.txt" || fail "$(cat "$work/fleet.txt")"
fleet up || fail "not up again: $(cat "$work/fleet.txt")"
sites >"$work/sites.now"
cmp "$work/sites.then" "$work/sites.now" || fail "the sites are not those of that time"
[ "$(ask /v1/flights | jq -c '[.flights[].id] | sort')" = "$(printf '%s\n' "$first" "$second" "$third" | jq -Rsc 'split("\n")[:3] | sort')" ] ||
  fail "the flights are not those of that time: $(ask /v1/flights)"
control replay "$third"
echo "restored to $then: the same $(jq length "$work/sites.now") sites, and the photographs give them again"
echo "fleet.sh: everything that ran has passed, $SECONDS s"
