#!/usr/bin/env bash
# Builds the fuzz targets with clang below libFuzzer, and runs them.
#
#   tests/fuzz/run.sh [SECONDS [TARGET...]]
#
# 60 seconds each by default, all of tests/fuzz/seeds. New inputs are kept in build/fuzz/corpus.
set -Eeuo pipefail
cd "$(dirname "$0")/../.."
command -v clang++ >/dev/null || { echo "run.sh: SKIPPED: clang++ is not installed" >&2; exit 0; }
seconds="${1:-60}"
shift || true
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then targets=($(ls tests/fuzz/seeds)); fi
flags="-fsanitize=address,undefined,fuzzer-no-link -fno-sanitize-recover=undefined"
cmake -S . -B build/fuzz -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DFREELSD_FUZZ=ON \
  -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_CXX_FLAGS="$flags" -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -g1"
cmake --build build/fuzz --target freelsd-libfuzzer -j "${JOBS:-$(nproc)}"
for target in "${targets[@]}"; do
  echo "-- $target"
  mkdir -p "build/fuzz/corpus/$target"
  FREELSD_FUZZ_TARGET="$target" build/fuzz/tests/freelsd-libfuzzer -max_total_time="$seconds" \
    -timeout=5 -rss_limit_mb=1024 -max_len=200000 -print_final_stats=0 -verbosity=0 \
    "build/fuzz/corpus/$target" "tests/fuzz/seeds/$target"
done
