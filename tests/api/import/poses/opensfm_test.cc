#include "tests/api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr double kMaxPlaceErrorM = 1e-5;

// A half turn about x as axis times angle; t = -R C with C = (10, 20, 30).
constexpr char kReconstruction[] = R"([{
  "cameras": {"v2 canon 4000 3000 brown": {"projection_type": "brown", "width": 4000,
    "height": 3000, "focal_x": 0.5, "focal_y": 0.51, "c_x": 0.01, "c_y": -0.02, "k1": -0.1,
    "k2": 0.02, "p1": 0.001, "p2": 0.002, "k3": 0.003}},
  "shots": {"a.jpg": {"rotation": [3.14159265358979, 0, 0], "translation": [-10, 20, 30],
    "camera": "v2 canon 4000 3000 brown"}},
  "points": {}}])";
constexpr char kReference[] = R"({"latitude": 47.0, "longitude": 8.0, "altitude": 400.0})";

TEST_CASE("opensfm: axis times angle from the world to the camera, about the reference") {
  const PoseFile file = PosesFromFiles(
      {{"opensfm/reconstruction.json", kReconstruction}, {"reference_lla.json", kReference}}, {});
  const FrameMeta& meta = MetaOf(file, "a.jpg");
  CheckPlace(meta, {47.0, 8.0, 400.0}, {10, 20, 30}, kMaxPlaceErrorM);
  CheckAxis(meta, {1, 0, 0}, {0, 1, 0});
  CheckAxis(meta, {0, 0, 1}, {0, 0, 1});
  CHECK(file.formats[0].name == "opensfm");
  CHECK(file.formats[1].name == "opensfm-reference");
}

TEST_CASE("opensfm: lengths of the camera are in the image's longer side, from its centre") {
  const Camera camera =
      PosesFromFiles({{"r.json", kReconstruction}, {"l.json", kReference}}, {}).camera.value();
  CHECK(camera.fx_px == doctest::Approx(2000.0));
  CHECK(camera.fy_px == doctest::Approx(2040.0));
  CHECK(camera.cx_px == doctest::Approx(2039.5));
  CHECK(camera.cy_px == doctest::Approx(1419.5));
  CHECK(camera.coefficients == std::vector<double>{-0.1, 0.02, 0.001, 0.002, 0.003});
}

TEST_CASE("opensfm: numbers that overflow on their way to the earth are refused, not carried on") {
  for (const char* const shot :
       {R"({"rotation": [1e307, 0.2, 3.0], "translation": [1, 2, 3], "camera": "c"})",
        R"({"rotation": [0.1, 0.2, 3.0], "translation": [1e308, 1e308, 3], "camera": "c"})"}) {
    const std::string text =
        R"([{"cameras": {"c": {"projection_type": "perspective", "width": 400, "height": 300,
          "focal": 0.6, "k1": 0, "k2": 0}}, "shots": {"a.jpg": )" +
        std::string(shot) + "}}]";
    CHECK(ErrorOfFiles({{"r.json", text}, {"l.json", kReference}}) == "422 InvalidPoses /poses");
  }
}

TEST_CASE("opensfm: OpenDroneMap's cameras.json is a calibration, an unused camera is none") {
  const std::string brown =
      R"({"dji 376 240 brown 0.61": {"projection_type": "brown", "width": 376, "height": 240,
        "focal_x": 0.618, "focal_y": 0.618, "c_x": 0, "c_y": 0, "k1": 0.01}})";
  const PoseFile odm =
      PosesFromFiles({{"cameras.json", brown}, {"geo.txt", "EPSG:4326\na.jpg 8 47 5\n"}}, {});
  CHECK(odm.camera->fx_px == doctest::Approx(0.618 * 376));
  CHECK(odm.poses.size() == 1);
  std::string unused = kReconstruction;
  unused.insert(unused.find("\"v2 canon"),
                R"("old": {"projection_type": "spherical", "width": 10, "height": 5}, )");
  const PoseFile file = PosesFromFiles({{"r.json", unused}, {"l.json", kReference}}, {});
  CHECK(file.camera->width_px == 4000);
  CHECK(Warns(file, "1 cameras of no photograph"));
  // The largest of several reconstructions.
  const PoseFile largest = PosesFromFiles(
      {{"r.json", R"([{"cameras": {}, "shots": {}}, )" + std::string(kReconstruction).substr(1)},
       {"l.json", kReference}},
      {});
  CHECK(largest.poses.size() == 1);
}

TEST_CASE("opensfm: what is missing is said") {
  CHECK(ErrorOfFiles({{"r.json", kReconstruction}}) == "422 InvalidPoses /poses");
  CHECK(ErrorOfFiles({{"r.json", R"([{"cameras": {}}])"}}) == "422 InvalidPoses /poses/r.json");
  CHECK(ErrorOfFiles({{"r.json", R"([{"cameras": {}, "shots": {"a": {"rotation": [1, 2]}}}])"}}) ==
        "422 InvalidPoses /poses/r.json");
  CHECK(ErrorOfFiles({{"r.json", R"([{"cameras": )"}}) == "422 InvalidPoses /poses/r.json");
  // Others' JSON lies in such folders too.
  CHECK(ErrorOfFiles({{"log.json", R"({"a": 1})"}}) == "nothing");
}

}  // namespace
}  // namespace freelsd
