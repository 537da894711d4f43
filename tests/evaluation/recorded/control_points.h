// Surveyed targets on the ground against adjusted cameras: truth from outside.
#pragma once

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
std::map<std::string, Eigen::Vector3d> PlacesOfTargets(const AdjustedBlock& block,
                                                       const std::vector<TargetSighting>& sightings);

// WGS84 from the grid by the seven parameters of the Ordnance Survey: within about 2 m.
GeoPoint GeoFromBritishGrid(const Eigen::Vector3d& target);

struct ControlErrors {
  // Targets seen in two views or more of the largest group: another group has a place of its own.
  int num_targets = 0;
  // Root mean squares, metres. Aligned: after the similarity that the other targets define.
  double aligned_horizontal_m = 0.0;
  double aligned_vertical_m = 0.0;
  // As georeferenced by the positions alone: the mean shift, and what remains without it.
  Eigen::Vector3d shift_in_world = Eigen::Vector3d::Zero();
  double georeferenced_horizontal_m = 0.0;
  double georeferenced_vertical_m = 0.0;
  // Of the map at all targets it covers, brought to them by the similarity of the sighted ones.
  int num_map_targets = 0;
  double map_vertical_m = 0.0;
  double map_largest_m = 0.0;
};

// Needs at least five targets; fewer give num_targets alone.
ControlErrors CompareWithTargets(const RecordedFlight& flight,
                                 const ElevationMap& map,
                                 const Targets& targets,
                                 const std::vector<TargetSighting>& sightings);

}  // namespace freelsd
