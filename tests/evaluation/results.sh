#!/usr/bin/env bash
# Runs all measurements and prints one page of them. A seeded world takes half a minute of one
# core; the other parts take about 45 minutes together.
#
#   FREELSD_DATA=FOLDER tests/evaluation/results.sh [NUM_WORLDS [NUM_WORLDS_IN_NOISE [PART...]]] \
#     > tests/evaluation/RESULTS.md
#
# Parts: world worlds textured ground places look noise2 damage frames flights bench peers growth. The
# default is all parts. `world` is the table of world.sh; worlds, textured and ground print the reports behind it.
# build/reports, which is not committed, keeps the whole report of each part, PART.md, with the revision
# that made it. The page has what it shows of all kept parts and marks those of an older revision.
# build/reports also holds the reports of the worlds, so an interrupted run continues.
set -euo pipefail
cd "$(dirname "$0")/../.."
programs=build/release/tests
page_parts=(world bench growth peers)
all_parts=(world worlds textured ground places look noise2 damage frames flights bench peers growth)
num_worlds="${1:-24}"
num_in_noise="${2:-24}"
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
# Prints the table that world.sh made.
table_of() {
  local name="$1" title="$2"
  heading "$title" "tests/evaluation/world.sh --row $name" "$(revision_of "$reports/$name.json")"
  verbatim cat "$reports/$name.txt"
}
make() {
  case "$1" in
    world)
      heading "Right about the world" "tests/evaluation/world.sh"
      tests/evaluation/world.sh --worlds "$num_worlds"
      ;;
    worlds) table_of painted "Painted worlds" ;;
    textured) table_of textured "Painted worlds with recorded texture" ;;
    ground) table_of ground "Real ground" ;;
    places)
      heading "New places" "tests/evaluation/world.sh --row places" \
        "$(revision_of "$reports/places.json")"
      verbatim cat "$reports/places.txt"
      ;;
    look)
      local pool
      heading "Frames beside photographs" "freelsd-frames --pool tuning, then --pool report"
      for pool in tuning report; do
        $programs/freelsd-frames --pool $pool --jobs "$(nproc)" | sed 's/^#/##/'
      done
      ;;
    noise2)
      worlds noise2 "Painted worlds, noise doubled" --seed 52000 --worlds "$num_in_noise" --noise 2
      ;;
    damage)
      worlds damage "Painted worlds, a fifth of the photographs damaged" \
        --seed 50000 --worlds "$num_in_noise" --damage 0.2
      ;;
    frames)
      worlds frames "Painted worlds, half as many photographs" \
        --seed 50000 --worlds "$num_in_noise" --spacing 30 --frames 25
      ;;
    flights)
      heading "Recorded flights" "tests/evaluation/flights.sh"
      tests/evaluation/flights.sh
      ;;
    bench)
      heading "What stages cost" "freelsd-bench"
      verbatim $programs/freelsd-bench
      ;;
    peers)
      heading "Beside COLMAP" "tests/bench/colmap.sh"
      tests/bench/colmap.sh "$FREELSD_DATA/flights/swindale"
      ;;
    growth)
      heading "Long flights" "tests/bench/growth.sh"
      tests/bench/growth.sh
      ;;
    *) echo "results.sh: no part $1: one of ${all_parts[*]}" >&2; exit 1 ;;
  esac
}

# The part's report as the page has it: of many tables of the world the first ones and that of its costs.
shorten() {
  awk '/^### / { is_left_out = !/^### (The table|Causes|Heights)$/ } !is_left_out' "$reports/$1.md"
}
# Copies a report. A section of an older revision gets a mark below its heading.
mark_age() {
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
  done
}

for part in "${parts[@]}"; do
  make "$part" >"$reports/$part.part"
  mv "$reports/$part.part" "$reports/$part.md"
done
cat <<TEXT
# What freelsd achieves

\`tests/evaluation/results.sh\` writes this page; do not edit it by hand. It was written at revision
$(git rev-parse --short HEAD). A section of an older revision is marked; its figures may differ today. The whole reports are
in \`build/reports\` after a run.

The [protocol](README.md) explains the figures. The [decision records](decisions/README.md) say what was
tried. The [model card](../../engine/ground_kind/training/README.md) has the scores of the network of ground kinds.
TEXT
for part in "${page_parts[@]}"; do
  if [ -f "$reports/$part.md" ]; then shorten "$part" | mark_age; fi
done | cat -s
