#!/usr/bin/env bash
# Runs the tests of the link and writes their figures to tests/autopilot/RESULTS.md.
#
#   FREELSD_DATA=DIR tests/autopilot/results.sh
#
# FREELSD_SERVER names the service if it is not at build/release/server/freelsd-server. FREELSD_SITES_URL
# names a running service with stored sites, for the missions to all of them. With 10 hours of flying
# and 200 uploads it takes about 10 minutes on two idle processors.
set -Eeuo pipefail
cd "$(dirname "$0")/../.."

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
[ -d server/mavlink/node_modules ] || npm ci --prefix server/mavlink --no-audit --no-fund
export FREELSD_HOURS="${FREELSD_HOURS:-10}" FREELSD_UPLOADS="${FREELSD_UPLOADS:-200}"
FREELSD_REPORT="$work/figures" node --test tests/autopilot/*_test.js
{
  echo "# Figures of the link to the autopilot"
  echo
  echo "Made by \`FREELSD_DATA=DIR tests/autopilot/results.sh\`. The recordings are of ArduPlane 4.7-dev in simulation, wind 6 m/s from 70 degrees."
  echo
  echo "Guidance after an engine failure: [trial/RESULTS.md](trial/RESULTS.md)."
  echo
  echo "| subject | figure | value |"
  echo "|---|---|---|"
  jq -r '"| \(.subject) | \(.figure) | \(.value) |"' "$work/figures"
} >"$work/RESULTS.md"
mv "$work/RESULTS.md" tests/autopilot/RESULTS.md
