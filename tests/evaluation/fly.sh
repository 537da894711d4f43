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
for ((i = 0; i < worlds; ++i)); do
  "$root/tests/evaluation/flown/mosaic.sh" --build "$build" --folder "$folder" --side 1 --seed $((seed + i)) \
    --aircraft both
done
"$build/tests/freelsd-fly" --folder "$folder" --worlds "$worlds" --seed "$seed" --recalls "$recalls"
