#!/usr/bin/env bash
# Causes faults in a real server and reports the results as a Markdown table.
#
#   tests/faults/run.sh [--short | --long] [--rows NAME,...] [--sizes NAME=N,...] [--minutes N]
#                       [--build DIR] [--out FILE]
#
#   --short    less than a minute, the default
#   --long     the sizes of RESULTS.md: an hour; all rows go to tests/faults/RESULTS.md without --out
#   --rows     only these rows of faults.py, by name
#   --sizes    number of repetitions, for example kill=50
#   --minutes  duration of the soak
#   --build    a build with freelsd-server and freelsd-render, default build/release
#
# Needs python3 and g++ (for the clock). A row that cannot run here is SKIPPED. Status 0 means that no
# row failed.
set -Eeuo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
root="$(cd "$here/../.." && pwd)"
build="$root/build/release"
arguments=()
out=""
is_long=no
has_all_rows=yes
while [ $# -gt 0 ]; do
  case "$1" in
    --short) shift ;;
    --long) is_long=yes; arguments+=(--long); shift ;;
    --build) build="$(realpath "${2:?--build needs a folder}")"; shift 2 ;;
    --out) out="${2:?--out needs a file}"; shift 2 ;;
    --rows) has_all_rows=no; arguments+=("$1" "${2:?$1 needs a value}"); shift 2 ;;
    --sizes | --minutes) arguments+=("$1" "${2:?$1 needs a value}"); shift 2 ;;
    -h | --help) sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0"; exit 0 ;;
    *) echo "run.sh: unknown argument $1" >&2; exit 1 ;;
  esac
done
if [ "$is_long" = yes ] && [ "$has_all_rows" = yes ] && [ -z "$out" ]; then out="$here/RESULTS.md"; fi
if [ -n "$out" ]; then arguments+=(--out "$out"); fi

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
if command -v g++ >/dev/null; then
  g++ -shared -fPIC -O2 -o "$work/shifted_clock.so" "$here/shifted_clock.cc" -ldl
  arguments+=(--clock "$work/shifted_clock.so")
fi
PYTHONDONTWRITEBYTECODE=1 python3 "$here/faults.py" --build "$build" "${arguments[@]}" &
trap 'kill "$!" 2>/dev/null || true; rm -rf "$work"' EXIT
wait "$!"
