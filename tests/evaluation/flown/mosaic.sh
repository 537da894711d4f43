#!/usr/bin/env bash
# Surveys a square of --side x --side seeded worlds of 500 m, each by a flight of its own, for
# tests/autopilot/trial/trial.sh and tests/evaluation/fly.sh.
#
#   tests/evaluation/flown/mosaic.sh [--build DIR] [--folder DIR] [--side N] [--seed N] [--aircraft PROFILE|both]
#
# A server gets the flights once, in the data folder --seed below --folder (default
# build/insurance); that takes half a minute a world.
set -euo pipefail
root="$(cd "$(dirname "$0")/../../.." && pwd)"
build="$root/build/release"
folder="$root/build/insurance"
side=6
seed=57000
aircraft=small
while [ $# -gt 0 ]; do
  case "$1" in
    --build) build="$2" ;;
    --folder) folder="$2" ;;
    --side) side="$2" ;;
    --seed) seed="$2" ;;
    --aircraft) aircraft="$2" ;;
    *) echo "mosaic.sh: unknown argument $1" >&2; exit 2 ;;
  esac
  shift 2
done
for program in server/freelsd-server tests/freelsd-judge-tracks; do
  [ -x "$build/$program" ] || { echo "mosaic.sh: no program at $build/$program" >&2; exit 1; }
done
mkdir -p "$folder"
server_pid=""
stop_server() {
  if [ -n "$server_pid" ]; then kill "$server_pid" 2>/dev/null && wait "$server_pid" 2>/dev/null; fi
  server_pid=""
}
trap 'stop_server || true' EXIT

start_server() { # DATA LOG: sets url
  "$build/server/freelsd-server" --data "$1" --listen 127.0.0.1:0 >"$2" 2>&1 &
  server_pid=$!
  url=""
  for _ in $(seq 300); do
    url="$(grep -o 'listens on http://127.0.0.1:[0-9]*' "$2" | head -1 | sed 's/^listens on //' || true)"
    [ -n "$url" ] && return
    sleep 0.1
  done
  echo "mosaic.sh: the server did not start:" >&2
  cat "$2" >&2
  exit 1
}

data="$folder/$seed"
[ ! -e "$data/complete" ] || exit 0
rm -rf "$data"
mkdir -p "$data"
start_server "$data" "$folder/$seed.log"
"$build/tests/freelsd-judge-tracks" --side "$side" --seed "$seed" --aircraft "$aircraft" --survey "$url"
stop_server || true
touch "$data/complete"
