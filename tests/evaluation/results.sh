#!/usr/bin/env bash
# Everything that is measured, as one document. A seeded world takes 40 seconds of one core; the
# rest takes about three quarters of an hour.
#
#   FREELSD_DATA=FOLDER tests/evaluation/results.sh [NUM_WORLDS [NUM_WORLDS_IN_NOISE [PART...]]] \
#     > tests/evaluation/RESULTS.md
#
# Parts: worlds noise2 damage frames rules ground flights survey bench; without any, all of them.
# Each is kept in build/reports with the revision that made it, and what is there of the others is
# printed too. The worlds' reports lie there as well: an interrupted run goes on from them, and
# parts of it that were flown elsewhere (other seeds, --merge) can be put there.
set -euo pipefail
cd "$(dirname "$0")/../.."
programs=build/release/tests
all_parts=(worlds noise2 damage frames rules ground flights survey bench)
num_worlds="${1:-200}"
num_in_noise="${2:-50}"
parts=("${@:3}")
[ ${#parts[@]} -gt 0 ] || parts=("${all_parts[@]}")
reports=build/reports
mkdir -p $reports
[ -n "${FREELSD_DATA:-}" ] || { echo "results.sh: FREELSD_DATA is not set" >&2; exit 1; }
[ -x $programs/freelsd-eval ] || { echo "results.sh: build the release preset first" >&2; exit 1; }

verbatim() { printf '```\n'; "$@"; printf '```\n'; }
heading() {
  local revision="${3:-$(git rev-parse --short HEAD)}"
  printf '\n## %s\n\n`%s`, of revision %s on %s cores.\n\n' "$1" "$2" "$revision" "$(nproc)"
}
# The newest when a report was last written, which is what flew its last worlds.
revision_of() { git log -1 --format=%h --until="@$(stat -c %Y "$1")"; }
# Name of the report, what it is about, and how the worlds are flown.
worlds() {
  local name="$1" title="$2"
  shift 2
  local table
  table="$(verbatim $programs/freelsd-eval "$@" --jobs "$(nproc)" \
    --json "$reports/$name.json" --resume)"
  heading "$title" "freelsd-eval $*" "$(revision_of "$reports/$name.json")"
  echo "$table"
}
make() {
  case "$1" in
    worlds) worlds worlds "Seeded worlds: the safety table" --seed 17000 --worlds "$num_worlds" ;;
    noise2)
      worlds noise2 "Seeded worlds, noise doubled" --seed 15000 --worlds "$num_in_noise" --noise 2
      ;;
    damage)
      worlds damage "Seeded worlds, a fifth of the photographs damaged" \
        --seed 17000 --worlds "$num_in_noise" --damage 0.2
      ;;
    frames)
      worlds frames "Seeded worlds, half as many photographs" \
        --seed 17000 --worlds "$num_in_noise" --frames 25
      ;;
    rules)
      worlds rules "Seeded worlds, planned on maps without error: what the rules allow" \
        --seed 17000 --worlds "$num_worlds" --on-truth
      ;;
    ground)
      for pack in brighton_beach honduras_pool; do
        worlds "ground_$pack" "Worlds of real ground: $pack" \
          --seed 17000 --worlds 4 --ground "$pack"
      done
      ;;
    flights)
      heading "Recorded flights" "tests/evaluation/flights.sh"
      tests/evaluation/flights.sh
      ;;
    survey)
      heading "How recorded flights fit" "freelsd-survey \$FREELSD_DATA/flights/*"
      $programs/freelsd-survey "$FREELSD_DATA"/flights/*
      ;;
    bench)
      heading "What stages cost" "freelsd-bench"
      verbatim $programs/freelsd-bench
      ;;
    *) echo "results.sh: no part $1: one of ${all_parts[*]}" >&2; exit 1 ;;
  esac
}

for part in "${parts[@]}"; do
  make "$part" >"$reports/$part.part"
  mv "$reports/$part.part" "$reports/$part.md"
done
cat <<TEXT
# What freelsd achieves

Made by \`tests/evaluation/results.sh\`; not edited by hand. What the figures mean, and what was tried, stands in
[evaluation.md](evaluation.md); what the classifier scores in
[grass_model.md](../../engine/classification/grass_model.md).
TEXT
for part in "${all_parts[@]}"; do
  if [ -f "$reports/$part.md" ]; then cat "$reports/$part.md"; fi
done
