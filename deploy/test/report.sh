# shellcheck shell=bash disable=SC2154
# How test.sh and its long parts report: steps with their seconds, what was skipped, and how test programs are run. To
# be sourced after steps.sh; `work` is a folder for logs.

summary=()
started=0

start_step() {
  started=$SECONDS
  begin "$1"
}

# end_step WORD: one line, printed now and in the summary.
end_step() {
  local line
  line="$(printf '%-7s  %5d s  %s' "$1" $((SECONDS - started)) "$step")"
  echo "$line"
  summary+=("$line")
}
passed() { end_step passed; }
skipped() {
  local line="SKIPPED           $step: $1"
  echo "$line"
  summary+=("$line")
}

# may_skip COMMAND...: status 77 means that something is not at hand; it has said what.
may_skip() { "$@" || [ $? -eq 77 ]; }

# report_skipped LOG: its lines "skipped: why" are in the summary too.
report_skipped() {
  local line
  while read -r line; do skipped "${line#*: }"; done < <(grep -iE '^skipped: ' "$1" || true)
}

# passed_but LOG: passed if the log says so, but for what was skipped.
passed_but() {
  if grep -q 'everything that ran has passed' "$1"; then passed; fi
  report_skipped "$1"
}

print_summary() {
  echo
  echo "== summary"
  local line
  for line in "${summary[@]}"; do echo "$line"; done
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

# build_without_warnings PRESET TARGET...
build_without_warnings() {
  build "$@" 2>&1 | tee "$work/build.log"
  refuse_warnings "$work/build.log"
}

# run_program FOLDER NAME FILTER...: a program of doctest, all cases in one process. If it fails, what it wrote is shown.
run_program() {
  local program="$1/$2" name="${*:2}" log num_run num_there
  shift 2
  log="$(mktemp -p "$work")"
  if ! timeout 1800 "$program" "$@" >"$log" 2>&1; then
    tail -n 200 "$log" >&2
    echo "$name: FAILED after $SECONDS s" >&2
    return 1
  fi
  # A case that ends the process ends the others too.
  num_run="$(sed -nE 's/^\[doctest\] test cases: +([0-9]+) .*/\1/p' "$log")"
  num_there="$("$program" --count "$@" | grep -oE '[0-9]+$' || echo 0)"
  if [ "${num_run:-0}" -ne "$num_there" ] || [ "$num_there" -eq 0 ]; then
    echo "$name: only ${num_run:-0} of $num_there cases have run" >&2
    return 1
  fi
  # A test that skips itself counts as run.
  sed -nE 's/.*MESSAGE: skipped: (.*)/\1/p' "$log" | sort | uniq -c | sed -E 's/^ *([0-9]+) (.*)/skipped: \2 (\1 times)/'
  echo "$name: $num_run cases, $SECONDS s"
  echo "$num_run" >>"$work/num_run"
}

# run_unit_tests PRESET "NAME FILTER"...: one more process at once than there are cores, because tests of servers mostly
# wait. All cases of the named programs must have run, whatever the filters are.
run_unit_tests() {
  local folder="build/$1/tests" num_run num_there=0 name
  shift
  : >"$work/num_run"
  export work
  export -f run_program
  printf '%s\n' "$@" | xargs -P "$(($(nproc) + 1))" -L 1 bash -c 'run_program "$@"' run_program "$folder" ||
    fail "unit tests failed"
  for name in $(printf '%s\n' "${@%% *}" | sort -u); do
    num_there=$((num_there + $("$folder/$name" --count | grep -oE '[0-9]+$')))
  done
  num_run="$(awk '{ sum += $1 } END { print sum }' "$work/num_run")"
  if [ "$num_run" -ne "$num_there" ]; then fail "$num_run of $num_there unit tests have run"; fi
  echo "$num_run unit tests have passed"
}

# test_link LOG NODE-ARGUMENTS...: tests of the link to an autopilot.
test_link() {
  local log="$1"
  shift
  npm ci --ignore-scripts --omit=optional --no-audit --no-fund --loglevel=error --prefix server/mavlink
  FREELSD_SERVER="$PWD/build/release/server/freelsd-server" timeout 1800 node --test "$@" >"$log" 2>&1 || {
    cat "$log" >&2
    fail "tests of the link failed"
  }
  grep -E '^# (pass|fail|skipped) ' "$log"
  sed -nE 's/^ok [0-9]+ - (.*) # SKIP ?(.*)$/skipped: \1: \2/p' "$log"
}
