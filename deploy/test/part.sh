#!/usr/bin/env bash
# One part of deploy/test.sh --long, after cmake --build --preset release.
#
#   deploy/test/part.sh PART
#
# What cannot be tested here is said as "skipped: why", with status 77 if that is all of it. FREELSD_CLEAN_ROOT=1 also
# installs the package in a clean Debian, which fetches some hundred MB.
set -Eeuo pipefail
cd "$(dirname "$0")/../.."
program="part.sh"
source deploy/steps.sh
source deploy/test/report.sh
source deploy/test/register.sh

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
readonly server=build/release/server/freelsd-server
readonly model=engine/ground_kind/ground_kind.onnx
readonly flight=build/test/sample-flight-1-72

# or_skip COMMAND...: then the whole part is skipped.
or_skip() {
  local status=0
  "$@" || status=$?
  if [ "$status" -eq 77 ]; then exit 77; fi
  return "$status"
}

# The flight of the demo.
render_flight() {
  if [ "$flight/complete" -nt build/release/tests/freelsd-render ]; then return; fi
  rm -rf "$flight"
  build/release/tests/freelsd-render --out "$flight" --seed 1 --frames 72
  touch "$flight/complete"
}

part_arm64() {
  render_flight
  deploy/arm64.sh
  deploy/package.sh
  build arm64 freelsd-stages
  tests/deploy/arm64.sh "$flight"
}

part_autopilot() { test_link "$work/link.log" tests/autopilot/*_test.js; }

part_container() { or_skip tests/deploy/container.sh; }

part_documents() {
  render_flight
  tests/deploy/documents.sh build/release "$flight"
}

part_edges() {
  local fly_over=build/release/tests/freelsd-fly-over
  tests/deploy/edge.sh "$server" "$model" "$fly_over"
  may_skip tests/deploy/edge.sh "$server" "$model" "$fly_over" --postgresql --tls
}

part_evaluation() {
  tests/evaluation/world.sh --short
}

part_faults() { tests/faults/run.sh --short; }

part_fleet-faults() {
  render_flight
  or_skip tests/faults/fleet.sh --flight "$flight" --rows commit,pause,api
}

part_freelsdctl() {
  render_flight
  tests/deploy/freelsdctl.sh "$server" "$model" "$flight"
}

part_fuzz() {
  build/release/tests/freelsd-fuzz tests/fuzz/seeds --seconds 2
  tests/fuzz/run.sh 30
}

part_lint() { deploy/lint.sh --all; }

part_manuals() {
  local page
  for page in deploy/*.[18]; do groff -man -Tutf8 -ww "$page" 2>&1 >/dev/null | tee -a "$work/groff.log"; done
  if [ -s "$work/groff.log" ]; then fail "groff warns of the man pages"; fi
}

part_move() {
  render_flight
  or_skip tests/deploy/move_to_postgresql.sh "$server" "$model" "$flight"
}

part_nginx() { tests/deploy/nginx.sh "$server" "$model"; }

# All programs, linked by link-time optimization: it sees when two sources of one program define a name differently.
part_odr() { build_without_warnings odr; }

part_package() {
  deploy/package.sh
  tests/deploy/package.sh build/release/freelsd_*.deb ${FREELSD_CLEAN_ROOT:+--clean-root}
}

part_postgresql() {
  render_flight
  or_skip tests/deploy/postgresql.sh "$server" "$model" "$flight"
}

# The unit tests of storage and server again, on PostgreSQL.
part_postgresql-tests() {
  ctest --preset release -R postgresql --no-tests=error -j "$(nproc)" 2>&1 | tee "$work/ctest.log"
  grep -oE '[a-z_]+ \.+\*{3}Skipped' "$work/ctest.log" | sed -E 's/^([a-z_]+).*/skipped: \1/' || true
  if ! grep -q ' Passed ' "$work/ctest.log"; then exit 77; fi
}

part_roles() {
  render_flight
  or_skip tests/deploy/roles.sh "$server" "$model" "$flight"
}

part_sanitizers() {
  local suites=(engine_tests storage_tests api_tests synthetic_tests evaluation_tests)
  export ASAN_OPTIONS="detect_stack_use_after_return=1:strict_string_checks=1"
  export UBSAN_OPTIONS="print_stacktrace=1"
  build_without_warnings asan "${suites[@]}"
  run_unit_tests asan "${suites[@]}"
}

part_threads() { tests/sanitizers/thread.sh; }

part_units() {
  if ! command -v systemd-analyze >/dev/null; then
    echo "skipped: no systemd-analyze at hand"
    exit 77
  fi
  local unit
  for unit in freelsd.service freelsd-mavlink@.service; do
    sed -E 's|/usr/bin/freelsd-[a-z]+|/bin/true|' "deploy/$unit" >"$work/$unit"
  done
  systemd-analyze verify "$work/freelsd.service" "$work/freelsd-mavlink@wing.service"
  # Tenths: an exposure of 2.0 at most.
  for unit in freelsd.service freelsd-mavlink@.service; do
    systemd-analyze security --offline=true --threshold=20 "$work/$unit" | tail -n 1
  done
}

part="${1:?the name of the part is missing}"
is_part "$part" || fail "no part $part; parts: $(part_names | tr '\n' ' ')"
step="testing $part"
"part_$part"
