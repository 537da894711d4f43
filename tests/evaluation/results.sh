#!/usr/bin/env bash
# Everything that is measured, as one document; takes about three quarters of an hour.
#
#   FREELSD_DATA=FOLDER tests/evaluation/results.sh [NUM_WORLDS] > tests/evaluation/RESULTS.md
#
# Each part can be made alone with the command that stands above it.
set -euo pipefail
cd "$(dirname "$0")/../.."
programs=build/release/tests
num_worlds="${1:-12}"
[ -n "${FREELSD_DATA:-}" ] || { echo "results.sh: FREELSD_DATA is not set" >&2; exit 1; }
[ -x $programs/freelsd-eval ] || { echo "results.sh: build the release preset first" >&2; exit 1; }

part() { printf '\n## %s\n\n`%s`\n\n' "$1" "$2"; }
verbatim() { printf '```\n'; "$@"; printf '```\n'; }

cat <<TEXT
# What freelsd achieves

Made by \`tests/evaluation/results.sh $num_worlds > tests/evaluation/RESULTS.md\`, of revision
$(git rev-parse --short HEAD), on $(nproc) cores; not edited by hand. What the figures mean, and what was tried, stands in
[evaluation.md](evaluation.md); what the classifier scores in
[grass_model.md](../../engine/classification/grass_model.md).
TEXT
part "Seeded worlds: the safety table" "freelsd-eval --worlds $num_worlds --seed 9000"
verbatim $programs/freelsd-eval --worlds "$num_worlds" --seed 9000
part "Recorded flights" "tests/evaluation/flights.sh"
tests/evaluation/flights.sh
part "How recorded flights fit" "freelsd-survey \$FREELSD_DATA/flights/*"
$programs/freelsd-survey "$FREELSD_DATA"/flights/*
part "What stages cost" "freelsd-bench"
verbatim $programs/freelsd-bench
