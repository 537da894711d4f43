#!/usr/bin/env bash
# Sends every recorded flight of $FREELSD_DATA through a fresh server, by curl alone, from geotags
# or the flight's pose file, and prints what came out as a part of RESULTS.md.
#
#   tests/evaluation/flights.sh [--server PATH] [--pictures DIR] [--flight NAME] [--aircraft NAME]
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
server="$root/build/release/server/freelsd-server"
pictures=""
flights="swindale garfield_park brighton_beach seneca_nir"
profiles="techpod small"
while [ $# -gt 0 ]; do
  case "$1" in
    --server) server="$2" ;;
    --pictures) pictures="$2" ;;
    --flight) flights="$2" ;;
    --aircraft) profiles="$2" ;;
    *) echo "flights.sh: unknown argument $1" >&2; exit 2 ;;
  esac
  shift 2
done
if [ -z "${FREELSD_DATA:-}" ]; then
  echo "skipped: FREELSD_DATA is not set, so there are no recorded flights" >&2
  exit 0
fi
for program in curl jq; do
  command -v "$program" >/dev/null || { echo "flights.sh: $program is not installed" >&2; exit 1; }
done
[ -x "$server" ] || { echo "flights.sh: no program at $server" >&2; exit 1; }

work="$(mktemp -d)"
server_pid=""
stop_server() {
  if [ -n "$server_pid" ]; then kill "$server_pid" 2>/dev/null && wait "$server_pid" 2>/dev/null; fi
  server_pid=""
}
trap 'stop_server || true; rm -rf "$work"' EXIT
port=18750

start_server() {
  port=$((port + 1))
  url="http://127.0.0.1:$port"
  "$server" --data "$work/data-$port" --listen "127.0.0.1:$port" >"$work/server.log" 2>&1 &
  server_pid=$!
  for _ in $(seq 100); do
    curl -fs "$url/healthz" >/dev/null 2>&1 && return
    sleep 0.1
  done
  echo "flights.sh: the server did not start:" >&2
  cat "$work/server.log" >&2
  exit 1
}

# Waits for a job and fails when it does.
await_job() {
  local state
  while true; do
    state="$(curl -fsS "$url/v1/jobs/$1" | jq -r .state)"
    case "$state" in
      done) return ;;
      failed | cancelled) curl -fsS "$url/v1/jobs/$1" >&2; exit 1 ;;
    esac
    sleep 0.5
  done
}

# Images named by suffix; swindale has its poses in a file, the others in the images.
upload() {
  local folder="$FREELSD_DATA/flights/$1" arguments=() image
  for image in "$folder"/images/*; do arguments+=(-F "images=@$image"); done
  if [ "$1" = swindale ]; then arguments+=(-F "poses=@$folder/poses.csv"); fi
  curl -fsS "${arguments[@]}" "$url/v1/flights/$2/batch" | jq -r .id
}

save_pictures() {
  [ -n "$pictures" ] || return 0
  mkdir -p "$pictures/$1"
  curl -fsS "$url/v1/flights/$2/regions" >"$pictures/$1/regions.geojson"
  curl -fsS "$url/v1/flights/$2/sites" >"$pictures/$1/sites.geojson"
  curl -fsS "$url/v1/flights/$2" >"$pictures/$1/flight.json"
  local site layer
  for site in $(jq -r '.features[].properties.id' "$pictures/$1/sites.geojson"); do
    curl -fsS "$url/v1/sites/$site" >"$pictures/$1/$site.json"
    for layer in $(curl -fsS "$url/v1/sites/$site/layers" | jq -r '.layers[].name'); do
      curl -fsS "$url/v1/sites/$site/layers/$layer.png" >"$pictures/$1/$site-$layer.png"
    done
  done
}

run_flight() {
  local name="$1" profile="$2" flight job begin end sites stages memory
  start_server
  flight="$(curl -fsS -H 'Content-Type: application/json' \
    -d "{\"name\": \"$name\", \"aircraft\": {\"profile\": \"$profile\"}}" "$url/v1/flights" | jq -r .id)"
  begin="$(date +%s.%N)"
  job="$(upload "$name" "$flight")"
  await_job "$job"
  job="$(curl -fsS -X POST "$url/v1/flights/$flight/finish" | jq -r .id)"
  await_job "$job"
  end="$(date +%s.%N)"
  curl -fsS "$url/v1/flights/$flight" >"$work/flight.json"
  sites="$(curl -fsS "$url/v1/flights/$flight/sites" | jq -r '
    [.features[].properties] as $p
    | def count(v): [$p[] | select(.verdict == v)] | length;
      "\(count("landable")) / \(count("unverified")) / \(count("rejected"))"
      + " | " + ([$p[] | .reject_reason | select(. != null)] | group_by(.)
                 | map("\(.[0]) \(length)") | join(", "))')"
  # Without any site the flight itself says why.
  sites="$sites$(jq -r '[.warnings[] | select(startswith("no sites: "))] | join(", ")' "$work/flight.json")"
  memory="$(awk '/VmHWM/ {printf "%d", $2 / 1024}' "/proc/$server_pid/status")"
  printf '| %s | %s | %s | %s | %.0f | %s MiB |\n' "$name" "$profile" \
    "$(jq -r '"\(.frames.processed) of \(.frames.received) | \(.num_regions)"' "$work/flight.json")" \
    "$sites" "$(awk "BEGIN {print $end - $begin}")" "$memory"
  stages="$(jq -r '.stages | to_entries | map("\(.key) \(.value.mean_ms * 10 | round / 10) (\(.value.count))") | join(", ")' "$work/flight.json")"
  echo "$name, $profile: $stages" >>"$work/stages"
  jq -r '.warnings[]' "$work/flight.json" | sed "s/^/$name: /" >>"$work/warnings"
  save_pictures "$name-$profile" "$flight"
  stop_server || true
}

cat <<'TEXT'
Each flight is sent by `curl` as one batch (swindale with its pose file, the others by their geotags
alone) to a fresh server, then finished. Sites are landable / unverified / rejected.

| flight | aircraft | frames | regions | sites | reasons of rejection | seconds | peak memory |
|---|---|---|---|---|---|---|---|
TEXT
for name in $flights; do
  for profile in $profiles; do run_flight "$name" "$profile"; done
done
printf '\n### Mean milliseconds per call of each stage (number of calls)\n\n%s cores.\n\n' "$(nproc)"
sed 's/^/- /' "$work/stages"
printf '\n### Warnings\n\n'
sort "$work/warnings" | uniq -c | sed -E 's/^ *([0-9]+) (.*)$/- \2 (in \1 runs)/'
