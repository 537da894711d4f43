#include <cmath>
#include <sstream>

#include "tests/api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr double kMaxPlaceErrorM = 1e-4;
const GeoPoint kOrigin{47.0, 8.0, 400.0};
constexpr char kCameras[] =
    "# Camera list with one line of data per camera:\n1 PINHOLE 640 480 500 501 320 240\n";

// w first or w last.
enum class Order { kWFirst, kWLast };

// Looks down at the reconstruction's (x, y), z = up, turned by a yaw: a half turn about the axis
// (c, s, 0), half the yaw from x, so (0, c, s, 0) w first; and t = -R C, where R v = 2 (a v) a - v.
std::string ImageLine(int id, double x, double y, double z, double yaw_deg, Order order) {
  const double c = std::cos(RadFromDeg(0.5 * yaw_deg)), s = std::sin(RadFromDeg(0.5 * yaw_deg));
  const double along = 2.0 * (c * x + s * y);
  std::ostringstream line;
  line.precision(12);
  line << id << " ";
  if (order == Order::kWFirst) line << "0 ";
  line << c << " " << s << " 0 ";
  if (order == Order::kWLast) line << "0 ";
  line << x - along * c << " " << y - along * s << " " << z << " 1 flight/" << id << ".jpg\n\n";
  return line.str();
}
std::string Images(Order order = Order::kWFirst) {
  return "# Image list with two lines of data per image:\n" + ImageLine(1, 0, 0, 3, 50, order) +
         ImageLine(2, 4, 0, 3, 100, order) + ImageLine(3, 0, 4, 3, 150, order) +
         ImageLine(4, 4, 4, 3.5, 200, order) + ImageLine(5, 2, 1, 3, 0, order);
}
// Ten times as large, and turned to the left by 90 deg: (x, y) lies at (-10 y, 10 x).
SideContext Geotags() {
  const LocalFrame frame(kOrigin);
  SideContext context;
  const std::vector<Eigen::Vector3d> places{{0, 0, 30}, {0, 40, 30}, {-40, 0, 30}, {-40, 40, 35}};
  for (size_t i = 0; i < places.size(); ++i) {
    FrameMeta meta;
    meta.position = frame.GeoFromWorld(places[i]);
    context.image_tags.emplace_back(std::to_string(i + 1) + ".jpg", meta);
  }
  return context;
}

TEST_CASE("colmap: camera from world, w first, scale and turn come from geotags") {
  const PoseFile file = PosesFromFiles(
      {{"sparse/cameras.txt", kCameras}, {"sparse/images.txt", Images()}}, Geotags());
  REQUIRE(file.poses.size() == 5);
  const FrameMeta& meta = MetaOf(file, "5.jpg");
  CheckPlace(meta, kOrigin, {-10, 20, 30}, kMaxPlaceErrorM);
  // Camera x was the reconstruction's x, which points north.
  CheckAxis(meta, {1, 0, 0}, {1, 0, 0});
  CheckAxis(meta, {0, 0, 1}, {0, 0, 1});
  CHECK(file.formats[1].name == "colmap-images");
  CHECK_FALSE(Warns(file, "QuaternionOrder"));
  CHECK_FALSE(Warns(file, "PoorFit"));
}

TEST_CASE("colmap: the centre of the top-left pixel is (0.5, 0.5), ours is (0, 0)") {
  const Camera camera = PosesFromFiles({{"cameras.txt", kCameras}}, {}).camera.value();
  CHECK(camera.fx_px == 500.0);
  CHECK(camera.fy_px == 501.0);
  CHECK(camera.cx_px == 319.5);
  CHECK(camera.cy_px == 239.5);
  const Camera radial =
      PosesFromFiles({{"cameras.txt", "1 SIMPLE_RADIAL 640 480 500 320 240 0.1"}}, {})
          .camera.value();
  CHECK(radial.fy_px == 500.0);
  CHECK(radial.coefficients == std::vector<double>{0.1, 0, 0, 0});
}

TEST_CASE("colmap: quaternions written w last are warned of by name") {
  CHECK(
      Warns(PosesFromFiles({{"images.txt", Images(Order::kWLast)}}, Geotags()), "QuaternionOrder"));
}

