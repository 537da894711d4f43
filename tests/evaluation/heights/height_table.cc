#include "tests/evaluation/heights/height_table.h"

#include <cmath>
#include <sstream>

#include "tests/evaluation/heights/height_scores.h"

namespace freelsd {
namespace {

// As HeightsOptions::min_thing_height_m.
constexpr double kMinThingM = 0.5;
// A measured ground that is at least this share of the thing's height above the true ground shows
// the thing itself.
constexpr double kShownShare = 0.5;
// Added to each count. A bin without cells counts for a thing: what was never seen is not trusted.
constexpr double kPriorCount = 2.0;

bool Stands(Cover cover) {
  return cover == Cover::kTree || cover == Cover::kBareTree || cover == Cover::kHedge ||
         cover == Cover::kHouse || cover == Cover::kBoulder || cover == Cover::kVehicle ||
         cover == Cover::kAnimal || cover == Cover::kPole;
}

}  // namespace

void HeightTable::Add(const Scenario& scenario,
                      const TruthMap& truth,
                      const PhotographHeights& heights,
                      const MapOffset& offset) {
  const cv::Mat1b is_open = OpenGround(truth);
  for (int row = 0; row < heights.grid.num_rows; ++row) {
    for (int col = 0; col < heights.grid.num_cols; ++col) {
      const Eigen::Vector2d on_map = heights.grid.CellCenter(row, col);
      const Eigen::Vector2d place = on_map - offset.ShiftAt(on_map);
      const cv::Point cell = truth.CellAt(place);
      if (place.cwiseAbs().maxCoeff() >= 0.5 * truth.size_m) continue;
      const auto bin = BinOf(heights.evidence, {col, row});
      if (!bin) continue;
      const auto index = static_cast<size_t>(IndexOf(*bin));
      const double ground = scenario.world.GroundHeight(place.x(), place.y());
      const double top = truth.top(cell) - ground;
      const double measured = heights.evidence.ground(row, col) - ground - offset.height.At(place);
      if (is_open(cell) != 0) {
        ++num_empty_[index];
        ++num_all_empty_;
      } else if (Stands(static_cast<Cover>(truth.cover(cell))) && top > kMinThingM &&
                 measured < kShownShare * top) {
        ++num_things_[index];
        ++num_all_things_;
      }
    }
  }
}

std::string HeightTable::Text() const {
  std::ostringstream text;
  text << "// " << num_all_things_ << " cells with a hidden thing, " << num_all_empty_
       << " of open ground.\n";
  for (int i = 0; i < kNumTableBins; ++i) {
    const auto index = static_cast<size_t>(i);
    const double thing_share = (static_cast<double>(num_things_[index]) + kPriorCount) /
                               (static_cast<double>(num_all_things_) + kPriorCount * kNumTableBins);
    const double empty_share = (static_cast<double>(num_empty_[index]) + kPriorCount) /
                               (static_cast<double>(num_all_empty_) + kPriorCount * kNumTableBins);
    text << std::lround(10.0 * std::log(thing_share / empty_share)) << ",";
    const int per_line = 4 * kNumGainBins;
    text << (i % per_line == per_line - 1 ? "\n" : " ");
  }
  return text.str();
}

}  // namespace freelsd
