#include "engine/cover/steepest_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <opencv2/core/utility.hpp>

#include "engine/footprint/footprint.h"

namespace freelsd {
namespace {

// Views are tried for blocks of this side, in cells, nearest first: of a long flight, few show one.
constexpr int kSteepestBlockSize = 32;

// Whether the image shows all four corners of the cell.
bool IsCellShown(const ElevationMap& map,
                 const Camera& camera,
                 const Rigid3d& camera_from_world,
                 int row,
                 int col) {
  const float height = map.elevation(row, col);
  const auto is_shown = [&](double south, double east) {
    return ImageOfCorner(map, camera, camera_from_world, row + south, col + east, height)
        .has_value();
  };
  return is_shown(0, 0) && is_shown(0, 1) && is_shown(1, 0) && is_shown(1, 1);
}

bool IsElsewhere(const AdjustedBlock& block, int view, int first, double min_crossing_ratio) {
  if (first < 0) return false;
  const AdjustedView& other = block.views[static_cast<size_t>(first)];
  const Eigen::Vector3d baseline =
      block.views[static_cast<size_t>(view)].world_from_camera.translation -
      other.world_from_camera.translation;
  return baseline.head<2>().norm() >= min_crossing_ratio * other.height_above_ground;
}

// A connected view of the block.
struct SeeingView {
  int index = 0;
  Camera camera;
  Eigen::Vector2d place_in_world = Eigen::Vector2d::Zero();
  Rigid3d camera_from_world;
  Footprint footprint;
};

std::vector<SeeingView> SeeingViews(const ElevationMap& map, const AdjustedBlock& block) {
  std::vector<SeeingView> views;
  const HeightRange heights = HeightRangeOf(map.elevation);
  if (heights.IsEmpty()) return views;
  for (size_t v = 0; v < block.views.size(); ++v) {
    if (!block.views[v].is_connected) continue;
    const Rigid3d& world_from_camera = block.views[v].world_from_camera;
    const Camera camera = block.CameraOf(v);
    views.push_back({static_cast<int>(v),
                     camera,
                     world_from_camera.translation.head<2>(),
                     Inverse(world_from_camera),
                     FootprintOf(camera, world_from_camera, heights.lowest_m, heights.highest_m)});
  }
  return views;
}

class SteepestOfBlock {
 public:
  SteepestOfBlock(const ElevationMap& map,
                  const AdjustedBlock& block,
                  const cv::Mat1i& first,
                  double min_crossing_ratio,
                  const cv::Rect& cells)
      : map_(map),
        block_(block),
        first_(first),
        min_crossing_ratio_(min_crossing_ratio),
        cells_(cells),
        least_(cells.size(), std::numeric_limits<float>::infinity()) {}

  // Writes only the cells of the block.
  void Find(const std::vector<SeeingView>& views, cv::Mat1i& steepest) {
    for (const auto& [distance, view] : NearestFirst(views)) {
      // No cell is nearer than the block's middle less half of its diagonal.
      const double nearest = std::max(0.0, distance - HalfDiagonal());
      if (nearest * nearest > FarthestTaken()) return;
      Offer(*view, steepest);
    }
  }

 private:
  double HalfDiagonal() const {
    return 0.5 * map_.grid.cell_size_m * std::hypot(cells_.width, cells_.height);
  }

  std::vector<std::pair<double, const SeeingView*>> NearestFirst(
      const std::vector<SeeingView>& views) const {
    const double cell = map_.grid.cell_size_m;
    const Eigen::Vector2d north_west =
        map_.grid.north_west_in_world + cell * Eigen::Vector2d(cells_.x, -cells_.y);
    const Eigen::Vector2d size = cell * Eigen::Vector2d(cells_.width, cells_.height);
    const Eigen::Vector2d min(north_west.x(), north_west.y() - size.y());
    const Eigen::Vector2d max(north_west.x() + size.x(), north_west.y());
    std::vector<std::pair<double, const SeeingView*>> nearest;
    for (const SeeingView& view : views) {
      const bool is_apart = (view.footprint.max_in_world.array() < min.array()).any() ||
                            (view.footprint.min_in_world.array() > max.array()).any();
      if (!is_apart) nearest.emplace_back((view.place_in_world - 0.5 * (min + max)).norm(), &view);
    }
    std::sort(nearest.begin(), nearest.end());
    return nearest;
  }

