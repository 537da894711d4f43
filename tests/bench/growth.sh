#!/usr/bin/env bash
# What a long flight costs, as Markdown: processor seconds a photograph and peak of memory of the server, for a few and
# for many photographs of one rendered survey of 2 km by 2 km.
#   tests/bench/growth.sh [FEW MANY]        default 400 2000; 2000 take a quarter of an hour on two cores
set -euo pipefail
counts=("${1:-400}" "${2:-2000}")
cd "$(dirname "$0")/../.."
source deploy/steps.sh
work="$(mktemp -d)"
server=""
trap '[ -z "$server" ] || kill "$server"; rm -rf "$work"' EXIT
build/release/tests/freelsd-render --out "$work/all" --seed 1060 --frames "${counts[1]}" --size 2000 --pattern survey \
  >"$work/render.log"
port="$(free_port 18200)"

processor_s() { awk '{ print ($14 + $15) / 100 }' "/proc/$server/stat"; }

# measure COUNT
measure() {
  local folder="$work/$1" begin
  mkdir -p "$folder/images"
  find "$work/all" -name 'frame_*.jpg' | sort | sed -n "1,$1p" | xargs ln -st "$folder/images"
  head -n "$(($1 + 1))" "$work/all/poses.csv" >"$folder/poses.csv"
  cp "$work/all/flight.json" "$folder/"
  build/release/server/freelsd-server --data "$folder/data" --listen "127.0.0.1:$port" >"$work/server.log" 2>&1 &
  server=$!
  until curl -sf "http://127.0.0.1:$port/readyz" >/dev/null; do sleep 0.1; done
  begin=$(date +%s)
  deploy/freelsdctl --url "http://127.0.0.1:$port" submit "$folder" >"$work/$1.log" 2>&1
  echo "| $1 | $(($(date +%s) - begin)) | $(awk -v all="$(processor_s)" -v count="$1" \
    'BEGIN { printf "%.3f", all / count }') | $(awk '/VmHWM/ { printf "%.0f", $2 / 1024 }' "/proc/$server/status") |" \
    "$(curl -sf "http://127.0.0.1:$port/v1/sites?limit=1000" | jq '.features | length') |"
  kill "$server"
  wait "$server" || true
  server=""
}

echo "| photographs | seconds | processor seconds a photograph | peak of memory, MiB | sites, rejected ones included |"
echo "|---|---|---|---|---|"
for count in "${counts[@]}"; do measure "$count"; done
