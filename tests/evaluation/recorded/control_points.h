// Surveyed targets on the ground against adjusted cameras: truth from outside.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "tests/evaluation/recorded/recorded_flight.h"

namespace freelsd {

// Place in the British National Grid (EPSG:27700) and height above the sea, metres.
using Targets = std::map<std::string, Eigen::Vector3d>;

struct TargetSighting {
  std::string frame_id;
  std::string target;
  Eigen::Vector2d point_in_image = Eigen::Vector2d::Zero();
};

// Tables with a line of headings: name, easting, northing, height, ...; image, name, x, y. Throws
// std::runtime_error when they cannot be read.
Targets ReadTargets(const std::string& path);
std::vector<TargetSighting> ReadSightings(const std::string& path);

// Where the views of the largest group triangulate the targets that two or more of them show.
std::map<std::string, Eigen::Vector3d> PlacesOfTargets(
    const AdjustedBlock& block, const std::vector<TargetSighting>& sightings);

// WGS84 from the grid by the seven parameters of the Ordnance Survey: within about 2 m.
GeoPoint GeoFromBritishGrid(const Eigen::Vector3d& target);

// Heights of a map at targets.
struct HeightChecks {
  int num_targets = 0;
  // Where the map has a height. The others count only them; NaN without any.
  int num_known = 0;
  double rms_m = std::numeric_limits<double>::quiet_NaN();
  double largest_m = std::numeric_limits<double>::quiet_NaN();
  // Farther off than three of the deviations that the map states there.
  int num_beyond = 0;
};

struct ControlErrors {
  // Targets seen in two views or more of the largest group: another group has a place of its own.
  int num_targets = 0;
  // Root mean squares and largest, metres. Aligned: after the similarity that the other targets
  // define.
  double aligned_horizontal_m = 0.0;
  double aligned_vertical_m = 0.0;
  double largest_horizontal_m = 0.0;
  double largest_vertical_m = 0.0;
  // As georeferenced by the positions alone: the mean shift, and what remains without it.
  Eigen::Vector3d shift_in_world = Eigen::Vector3d::Zero();
  double georeferenced_horizontal_m = 0.0;
  double georeferenced_vertical_m = 0.0;
  // The map at all targets, brought to them by the similarity of those seen twice.
  HeightChecks map;
  // At those seen twice, each by the similarity of the others.
  HeightChecks map_seen_twice;
  // At those sighted in the largest group that are not triangulated, mostly because one view shows
  // them.
  HeightChecks map_seen_once;
};

// Needs at least five targets; fewer give num_targets alone.
ControlErrors CompareWithTargets(const RecordedFlight& flight,
                                 const ElevationMap& map,
                                 const Targets& targets,
                                 const std::vector<TargetSighting>& sightings);

}  // namespace freelsd
