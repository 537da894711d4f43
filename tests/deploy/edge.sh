#!/usr/bin/env bash
# Two edges follow a centre. Their links are cut for a simulated hour in which all three change: new sites, superseded
# and confirmed ones, deleted ones, obstacles that come, go and expire. An edge is killed and started again. Then the
# links come back, stalling and resetting. Afterwards all three tell the same, byte by byte but for ages; meanwhile the
# edges answered from their copies and said how old they are.
#
#   tests/deploy/edge.sh FREELSD_SERVER MODEL FREELSD_FLY_OVER [--long] [--postgresql] [--tls]
#
# --long: a flight each minute of the hour on each server instead of one in five. --postgresql: the centre is a server on
# PostgreSQL, beside a cluster of its own; status 77 where there is none. --tls: the edges follow over https.
# Needs curl, jq, openssl, python3 and, for --tls, socat.
set -Eeuo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
num_minutes=12
num_recalls=300
centre_on=sqlite
scheme=http
for argument in "${@:4}"; do
  case "$argument" in
    --long) num_minutes=60 num_recalls=5000 ;;
    --postgresql) centre_on=postgresql ;;
    --tls) scheme=https ;;
  esac
done
if [ "$centre_on" = postgresql ] && [ -z "${FREELSD_TEST_CLUSTER:-}" ]; then
  exec "$root/tests/storage/postgres_cluster.sh" "$0" "$@"
