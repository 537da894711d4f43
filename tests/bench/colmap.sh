#!/usr/bin/env bash
# The whole engine beside the sparse reconstruction of COLMAP, on the same photographs, as a row of Markdown:
#   tests/bench/colmap.sh FOLDER [WIDTH [ROUNDS]]
# FOLDER: a recorded flight with images/ and perhaps poses.csv. WIDTH: largest side of an image in COLMAP (default 752,
# at which the engine tracks). ROUNDS: both in turns, so often (default 3); medians are told. COLMAP is installed from
# Debian if it is missing; SIFT runs on the processor, headless, and both have two threads. COLMAP matches each
# photograph with the ten before it, not with all.
set -euo pipefail
flight="$(realpath -e "${1:?usage: tests/bench/colmap.sh FOLDER [WIDTH [ROUNDS]]}")"
width="${2:-752}"
rounds="${3:-3}"
cd "$(dirname "$0")/../.."
readonly threads=2
export QT_QPA_PLATFORM=offscreen
if ! command -v colmap >/dev/null; then apt-get install -y --no-install-recommends colmap >/dev/null; fi
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

# seconds LOG COMMAND...
seconds() {
  local log="$1" begin
  shift
  begin=$(date +%s.%N)
  "$@" >"$log" 2>&1 || { tail -5 "$log" >&2; exit 1; }
  awk -v begin="$begin" -v end="$(date +%s.%N)" 'BEGIN { printf "%.1f\n", end - begin }'
}

reconstruct() {
  rm -rf "$work/colmap"
  mkdir -p "$work/colmap/sparse"
  colmap feature_extractor --database_path "$work/colmap/points.db" --image_path "$flight/images" \
    --ImageReader.single_camera 1 --SiftExtraction.use_gpu 0 --SiftExtraction.num_threads "$threads" \
    --SiftExtraction.max_image_size "$width" &&
    colmap sequential_matcher --database_path "$work/colmap/points.db" --SiftMatching.use_gpu 0 \
    --SiftMatching.num_threads "$threads" --SequentialMatching.overlap 10 --SequentialMatching.quadratic_overlap 0 &&
    colmap mapper --database_path "$work/colmap/points.db" --image_path "$flight/images" \
    --output_path "$work/colmap/sparse" --Mapper.num_threads "$threads"
}

find_sites() {
  taskset -c "0-$((threads - 1))" build/release/tests/freelsd-survey "$flight"
}

median() { sort -n "$1" | awk '{ all[NR] = $1 } END { print all[int((NR + 1) / 2)] }'; }

for _ in $(seq "$rounds"); do
  seconds "$work/colmap.log" reconstruct >>"$work/theirs"
  seconds "$work/freelsd.log" find_sites >>"$work/ours"
done
registered=$(for model in "$work"/colmap/sparse/*/; do
  colmap model_analyzer --path "$model" 2>&1 | sed -n 's/.*Registered images: //p'
done | sort -n | tail -1)
echo "| flight | photographs | COLMAP sparse, s | of them placed | poses, map and sites, s | ratio | machine | date |"
echo "|---|---|---|---|---|---|---|---|"
echo "| $(basename "$flight") at $width px | $(find "$flight/images" -type f | wc -l) | $(median "$work/theirs") |" \
  "$registered | $(median "$work/ours") |" \
  "$(awk -v a="$(median "$work/theirs")" -v b="$(median "$work/ours")" 'BEGIN { printf "%.2f", a / b }') |" \
  "$(sed -n 's/^model name.*: //p' /proc/cpuinfo | head -1), $threads cores | $(date +%F) |"
