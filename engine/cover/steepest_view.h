// Private to cover/. From which views the orthophoto is taken.
#pragma once

#include <optional>

#include <opencv2/core.hpp>

#include "engine/adjustment/adjustment.h"
#include "engine/terrain/terrain.h"

namespace freelsd {

// Image position of the corner (row, col) of the map's cells. Its height is that of the cell
// south-east of it.
std::optional<Eigen::Vector2d> ImageOfCorner(const ElevationMap& map,
                                             const Camera& camera,
                                             const Rigid3d& camera_from_world,
                                             double row,
                                             double col,
                                             float height);

// The connected view that looks down on each seen cell most steeply and shows all of it; -1 where
// none does. With `first` given, only views whose cameras are at least min_crossing_ratio of their
// height apart from that view's camera compete.
cv::Mat1i SteepestViews(const ElevationMap& map,
                        const AdjustedBlock& block,
                        const cv::Mat1i& first = {},
                        double min_crossing_ratio = 0.0);

}  // namespace freelsd
