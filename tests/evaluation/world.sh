#!/usr/bin/env bash
# Is the engine right about the world? Runs painted worlds, painted worlds with recorded texture, real
# ground, recorded flights and new places, and prints one table of all of them, as Markdown.
#
#   FREELSD_DATA=FOLDER tests/evaluation/world.sh [--row NAME]... [--worlds N] [--spacing S]
#   FREELSD_DATA=FOLDER tests/evaluation/world.sh --short
#
# Rows: painted textured ground flights places; the default is all. The reports are kept in
# build/reports: an interrupted run continues, and what is there is not run again. N worlds per row
# of worlds (default 24; ground: at least 40, so that each window is flown by each aircraft).
# S: metres between photographs; the default is mix, 6, 13 and 30 m in turns.
# --short runs a few worlds of the tuning pool, one small flight and one place, in some minutes, and
# fails if a site is false safe, if the planner on maps without error is false safe anywhere, or if
# an engine that is blinded on purpose is not caught.
set -euo pipefail
cd "$(dirname "$0")/../.."
programs=build/release/tests
reports=build/reports
num_worlds=24
spacing=mix
is_short=false
rows=()
while [ $# -gt 0 ]; do
  case "$1" in
    --row) rows+=("$2"); shift ;;
    --worlds) num_worlds="$2"; shift ;;
    --spacing) spacing="$2"; shift ;;
    --short) is_short=true ;;
    *) echo "world.sh: unknown argument $1" >&2; exit 2 ;;
  esac
  shift
done
[ ${#rows[@]} -gt 0 ] || rows=(painted textured ground flights places)
if [ -z "${FREELSD_DATA:-}" ]; then
  echo "skipped: FREELSD_DATA is not set, so there is no recorded ground" >&2
  exit 0
fi
[ -x $programs/freelsd-eval ] || { echo "world.sh: build the release preset first" >&2; exit 1; }
command -v jq >/dev/null || { echo "world.sh: jq is not installed" >&2; exit 1; }

# Photographs that are nearer to each other show less ground, too little for 25 of them.
if $is_short; then spacing=30; fi
recorded=(--texture recorded --conditions recorded)
if $is_short; then
  reports="$(mktemp -d)"
  trap 'rm -rf "$reports"' EXIT
fi
mkdir -p "$reports"
jobs="$(nproc)"

# evaluate NAME ARGUMENTS...
evaluate() {
  $programs/freelsd-eval --jobs "$jobs" --blind each --spacing "$spacing" \
    --json "$reports/$1.json" --resume "${@:2}" >"$reports/$1.txt"
}
survey_fields() {
  local flights=("${@/#/$FREELSD_DATA/flights/}")
  $programs/freelsd-fields "${flights[@]}" --jobs "$jobs" --blind hazards,shift,kinds,heights,flat \
    --json "$reports/flights.json" --resume >"$reports/flights.txt"
}
# The blinded classifier is caught by its exit status 3.
judge_places() {
  $programs/freelsd-places --jobs "$jobs" --json "$reports/places.json" "$@" >"$reports/places.txt"
  $programs/freelsd-places --jobs "$jobs" --json "$reports/blind_places.json" --blind "$@" \
    >"$reports/blind_places.txt" || [ $? -eq 3 ]
}
run_row() {
  case "$1" in
    painted) evaluate painted --seed 50000 --worlds "$num_worlds" ;;
    textured) evaluate textured --seed 51000 --worlds "$num_worlds" --cell 0.1 "${recorded[@]}" ;;
    ground)
      evaluate ground --seed 50000 --worlds $((num_worlds > 40 ? num_worlds : 40)) --ground report \
        "${recorded[@]}"
      ;;
    flights) survey_fields swindale garfield_park brighton_beach ;;
    places) judge_places ;;
    *) echo "world.sh: no row $1" >&2; exit 2 ;;
  esac
}
# Worlds of 25 photographs, 30 m apart. The windows are those with a field: a lawn and a pitch.
run_short_row() {
  case "$1" in
    painted) evaluate painted --seed 1048 --worlds 2 --frames 25 ;;
    textured) evaluate textured --seed 1048 --worlds 2 --frames 25 "${recorded[@]}" ;;
    ground) evaluate ground --seed 1002 --worlds 2 --frames 25 --ground autzen_or "${recorded[@]}" ;;
    flights) survey_fields brighton_beach ;;
    places) judge_places --place tuniu_tw ;;
    *) echo "world.sh: no row $1" >&2; exit 2 ;;
  esac
}

report_or_null() { if [ -f "$reports/$1.json" ]; then cat "$reports/$1.json"; else echo null; fi; }
print_tables() {
  local name
  for name in painted textured ground flights places blind_places; do
    report_or_null $name | jq -c "{$name: (if . == null then null else del(.worlds) end)}"
  done | jq -s add | jq -r -f tests/evaluation/world_table.jq
}

# check REPORT SENTENCE CONDITION
check() {
  jq -e "$3" "$reports/$1.json" >/dev/null && return
  echo "world.sh: $1: $2" >&2
  exit 3
}
check_short_run() {
  local name
  for name in painted textured ground; do
    check $name "a site is false safe" '.safety.num_false_safe == 0'
    check $name "the planner on maps without error is false safe" '.found.num_false_safe_on_truth == 0'
    check $name "an engine without hazards is not caught" \
      '.blinded.hazards.num_false_safe > .blinded.none.num_false_safe'
    check $name "an engine with kinds swapped is not caught" \
      '.blinded.kinds.failure_ratio > (.blinded.none.failure_ratio // 0)'
  done
  check flights "a site is false safe" '[.surveys[].counts.false_safe] | add == 0'
  check blind_places "a classifier with kinds swapped is not caught" \
    '.pooled.auc | . != null and . < 0.5'
}

for row in "${rows[@]}"; do
  started=$SECONDS
  if $is_short; then run_short_row "$row"; else run_row "$row"; fi
  echo "$row: $((SECONDS - started)) s" >&2
done
print_tables
if $is_short; then check_short_run; fi
