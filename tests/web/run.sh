#!/usr/bin/env bash
# Tests the page of a running server that holds a finished flight: tests/web/run.sh URL [FOLDER [PHOTOGRAPHS]]
# FOLDER receives screenshots. PHOTOGRAPHS: the folder of a sample flight, for the test of a live flight.
set -euo pipefail
usage="usage: tests/web/run.sh URL [FOLDER [PHOTOGRAPHS]]"
export FREELSD_URL="${1:?$usage}"
if [ $# -ge 2 ]; then FREELSD_SCREENSHOTS="$(realpath -m "$2")" && export FREELSD_SCREENSHOTS; fi
if [ $# -ge 3 ]; then FREELSD_PHOTOGRAPHS="$(realpath -e "$3")" && export FREELSD_PHOTOGRAPHS; fi
cd "$(dirname "$0")"
for program in node npm; do
  command -v "$program" >/dev/null || { echo "page test: $program is not installed" >&2; exit 1; }
done
npm ci --ignore-scripts --no-audit --no-fund --loglevel=error
# A page that hangs must not hang the tests.
timeout 900 node --test --test-concurrency=2 --test-reporter=spec modules_test.mjs page_test.mjs plan_test.mjs parts_test.mjs ground_test.mjs why_test.mjs route_test.mjs next_look_test.mjs links_test.mjs emergency_test.mjs service_test.mjs
# Alone: it loads the engine, and its flight would disturb the other tests.
timeout 600 node --test --test-reporter=spec live_test.mjs
