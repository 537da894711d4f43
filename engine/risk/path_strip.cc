#include "engine/risk/path_strip.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Below every height.
constexpr float kNothing = -1e6f;
// A cell that is more probably unfit than fit is no ground to land on.
constexpr double kEven = 0.5;

struct StripCell {
  float kind = 0.0f;
  float shape = 0.0f;
  float ground_top = kNothing;
  float obstacle_top = kNothing;
  float obstacle_sd = 0.0f;
};

// Unseen cells count for nothing.
StripCell CellAt(const RiskGround& ground, const Eigen::Vector2d& place, double touchdown_height) {
  const std::optional<CellRisk> cell = ground.At(place);
  if (!cell) return {};
  StripCell found{.kind = static_cast<float>(cell->kind),
                  .shape = static_cast<float>(cell->shape),
                  .obstacle_sd = static_cast<float>(cell->top_sd)};
  const bool is_fit = (1.0 - cell->kind) * (1.0 - cell->shape) >= kEven;
  (is_fit ? found.ground_top : found.obstacle_top) =
      static_cast<float>(cell->top - touchdown_height);
  return found;
}

// Largest value of each row within half_width_cells.
cv::Mat1f WidestOf(const cv::Mat1f& raster, int half_width_cells) {
  cv::Mat1f widened;
  cv::dilate(raster, widened, cv::Mat1b::ones(1, 2 * half_width_cells + 1));
  return widened;
}

cv::Mat1f MeanOf(const cv::Mat1f& raster, int half_width_cells) {
  cv::Mat1f mean;
  cv::blur(raster, mean, {2 * half_width_cells + 1, 1});
  return mean;
}

}  // namespace

int PathStrip::RowAt(double along) const {
  const int row = static_cast<int>(std::lround((along - first_along) / step));
  return std::clamp(row, 0, kind.rows - 1);
}

int PathStrip::ColAt(double across) const {
  const int col = static_cast<int>(std::lround((across - first_across) / step));
  return std::clamp(col, 0, kind.cols - 1);
}

std::optional<CellRisk> RiskGround::At(const Eigen::Vector2d& place_in_world) const {
  const auto cell = map.grid.CellAt(place_in_world);
  return cell ? RiskOfCell(map, layers, aircraft, *cell) : std::nullopt;
}

PathStrip MakePathStrip(const RiskGround& ground,
                        const PlannedLanding& landing,
                        const StripExtent& extent) {
  PathStrip strip;
  strip.step = ground.map.grid.cell_size_m;
  const int half_width_cells =
      static_cast<int>(std::ceil(ground.aircraft.path_half_width_m / strip.step));
  const int num_each_side =
      static_cast<int>(std::ceil(extent.across / strip.step)) + half_width_cells;
  strip.first_along = -extent.behind;
  strip.first_across = -num_each_side * strip.step;
  const cv::Size size(2 * num_each_side + 1,
                      static_cast<int>(std::ceil((extent.behind + extent.ahead) / strip.step)) + 1);
  strip.kind = cv::Mat1f(size);
  strip.shape = cv::Mat1f(size);
  strip.ground_top = cv::Mat1f(size);
  strip.obstacle_top = cv::Mat1f(size);
  strip.obstacle_sd = cv::Mat1f(size);
  const Eigen::Vector2d forward = DirectionOf(landing.heading);
  const Eigen::Vector2d right(forward.y(), -forward.x());
  for (int row = 0; row < size.height; ++row) {
    for (int col = 0; col < size.width; ++col) {
      const Eigen::Vector2d place = landing.touchdown_in_world.head<2>() +
                                    strip.Along(row) * forward +
                                    (strip.first_across + col * strip.step) * right;
      const StripCell cell = CellAt(ground, place, landing.touchdown_in_world.z());
      strip.kind(row, col) = cell.kind;
      strip.shape(row, col) = cell.shape;
      strip.ground_top(row, col) = cell.ground_top;
      strip.obstacle_top(row, col) = cell.obstacle_top;
      strip.obstacle_sd(row, col) = cell.obstacle_sd;
    }
  }
  strip.kind = MeanOf(strip.kind, half_width_cells);
  strip.shape = WidestOf(strip.shape, half_width_cells);
  strip.ground_top = WidestOf(strip.ground_top, half_width_cells);
  strip.obstacle_top = WidestOf(strip.obstacle_top, half_width_cells);
  strip.obstacle_sd = WidestOf(strip.obstacle_sd, half_width_cells);
  return strip;
}

}  // namespace freelsd
