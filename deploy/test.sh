#!/usr/bin/env bash
# Installs what the tests need, builds and runs them all, from a bare Debian 12.
#
#   deploy/test.sh
#
# Tests on recorded flights need FREELSD_DATA, the folder that holds them. FREELSD_CLEAN_ROOT=1 also installs
# the package in a clean Debian, which fetches some hundred MB. Ends with a summary;
# what was skipped is said there too. Status 0 means that everything that ran has passed.
set -Eeuo pipefail
cd "$(dirname "$0")/.."
program="test.sh"
source deploy/steps.sh

work="$(mktemp -d)"
server_pid=""
summary=()
started=0

end() {
  local status=$?
  if [ -n "$server_pid" ]; then stop_server "$server_pid" || true; fi
  rm -rf "$work"
  echo
  echo "== summary"
  local line
  for line in "${summary[@]}"; do echo "$line"; done
  if [ "$status" -eq 0 ]; then
    echo "test.sh: everything that ran has passed, $SECONDS s"
  else
    echo "test.sh: FAILED while $step, after $SECONDS s"
  fi
}
trap end EXIT

start_step() {
  started=$SECONDS
  begin "$1"
}
passed() { summary+=("$(printf 'passed   %5d s  %s' $((SECONDS - started)) "$step")"); }
skipped() {
  summary+=("$(printf 'SKIPPED           %s: %s' "$step" "$1")")
  echo "SKIPPED: $1"
}

# Nothing that was compiled may have warned.
refuse_warnings() {
  local num_warnings
  num_warnings="$(grep -c 'warning:' "$1" || true)"
  if [ "$num_warnings" -ne 0 ]; then
    grep 'warning:' "$1" | sort | uniq -c >&2
    fail "the compiler gave $num_warnings warnings"
  fi
  echo "no compiler warnings"
}

# run_unit_tests PRESET ARGUMENTS...
run_unit_tests() {
  local arguments=(-j "$(nproc)" --no-tests=error --preset "$@")
  ctest "${arguments[@]}" 2>&1 | tee "$work/ctest.log" |
    grep -vE '^ +Start +[0-9]+:|^ *[0-9]+/[0-9]+ Test .* Passed ' || true
  # The grep above must not hide how it ended.
  grep -q '^100% tests passed' "$work/ctest.log" || fail "unit tests failed"
}

