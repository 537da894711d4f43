#include "tests/evaluation/fields/labelled_ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <opencv2/imgproc.hpp>

#include "tests/evaluation/fields/outline_agreement.h"
#include "tests/evaluation/fields/outline_masks.h"

namespace freelsd {
namespace {

constexpr double kCellSizeM = 0.25;
constexpr double kMarginM = 2.0;
// Stereo smears what stands on the ground over its surroundings.
constexpr double kSmearM = 2.0;

Grid GridOver(const std::vector<GroundOutline>& outlines) {
  if (outlines.empty()) return {};
  Eigen::Vector2d low = outlines.front().outline.front(), high = low;
  for (const GroundOutline& outline : outlines) {
    for (const Eigen::Vector2d& corner : outline.outline) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(kMarginM);
  return GridAround(low - margin, high + margin, kCellSizeM);
}

std::vector<LabelledObject> ObjectsOf(const std::vector<GroundOutline>& outlines) {
  std::map<std::string, LabelledObject> by_id;
  for (const GroundOutline& outline : outlines) {
    LabelledObject& object = by_id[outline.id];
    object.id = outline.id;
    object.kind = outline.kind;
    object.height_m = std::max(object.height_m, outline.height_m);
    object.views.push_back(outline);
  }
  std::vector<LabelledObject> objects;
  objects.reserve(by_id.size());
  for (auto& [id, object] : by_id) objects.push_back(std::move(object));
  return objects;
}

void FillMask(const Grid& grid, LabelledObject* object) {
  cv::Mat1b whole;
  for (const GroundOutline& view : object->views) {
    const cv::Mat1b mask = MaskOf(view.outline, grid);
    if (whole.empty()) {
      whole = mask;
    } else {
      whole =
          object->kind == OutlineKind::kLand ? cv::Mat1b(whole & mask) : cv::Mat1b(whole | mask);
    }
  }
  object->cells = cv::boundingRect(whole);
  object->mask = whole(object->cells).clone();
}

// Elevation without the cells in which something stands.
cv::Mat1f BareElevation(const std::vector<LabelledObject>& objects,
                        const Grid& grid,
                        const ElevationMap& map) {
  cv::Mat1b is_covered = cv::Mat1b::zeros(grid.num_rows, grid.num_cols);
  for (const LabelledObject& object : objects) {
    if (object.height_m > 0.0) is_covered(object.cells) |= object.mask;
  }
  const int reach = static_cast<int>(std::ceil(kSmearM / grid.cell_size_m));
  if (!is_covered.empty()) {
    cv::dilate(is_covered,
               is_covered,
               cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * reach + 1, 2 * reach + 1}));
  }
  cv::Mat1f bare = map.elevation.clone();
  for (int row = 0; row < bare.rows; ++row) {
    for (int col = 0; col < bare.cols; ++col) {
      const auto cell = grid.CellAt(map.grid.CellCenter(row, col));
      if (cell && is_covered(*cell) != 0) bare(row, col) = std::numeric_limits<float>::quiet_NaN();
    }
  }
  return bare;
}

void FillLand(LabelledGround* ground) {
  cv::Mat1b land = cv::Mat1b::zeros(ground->grid.num_rows, ground->grid.num_cols);
  cv::Mat1b danger = land.clone();
  for (const LabelledObject& object : ground->objects) {
    if (object.cells.empty()) continue;
    if (object.kind == OutlineKind::kLand) land(object.cells) |= object.mask;
    if (object.IsDanger()) danger(object.cells) |= object.mask;
  }
  ground->free_land = land & ~danger;
  cv::Mat1f cells;
  cv::distanceTransform(land == 0, cells, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  ground->distance_to_land = cells * ground->grid.cell_size_m;
}

}  // namespace

LabelledGround MakeLabelledGround(const std::vector<GroundOutline>& outlines,
                                  const ElevationMap& map,
                                  double position_sd_m) {
  const Grid grid = GridOver(outlines);
  std::vector<LabelledObject> objects = ObjectsOf(outlines);
  for (LabelledObject& object : objects) FillMask(grid, &object);
  GroundHeights bare(map.grid, BareElevation(objects, grid, map));
  LabelledGround ground{
      grid, std::move(objects), {}, {}, std::move(bare), {}, {}, 0.0, position_sd_m};
  if (outlines.empty()) return ground;
  FillLand(&ground);
  ground.disagreement = DisagreementOf(ground.objects, grid, Tallness::kLow);
  ground.tall_disagreement = DisagreementOf(ground.objects, grid, Tallness::kTall);
  ground.tolerance_m = std::hypot(position_sd_m, ground.disagreement.median_m);
  return ground;
}

}  // namespace freelsd
