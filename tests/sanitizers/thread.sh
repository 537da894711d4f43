#!/usr/bin/env bash
# The server's tests under the thread sanitizer: no data race may be reported.
#
#   tests/sanitizers/thread.sh [-tc=PATTERN]
#
# A quarter of an hour. On one processor OpenCV starts no threads of its own: their locks are in a
# library that was not built for the sanitizer, and all they do would be reported. Ours run as ever.
set -Eeuo pipefail
cd "$(dirname "$0")/../.."
cmake --preset tsan
cmake --build --preset tsan -j "${JOBS:-$(nproc)}" --target server_tests
TSAN_OPTIONS="suppressions=$PWD/tests/sanitizers/thread.supp halt_on_error=1" \
  taskset -c 0 build/tsan/tests/server_tests --no-intro "$@"
echo "thread.sh: no data race in the server's tests"
