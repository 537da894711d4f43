#!/usr/bin/env bash
# Tests the page of a running server that holds a finished flight: tests/web/run.sh URL [FOLDER]
# FOLDER: where screenshots of the page are put.
set -euo pipefail
export FREELSD_URL="${1:?usage: tests/web/run.sh URL [FOLDER]}"
if [ $# -ge 2 ]; then export FREELSD_SCREENSHOTS="$(realpath -m "$2")"; fi
cd "$(dirname "$0")"
for program in node npm; do
  command -v "$program" >/dev/null || { echo "page test: $program is not installed" >&2; exit 1; }
done
npm ci --ignore-scripts --no-audit --no-fund --loglevel=error
# A page that hangs must not hang the tests.
exec timeout 300 node --test --test-concurrency=2 --test-reporter=spec modules_test.mjs page_test.mjs service_test.mjs