# CTest passes too if it has not found the tests of the programs.
check_that_all_were_found() {
  local num_found num_there=0 program
  num_found="$(sed -nE 's/^100% tests passed.* out of ([0-9]+)$/\1/p' "$work/ctest.log")"
  for program in build/release/tests/*_tests; do
    num_there=$((num_there + $("$program" --count | grep -oE '[0-9]+$')))
  done
  if [ "$num_found" -lt "$num_there" ]; then fail "only $num_found of $num_there unit tests were found"; fi
}

# Where there is no PostgreSQL, the tests on it are skipped.
report_skipped_tests() {
  local name
  while read -r name; do skipped "$name"; done < <(grep -oE '[a-z_]+ \.+\*{3}Skipped' "$work/ctest.log" | awk '{ print $1 }')
}

# The demo's result must be served again by a new process, set up as the example says.
restart_on_demo_data() {
  build/release/server/freelsd-server --config deploy/config.example.json \
    --data "$work/demo/server" --listen "127.0.0.1:$port" >"$work/server.log" 2>&1 &
  server_pid=$!
  await_server "http://127.0.0.1:$port" "$server_pid" "$work/server.log"
  local num_sites
  num_sites="$(curl -fsS "http://127.0.0.1:$port/v1/sites" |
    jq '[.features[] | select(.properties.verdict != "rejected")] | length')"
  echo "$num_sites sites that are not rejected are served after a restart"
  if [ "$num_sites" -eq 0 ]; then fail "the demo found no site that is landable or unverified"; fi
}

# passed_but LOG: passed, and what of it was skipped is in the summary too.
passed_but() {
  if grep -q 'everything that ran has passed' "$1"; then passed; fi
  local line
  while read -r line; do skipped "${line#skipped: }"; done < <(grep '^skipped: ' "$1" || true)
}

start_step "installing packages"
install_packages test package
passed

start_step "lint"
if git rev-parse --verify --quiet HEAD >/dev/null; then
  deploy/lint.sh 2>&1 | tee "$work/lint.log"
  passed_but "$work/lint.log"
else
  skipped "no history of git at hand, so what changed is unknown"
fi

start_step "building (release)"
build release 2>&1 | tee "$work/build.log"
refuse_warnings "$work/build.log"
passed

start_step "unit tests (release)"
run_unit_tests release
check_that_all_were_found
passed
report_skipped_tests
if [ -z "${FREELSD_DATA:-}" ]; then skipped "tests on recorded flights: FREELSD_DATA is not set"; fi

# Worlds of the tuning seeds with 15 fields to find; 8 are found where this was written, and another
# processor's rounding may cost one.
start_step "seeded worlds: no site that is false safe"
build/release/tests/freelsd-eval --worlds 6 --seed 1046 --jobs "$(nproc)" \
  --max-false-safe 0 --min-found-ratio 0.5 | sed -n '1,/^sites, by what/p'
passed

start_step "right about the world, short form"
if [ -n "${FREELSD_DATA:-}" ]; then
  tests/evaluation/world.sh --short
  passed
else
  skipped "FREELSD_DATA is not set"
fi

start_step "building (sanitizers)"
# Folders in which something has changed, or in what they include or how they are built. Without a history: all.
sanitized=()
for folder in engine storage api; do
  watched=("$folder" "tests/$folder" CMakeLists.txt CMakePresets.json)
  if [ "$folder" = api ]; then watched+=(engine); fi
  if ! git rev-parse --verify --quiet HEAD >/dev/null || ! git diff --quiet "$(first_revision)" -- "${watched[@]}"; then
    sanitized+=("$folder")
  else
    skipped "unit tests (sanitizers) of $folder/: unchanged since $(git log -1 --format='%h, %cs' "$(first_revision)")"
  fi
done
build asan freelsd-libfuzzer "${sanitized[@]/%/_tests}" 2>&1 | tee "$work/build.log"
refuse_warnings "$work/build.log"
passed

start_step "unit tests (sanitizers)"
export ASAN_OPTIONS="detect_stack_use_after_return=1:strict_string_checks=1"
export UBSAN_OPTIONS="print_stacktrace=1"
if [ ${#sanitized[@]} -ne 0 ]; then run_unit_tests asan -L "^($(IFS='|' && echo "${sanitized[*]}"))$"; fi
passed

start_step "parsers on changed seeds"
build/release/tests/freelsd-fuzz tests/fuzz/seeds --seconds 2
passed

# Four of the targets, others every hour: all of them have had their turn after four runs.
start_step "parsers below libFuzzer"
tests/fuzz/run.sh --rotate 4 30
passed

port="$(free_port 18080)"
start_step "the demo, end to end"
deploy/demo.sh --once --port "$port" --data "$work/demo"
passed

start_step "recorded answers"
{ tests/server/recorded/run.sh build/release --photographs "$work/demo/sample-flight-1-72" || [ $? -eq 77 ]; } 2>&1 |
  tee "$work/recorded.log"
if ! grep -q '^SKIPPED: .* differ' "$work/recorded.log"; then passed; fi
while read -r line; do skipped "${line#SKIPPED: }"; done < <(grep '^SKIPPED: ' "$work/recorded.log" || true)

start_step "restart on the demo's data"
restart_on_demo_data
passed

start_step "page test in a browser"
tests/web/run.sh "http://127.0.0.1:$port" build/screenshots "$work/demo/sample-flight-1-72"
passed
stop_server "$server_pid"
server_pid=""

start_step "faults, short form"
tests/faults/run.sh --short
passed

# Tests that have a long form run their short one.
start_step "link to an autopilot, short form"
npm ci --ignore-scripts --omit=optional --no-audit --no-fund --loglevel=error --prefix server/mavlink
FREELSD_SHORT=1 FREELSD_SERVER="$PWD/build/release/server/freelsd-server" \
  timeout 600 node --test tests/autopilot/*_test.js >"$work/autopilot.log" 2>&1 || {
  cat "$work/autopilot.log" >&2
  fail "tests of the link failed"
}
grep -E '^# (pass|fail|skipped) ' "$work/autopilot.log"
passed
while read -r line; do skipped "$line"; done < <(sed -nE 's/^ok [0-9]+ - (.*) # SKIP ?(.*)$/\1: \2/p' "$work/autopilot.log")

start_step "freelsdctl"
tests/deploy/freelsdctl.sh build/release/server/freelsd-server engine/classification/grass_model.yml \
  "$work/demo/sample-flight-1-72"
passed

start_step "commands of the documents"
tests/deploy/documents.sh build/release "$work/demo/sample-flight-1-72"
passed

start_step "server on PostgreSQL"
{ tests/deploy/postgresql.sh build/release/server/freelsd-server engine/classification/grass_model.yml \
  "$work/demo/sample-flight-1-72" || [ $? -eq 77 ]; } 2>&1 | tee "$work/postgresql.log"
passed_but "$work/postgresql.log"

start_step "roles on PostgreSQL"
{ tests/deploy/roles.sh build/release/server/freelsd-server engine/classification/grass_model.yml \
  "$work/demo/sample-flight-1-72" || [ $? -eq 77 ]; } 2>&1 | tee "$work/roles.log"
passed_but "$work/roles.log"

start_step "a fleet"
{ tests/deploy/fleet.sh build/release/server/freelsd-server "$work/demo/sample-flight-1-72" ||
  [ $? -eq 77 ]; } 2>&1 | tee "$work/fleet.log"
passed_but "$work/fleet.log"

start_step "from SQLite to PostgreSQL"
{ tests/deploy/move_to_postgresql.sh build/release/server/freelsd-server engine/classification/grass_model.yml \
  "$work/demo/sample-flight-1-72" || [ $? -eq 77 ]; } 2>&1 | tee "$work/move.log"
passed_but "$work/move.log"

start_step "faults of a fleet, short form"
{ tests/faults/fleet.sh --flight "$work/demo/sample-flight-1-72" --rows commit,pause,api || [ $? -eq 77 ]; } 2>&1 |
  tee "$work/fleet-faults.log"
if grep -q '^skipped: ' "$work/fleet-faults.log"; then passed_but "$work/fleet-faults.log"; else passed; fi

start_step "edges that follow a centre, short form"
tests/deploy/edge.sh build/release/server/freelsd-server engine/classification/grass_model.yml \
  build/release/tests/freelsd-fly-over
passed

start_step "edges that follow a centre on PostgreSQL, short form"
{ tests/deploy/edge.sh build/release/server/freelsd-server engine/classification/grass_model.yml \
  build/release/tests/freelsd-fly-over --postgresql --tls || [ $? -eq 77 ]; } 2>&1 | tee "$work/edge.log"
passed_but "$work/edge.log"

start_step "nginx in front"
if command -v nginx >/dev/null; then
  tests/deploy/nginx.sh build/release/server/freelsd-server engine/classification/grass_model.yml
  passed
else
  skipped "no nginx at hand"
fi

start_step "container"
tests/deploy/container.sh 2>&1 | tee "$work/container.log"
passed_but "$work/container.log"

start_step "man pages"
if command -v groff >/dev/null; then
  for page in deploy/*.[18]; do
    groff -man -Tutf8 -ww "$page" 2>&1 >/dev/null | tee -a "$work/groff.log"
  done
  if [ -s "$work/groff.log" ]; then fail "groff warns of the man pages"; fi
  passed
else
  skipped "no groff at hand"
fi

start_step "service units"
if command -v systemd-analyze >/dev/null; then
  for unit in freelsd.service freelsd-mavlink@.service; do
    sed -E 's|/usr/bin/freelsd-[a-z]+|/bin/true|' "deploy/$unit" >"$work/$unit"
  done
  systemd-analyze verify "$work/freelsd.service" "$work/freelsd-mavlink@wing.service"
  # Tenths: an exposure of 2.0 at most.
  for unit in freelsd.service freelsd-mavlink@.service; do
    systemd-analyze security --offline=true --threshold=20 "$work/$unit" | tail -n 1
  done
  passed
else
  skipped "no systemd-analyze at hand"
fi

start_step "Debian package"
deploy/package.sh
tests/deploy/package.sh build/release/freelsd_*.deb ${FREELSD_CLEAN_ROOT:+--clean-root} 2>&1 | tee "$work/package.log"
passed_but "$work/package.log"
