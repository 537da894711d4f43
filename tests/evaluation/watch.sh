#!/usr/bin/env bash
# Watches stored strips in later passes, and prints the tables of decision 0036: events, hours without
# events, and the legs of recorded flights against each other.
#
#   tests/evaluation/watch.sh [--seed N] [--worlds N] [--events N] [--quiet N] [--folder DIR] [--pictures DIR]
#
# Seeds below 9000 are for tuning; the report's begin at 52000. Each world with a strip is photographed in
# so many later passes with an event, and in so many without, one photograph a second. Photographs remain
# in DIR: a run continues where an interrupted one ended, and a changed method watches the same ones again.
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
program="$root/build/release/tests/freelsd-watch"
seed=52000
worlds=24
events=24
quiet=64
folder=""
pictures=()
while [ $# -gt 0 ]; do
  case "$1" in
    --seed) seed="$2" ;;
    --worlds) worlds="$2" ;;
    --events) events="$2" ;;
    --quiet) quiet="$2" ;;
    --folder) folder="$2" ;;
    --pictures) pictures=(--pictures "$2") ;;
    *) echo "watch.sh: unknown argument $1" >&2; exit 2 ;;
  esac
  shift 2
done
[ -x "$program" ] || { echo "watch.sh: no program at $program" >&2; exit 1; }
if [ -z "${FREELSD_DATA:-}" ]; then
  echo "skipped: FREELSD_DATA is not set, so there are no recorded textures and flights" >&2
  exit 0
fi
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
[ -n "$folder" ] || folder="$work"
"$program" photograph --seed "$seed" --worlds "$worlds" --events "$events" --quiet "$quiet" \
  --cell 0.1 --texture recorded --conditions recorded "$folder"
echo "## Worlds from seed $seed"
"$program" watch "$folder" "${pictures[@]}"
echo
echo "## Legs of recorded flights (tuning pool)"
flights="$FREELSD_DATA/flights"
"$program" recorded "$flights/garfield_park" "$flights/swindale" "${pictures[@]}"
