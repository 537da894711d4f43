#!/usr/bin/env bash
# Watches stored strips in later passes, and prints the tables of decision 0036: events, hours without
# events, and the legs of recorded flights against each other.
#
#   tests/evaluation/watch.sh [--seed N] [--worlds N] [--log DIR] [--pictures DIR]
#
# Seeds below 9000 are for tuning; the report's begin at 50000. Half of the worlds have no site and take a
# minute for nothing. A run continues where DIR has logs of it: delete them to begin anew.
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
program="$root/build/release/tests/freelsd-watch"
seed=50000
worlds=16
log=""
pictures=()
while [ $# -gt 0 ]; do
  case "$1" in
    --seed) seed="$2" ;;
    --worlds) worlds="$2" ;;
    --log) log="$2" ;;
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
[ -n "$log" ] || log="$work"
mkdir -p "$log"

# fly NAME OPTIONS...: each world once, so that an interrupted run can continue.
fly() {
  local name="$1" i
  shift
  for ((i = seed; i < seed + worlds; ++i)); do
    [ ! -e "$log/$name-$i.done" ] || continue
    rm -f "$log/$name-$i.csv"
    "$program" fly --seed "$i" --cell 0.1 --texture recorded --conditions recorded "${pictures[@]}" \
      --log "$log/$name-$i.csv" "$@" >/dev/null
    touch "$log/$name-$i.done"
  done
}

fly events --events --passes 36
fly quiet --passes 80
echo "## Worlds from seed $seed"
"$program" report "$log"/events-*.csv "$log"/quiet-*.csv
echo
echo "## Legs of recorded flights (tuning pool)"
flights="$FREELSD_DATA/flights"
"$program" recorded "$flights/garfield_park" "$flights/swindale" "${pictures[@]}"
