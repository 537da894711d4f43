#!/bin/bash
# Writes engine/cover/kind/kind_table.cc from tuning data alone: fit.sh FOLDER_FOR_CELLS
# Takes about 20 minutes of one core. Prints the tables of the decision record 0029.
set -euo pipefail
cd "$(dirname "$0")/../../.."
cells=${1:?"fit.sh FOLDER_FOR_CELLS"}
mkdir -p "$cells"
kinds=build/release/tests/freelsd-kinds
for flight in swindale garfield_park brighton_beach; do
  "$kinds" cells --out "$cells" --flight "$FREELSD_DATA/flights/$flight"
done
for pack in honduras_pool churo_pe autzen_or brighton_beach; do
  "$kinds" cells --out "$cells" --worlds 2 --seed 1200 --ground "$pack"
done
"$kinds" cells --out "$cells" --worlds 6 --seed 1000 --texture recorded --conditions recorded --cell 0.1
"$kinds" cells --out "$cells" --worlds 4 --seed 1100
"$kinds" fit --cells "$cells" --every 3 --ridge 5 --table engine/cover/kind/kind_table.cc
clang-format -i engine/cover/kind/kind_table.cc
