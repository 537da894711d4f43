#include "engine/geometry/geometry.h"

#include <cmath>
#include <functional>
#include <stdexcept>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

Camera WideCamera() {
  Camera camera;
  camera.width_px = 1600;
  camera.height_px = 1200;
  camera.fx_px = camera.fy_px = 900.0;
  camera.cx_px = 801.0;
  camera.cy_px = 597.0;
  camera.distortion = DistortionModel::kRadTan;
  camera.coefficients = {-0.25, 0.07, 0.0004, -0.0003, 0.002};
  return camera;
}

// Where a camera that turns and flies on during its readout sees a point: the row that is read when
// the point's image is on it, found by iteration.
Eigen::Vector2d SeenWhileMoving(const Camera& camera,
                                const Eigen::Vector3d& point,
                                const Eigen::Vector3d& turn,
                                const Eigen::Vector3d& way) {
  Eigen::Vector2d pixel(camera.cx_px, camera.cy_px);
  for (int i = 0; i < 50; ++i) {
    const double share = (pixel.y() - camera.cy_px) / camera.height_px;
    // Half a turn vector is the tangent of half the angle, along the axis.
    const Eigen::Vector3d half = -0.5 * share * turn;
    const Eigen::Quaterniond turned =
        Eigen::Quaterniond(1.0, half.x(), half.y(), half.z()).normalized();
    pixel = *camera.ImageFromCamera(turned * (point - share * way));
  }
  return pixel;
}

TEST_CASE(
    "camera: a rolling shutter sees what a turning camera sees, and flight as a turn nearly") {
  Camera camera = WideCamera();
  const double depth = 100.0;
  const Eigen::Vector3d turn(RadFromDeg(0.5), RadFromDeg(2.0), RadFromDeg(1.0)),
      way(0.0, -1.5, 0.0);
  const Eigen::Vector3d flight_as_turn(1.5 / depth, 0.0, 0.0);
  constexpr double kMaxTurnErrorPx = 1e-6;
  constexpr double kMaxFlightErrorPx = 3.0;  // of up to 8 px of flight: a turn bends the image too
  double largest_px = 0.0;
  for (const double x : {-60.0, 0.0, 60.0}) {
    for (const double y : {-45.0, 5.0, 45.0}) {
      const Eigen::Vector3d point(x, y, depth);
      const Eigen::Vector2d turned = SeenWhileMoving(camera, point, turn, Eigen::Vector3d::Zero());
      CHECK((*camera.With(Readout::Turning(turn)).ImageFromCamera(point) - turned).norm() <
            kMaxTurnErrorPx);
      const Eigen::Vector2d flown = SeenWhileMoving(camera, point, turn, way);
      const Camera both = camera.With(Readout::Turning(turn + flight_as_turn));
      CHECK((*both.ImageFromCamera(point) - flown).norm() < kMaxFlightErrorPx);
      largest_px = std::max(largest_px, (*camera.ImageFromCamera(point) - flown).norm());
    }
  }
  CHECK(largest_px > 3.0 * kMaxFlightErrorPx);
  // At the last row, half an image below the middle: half of the even turn and a quarter of the
  // rest.
  const Readout uneven = Readout::Turning({0.02, 0.0, 0.0}, {0.04, 0.0, 0.0});
  CHECK(uneven.TurnAt(0.5).x() == doctest::Approx(0.02));
  CHECK(uneven.TurnAt(-0.5).x() == doctest::Approx(0.0));
}

TEST_CASE(
    "camera: a pixel's ray leads back to it through a rolling shutter, also at another size") {
  const Camera camera = WideCamera().With(Readout::Turning({0.02, -0.03, 0.04}));
  for (const double factor : {1.0, 0.5}) {
    const Camera scaled = camera.Scaled(factor);
    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(30.0, 20.0), Eigen::Vector2d(1500.0, 1100.0)}) {
      const Eigen::Vector2d there = factor * pixel;
      const auto back = scaled.ImageFromCamera(scaled.RayFromImage(there));
      REQUIRE(back);
      CHECK((*back - there).norm() < 1e-6);
    }
  }
}

TEST_CASE("rigid3: yaw 90 deg is the quaternion of the contract, and the nose points east") {
  const Eigen::Quaterniond ned_from_body = NedFromBody({.roll = 0.0, .pitch = 0.0, .yaw = kPi / 2});
  CHECK(std::abs(ned_from_body.w()) == doctest::Approx(0.7071).epsilon(1e-4));
  CHECK(std::abs(ned_from_body.z()) == doctest::Approx(0.7071).epsilon(1e-4));
  const Eigen::Vector3d nose = WorldFromNed() * ned_from_body * Eigen::Vector3d::UnitX();
  CHECK((nose - Eigen::Vector3d(1, 0, 0)).norm() < 1e-12);
}

