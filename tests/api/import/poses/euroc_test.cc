#include <cmath>

#include "tests/api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr double kMaxPlaceErrorM = 1e-5;
const GeoPoint kOrigin{47.0, 8.0, 400.0};

// The camera looks against the body's z, which points up: points of the sensor to points of the
// body.
constexpr char kSensor[] = R"(#Default imu sensor yaml file
sensor_type: camera
comment: VI-Sensor cam0 (MT9M034)
T_BS:
  cols: 4
  rows: 4
  data: [1.0, 0.0, 0.0, 0.1,
         0.0, -1.0, 0.0, 0.2,
         0.0, 0.0, -1.0, -0.3,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 20
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.654, 457.296, 367.215, 248.375] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
)";
// The same transform, the other way.
constexpr char kCamchain[] = R"(cam0:
  T_cam_imu:
  - [1.0, 0.0, 0.0, -0.1]
  - [0.0, -1.0, 0.0, 0.2]
  - [0.0, 0.0, -1.0, -0.3]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_model: none
  intrinsics: [458.654, 457.296, 367.215, 248.375]
  resolution: [752, 480]
)";
constexpr char kImages[] =
    "#timestamp [ns],filename\r\n1500000000,1500000000.png\r\n9000000000,9000000000.png\r\n";
// A quarter turn to the left within a second. w first.
constexpr char kGroundTruth[] =
    "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z "
    "[]\n1000000000,10,20,50,1,0,0,0,0.5\n2000000000,20,20,50,0.70710678,0,0,0.70710678,0.5\n";

std::vector<SideFile> Folder() {
  return {{"mav0/cam0/data.csv", kImages},
          {"mav0/cam0/sensor.yaml", kSensor},
          {"mav0/imu0/data.csv", "#timestamp [ns],w_RS_S_x [rad s^-1]\n1,2\n"},
          {"mav0/imu0/sensor.yaml", "sensor_type: imu\nT_BS:\n  rows: 4\n"},
          {"mav0/state_groundtruth_estimate0/data.csv", kGroundTruth}};
}

SideContext WithOrigin() {
  SideContext context;
  context.origin = kOrigin;
  return context;
}

void CheckMiddle(const PoseFile& file) {
  const FrameMeta& meta = MetaOf(file, "1500000000.png");
  // Half way, turned by 45 deg: (0.1, 0.2) becomes (-0.0707107, 0.2121320).
  CheckPlace(meta, kOrigin, {14.9292893, 20.2121320, 49.7}, kMaxPlaceErrorM);
  CheckAxis(meta, {1, 0, 0}, {std::sqrt(0.5), std::sqrt(0.5), 0});
  CheckAxis(meta, {0, 0, 1}, {0, 0, 1});
  CHECK(meta.timestamp_us == 1500000);
}

TEST_CASE("euroc: T_BS is body from sensor, quaternions are w first, times are nanoseconds") {
  const PoseFile file = PosesFromFiles(Folder(), WithOrigin());
  CHECK(file.poses.size() == 1);
  CheckMiddle(file);
  CHECK(file.camera->fx_px == 458.654);
  CHECK(file.camera->width_px == 752);
  CHECK(Warns(file, "1 images lie outside"));
  CHECK(Warns(file, "east, north, up"));
  CHECK(file.formats[0].name == "euroc-images");
  CHECK(file.formats[4].name == "euroc-ground-truth");
}

TEST_CASE("euroc with a Kalibr camchain: T_cam_imu is the other way round") {
  const PoseFile file = PosesFromFiles(
      {{"camchain.yaml", kCamchain}, {"data.csv", kImages}, {"truth.csv", kGroundTruth}},
      WithOrigin());
  CheckMiddle(file);
}

TEST_CASE("euroc: without data.csv the images' names are their times") {
  SideContext context = WithOrigin();
  context.image_tags = {{"1500000000.png", {}}, {"readme.png", {}}};
  CheckMiddle(PosesFromFiles({{"sensor.yaml", kSensor}, {"truth.csv", kGroundTruth}}, context));
}

TEST_CASE("euroc: what is missing is said") {
  CHECK(ErrorOfFiles(Folder()) == "422 InvalidPoses /poses");
  CHECK(ErrorOfFiles({{"data.csv", kImages}, {"truth.csv", kGroundTruth}}, WithOrigin()) ==
        "422 InvalidPoses /poses");
  CHECK(ErrorOfFiles({{"data.csv", "#timestamp [ns],filename\n1.5,a.png\n"}}) ==
        "422 InvalidPoses /poses/data.csv/2");
}

}  // namespace
}  // namespace freelsd
