#!/usr/bin/env bash
# Flies the paths that emergency recall tells over seeded worlds, and prints what the aircraft met.
#
#   tests/evaluation/fly.sh [--build DIR] [--folder DIR] [--worlds N] [--seed N] [--recalls N]
#
# A server gets the flight over each world once, in a data folder of its own below --folder
# (default build/fly); that takes half a minute a world. Later runs use these folders again.
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
build="$root/build/release"
folder="$root/build/fly"
worlds=16
seed=3000
recalls=1000
while [ $# -gt 0 ]; do
  case "$1" in
    --build) build="$2" ;;
    --folder) folder="$2" ;;
    --worlds) worlds="$2" ;;
    --seed) seed="$2" ;;
    --recalls) recalls="$2" ;;
    *) echo "fly.sh: unknown argument $1" >&2; exit 2 ;;
  esac
  shift 2
done
for program in server/freelsd-server tests/freelsd-eval tests/freelsd-fly; do
  [ -x "$build/$program" ] || { echo "fly.sh: no program at $build/$program" >&2; exit 1; }
done
mkdir -p "$folder"
server_pid=""
stop_server() {
  if [ -n "$server_pid" ]; then kill "$server_pid" 2>/dev/null && wait "$server_pid" 2>/dev/null; fi
  server_pid=""
}
trap 'stop_server || true' EXIT

# store_world SEED: the data folder appears under its name when it is complete.
store_world() {
  local part="$folder/$1.part" log="$folder/$1.log" url=""
  rm -rf "$part"
  "$build/server/freelsd-server" --data "$part" --listen 127.0.0.1:0 >"$log" 2>&1 &
  server_pid=$!
  for _ in $(seq 300); do
    url="$(grep -o 'listens on http://127.0.0.1:[0-9]*' "$log" | head -1 | sed 's/^listens on //' || true)"
    [ -n "$url" ] && break
    sleep 0.1
  done
  [ -n "$url" ] || { echo "fly.sh: the server did not start:" >&2; cat "$log" >&2; exit 1; }
  "$build/tests/freelsd-eval" --worlds 1 --seed "$1" --url "$url" >"$folder/$1.txt"
  stop_server || true
  mv "$part" "$folder/$1"
}

for ((i = 0; i < worlds; ++i)); do
  [ -d "$folder/$((seed + i))" ] || store_world $((seed + i))
done
"$build/tests/freelsd-fly" --folder "$folder" --worlds "$worlds" --seed "$seed" --recalls "$recalls"