TEST_CASE("rigid3: Euler angles survive the round trip, negative and large yaw are wrapped") {
  const EulerAngles attitude{.roll = 0.2, .pitch = -0.3, .yaw = -2.9};
  const EulerAngles back = EulerFromNedFromBody(NedFromBody(attitude));
  CHECK(back.roll == doctest::Approx(attitude.roll));
  CHECK(back.pitch == doctest::Approx(attitude.pitch));
  CHECK(back.yaw == doctest::Approx(attitude.yaw));
  CHECK(WrapAngle(RadFromDeg(326.721)) == doctest::Approx(RadFromDeg(-33.279)));
}

TEST_CASE("rigid3: nose up and right wing down are the positive senses of pitch and roll") {
  const Eigen::Quaterniond pitched = NedFromBody({.roll = 0.0, .pitch = 0.1, .yaw = 0.0});
  CHECK((WorldFromNed() * pitched * Eigen::Vector3d::UnitX()).z() > 0.0);
  const Eigen::Quaterniond rolled = NedFromBody({.roll = 0.1, .pitch = 0.0, .yaw = 0.0});
  CHECK((WorldFromNed() * rolled * Eigen::Vector3d::UnitY()).z() < 0.0);
}

TEST_CASE("rigid3: the default mount looks straight down with the image top towards the nose") {
  // Flying north, level: the pixel above the centre sees ground north of the one at the centre.
  const Eigen::Quaterniond body_from_camera(0.7071067811865476, 0, 0, 0.7071067811865476);
  const Eigen::Quaterniond world_from_camera =
      WorldFromNed() * NedFromBody(EulerAngles{}) * body_from_camera;
  CHECK((world_from_camera * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(0, 0, -1)).norm() < 1e-9);
  CHECK((world_from_camera * Eigen::Vector3d(0, -1, 0) - Eigen::Vector3d(0, 1, 0)).norm() < 1e-9);
  CHECK((world_from_camera * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 0, 0)).norm() < 1e-9);
}

TEST_CASE("camera: distortion is inverted to a thousandth of a pixel over the image") {
  Camera camera = WideCamera();
  for (int model = 0; model < 2; ++model) {
    if (model == 1) {
      camera.distortion = DistortionModel::kEquidistant;
      camera.coefficients = {0.01, -0.004, 0.001, 0.0};
    }
    for (double u = 0; u < camera.width_px; u += 133) {
      for (double v = 0; v < camera.height_px; v += 133) {
        const auto back = camera.ImageFromCamera(camera.RayFromImage({u, v}) * 57.0);
        REQUIRE(back);
        CHECK((*back - Eigen::Vector2d(u, v)).norm() < 1e-3);
      }
    }
  }
}

TEST_CASE("camera: a point behind it is not seen, and half size keeps the same ray") {
  const Camera camera = WideCamera();
  CHECK_FALSE(camera.ImageFromCamera({0.0, 0.0, -1.0}));
  const Camera half = camera.Scaled(0.5);
  CHECK(half.width_px == 800);
  // Centre of the four pixels (0..1, 0..1) is the centre of pixel (0, 0) at half size.
  CHECK((half.NormalizedFromImage({0, 0}) - camera.NormalizedFromImage({0.5, 0.5})).norm() < 1e-9);
}

TEST_CASE("camera: what lies beyond the fold of the lens is not seen, however far beyond") {
  Camera camera = WideCamera();
  for (int model = 0; model < 2; ++model) {
    camera.distortion = model == 0 ? DistortionModel::kRadTan : DistortionModel::kEquidistant;
    // Radius and angle of the fold: 1 + 3 k1 r^2 = 0.
    camera.coefficients = {model == 0 ? -0.05 : -0.4, 0.0, 0.0, 0.0};
    const double fold = model == 0 ? 2.582 : std::tan(0.9129);
    CAPTURE(model);
    CHECK(camera.ImageFromCamera({0.98 * fold, 0.0, 1.0}));
    for (const double factor : {1.02, 1.7, 2.0, 3.0, 4.0}) {
      CHECK_FALSE(camera.ImageFromCamera({factor * fold, 0.0, 1.0}));
      CHECK_FALSE(camera.ImageFromCamera({0.6 * factor * fold, -0.8 * factor * fold, 1.0}));
    }
  }
}

TEST_CASE("camera: a lens that is not known out to the borders is refused") {
  Camera camera = WideCamera();
  CHECK_NOTHROW(camera.Check());
  camera.coefficients = {-0.6, 0.0, 0.0, 0.0};
  CHECK_THROWS_AS(camera.Check(), std::invalid_argument);
  camera.coefficients = {-1e9, 1e9, 0.0, 0.0};
  CHECK_THROWS_AS(camera.Check(), std::invalid_argument);
}

