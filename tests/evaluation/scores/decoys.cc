#include "tests/evaluation/scores/decoys.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

#include "tests/evaluation/truth_run.h"

namespace freelsd {
namespace {

constexpr int kFourNeighbours = 4;

struct Piece {
  Region region;
  int64_t num_cells = 0;
};

void AddPieces(std::vector<Piece>& pieces,
               const cv::Mat1b& mask,
               const TruthMap& truth,
               double min_area_m2) {
  cv::Mat1i label, stats;
  cv::Mat1d centroids;
  const int num_labels =
      cv::connectedComponentsWithStats(mask, label, stats, centroids, kFourNeighbours);
  for (int i = 1; i < num_labels; ++i) {
    const int num_cells = stats(i, cv::CC_STAT_AREA);
    if (num_cells * truth.cell_size_m * truth.cell_size_m < min_area_m2) continue;
    pieces.push_back({RegionAround(label, i, truth), num_cells});
  }
}

}  // namespace

std::vector<Region> LargestDecoys(const Scenario& scenario,
                                  const TruthMap& truth,
                                  size_t max_num_decoys,
                                  int first_id) {
  std::vector<Piece> pieces;
  for (int cover = 0; cover < kNumCovers; ++cover) {
    const bool is_decoy =
        static_cast<Cover>(cover) != Cover::kMeadow && static_cast<Cover>(cover) != Cover::kDoubt;
    if (!is_decoy) continue;
    const cv::Mat1b of_cover = (truth.cover == cover) & (scenario.seen != 0);
    AddPieces(pieces, of_cover, truth, scenario.aircraft.min_area_m2);
  }
  std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
    return a.num_cells > b.num_cells;
  });
  pieces.resize(std::min(pieces.size(), max_num_decoys));
  std::vector<Region> decoys;
  decoys.reserve(pieces.size());
  for (Piece& piece : pieces) {
    piece.region.id = first_id + static_cast<int>(decoys.size());
    decoys.push_back(std::move(piece.region));
  }
  return decoys;
}

}  // namespace freelsd
