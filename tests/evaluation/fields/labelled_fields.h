// Input: ground fit to land on by eye. Output: where an aircraft fits on it in a wind, by the
// outlines alone.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/flight/flight.h"
#include "tests/evaluation/fields/labelled_ground.h"
#include "tests/evaluation/fields/wind_plans.h"

namespace freelsd {

// Land of one id without the danger on it.
struct LabelledField {
  std::string id;
  double area_m2 = 0.0;
  // Farthest from the border and from danger, and that distance.
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double radius_m = 0.0;
  // In cells of the labelled ground.
  cv::Rect cells;
  cv::Mat1b mask;
  // Metres to the nearest cell that is not of the field; 0 outside.
  cv::Mat1f distance;
};

std::vector<LabelledField> FieldsOf(const LabelledGround& ground);

bool Contains(const LabelledField& field, const Grid& grid, const Eigen::Vector2d& place);

// Whether touchdown disc and ground roll fit into the wind, in calm air for any heading in steps of
// 10 degrees.
bool Fits(const LabelledField& field,
          const Grid& grid,
          const Aircraft& aircraft,
          const Eigen::Vector2d& wind_in_world);

}  // namespace freelsd
