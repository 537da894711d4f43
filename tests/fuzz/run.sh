#!/usr/bin/env bash
# Runs the fuzz targets below libFuzzer with both sanitizers, one on each core.
#
#   tests/fuzz/run.sh [SECONDS [TARGET...]]
#
# 60 seconds each by default, all of tests/fuzz/seeds. New inputs and what each run said are kept in build/asan/fuzz.
set -Eeuo pipefail
cd "$(dirname "$0")/../.."
seconds="${1:-60}"
shift || true
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then mapfile -t targets < <(ls tests/fuzz/seeds); fi

cmake --preset asan >/dev/null
cmake --build --preset asan --target freelsd-libfuzzer -j "${JOBS:-$(nproc)}"

fuzz() {
  local target="$1" kept="build/asan/fuzz"
  mkdir -p "$kept/$target"
  if FREELSD_FUZZ_TARGET="$target" build/asan/tests/freelsd-libfuzzer -max_total_time="$seconds" \
    -timeout=5 -rss_limit_mb=1024 -max_len=200000 -verbosity=0 -print_final_stats=1 \
    -artifact_prefix="$kept/$target-" "$kept/$target" "tests/fuzz/seeds/$target" \
    >"$kept/$target.log" 2>&1; then
    echo "$target: $(sed -n 's/^stat::number_of_executed_units: *//p' "$kept/$target.log") inputs, 0 findings"
  else
    tail -n 60 "$kept/$target.log"
    echo "$target: FOUND, see $kept/$target-*"
    return 1
  fi
}
export -f fuzz
export seconds
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I{} bash -c 'fuzz {}'
