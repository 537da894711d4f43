#!/usr/bin/env bash
# Everything that is measured, as one document. A seeded world takes 80 seconds of one core; the
# rest takes about three quarters of an hour.
#
#   FREELSD_DATA=FOLDER tests/evaluation/results.sh [NUM_WORLDS [NUM_WORLDS_IN_NOISE]] \
#     > tests/evaluation/RESULTS.md
#
# Each part can be made alone with the command that stands above it. The worlds' reports lie in
# build/reports: an interrupted run goes on from there, and parts of it that were flown elsewhere
# (other seeds, --merge) can be put there.
set -euo pipefail
cd "$(dirname "$0")/../.."
programs=build/release/tests
num_worlds="${1:-200}"
num_in_noise="${2:-50}"
reports=build/reports
mkdir -p $reports
[ -n "${FREELSD_DATA:-}" ] || { echo "results.sh: FREELSD_DATA is not set" >&2; exit 1; }
[ -x $programs/freelsd-eval ] || { echo "results.sh: build the release preset first" >&2; exit 1; }

part() { printf '\n## %s\n\n`%s`\n\n' "$1" "$2"; }
verbatim() { printf '```\n'; "$@"; printf '```\n'; }

cat <<TEXT
# What freelsd achieves

Made by \`tests/evaluation/results.sh $num_worlds $num_in_noise > tests/evaluation/RESULTS.md\`, of revision
$(git rev-parse --short HEAD), on $(nproc) cores; not edited by hand. What the figures mean, and what was tried, stands in
[evaluation.md](evaluation.md); what the classifier scores in
[grass_model.md](../../engine/classification/grass_model.md).
TEXT
# Name of the report, what it is about, and how the worlds are flown.
worlds() {
  local name="$1" title="$2"
  shift 2
  part "$title" "freelsd-eval --seed 9000 $*"
  verbatim $programs/freelsd-eval --seed 9000 "$@" --jobs "$(nproc)" --json "$reports/$name.json" --resume
}
worlds worlds "Seeded worlds: the safety table" --worlds "$num_worlds"
worlds noise2 "Seeded worlds, noise doubled" --worlds "$num_in_noise" --noise 2
worlds damage "Seeded worlds, a fifth of the photographs damaged" --worlds "$num_in_noise" --damage 0.2
worlds frames "Seeded worlds, half as many photographs" --worlds "$num_in_noise" --frames 25
worlds rules "Seeded worlds, planned on maps without error: what the rules allow" --worlds "$num_worlds" --on-truth
part "Recorded flights" "tests/evaluation/flights.sh"
tests/evaluation/flights.sh
part "How recorded flights fit" "freelsd-survey \$FREELSD_DATA/flights/*"
$programs/freelsd-survey "$FREELSD_DATA"/flights/*
part "What stages cost" "freelsd-bench"
verbatim $programs/freelsd-bench
