#include "tests/evaluation/fields/labelled_fields.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Between touchdowns that are tried, and between samples of the ground roll.
constexpr double kTrySpacingM = 1.0;
constexpr double kRollSpacingM = 0.5;
constexpr double kCalmMps = 0.5;
constexpr int kNumCalmHeadings = 36;

cv::Mat1f DistanceWithin(const cv::Mat1b& mask) {
  cv::Mat1b framed;
  cv::copyMakeBorder(mask, framed, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::Mat1f cells;
  cv::distanceTransform(framed, cells, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return cells(cv::Rect(1, 1, mask.cols, mask.rows)).clone();
}

bool IsRollFree(const LabelledField& field,
                const Grid& grid,
                const Aircraft& aircraft,
                const Eigen::Vector2d& touchdown,
                const Eigen::Vector2d& forward) {
  const Eigen::Vector2d across(forward.y(), -forward.x());
  const double half = aircraft.path_half_width_m;
  for (double along = 0.0; along <= aircraft.ground_roll_m; along += kRollSpacingM) {
    for (double side = -half; side <= half; side += kRollSpacingM) {
      if (!Contains(field, grid, touchdown + along * forward + side * across)) return false;
    }
  }
  return true;
}

std::vector<Eigen::Vector2d> DirectionsInto(const Eigen::Vector2d& wind_in_world) {
  if (wind_in_world.norm() >= kCalmMps) return {-wind_in_world.normalized()};
  std::vector<Eigen::Vector2d> directions;
  directions.reserve(kNumCalmHeadings);
  for (int i = 0; i < kNumCalmHeadings; ++i) {
    directions.push_back(DirectionOf(2.0 * kPi * i / kNumCalmHeadings));
  }
  return directions;
}

LabelledField FieldOf(const LabelledObject& object, const LabelledGround& ground) {
  LabelledField field;
  field.id = object.id;
  field.cells = object.cells;
  if (field.cells.empty()) return field;
  field.mask = ground.free_land(object.cells) & object.mask;
  const double cell_size = ground.grid.cell_size_m;
  field.area_m2 = cv::countNonZero(field.mask) * cell_size * cell_size;
  field.distance = DistanceWithin(field.mask) * cell_size;
  cv::Point deepest;
  cv::minMaxLoc(field.distance, nullptr, &field.radius_m, nullptr, &deepest);
  field.middle = ground.grid.CellCenter(field.cells.y + deepest.y, field.cells.x + deepest.x);
  return field;
}

}  // namespace

std::vector<LabelledField> FieldsOf(const LabelledGround& ground) {
  std::vector<LabelledField> fields;
  for (const LabelledObject& object : ground.objects) {
    if (object.kind == OutlineKind::kLand) fields.push_back(FieldOf(object, ground));
  }
  return fields;
}

bool Contains(const LabelledField& field, const Grid& grid, const Eigen::Vector2d& place) {
  const auto cell = grid.CellAt(place);
  return cell && field.cells.contains(*cell) && field.mask(*cell - field.cells.tl()) != 0;
}

bool Fits(const LabelledField& field,
          const Grid& grid,
          const Aircraft& aircraft,
          const Eigen::Vector2d& wind_in_world) {
  const std::vector<Eigen::Vector2d> directions = DirectionsInto(wind_in_world);
  const int step = std::max(1, static_cast<int>(kTrySpacingM / grid.cell_size_m));
  for (int row = 0; row < field.mask.rows; row += step) {
    for (int col = 0; col < field.mask.cols; col += step) {
      if (field.distance(row, col) < aircraft.touchdown_uncertainty_m) continue;
      const Eigen::Vector2d place = grid.CellCenter(field.cells.y + row, field.cells.x + col);
      if (std::any_of(directions.begin(), directions.end(), [&](const Eigen::Vector2d& forward) {
            return IsRollFree(field, grid, aircraft, place, forward);
          })) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace freelsd
