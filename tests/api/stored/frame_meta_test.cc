#include <doctest/doctest.h>

#include "api/stored/stored.h"

namespace freelsd {
namespace {

TEST_CASE("meta: the stored form is a fixed point, camera attitude included") {
  FrameMeta meta = ParseFrameMeta(R"({"timestamp_us": 3, "attitude":
      {"roll_deg": 12.3, "pitch_deg": -4.56, "yaw_deg": -78.9}, "wind": {"east_mps": 0.1,
      "north_mps": 0.2}, "position": {"latitude_deg": 1.1, "longitude_deg": 2.2, "altitude_m": 3}})");
  meta.ned_from_camera = Eigen::Quaterniond(0.1, 0.2, 0.3, 0.4).normalized();
  const std::string stored = FrameMetaJson(meta);
  CHECK(FrameMetaJson(ParseStoredFrameMeta(stored)) == stored);
  CHECK(ParseStoredFrameMeta(stored).ned_from_camera->z() == meta.ned_from_camera->z());
}

TEST_CASE("meta: a row's pose is the resolved one, else what was sent over the image's tags") {
  const std::string sent = R"({"timestamp_us": 3})";
  const std::string tags = R"({"timestamp_us": 4, "height_above_ground_m": 50})";
  const FrameMeta known = ParseStoredPose("", sent, tags);
  CHECK(known.timestamp_us == 3);
  CHECK(known.height_above_ground_m == 50.0);
  CHECK(ParseStoredPose(R"({"timestamp_us": 5})", sent, tags).timestamp_us == 5);
}

}  // namespace
}  // namespace freelsd