  // Largest squared distance of a seen cell to its view so far; infinite while one has none.
  double FarthestTaken() const {
    float farthest = 0.0f;
    for (int row = 0; row < cells_.height; ++row) {
      for (int col = 0; col < cells_.width; ++col) {
        if (map_.IsSeen(cells_.y + row, cells_.x + col)) {
          farthest = std::max(farthest, least_(row, col));
        }
      }
    }
    // The distances are rounded.
    return 1.0001 * farthest;
  }

  void Offer(const SeeingView& view, cv::Mat1i& steepest) {
    for (int row = cells_.y; row < cells_.y + cells_.height; ++row) {
      for (int col = cells_.x; col < cells_.x + cells_.width; ++col) {
        if (!map_.IsSeen(row, col)) continue;
        const Eigen::Vector2d offset = map_.grid.CellCenter(row, col) - view.place_in_world;
        const auto distance = static_cast<float>(offset.squaredNorm());
        float& least = least_(row - cells_.y, col - cells_.x);
        // Of two views that are equally near, the first is taken.
        const bool is_better =
            distance < least || (distance == least && view.index < steepest(row, col));
        if (!is_better || !MayCompete(view.index, row, col)) continue;
        if (!IsCellShown(map_, view.camera, view.camera_from_world, row, col)) continue;
        least = distance;
        steepest(row, col) = view.index;
      }
    }
  }

  bool MayCompete(int view, int row, int col) const {
    return first_.empty() || IsElsewhere(block_, view, first_(row, col), min_crossing_ratio_);
  }

  const ElevationMap& map_;
  const AdjustedBlock& block_;
  const cv::Mat1i& first_;
  const double min_crossing_ratio_;
  const cv::Rect cells_;
  // Squared distance of each cell of the block to its view.
  cv::Mat1f least_;
};

}  // namespace

std::optional<Eigen::Vector2d> ImageOfCorner(const ElevationMap& map,
                                             const Camera& camera,
                                             const Rigid3d& camera_from_world,
                                             double row,
                                             double col,
                                             float height) {
  const double cell = map.grid.cell_size_m;
  Eigen::Vector3d place_in_world;
  place_in_world << map.grid.north_west_in_world + cell * Eigen::Vector2d(col, -row), height;
  std::optional<Eigen::Vector2d> pixel = camera.ImageFromCamera(camera_from_world * place_in_world);
  if (!pixel || !camera.IsInside(*pixel)) return std::nullopt;
  return pixel;
}

cv::Mat1i SteepestViews(const ElevationMap& map,
                        const AdjustedBlock& block,
                        const cv::Mat1i& first,
                        double min_crossing_ratio) {
  cv::Mat1i steepest(map.elevation.size(), -1);
  const std::vector<SeeingView> views = SeeingViews(map, block);
  if (views.empty()) return steepest;
  const cv::Rect whole({}, steepest.size());
  const int num_across = (whole.width + kSteepestBlockSize - 1) / kSteepestBlockSize;
  const int num_down = (whole.height + kSteepestBlockSize - 1) / kSteepestBlockSize;
  cv::parallel_for_({0, num_across * num_down}, [&](const cv::Range& blocks) {
    for (int i = blocks.start; i < blocks.end; ++i) {
      const cv::Point corner(i % num_across * kSteepestBlockSize,
                             i / num_across * kSteepestBlockSize);
      const cv::Rect cells =
          cv::Rect(corner, cv::Size(kSteepestBlockSize, kSteepestBlockSize)) & whole;
      SteepestOfBlock(map, block, first, min_crossing_ratio, cells).Find(views, steepest);
    }
  });
  return steepest;
}

}  // namespace freelsd
