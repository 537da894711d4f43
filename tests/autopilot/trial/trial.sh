#!/usr/bin/env bash
# Flies the trial of guidance after an engine failure and prints its figures.
#
#   tests/autopilot/trial/trial.sh [--build DIR] [--folder DIR] [--side N] [--seed N] [--flights N]
#                                  [--first N] [--altimeter survey|true] [--processes N] [--keep DIR]
#
# The world is a mosaic of --side x --side seeded worlds, each surveyed by a flight of its own
# (tests/evaluation/flown/mosaic.sh makes it once, in --folder, half a minute a world). Flights have
# the seeds from --first on. --altimeter survey: the altimeter of the aircraft has the error of the
# survey below it, as in one flight; true: it has none. Each process has a server of its own. --keep
# keeps tracks and verdicts in a folder, for draw_track.js.
set -Eeuo pipefail
root="$(cd "$(dirname "$0")/../../.." && pwd)"
build="$root/build/release"
folder="$root/build/insurance"
side=6
seed=57000
flights=300
first=1001
altimeter=survey
processes=2
keep=""
while [ $# -gt 0 ]; do
  case "$1" in
    --build) build="$2" ;;
    --folder) folder="$2" ;;
    --side) side="$2" ;;
    --seed) seed="$2" ;;
    --flights) flights="$2" ;;
    --first) first="$2" ;;
    --altimeter) altimeter="$2" ;;
    --processes) processes="$2" ;;
    --keep) keep="$2" ;;
    *) echo "trial.sh: unknown argument $1" >&2; exit 2 ;;
  esac
  shift 2
done
for program in server/freelsd-server tests/freelsd-judge-tracks; do
  [ -x "$build/$program" ] || { echo "trial.sh: no program at $build/$program" >&2; exit 1; }
done
[ -d "$root/server/mavlink/node_modules" ] || npm ci --prefix "$root/server/mavlink" --no-audit --no-fund
[ -e "$folder/$seed/complete" ] ||
  "$root/tests/evaluation/flown/mosaic.sh" --build "$build" --folder "$folder" --side "$side" --seed "$seed"
judge() { "$build/tests/freelsd-judge-tracks" --side "$side" --seed "$seed" "$@"; }
[ -e "$folder/$seed-surface.f32" ] || judge --heights "$folder/$seed-surface"

work="$(mktemp -d)"
pids=()
stop() { for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done; rm -rf "$work"; }
trap stop EXIT
runs=()
tracks=()
each=$(((flights + processes - 1) / processes))
for ((i = 0; i < processes; ++i)); do
  cp -r "$folder/$seed" "$work/data-$i"
  "$build/server/freelsd-server" --data "$work/data-$i" --listen 127.0.0.1:0 >"$work/server-$i" 2>&1 &
  pids+=($!)
  url=""
  for _ in $(seq 300); do
    url="$(grep -o 'listens on http://127.0.0.1:[0-9]*' "$work/server-$i" | head -1 | sed 's/^listens on //' || true)"
    [ -z "$url" ] || break
    sleep 0.1
  done
  [ -n "$url" ] || { echo "trial.sh: the server did not start" >&2; exit 1; }
  node "$root/tests/autopilot/trial/trial.js" --url "$url" --ground "$folder/$seed-surface" \
    --out "$work/tracks-$i.json" --flights "$each" --seed $((first + 1000 * i)) --altimeter "$altimeter" &
  pids+=($!)
  runs+=($!)
  tracks+=(--tracks "$work/tracks-$i.json")
done
wait "${runs[@]}"
jq -s '{tracks: map(.tracks) | add}' "$work"/tracks-*.json >"$work/all.json"
judge --tracks "$work/all.json" >"$work/verdicts.json"
[ -z "$keep" ] || { mkdir -p "$keep" && cp "$work/all.json" "$work/verdicts.json" "$keep/"; }
node "$root/tests/autopilot/trial/trial_report.js" --tracks "$work/all.json" --verdicts "$work/verdicts.json" \
  --subject "guidance, altimeter $altimeter"
