#include "tests/api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr char kKalibr[] = R"(cam0:
  T_cam_imu:
  - [1.0, 0.0, 0.0, -0.1]
  - [0.0, -1.0, 0.0, 0.2]
  - [0.0, 0.0, -1.0, -0.3]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 1.9e-4, 1.8e-05]
  distortion_model: radtan
  intrinsics: [461.629, 460.152, 362.680, 246.049]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
)";
constexpr char kCameraInfo[] = R"(image_width: 640
image_height: 480
camera_name: narrow
camera_matrix:
  rows: 3
  cols: 3
  data: [500.5, 0, 320.25,
         0, 501.5, 240.75,
         0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.1, 0.01, 0.001, 0.002, 0.0003]
)";

Camera CameraIn(const std::string& text) {
  return PosesFromFiles({{"camera.yaml", text}}, {}).camera.value();
}
std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  REQUIRE(text.find(from) != std::string::npos);
  return text.replace(text.find(from), from.size(), to);
}
std::string ErrorOfYaml(const std::string& text) { return ErrorOfFiles({{"c.yaml", text}}); }

TEST_CASE("kalibr: resolution is width first, radtan is k1, k2, p1, p2") {
  const Camera camera = CameraIn(kKalibr);
  CHECK(camera.width_px == 752);
  CHECK(camera.height_px == 480);
  CHECK(camera.fx_px == 461.629);
  CHECK(camera.cy_px == 246.049);
  CHECK(camera.distortion == DistortionModel::kRadTan);
  CHECK(camera.coefficients == std::vector<double>{-0.28, 0.07, 1.9e-4, 1.8e-5});
}

TEST_CASE("kalibr: equidistant and none, another model is refused by name") {
  CHECK(CameraIn(Replaced(kKalibr, "radtan", "equidistant")).distortion ==
        DistortionModel::kEquidistant);
  CHECK(CameraIn(Replaced(kKalibr, "radtan", "none")).distortion == DistortionModel::kNone);
  CHECK(ErrorOfYaml(Replaced(kKalibr, "radtan", "fov")) == "422 InvalidPoses /poses/c.yaml");
  CHECK(ErrorOfYaml(Replaced(kKalibr, "pinhole", "omni")) == "422 InvalidPoses /poses/c.yaml");
}

TEST_CASE("camera_info: the matrix row after row, plumb_bob is k1, k2, p1, p2, k3") {
  const Camera camera = CameraIn(kCameraInfo);
  CHECK(camera.width_px == 640);
  CHECK(camera.fx_px == 500.5);
  CHECK(camera.fy_px == 501.5);
  CHECK(camera.cx_px == 320.25);
  CHECK(camera.cy_px == 240.75);
  CHECK(camera.coefficients == std::vector<double>{-0.1, 0.01, 0.001, 0.002, 0.0003});
  CHECK(ErrorOfYaml(Replaced(Replaced(kCameraInfo, "plumb_bob", "rational_polynomial"),
                             "0.0003]",
                             "0.0003, 0.1, 0, 0]")) == "422 InvalidPoses /poses/c.yaml");
  CHECK(CameraIn(Replaced(Replaced(kCameraInfo, "plumb_bob", "rational_polynomial"),
                          "0.0003]",
                          "0.0003, 0, 0, 0]"))
            .coefficients.size() == 5);
}

TEST_CASE("cameras: two that differ are refused, the same twice is one") {
  CHECK(ErrorOfFiles({{"a.yaml", kKalibr}, {"b.yaml", kCameraInfo}}) ==
        "422 InvalidPoses /poses/b.yaml");
  CHECK(ErrorOfFiles({{"a.yaml", kKalibr}, {"b.yaml", kKalibr}}) == "nothing");
}

}  // namespace
}  // namespace freelsd
