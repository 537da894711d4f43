#!/usr/bin/env bash
# Runs all measurements and prints them as one document. A seeded world takes half a minute of one
# core; the other parts take about 45 minutes together.
#
#   FREELSD_DATA=FOLDER tests/evaluation/results.sh [NUM_WORLDS [NUM_WORLDS_IN_NOISE [PART...]]] \
#     > tests/evaluation/RESULTS.md
#
# Parts: worlds noise2 damage frames rules ground flights survey bench. The default is all parts.
# build/reports keeps each part with the revision that made it. The document contains all kept
# parts and marks those of an older revision. build/reports also holds the reports of the worlds, so
# an interrupted run continues. Reports made elsewhere (other seeds, --merge) may be put there.
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
# The newest revision at the time of the report's last change: it flew the last worlds.
revision_of() { git log -1 --format=%h --until="@$(stat -c %Y "$1")"; }
# worlds NAME TITLE ARGUMENTS...: flies the worlds; NAME is the report's.
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

# Prints a part. A section of an older revision gets a mark below its heading.
print_part() {
  local line revision num_commits
  while IFS= read -r line; do
    printf '%s\n' "$line"
    if [[ $line =~ \ of\ revision\ ([0-9a-f]+)\ on ]]; then
      revision="${BASH_REMATCH[1]}"
      if [ "$(git rev-parse "$revision")" != "$(git rev-parse HEAD)" ]; then
        num_commits="$(git rev-list --count "$revision..HEAD" -- engine)"
        printf '\n**Older revision.** Later commits that change `engine/`: %s.\n' "$num_commits"
      fi
    fi
  done <"$1"
}

for part in "${parts[@]}"; do
  make "$part" >"$reports/$part.part"
  mv "$reports/$part.part" "$reports/$part.md"
done
cat <<TEXT
# What freelsd achieves

\`tests/evaluation/results.sh\` writes this document; do not edit it by hand. It was written at revision
$(git rev-parse --short HEAD). A section of an older revision is marked; its figures may differ today.

The [protocol](README.md) explains the figures. The [decision records](decisions/README.md) say what was
tried. [grass_model.md](../../engine/classification/grass_model.md) has the scores of the classifier.
TEXT
for part in "${all_parts[@]}"; do
  if [ -f "$reports/$part.md" ]; then print_part "$reports/$part.md"; fi
done
