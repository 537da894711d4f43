// What the tests of files beside images share.
#pragma once

#include <algorithm>

#include <doctest/doctest.h>

#include "api/import/poses/poses.h"
#include "tests/api/errors.h"

namespace freelsd {

inline bool Warns(const PoseFile& file, const std::string& part) {
  return std::any_of(file.warnings.begin(), file.warnings.end(), [&part](const auto& warning) {
    return warning.find(part) != std::string::npos;
  });
}

inline const FrameMeta& MetaOf(const PoseFile& file, const std::string& id) {
  for (const auto& [image_id, meta] : file.poses) {
    if (image_id == id) return meta;
  }
  FAIL("no pose for " << id);
  throw std::out_of_range(id);
}

// Of a camera's axis, north, east, down.
inline void CheckAxis(const FrameMeta& meta,
                      const Eigen::Vector3d& axis_in_camera,
                      const Eigen::Vector3d& expected_in_ned) {
  constexpr double kMaxAxisError = 1e-6;
  REQUIRE(meta.ned_from_camera.has_value());
  CHECK((*meta.ned_from_camera * axis_in_camera - expected_in_ned).norm() < kMaxAxisError);
}

inline void CheckPlace(const FrameMeta& meta,
                       const GeoPoint& origin,
                       const Eigen::Vector3d& expected_in_world,
                       double max_error_m) {
  REQUIRE(meta.position.has_value());
  const Eigen::Vector3d place = LocalFrame(origin).WorldFromGeo(*meta.position);
  CHECK((place - expected_in_world).norm() < max_error_m);
}

inline std::string ErrorOfFiles(const std::vector<SideFile>& files,
                                const SideContext& context = {}) {
  return ErrorOf([&] { PosesFromFiles(files, context); });
}

}  // namespace freelsd
