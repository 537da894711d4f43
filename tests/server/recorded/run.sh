#!/usr/bin/env bash
# Asks a server the requests of requests/ and compares its answers with those in answers/, to the last digit.
#
#   tests/server/recorded/run.sh BUILD [--write] [--parts NAME,...] [--answers DIR] [--whole DIR] [--photographs DIR]
#
#   BUILD          a build with freelsd-server and freelsd-render, for example build/release
#   --write        writes the answers anew instead
#   --parts        only these of demo, real, damaged and lost
#   --answers      where the recorded answers are, instead of answers/ beside this file
#   --whole        a folder for all answers in full length, to be compared by other programs
#   --photographs  the demo's flight if it is rendered already, as deploy/demo.sh leaves it
#
# Needs python3 and g++ (for the clock). Flights of the part `real` are in FREELSD_DATA. Status 0: every answer that
# was asked for is equal. 77: some differ, but another kind of processor recorded them, so this says nothing.
set -Eeuo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
case "${1:-}" in
  "" | -*) sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0"; exit 1 ;;
esac
build="$(realpath "$1")"
shift

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
g++ -shared -fPIC -O2 -o "$work/clock.so" "$here/../../faults/shifted_clock.cc" -ldl
PYTHONDONTWRITEBYTECODE=1 python3 "$here/recorded.py" --build "$build" --clock "$work/clock.so" --work "$work" "$@" &
trap 'kill "$!" 2>/dev/null || true; wait; rm -rf "$work"' EXIT
wait "$!"
