#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/stored/stored.h"
#include "tests/api/errors.h"

namespace freelsd {
namespace {

constexpr double kMaxRotationErrorRad = 1e-9;
const double kHalf = std::sqrt(0.5);

std::string ErrorOfMeta(const std::string& text) {
  return ErrorOf([&text] { ParseFrameMeta(text); });
}

TEST_CASE("meta: every field arrives") {
  const FrameMeta meta = ParseFrameMeta(R"({"timestamp_us": 1479832354498032,
    "position": {"latitude_deg": 41.4, "longitude_deg": -81.6, "altitude_m": 347.7},
    "attitude": {"roll_deg": 0, "pitch_deg": 0, "yaw_deg": 450},
    "wind": {"east_mps": 3.5, "north_mps": -1}, "height_above_ground_m": 110,
    "position_sd_m": 2.3, "attitude_sd_deg": 1})");
  CHECK(meta.timestamp_us == 1479832354498032);
  CHECK(meta.position->longitude_deg == -81.6);
  CHECK(meta.wind_in_world == Eigen::Vector2d(3.5, -1));
  CHECK(meta.height_above_ground_m == 110.0);
  CHECK(meta.position_sd_m == 2.3);
  CHECK(meta.attitude_sd_deg == 1.0);
  // The contract's number: yaw 90 deg is [0.7071, 0, 0, 0.7071].
  const Eigen::Quaterniond expected(kHalf, 0, 0, kHalf);
  CHECK(AngleBetween(*meta.ned_from_body, expected) < kMaxRotationErrorRad);
}

TEST_CASE(
    "meta: a quaternion a little off its norm is normalised, and both signs are one attitude") {
  const FrameMeta a = ParseFrameMeta(R"({"attitude": {"quaternion_wxyz": [0.71, 0, 0, 0.71]}})");
  const FrameMeta b = ParseFrameMeta(R"({"attitude": {"quaternion_wxyz": [-0.71, 0, 0, -0.71]}})");
  CHECK(a.ned_from_body->norm() == doctest::Approx(1.0).epsilon(1e-12));
  CHECK(FrameMetaJson(a) == FrameMetaJson(b));
}

TEST_CASE("meta: empty and null are unknown") {
  CHECK(FrameMetaJson(ParseFrameMeta("{}")) == "{}");
  const char* const nulls =
      R"({"timestamp_us": null, "position": null, "attitude": null, "wind": null,
          "height_above_ground_m": null, "position_sd_m": null, "attitude_sd_deg": null})";
  CHECK(FrameMetaJson(ParseFrameMeta(nulls)) == "{}");
}

TEST_CASE("meta: what is wrong is refused where it is") {
  const std::string at = R"({"position": {"longitude_deg": 8, "altitude_m": 500, "latitude_deg": )";
  CHECK(ErrorOfMeta(at + "47}}") == "nothing");
  CHECK(ErrorOfMeta(at + "95}}") == "422 InvalidValue /position/latitude_deg");
  CHECK(ErrorOfMeta(at + "null}}") == "422 InvalidValue /position/latitude_deg");
  CHECK(ErrorOfMeta(at + "\"47\"}}") == "422 InvalidValue /position/latitude_deg");
  CHECK(ErrorOfMeta(at + "NaN}}") == "400 InvalidJson");
  CHECK(ErrorOfMeta(at + "1e999}}") == "400 InvalidJson");
  CHECK(ErrorOfMeta(at + "47, \"alt\": 3}}") == "422 UnknownKey /position/alt");
  CHECK(ErrorOfMeta(R"({"position": {"latitude_deg": 47, "longitude_deg": 8}})") ==
        "422 InvalidValue /position/altitude_m");
  CHECK(ErrorOfMeta(R"({"pos": 1})") == "422 UnknownKey /pos");
  CHECK(ErrorOfMeta(R"({"image": "a.jpg"})") == "422 UnknownKey /image");
  CHECK(ErrorOfMeta(R"({"timestamp_us": 1.5})") == "422 InvalidValue /timestamp_us");
  CHECK(ErrorOfMeta(R"({"timestamp_us": 1e300})") == "422 InvalidValue /timestamp_us");
  CHECK(ErrorOfMeta(R"({"timestamp_us": 18446744073709551615})") ==
        "422 InvalidValue /timestamp_us");
  CHECK(ErrorOfMeta(R"({"attitude": {"quaternion_wxyz": [0, 0, 0, 0]}})") ==
        "422 InvalidValue /attitude/quaternion_wxyz");
  CHECK(ErrorOfMeta(R"({"attitude": {"quaternion_wxyz": [1, 0, 0]}})") ==
        "422 InvalidValue /attitude/quaternion_wxyz");
  CHECK(ErrorOfMeta(R"({"attitude": {"quaternion_wxyz": [1, 0, 0, null]}})") ==
        "422 InvalidValue /attitude/quaternion_wxyz/3");
  CHECK(ErrorOfMeta(R"({"attitude": {"quaternion_wxyz": [1, 0, 0, 0], "yaw_deg": 3}})") ==
        "422 UnknownKey /attitude/yaw_deg");
  CHECK(ErrorOfMeta(R"({"attitude": {"yaw_deg": 3}})") == "422 InvalidValue /attitude/roll_deg");
  CHECK(ErrorOfMeta(R"({"wind": {"east_mps": 101, "north_mps": 0}})") ==
        "422 InvalidValue /wind/east_mps");
  CHECK(ErrorOfMeta(R"({"height_above_ground_m": 0})") ==
        "422 InvalidValue /height_above_ground_m");
  CHECK(ErrorOfMeta(R"({"position_sd_m": -1})") == "422 InvalidValue /position_sd_m");
  CHECK(ErrorOfMeta("[]") == "422 InvalidValue ");
}

