// What other programs make of our files: their readers are run where they are installed, and the
// geometry of QGroundControl is written down again.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {

bool IsInstalled(const std::string& program);
// A file in the temporary folder, removed at the end.
class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& bytes);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};
// What a command writes; nothing when it fails.
std::optional<std::string> OutputOf(const std::string& command);

// Metres and degrees between two places of one format, or of two. Between: of their feet on the
// ellipsoid. In space: as one flies it, which 3000 m up is 0.05 % more.
double MetresBetween(const GeoPoint& a, const GeoPoint& b);
double MetresInSpace(const GeoPoint& a, const GeoPoint& b);
double DegreesBetween(double a_deg, double b_deg);

// What QGroundControl shows of a landing pattern: on a sphere, heading and length of the tangent
// through the landing place, and the glide slope.
struct LandingPattern {
  GeoPoint land;
  GeoPoint loiter_center;
  double loiter_radius_m = 0.0;
  bool is_clockwise = false;
  double heading_deg = 0.0;
  double distance_m = 0.0;
  double glide_slope_deg = 0.0;
};
LandingPattern ReadPlan(const std::string& plan);

// Rows of text split at a separator; double quotes hold it together.
std::vector<std::vector<std::string>> SplitRows(const std::string& text, char separator);

}  // namespace freelsd
