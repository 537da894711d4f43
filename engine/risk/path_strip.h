// Private to risk/: the cells of a map along and across a final.
#pragma once

#include "engine/risk/risk.h"

namespace freelsd {

// Extent of a strip, metres from touchdown; `across` to each side.
struct StripExtent {
  double behind = 0.0;
  double ahead = 0.0;
  double across = 0.0;
};

// Row i lies FirstAlong() + i * step along the heading from touchdown. Column j lies j steps right
// of the left edge. Each value is over the width of the aircraft's path, centred on its column.
struct PathStrip {
  double step = 1.0;
  double first_along = 0.0;
  double first_across = 0.0;
  // Mean risk of the kind, largest risk of the shape.
  cv::Mat1f kind;
  cv::Mat1f shape;
  // Highest point above touchdown of ground that is probably fit to land on, and of everything
  // else with its deviation. Very low where there is none.
  cv::Mat1f ground_top;
  cv::Mat1f obstacle_top;
  cv::Mat1f obstacle_sd;

  int RowAt(double along) const;
  int ColAt(double across) const;
  double Along(int row) const { return first_along + row * step; }
};

// What a landing is planned on.
struct RiskGround {
  const ElevationMap& map;
  const HazardLayers& layers;
  Aircraft aircraft;

  std::optional<CellRisk> At(const Eigen::Vector2d& place_in_world) const;
};

PathStrip MakePathStrip(const RiskGround& ground,
                        const PlannedLanding& landing,
                        const StripExtent& extent);

}  // namespace freelsd