TEST_CASE(
    "meta: the first one wins field by field, and a gimbal's tag never over a given attitude") {
  const FrameMeta given = ParseFrameMeta(R"({"attitude": {"roll_deg": 0, "pitch_deg": 0,
      "yaw_deg": 0}, "timestamp_us": 5})");
  FrameMeta tags = ParseFrameMeta(R"({"timestamp_us": 6, "position_sd_m": 4, "attitude_sd_deg": 8,
      "position": {"latitude_deg": 1, "longitude_deg": 2, "altitude_m": 3}})");
  tags.ned_from_camera = Eigen::Quaterniond::Identity();
  const FrameMeta merged = Merged(given, tags);
  CHECK(merged.timestamp_us == 5);
  CHECK(merged.position->altitude_m == 3.0);
  CHECK(merged.position_sd_m == 4.0);
  CHECK(merged.ned_from_body);
  CHECK_FALSE(merged.ned_from_camera);
  CHECK_FALSE(merged.attitude_sd_deg);
  CHECK(Merged({}, tags).ned_from_camera);
}

struct Scene {
  Rig rig;
  LocalFrame local_frame{GeoPoint{47.0, 8.0, 400.0}};
  cv::Mat image = cv::Mat(6, 8, CV_8UC3, cv::Scalar(0, 0, 0));
  FrameMeta meta;

  Scene() {
    rig.camera.width_px = 8;
    rig.camera.height_px = 6;
    meta.position = GeoPoint{47.0, 8.0, 500.0};
  }
  Frame Make() const { return MakeFrame("f", image, meta, rig, local_frame, 77); }
};

TEST_CASE("frame: nose east with the wings level") {
  Scene scene;
  scene.meta.ned_from_body = Eigen::Quaterniond(kHalf, 0, 0, kHalf);
  const Frame frame = scene.Make();
  REQUIRE(frame.prior.world_from_body);
  const Eigen::Vector3d nose = *frame.prior.world_from_body * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d belly = *frame.prior.world_from_body * Eigen::Vector3d::UnitZ();
  CHECK((nose - Eigen::Vector3d(1, 0, 0)).norm() < kMaxRotationErrorRad);
  CHECK((belly - Eigen::Vector3d(0, 0, -1)).norm() < kMaxRotationErrorRad);
  CHECK((frame.prior.position_in_world - Eigen::Vector3d(0, 0, 100)).norm() < 1e-6);
  CHECK(frame.timestamp_us == 77);
}

TEST_CASE("frame: a camera attitude goes through the mount, whatever the mount is") {
  Scene scene;
  // Camera straight down, image top east; its axes in north, east, down.
  Eigen::Matrix3d axes;
  axes.col(0) = Eigen::Vector3d(-1, 0, 0);  // south
  axes.col(1) = Eigen::Vector3d(0, -1, 0);  // west
  axes.col(2) = Eigen::Vector3d(0, 0, 1);   // down
  scene.meta.ned_from_camera = Eigen::Quaterniond(axes);
  const Frame frame = scene.Make();
  // Default mount: image top towards the nose, so the nose is east.
  const Eigen::Vector3d nose = *frame.prior.world_from_body * Eigen::Vector3d::UnitX();
  CHECK((nose - Eigen::Vector3d(1, 0, 0)).norm() < kMaxRotationErrorRad);
  scene.rig.body_from_camera.rotation = Eigen::Quaterniond(0.5, 0.1, -0.3, 0.7).normalized();
  const Eigen::Quaterniond world_from_camera =
      *scene.Make().prior.world_from_body * scene.rig.body_from_camera.rotation;
  const Eigen::Vector3d axis = world_from_camera * Eigen::Vector3d::UnitZ();
  CHECK((axis - Eigen::Vector3d(0, 0, -1)).norm() < kMaxRotationErrorRad);
}

TEST_CASE("frame: without position there is none, and an image of another size is refused") {
  Scene scene;
  scene.rig.camera.width_px = 9;
  CHECK(ErrorOf([&] { scene.Make(); }) == "422 ImageSizeMismatch");
  scene.meta.position.reset();
  CHECK(ErrorOf([&] { scene.Make(); }) == "422 NoPosition");
}

TEST_CASE("frame: without attitude it stays unknown") {
  CHECK_FALSE(Scene().Make().prior.world_from_body);
}

}  // namespace
}  // namespace freelsd
