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
  // Of free cells: the larger the safer. Infinite for the layer hazard.
  float safety = kInfinity;
};

Touched TouchedAt(const WindowCell& cell, MapLayer layer) {
  if (!cell.window) return {kTouchesOutside};
  const HazardLayers& layers = cell.window->site_map.layers;
  const uint8_t hazard = layers.hazard(cell.row, cell.col);
  if (hazard == kHazard) return {kTouchesHazard};
  if (hazard != kFree) return {kTouchesUnseen};
  if (layer == MapLayer::kHazard) return {kTouchesFree};
  const bool is_risk = layer == MapLayer::kRisk;
  const cv::Mat1f& values = is_risk ? cell.window->risk : layers.distance;
  const float value = values.empty() ? kInfinity : values(cell.row, cell.col);
  if (!std::isfinite(value)) return {kTouchesUnseen};
  return {kTouchesFree, is_risk ? -value : value};
}

uint8_t StateOf(uint8_t bits) {
  if (bits & kTouchesHazard) return kHazard;
  if (bits == kTouchesOutside) return Safety::kOutside;
  return bits == kTouchesFree ? kFree : kUnseen;
}

// Joins what pixels touch.
class SafetyBuilder {
 public:
  SafetyBuilder(const cv::Size& size, MapLayer layer) : layer_(layer), bits_(size, 0) {
    if (layer != MapLayer::kHazard) least_ = cv::Mat1f(size, kInfinity);
  }

  void Add(int row, int col, const Touched& touched) {
    if (row < 0 || col < 0 || row >= bits_.rows || col >= bits_.cols) return;
    bits_(row, col) |= touched.bits;
    if (!least_.empty()) least_(row, col) = std::min(least_(row, col), touched.safety);
  }

  Safety Build() const {
    Safety safety{cv::Mat1b(bits_.size()), least_};
    if (layer_ == MapLayer::kRisk) safety.value = -least_;
    std::transform(bits_.begin(), bits_.end(), safety.state.begin(), StateOf);
    return safety;
  }

 private:
  MapLayer layer_;
  cv::Mat1b bits_;
  cv::Mat1f least_;
};

}  // namespace

bool IsSafetyLayer(MapLayer layer) {
  return layer == MapLayer::kHazard || layer == MapLayer::kDistance || layer == MapLayer::kRisk;
}

Safety SafetyOf(const PixelPlaces& places, const std::vector<MapWindow>& windows, MapLayer layer) {
  const cv::Rect& box = places.box();
  const int num_steps = NumSteps(places, windows);
  if (num_steps > kMaxNumSteps) return SafetyOf(places, AllCoarser(windows), layer);
  const double step = 1.0 / num_steps;
  const int num_cols = num_steps * box.width + 1;
  const CellFinder finder(windows);
  SafetyBuilder builder(box.size(), layer);
  for (int i = 0; i <= num_steps * box.height; ++i) {
    const auto line = places.Row({static_cast<double>(box.x), box.y + i * step}, step, num_cols);
    const int row = i / num_steps;
    const bool is_edge = i % num_steps == 0;
    for (int j = 0; j < num_cols; ++j) {
      const Touched touched = TouchedAt(finder.At(line[j]), layer);
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