fi
server="$(realpath "$1")"
model="$(realpath "$2")"
fly_over="$(realpath "$3")"
work="$(mktemp -d)"
program="edge.sh"
source "$root/deploy/steps.sh"
end() {
  local status=$?
  if [ "$status" -ne 0 ]; then tail -n 5 "$work"/*.log >&2 || true; fi
  clear_away
}
trap end EXIT
source "$root/tests/deploy/compared_servers.sh"

token="$(openssl rand -hex 32)"
umask 077
echo "$token" >"$work/token"
printf '[{"sha256": "%s", "scopes": ["read", "ingest", "admin"]}]' \
  "$(printf %s "$token" | sha256sum | cut -d' ' -f1)" >"$work/tokens.json"
echo "Authorization: Bearer $token" >"$work/header"
area=7,46,9,48

# ask NAME PATH
ask() { curl -fsS --globoff -H "@$work/header" "${url[$1]}$2"; }

set_links() { for edge in one other; do echo "$1" >"$work/$edge.mode"; done; }

# In front of the centre; the edges trust its certificate alone.
start_tls() {
  openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=127.0.0.1 -addext subjectAltName=IP:127.0.0.1 \
    -keyout "$work/key.pem" -out "$work/certificate.pem" 2>/dev/null
  cat "$work/key.pem" "$work/certificate.pem" >"$work/both.pem"
  link_target="$(free_port 18443)"
  socat "OPENSSL-LISTEN:$link_target,bind=127.0.0.1,reuseaddr,fork,cert=$work/both.pem,verify=0" \
    "TCP:127.0.0.1:${url[centre]##*:}" 2>/dev/null &
  pids+=($!)
  export SSL_CERT_FILE="$work/certificate.pem"
}

start_link() { # EDGE
  "$root/tests/deploy/link_proxy.py" "$work/$1.port" "$work/$1.mode" "$link_target" &
  pids+=($!)
  local _
  for _ in $(seq 100); do
    if [ -e "$work/$1.port" ]; then return; fi
    sleep 0.05
  done
  fail "the link of $1 did not start"
}

start_edge() {
  start_server "$1" --data "$work/$1" --token-file "$work/tokens.json" \
    --follow "$scheme://127.0.0.1:$(cat "$work/$1.port")" --area "$area" --follow-token-file "$work/token"
}

fly() { # NAME FIRST_MINUTE NUM_MINUTES SEED
  "$fly_over" --to "${url[$1]}" --name "$1-flight" --token-file "$work/token" --first-minute "$2" --minutes "$3" \
    --seed "$4"
}

# Everything that a server tells a new follower; without numbers, and without what is said of a server itself.
state_of() { # NAME
  local since=0 page="$work/page.json"
  : >"$work/$1.changes"
  while :; do
    ask "$1" "/v1/changes?since=$since&limit=1000" >"$page"
    jq -c '.changes[] | select(.change != "removed" and .change != "expired") | del(.number, .change)' "$page" \
      >>"$work/$1.changes"
    [ "$(jq .has_more "$page")" = true ] || break
    since="$(jq -r .next "$page")"
  done
  # Obstacles that have expired count nowhere, and are removed at the next write.
  jq -c --argjson now_us "$(date +%s)000000" \
    'select((.obstacle.expires_at_us // infinite) > $now_us)' "$work/$1.changes" | sort >"$work/$1.state"
}

are_equal() {
  local name
  for name in centre one other; do state_of "$name"; done
  cmp -s "$work/centre.state" "$work/one.state" && cmp -s "$work/centre.state" "$work/other.state"
}

await_equal() { # SECONDS
  local begin=$SECONDS
  until are_equal; do
    if [ $((SECONDS - begin)) -gt "$1" ]; then
      diff "$work/centre.state" "$work/one.state" | cut -c 1-300 | head -n 4 >&2 || true
      diff "$work/centre.state" "$work/other.state" | cut -c 1-300 | head -n 4 >&2 || true
      fail "the servers are not equal after $1 s"
    fi
    sleep 0.5
  done
  echo "all three are equal after $((SECONDS - begin)) s: $(wc -l <"$work/centre.state") sites, maps and obstacles"
}

recall_path() { # LONGITUDE
  echo "/v1/emergency?latitude_deg=46.99&longitude_deg=$1&altitude_m=1100&altitude_datum=amsl&wind_east_mps=0&wind_north_mps=-4&heading_deg=0&limit=10"
}

# An answer of recall without ages, and without what the copy says of itself.
recalled() { # NAME LONGITUDE
  local _
  # An answer is cut short when planning takes too long; what was planned is kept.
  for _ in $(seq 20); do
    ask "$1" "$(recall_path "$2")" >"$work/answer.json"
    grep -q 'not every stored site' "$work/answer.json" || break
  done
  jq -S 'del(.copy) | .warnings |= map(select(startswith("answered from a copy") | not))
    | walk(if type == "object" then del(.age_s, .score) else . end)' "$work/answer.json"
}

same_recalls() {
  local name longitude num_sites=0
  for longitude in 8.00 8.06 8.12 8.18 8.22; do
    for name in centre one other; do recalled "$name" "$longitude" >"$work/$name.recall"; done
    num_sites=$((num_sites + $(jq '.sites | length' "$work/centre.recall")))
    for name in one other; do
      cmp "$work/centre.recall" "$work/$name.recall" || {
        diff "$work/centre.recall" "$work/$name.recall" | head -n 20 >&2
        fail "recall of $name differs"
      }
    done
  done
  [ "$num_sites" -gt 0 ] || fail "nothing was recalled"
  echo "recall says the same everywhere, with $num_sites sites"
}

same_maps() {
  local id name
  for id in $(jq -r 'select(.subject == "map") | .id' "$work/centre.state"); do
    for name in centre one other; do ask "$name" "/v1/maps/$id" | sha256sum; done | sort -u | wc -l | grep -qx 1 ||
      fail "the map $id differs"
  done
  echo "all $(grep -c '"subject":"map"' "$work/centre.state") maps are the same bytes"
}

copy_age_s() { ask "$1" /healthz | jq '.copy.age_s // -1 | floor'; }

begin "an hour before the links are cut"
if [ "$centre_on" = postgresql ]; then
  start_server centre --data "$work/centre" --database "$FREELSD_TEST_DATABASE" --images "$work/images" \
    --token-file "$work/tokens.json"
else
  start_server centre --data "$work/centre" --token-file "$work/tokens.json"
fi
link_target="${url[centre]##*:}"
if [ "$scheme" = https ]; then start_tls; fi
set_links pass
for edge in one other; do
  start_link "$edge"
  start_edge "$edge"
done
fly centre 0 6 1
await_equal 60

begin "the links are cut, and all three change"
set_links cut
cut_at=$SECONDS
flying=()
seed=10
for name in centre one other; do
  fly "$name" 60 "$num_minutes" "$seed" >"$work/$name.flown" 2>&1 &
  flying+=($!)
  seed=$((seed + 1))
done
sleep 1
kill_server one
start_edge one
recalled one 8.00 >/dev/null
echo "an edge was killed among its flights; after its start it answers from its copy, $(copy_age_s one) s old"
# The flights of the killed edge ended with it; the same ones begin again, and what was acknowledged is the same.
wait "${flying[1]}" || true
fly one 60 "$num_minutes" 11 >"$work/one.flown" 2>&1 || fail "$(cat "$work/one.flown")"
for pid in "${flying[0]}" "${flying[2]}"; do wait "$pid" || fail "a flight failed: $(cat "$work"/*.flown)"; done
cat "$work"/*.flown
for edge in one other; do
  age_s="$(copy_age_s "$edge")"
  [ "$age_s" -ge $((SECONDS - cut_at - 8)) ] || fail "the copy of $edge says that it is only $age_s s old"
  ask "$edge" "$(recall_path 8.06)" | jq -e '.copy.age_s and (.warnings | any(startswith("answered from a copy")))' \
    >/dev/null || fail "$edge does not say how old its copy is"
done
are_equal && fail "nothing has changed while the links were cut"
"$fly_over" --to "${url[one]}" --name "recall at an edge without its link" --token-file "$work/token" \
  --recalls "$num_recalls"

begin "the links stall and reset"
set_links flaky
sleep 8
kill_server other
start_edge other
set_links pass
await_equal 120
same_maps
same_recalls
for name in centre one other; do
  grep -q "\"origin\":\"$name-flight\"" "$work/other.state" || fail "nothing of $name has arrived"
done
[ "$(grep -c '"superseded_by"' "$work/centre.state")" -gt 0 ] || fail "no site was superseded"
[ "$(grep -c '"confirmed_at_us"' "$work/centre.state")" -gt 0 ] || fail "no site was confirmed"
echo "$(grep -c '"superseded_by"' "$work/centre.state") sites are superseded, $(grep -c '"confirmed_at_us"' \
  "$work/centre.state") confirmed, $(grep -c '"subject":"obstacle"' "$work/centre.state") obstacles are known"
echo "edge.sh: everything that ran has passed, $SECONDS s"
