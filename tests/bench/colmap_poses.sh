#!/usr/bin/env bash
# The heights of the engine's stereo and fusion on its own poses and on those of COLMAP, for a rendered flight, as a
# table in Markdown:
#   tests/bench/colmap_poses.sh FOLDER SEED [THREADS]
# FOLDER: written by freelsd-render --out FOLDER --seed SEED, other options at their defaults. THREADS: of both (default
# 1). COLMAP is given the camera and the pairs of photographs that were taken near each other. It is installed from
# Debian if it is missing, where it has no CUDA: SIFT runs on the processor, with 4096 instead of 8192 points for each
# photograph, because the matching of all would take a quarter of an hour. Seconds are of the processor.
set -euo pipefail
flight="$(realpath -e "${1:?usage: tests/bench/colmap_poses.sh FOLDER SEED [THREADS]}")"
seed="${2:?the seed of the flight is missing}"
threads="${3:-1}"
cd "$(dirname "$0")/../.."
export QT_QPA_PLATFORM=offscreen
if ! command -v colmap >/dev/null; then apt-get install -y --no-install-recommends colmap >/dev/null; fi
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

# COLMAP's (0, 0) is the corner of the first pixel, ours is its centre.
camera="$(jq -r '.camera | [.fx_px, .fy_px, .cx_px + 0.5, .cy_px + 0.5] | map(tostring) | join(",")' \
  "$flight/flight.json")"
# Photographs that were taken at most 80 m apart overlap by half, and those of neighbouring legs are among them.
awk -F , -v near_m=80 '
  NR > 1 { name[NR] = $1; north[NR] = $2 * 111195; east[NR] = $3 * 111195 * cos($2 * 3.14159265 / 180) }
  NR > 1 { for (i = 2; i < NR; ++i) {
    if ((north[i] - north[NR]) ^ 2 + (east[i] - east[NR]) ^ 2 <= near_m ^ 2) print name[i], name[NR] } }
' "$flight/poses.csv" >"$work/pairs.txt"
mkdir -p "$work/images" "$work/sparse"
ln -s "$flight"/*.jpg "$work/images"

step() { "$@" >>"$work/log" 2>&1 || { tail -5 "$work/log" >&2; exit 1; }; }

step colmap feature_extractor --database_path "$work/points.db" --image_path "$work/images" \
  --ImageReader.single_camera 1 --ImageReader.camera_model PINHOLE --ImageReader.camera_params "$camera" \
  --SiftExtraction.use_gpu 0 --SiftExtraction.num_threads "$threads" --SiftExtraction.max_num_features 4096
step colmap matches_importer --database_path "$work/points.db" --match_list_path "$work/pairs.txt" --match_type pairs \
  --SiftMatching.use_gpu 0 --SiftMatching.num_threads "$threads"
step colmap mapper --database_path "$work/points.db" --image_path "$work/images" --output_path "$work/sparse" \
  --Mapper.num_threads "$threads" --Mapper.ba_refine_focal_length 0 --Mapper.ba_refine_principal_point 0 \
  --Mapper.ba_refine_extra_params 0
# Second line: user and system seconds of all commands so far, "1m5.049s 0m1.912s".
times >"$work/times"
seconds="$(awk 'NR == 2 { gsub(/[ms]/, " "); printf "%.1f", 60 * ($1 + $3) + $2 + $4 }' "$work/times")"

# Of several models the one with the most photographs.
best="" num_best=-1
for model in "$work"/sparse/*/; do
  num="$(colmap model_analyzer --path "$model" 2>&1 | sed -n 's/.*Registered images: //p')"
  if [ "$num" -gt "$num_best" ]; then best="$model" num_best="$num"; fi
done
mkdir "$work/text"
step colmap model_converter --input_path "$best" --output_path "$work/text" --output_type TXT
build/release/tests/freelsd-poses "$flight" --seed "$seed" --colmap "$work/text" --colmap-seconds "$seconds" \
  --threads "$threads"
