#include "tests/evaluation/scores/obstruction.h"

#include <algorithm>
#include <set>

namespace freelsd {

bool IsThinName(const std::string& name) {
  static const std::set<std::string> kThinThings{"fence", "pole", "wire"};
  return kThinThings.contains(name);
}

double StepOf(const World& world) { return 0.5 * world.cell_size_m; }

double TopOf(const World& world, const Eigen::Vector2d& place, ThinThings thin) {
  if (thin == ThinThings::kCount) return world.TopHeight(place.x(), place.y());
  const int row = world.CellIndex(place.y()), col = world.CellIndex(place.x());
  const auto cover = static_cast<Cover>(world.cover(row, col));
  const bool is_thin = cover == Cover::kFence || cover == Cover::kPole;
  return is_thin ? world.ground(row, col) : world.surface(row, col);
}

std::string NameOfThing(const World& world, const Eigen::Vector2d& place, ThinThings thin) {
  if (thin == ThinThings::kCount && world.IsWireAt(place.x(), place.y())) return "wire";
  const Cover cover = world.CoverAt(place.x(), place.y());
  return cover == Cover::kMeadow ? "ground" : CoverName(cover);
}

std::string NameOfFault(const TruthMap& truth, const cv::Point& cell) {
  switch (static_cast<GroundFault>(truth.fault(cell))) {
    case GroundFault::kNone:
      return "";
    case GroundFault::kOutside:
      return "outside";
    case GroundFault::kCover:
      return CoverName(static_cast<Cover>(truth.cover(cell)));
    case GroundFault::kSteep:
      return "steep";
    case GroundFault::kRough:
      return "rough";
  }
  return "";
}

bool IsThinFault(const TruthMap& truth, const cv::Point& cell) {
  const auto is_thin_cover = [&](const cv::Point& place) {
    return static_cast<GroundFault>(truth.fault(place)) == GroundFault::kCover &&
           IsThinName(CoverName(static_cast<Cover>(truth.cover(place))));
  };
  if (static_cast<GroundFault>(truth.fault(cell)) != GroundFault::kRough) {
    return is_thin_cover(cell);
  }
  for (int row = std::max(0, cell.y - 1); row <= std::min(truth.fault.rows - 1, cell.y + 1);
       ++row) {
    for (int col = std::max(0, cell.x - 1); col <= std::min(truth.fault.cols - 1, cell.x + 1);
         ++col) {
      if (is_thin_cover({col, row})) return true;
    }
  }
  return false;
}

}  // namespace freelsd