TEST_CASE("colmap: without three geotags off a line it is refused, not guessed") {
  CHECK(ErrorOfFiles({{"images.txt", Images()}}) == "422 InvalidPoses /poses");
  SideContext two = Geotags();
  two.image_tags.resize(2);
  CHECK(ErrorOfFiles({{"images.txt", Images()}}, two) == "422 InvalidPoses /poses");
  const std::string line = ImageLine(1, 0, 0, 3, 0, Order::kWFirst) +
                           ImageLine(2, 2, 0, 3, 0, Order::kWFirst) +
                           ImageLine(3, 4, 0, 3, 0, Order::kWFirst);
  CHECK(ErrorOfFiles({{"images.txt", line}}, Geotags()) == "422 InvalidPoses /poses");
}

TEST_CASE("colmap: what is malformed is refused at its line") {
  CHECK(ErrorOfFiles({{"cameras.txt", "1 FOV 640 480 1 2 3 4 5"}}) ==
        "422 InvalidPoses /poses/cameras.txt/1");
  CHECK(ErrorOfFiles({{"cameras.txt", "1 PINHOLE 640 480 1 2 3"}}) ==
        "422 InvalidPoses /poses/cameras.txt/1");
  CHECK(ErrorOfFiles({{"images.txt", "#\n1 2 0 0 0 0 0 0 1 a.jpg\n\n"}}) ==
        "422 InvalidPoses /poses/images.txt/2");
}

TEST_CASE("colmap: nearly equal cameras are one, unused ones none, different ones not mixed") {
  const auto read = [](const std::string& cameras, std::vector<int> camera_of) {
    std::string images = Images();
    for (size_t i = 0; i < camera_of.size(); ++i) {
      const std::string name = " flight/" + std::to_string(i + 1) + ".jpg";
      const size_t at = images.find(" 1" + name);
      images.replace(at, 2, " " + std::to_string(camera_of[i]));
    }
    return PosesFromFiles({{"cameras.txt", cameras}, {"images.txt", images}}, Geotags());
  };
  const std::string each =
      "1 PINHOLE 640 480 500 500 320 240\n2 PINHOLE 640 480 501 501 320 240\n"
      "3 PINHOLE 640 480 502 502 320 240\n";
  const PoseFile alike = read(each, {1, 2, 3, 1});
  CHECK(alike.poses.size() == 5);
  CHECK(alike.camera->fx_px == 500.0);
  CHECK(Warns(alike, "3 nearly equal cameras"));
  const PoseFile unused = read(each + "4 FOV 640 480 1 2 3 4 5\n", {1, 1, 1, 1});
  CHECK(unused.camera->fx_px == 500.0);
  CHECK(Warns(unused, "3 cameras of no photograph"));
  const PoseFile wide =
      read("1 PINHOLE 640 480 500 500 320 240\n2 PINHOLE 320 240 90 90 160 120\n", {1, 1, 1, 2});
  CHECK(wide.camera->width_px == 640);
  CHECK(Warns(wide, "the poses of 1 photographs of 1 other cameras are left out"));
  CHECK(
      ErrorOfFiles({{"cameras.txt",
                     "1 PINHOLE 640 480 500 500 320 240\n2 PINHOLE 640 480 900 900 320 240\n"}}) ==
      "422 InvalidPoses /poses/cameras.txt");
}

TEST_CASE("colmap: further models, names with blanks, no lines of points, files of rigs") {
  const auto camera = [](const std::string& line) {
    return PosesFromFiles({{"cameras.txt", line}}, {}).camera.value();
  };
  CHECK(camera("1 FULL_OPENCV 640 480 500 500 320 240 .1 .2 .01 .02 .3 0 0 0").coefficients ==
        std::vector<double>{.1, .2, .01, .02, .3});
  CHECK(camera("1 RADIAL_FISHEYE 640 480 500 320 240 .1 .2").coefficients ==
        std::vector<double>{.1, .2, 0, 0});
  std::string images = Images();
  for (size_t at; (at = images.find("\n\n")) != std::string::npos;) images.erase(at, 1);
  for (size_t at = 0; (at = images.find("flight/", at)) != std::string::npos; at += 7) {
    images.replace(at, 7, "my photo ");
  }
  SideContext context = Geotags();
  for (auto& [id, meta] : context.image_tags) id = "my_photo_" + id;
  const PoseFile file = PosesFromFiles(
      {{"images.txt", images}, {"rigs.txt", "# Rig calib list\n1 1\n"}, {"frames.txt", "1 1\n"}},
      context);
  CHECK(file.poses.size() == 5);
  CheckPlace(MetaOf(file, "my_photo_5.jpg"), kOrigin, {-10, 20, 30}, kMaxPlaceErrorM);
}

}  // namespace
}  // namespace freelsd
