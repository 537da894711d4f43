// Private to export/. The numbers of a layer as they leave the house.
#pragma once

#include <string>

#include "api/export/export.h"

namespace freelsd {

// The layer in its unit for people (slope in degrees), NaN where unseen. `hazard` has the values of
// Hazard and no NaN; `grass` is 1 where it counts as grass, else 0. Elevation is world z.
// Throws std::invalid_argument for a name that is no layer.
cv::Mat1f LayerValues(const SiteMap& site_map, const std::string& name);

// Altitude of world z = 0 at a place: the plane is tangent to a curved earth.
double AltitudeOfPlane(const Eigen::Vector2d& place_in_world, const LocalFrame& local_frame);

// Outer corners of the grid in world, from the north-west clockwise.
std::vector<Eigen::Vector2d> OuterCorners(const Grid& grid);

}  // namespace freelsd
