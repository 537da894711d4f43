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

}  // namespace
}  // namespace freelsd
