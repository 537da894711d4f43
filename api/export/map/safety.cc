#include <algorithm>
#include <cmath>
#include <limits>

#include "api/export/map/map_picture.h"

namespace freelsd {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
// What a pixel touches, one bit each.
constexpr uint8_t kTouchesFree = 1;
constexpr uint8_t kTouchesUnseen = 2;
constexpr uint8_t kTouchesHazard = 4;
constexpr uint8_t kTouchesOutside = 8;
// With more, the next level of the windows has few enough. A tile of the whole earth would have a
// million.
constexpr int kMaxNumSteps = 4;

// Steps into which a pixel is divided, so that every cell contains one of their ends: a square
// of that extent holds a point of every lattice of such steps, turned or not.
int NumSteps(const PixelPlaces& places, const std::vector<MapWindow>& windows) {
  double steps = 1.0;
  for (const MapWindow& window : windows) {
    steps = std::max(steps, places.PixelExtentM() / window.site_map.map.grid.cell_size_m);
  }
  return static_cast<int>(std::ceil(steps));
}

std::vector<MapWindow> AllCoarser(const std::vector<MapWindow>& windows) {
  std::vector<MapWindow> coarser;
  coarser.reserve(windows.size());
  for (const MapWindow& window : windows) coarser.push_back(Coarser(window));
  return coarser;
}

struct Touched {
  uint8_t bits = 0;
  float distance = kInfinity;
};

Touched TouchedAt(const WindowCell& cell, WithDistance with_distance) {
  if (!cell.window) return {kTouchesOutside};
  const HazardLayers& layers = cell.window->site_map.layers;
  const uint8_t hazard = layers.hazard(cell.row, cell.col);
  if (hazard == kHazard) return {kTouchesHazard};
  if (hazard != kFree) return {kTouchesUnseen};
  if (with_distance == WithDistance::kNo) return {kTouchesFree};
  const float distance = layers.distance.empty() ? kInfinity : layers.distance(cell.row, cell.col);
  if (!std::isfinite(distance)) return {kTouchesUnseen};
  return {kTouchesFree, distance};
}

uint8_t StateOf(uint8_t bits) {
  if (bits & kTouchesHazard) return kHazard;
  if (bits == kTouchesOutside) return Safety::kOutside;
  return bits == kTouchesFree ? kFree : kUnseen;
}

// Joins what pixels touch.
class SafetyBuilder {
 public:
  SafetyBuilder(const cv::Size& size, WithDistance with_distance) : bits_(size, 0) {
    if (with_distance == WithDistance::kYes) distance_ = cv::Mat1f(size, kInfinity);
  }

  void Add(int row, int col, const Touched& touched) {
    if (row < 0 || col < 0 || row >= bits_.rows || col >= bits_.cols) return;
    bits_(row, col) |= touched.bits;
    if (!distance_.empty()) distance_(row, col) = std::min(distance_(row, col), touched.distance);
  }

  Safety Build() const {
    Safety safety{cv::Mat1b(bits_.size()), distance_};
    std::transform(bits_.begin(), bits_.end(), safety.state.begin(), StateOf);
    return safety;
  }

 private:
  cv::Mat1b bits_;
  cv::Mat1f distance_;
};

}  // namespace

Safety SafetyOf(const PixelPlaces& places,
                const std::vector<MapWindow>& windows,
                WithDistance with_distance) {
  const cv::Rect& box = places.box();
  const int num_steps = NumSteps(places, windows);
  if (num_steps > kMaxNumSteps) return SafetyOf(places, AllCoarser(windows), with_distance);
  const double step = 1.0 / num_steps;
  const int num_cols = num_steps * box.width + 1;
  const CellFinder finder(windows);
  SafetyBuilder builder(box.size(), with_distance);
  for (int i = 0; i <= num_steps * box.height; ++i) {
    const auto line = places.Row({static_cast<double>(box.x), box.y + i * step}, step, num_cols);
    const int row = i / num_steps;
    const bool is_edge = i % num_steps == 0;
    for (int j = 0; j < num_cols; ++j) {
      const Touched touched = TouchedAt(finder.At(line[j]), with_distance);
      const int col = j / num_steps;
      builder.Add(row, col, touched);
      // A place on an edge belongs to the pixels on both sides.
      if (is_edge) builder.Add(row - 1, col, touched);
      if (j % num_steps != 0) continue;
      builder.Add(row, col - 1, touched);
      if (is_edge) builder.Add(row - 1, col - 1, touched);
    }
  }
  return builder.Build();
}

}  // namespace freelsd