TEST_CASE("camera: what no lens and no sensor can be is refused") {
  const auto is_refused = [](const std::function<void(Camera&)>& change) {
    Camera camera = WideCamera();
    change(camera);
    try {
      camera.Check();
    } catch (const std::invalid_argument&) {
      return true;
    }
    return false;
  };
  for (const double focal_px : {5e-324, 0.001, 1e308}) {
    CHECK(is_refused([&](Camera& camera) { camera.fx_px = camera.fy_px = focal_px; }));
  }
  CHECK(is_refused([](Camera& camera) { camera.fy_px = 5.0 * camera.fx_px; }));
  CHECK(is_refused([](Camera& camera) { camera.cx_px = 1e300; }));
  CHECK(is_refused([](Camera& camera) { camera.cy_px = -1.0; }));
  CHECK_FALSE(is_refused([](Camera&) {}));
}

TEST_CASE("camera: Check names field, value and constraint") {
  Camera camera = WideCamera();
  camera.fx_px = 0.0;
  CHECK_THROWS_WITH_AS(camera.Check(), "camera.fx_px = 0: must be positive", std::invalid_argument);
}

TEST_CASE("local frame: one degree north of a mid-latitude origin is 111.2 km, and comes back") {
  const LocalFrame frame({.latitude_deg = 47.0, .longitude_deg = 8.0, .altitude_m = 400.0});
  const GeoPoint point{.latitude_deg = 47.001, .longitude_deg = 8.001, .altitude_m = 450.0};
  const Eigen::Vector3d in_world = frame.WorldFromGeo(point);
  CHECK(in_world.y() == doctest::Approx(111.17).epsilon(1e-3));
  CHECK(in_world.x() == doctest::Approx(76.06).epsilon(1e-3));
  CHECK(in_world.z() == doctest::Approx(50.0).epsilon(1e-3));
  CHECK(frame.GeoFromWorld(in_world).longitude_deg == doctest::Approx(8.001).epsilon(1e-9));
}

TEST_CASE("polygon: winding number, area and centroid of a concave ring") {
  const Polygon ring{{0, 0}, {4, 0}, {4, 4}, {2, 1}, {0, 4}};
  CHECK(Contains(ring, {0.5, 1.0}));
  CHECK_FALSE(Contains(ring, {2.0, 3.0}));
  CHECK_FALSE(Contains(ring, {5.0, 1.0}));
  CHECK(Area(ring) == doctest::Approx(10.0));
  CHECK(Centroid({{0, 0}, {2, 0}, {2, 2}, {0, 2}}).isApprox(Eigen::Vector2d(1, 1)));
}

TEST_CASE("polygon: rotating calipers find a turned rectangle") {
  const double angle = 0.4;
  const Eigen::Rotation2Dd turn(angle);
  Polygon points;
  for (double u = 0; u <= 6; u += 1.5) {
    for (double v = 0; v <= 2; v += 1.0) points.push_back(turn * Eigen::Vector2d(u, v));
  }
  const Polygon rectangle = MinAreaRectangle(points);
  REQUIRE(rectangle.size() == 4);
  CHECK(SignedArea(rectangle) == doctest::Approx(12.0));
}

TEST_CASE("polygon: two squares that share a quarter overlap by a seventh, far ones not at all") {
  const Polygon a{{0, 0}, {2, 0}, {2, 2}, {0, 2}};
  const Polygon b{{1, 1}, {3, 1}, {3, 3}, {1, 3}};
  CHECK(Area(ConvexIntersection(a, b)) == doctest::Approx(1.0));
  CHECK(OverlapRatio(a, b) == doctest::Approx(1.0 / 7.0));
  CHECK(OverlapRatio(a, a) == doctest::Approx(1.0));
  CHECK(OverlapRatio(a, {{5, 5}, {6, 5}, {6, 6}, {5, 6}}) == 0.0);
}

TEST_CASE("triangulation: exact rays meet in their point, parallel rays do not meet") {
  const Eigen::Vector3d truth(3.0, -2.0, 1.0);
  std::vector<PosedRay> rays;
  for (const double east : {-10.0, 0.0, 15.0}) {
    PosedRay ray;
    ray.world_from_camera.translation = {east, 1.0, 80.0};
    ray.world_from_camera.rotation =
        WorldFromNed() * Eigen::Quaterniond(0.7071067811865476, 0, 0, 0.7071067811865476);
    ray.point_normalized = (Inverse(ray.world_from_camera) * truth).hnormalized();
    rays.push_back(ray);
  }
  const auto point = Triangulate(rays);
  REQUIRE(point);
  CHECK((point->point_in_world - truth).norm() < 1e-6);
  CHECK(DegFromRad(point->parallax) == doctest::Approx(17.6).epsilon(0.02));
  rays[1] = rays[0];
  rays.pop_back();
  CHECK_FALSE(Triangulate(rays));
}

}  // namespace
}  // namespace freelsd
