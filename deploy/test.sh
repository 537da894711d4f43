#!/usr/bin/env bash
# Installs what the tests need, builds what they use and runs them, from a bare Debian 12: about 28 minutes on two
# cores.
#
#   deploy/test.sh                     what a user runs, and continuous integration
#   deploy/test.sh --long [PART...]    all long tests, or only those parts; writes tests/LONG.md
#   deploy/test.sh --parts             which parts there are, and which of them the changes ask for
#
# Tests on recorded flights need FREELSD_DATA, the folder that holds them. Ends with a summary; what was skipped is said
# there too. Status 0 means that everything that ran has passed.
set -Eeuo pipefail
cd "$(dirname "$0")/.."
program="test.sh"
source deploy/steps.sh
source deploy/test/report.sh
source deploy/test/register.sh

work="$(mktemp -d)"
server_pid=""
port=""

end() {
  local status=$?
  if [ -n "$server_pid" ]; then stop_server "$server_pid" || true; fi
  rm -rf "$work"
  # Nothing was tested: a text was asked for, or the arguments are wrong.
  if [ ${#summary[@]} -eq 0 ] && [ "$step" = starting ]; then return 0; fi
  print_summary
  if [ "$status" -eq 0 ]; then
    echo "test.sh: everything that ran has passed, $SECONDS s"
  else
    echo "test.sh: FAILED while $step, after $SECONDS s"
  fi
}
trap end EXIT

usage() { sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' deploy/test.sh; }

# Format and layering of everything, clang-tidy of the newest changes.
lint() {
  start_step "lint"
  cmake -P tests/layering/layering.cmake
  if git rev-parse --verify --quiet HEAD >/dev/null; then
    deploy/lint.sh --seconds 90 2>&1 | tee "$work/lint.log"
    passed_but "$work/lint.log"
  else
    skipped "no history of git at hand, so what changed is unknown"
  fi
}

# What the steps below use; tools and benchmarks are built by --long.
build_what_is_tested() {
  start_step "building (release)"
  build_without_warnings release freelsd-server freelsd_web freelsd-render freelsd-eval \
    engine_tests api_tests storage_tests synthetic_tests evaluation_tests server_tests
  passed
}

# The slowest first. The tests of the suite "postgresql" are run by --long postgresql-tests.
test_units() {
  start_step "unit tests"
  local waiting="*/following/*,*/damage_test.cc,*/full_disk_test.cc"
  run_unit_tests release "server_tests --source-file-exclude=*/recall/*,$waiting" engine_tests \
    "server_tests --source-file=$waiting" "server_tests --source-file=*/recall/*" \
    storage_tests evaluation_tests api_tests synthetic_tests | tee "$work/units.log"
  passed
  report_skipped "$work/units.log"
  if [ -z "${FREELSD_DATA:-}" ]; then skipped "tests on recorded flights: FREELSD_DATA is not set"; fi
}

# Worlds of the tuning seeds with 15 fields to find; 8 are found where this was written, and another
# processor's rounding may cost one.
test_worlds() {
  start_step "seeded worlds: no site that is false safe"
  build/release/tests/freelsd-eval --worlds 6 --seed 1046 --spacing 30 --jobs "$(nproc)" \
    --max-false-safe 0 --min-found-ratio 0.5 | sed -n '1,/^sites, by what/p'
  passed
}

run_demo() {
  start_step "the demo, end to end"
  port="$(free_port 18080)"
  deploy/demo.sh --once --port "$port" --data "$work/demo"
  passed
}

compare_recorded_answers() {
  start_step "recorded answers"
  may_skip tests/server/recorded/run.sh build/release --photographs "$work/demo/sample-flight-1-72" 2>&1 |
    tee "$work/recorded.log"
  if ! grep -q '^SKIPPED: .* differ' "$work/recorded.log"; then passed; fi
  report_skipped "$work/recorded.log"
}

# The demo's result must be served again by a new process, set up as the example says.
restart_on_demo_data() {
  start_step "restart on the demo's data"
  build/release/server/freelsd-server --config deploy/config.example.json \
    --data "$work/demo/server" --listen "127.0.0.1:$port" >"$work/server.log" 2>&1 &
  server_pid=$!
  await_server "http://127.0.0.1:$port" "$server_pid" "$work/server.log"
  local num_sites
  num_sites="$(curl -fsS "http://127.0.0.1:$port/v1/sites" |
    jq '[.features[] | select(.properties.verdict != "rejected")] | length')"
  echo "$num_sites sites that are not rejected are served after a restart"
  if [ "$num_sites" -eq 0 ]; then fail "the demo found no site that is landable or unverified"; fi
  passed
}

# On the server that restart_on_demo_data has started.
test_page() {
  start_step "page test in a browser"
  tests/web/run.sh "http://127.0.0.1:$port" build/screenshots "$work/demo/sample-flight-1-72"
  passed
  stop_server "$server_pid"
  server_pid=""
}

# From a telemetry packet to the server and back, and a landing that is flown; --long autopilot has the rest.
test_short_link() {
  start_step "link to an autopilot, short form"
  local name
  local files=()
  for name in links landing_orders missions guidance sites hostile pairing engine_failure; do
    files+=("tests/autopilot/${name}_test.js")
  done
  test_link "$work/link.txt" --test-concurrency=2 "${files[@]}" | tee "$work/link.log"
  passed
  report_skipped "$work/link.log"
}

test_fleet() {
  start_step "a fleet on PostgreSQL"
  may_skip tests/deploy/fleet.sh build/release/server/freelsd-server "$work/demo/sample-flight-1-72" 2>&1 |
    tee "$work/fleet.log"
  passed_but "$work/fleet.log"
}

test_short_form() {
  start_step "installing packages"
  install_packages test
  passed
  lint
  build_what_is_tested
  test_units
  test_worlds
  run_demo
  compare_recorded_answers
  restart_on_demo_data
  test_page
  test_short_link
  test_fleet
  echo
  echo "== long tests"
  print_asked_parts
}

# run_part PART: what happens is recorded; a failure ends nothing else.
run_part() {
  local status=0 minutes result log="$work/$1.log"
  start_step "$1"
  deploy/test/part.sh "$1" 2>&1 | tee "$log" || status=$?
  minutes="$(awk -v s=$((SECONDS - started)) 'BEGIN { printf "%.1f", s / 60 }')"
  result="$(grep -iE '^skipped: ' "$log" | sed 's/^[^:]*: //' | paste -sd ';' || true)"
  case "$status" in
    0) end_step passed; result="passed${result:+, but skipped: $result}" ;;
    77) result="skipped: $result" ;;
    *) end_step FAILED; num_failed=$((num_failed + 1)); result="failed" ;;
  esac
  report_skipped "$log"
  record "$1" "$minutes" "$result"
}

# test_long_form PART...
test_long_form() {
  local part parts=("$@") num_failed=0
  if [ $# -eq 0 ]; then mapfile -t parts < <(part_names); fi
  for part in "${parts[@]}"; do
    is_part "$part" || fail "no part $part; parts: $(part_names | tr '\n' ' ')"
  done
  start_step "installing packages"
  install_packages test long package
  passed
  start_step "building (release)"
  build_without_warnings release
  passed
  for part in "${parts[@]}"; do run_part "$part"; done
  step="running long tests"
  if [ "$num_failed" -ne 0 ]; then fail "$num_failed of ${#parts[@]} parts failed"; fi
}

case "${1:-}" in
  "") test_short_form ;;
  --long) test_long_form "${@:2}" ;;
  --parts) part_names | paste -sd ' ' && print_asked_parts ;;
  -h | --help) usage ;;
  *) usage >&2; fail "unknown argument $1" ;;
esac
