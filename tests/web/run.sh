#!/usr/bin/env bash
# Tests the page of a running server that holds a finished flight: tests/web/run.sh URL [PICTURE.png]
set -euo pipefail
cd "$(dirname "$0")"
export FREELSD_URL="${1:?usage: tests/web/run.sh URL [PICTURE.png]}"
if [ $# -ge 2 ]; then export FREELSD_PICTURE="$2"; fi
for program in node npm; do
  command -v "$program" >/dev/null || { echo "page test: $program is not installed" >&2; exit 1; }
done
npm ci --ignore-scripts --no-audit --no-fund --loglevel=error
exec node --test --test-reporter=spec page_test.mjs
