#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include "engine/regions/regions.h"
#include "tests/engine/tracks/textured_plane.h"

namespace freelsd {
namespace {

constexpr double kHeightM = 100.0;
constexpr double kMaxErrorM = 0.3;  // a pixel is 0.22 m

// One view over level ground at world z = 0, position and attitude known.
class OneView {
 public:
  OneView(const Eigen::Vector3d& position, const EulerAngles& attitude)
      : rig_(VideoRig()),
        world_from_camera_(WorldFromCamera(rig_, position, attitude)),
        tracks_(rig_, TracksOptions{.assume_ground_plane = true}) {
    Frame frame;
    frame.id = "one";
    frame.image = TexturedPlane(200.0).Photograph(rig_.camera, world_from_camera_);
    frame.prior.position_in_world = position;
    frame.prior.world_from_body = WorldFromNed() * NedFromBody(attitude);
    tracks_.Add(frame);
    tracks_.Flush();
    REQUIRE(tracks_.views().size() == 1);
  }

  // A segment whose outline is the image of the places.
  Segment SegmentOf(const std::vector<Eigen::Vector2d>& places_in_world) const {
    Segment segment;
    segment.label = 1;
    for (const Eigen::Vector2d& place : places_in_world) {
      const auto pixel = rig_.camera.ImageFromCamera(Inverse(world_from_camera_) *
                                                     Eigen::Vector3d(place.x(), place.y(), 0.0));
      REQUIRE(pixel);
      segment.contour_in_image.push_back(*pixel);
      segment.touches_border = segment.touches_border || !rig_.camera.IsInside(*pixel, 2.0);
    }
    segment.area_m2 = 1200.0;
    return segment;
  }

  Region RegionOf(const Segment& segment) {
    Regions regions{RegionsOptions{}};
    Segments segments;
    segments.segments.push_back(segment);
    regions.Update(0, segments, {{0.9, Surface::kGrass}}, tracks_);
    const std::vector<Region> ranked = regions.Ranked();
    REQUIRE(ranked.size() == 1);
    return ranked.front();
  }

 private:
  Rig rig_;
  Rigid3d world_from_camera_;
  Tracks tracks_;
};

// Each corner has one of the region's near it.
void CheckCorners(const Region& region, const std::vector<Eigen::Vector2d>& corners) {
  REQUIRE(region.corners_in_world.size() == corners.size());
  for (const Eigen::Vector2d& corner : corners) {
    double nearest = 1e9;
    for (const Eigen::Vector3d& seen : region.corners_in_world) {
      nearest = std::min(nearest, (seen.head<2>() - corner).norm());
      CHECK(std::abs(seen.z()) < kMaxErrorM);
    }
    CHECK(nearest < kMaxErrorM);
  }
}

TEST_CASE("regions: a field under a camera flying east is put where it lies") {
  OneView view({30.0, -20.0, kHeightM}, {.roll = 0.0, .pitch = 0.0, .yaw = kPi / 2});
  const std::vector<Eigen::Vector2d> field{{40, -10}, {70, -10}, {70, 30}, {40, 30}};
  const Region region = view.RegionOf(view.SegmentOf(field));
  CHECK(region.is_fixed);
  CHECK(region.num_observations == 1);
  CHECK(region.num_grass_observations == 1);
  CheckCorners(region, field);
  CHECK(SignedArea(region.Footprint()) == doctest::Approx(1200.0).epsilon(0.02));
}

TEST_CASE("regions: a bank of 15 deg does not move a field, and its centre stays inside") {
  OneView view({0.0, 0.0, kHeightM},
               {.roll = RadFromDeg(15.0), .pitch = 0.0, .yaw = RadFromDeg(30.0)});
  const std::vector<Eigen::Vector2d> field{{-20, 0}, {10, 0}, {10, 30}, {-20, 30}};
  const Region region = view.RegionOf(view.SegmentOf(field));
  // The rectangle in the image holds the trapezium that the bank makes of the field: it is larger.
  constexpr double kMaxCentreErrorM = 3.0;
  CHECK((region.Center().head<2>() - Eigen::Vector2d(-5.0, 15.0)).norm() < kMaxCentreErrorM);
  for (const Eigen::Vector2d& corner : field) {
    const Eigen::Vector2d inwards = corner + 0.1 * (Eigen::Vector2d(-5.0, 15.0) - corner);
    CHECK(Contains(region.Footprint(), inwards));
  }
}

TEST_CASE("regions: a field that leaves the image is not fixed") {
  OneView view({0.0, 0.0, kHeightM}, {});
  // The image shows 81 m to each side, 52 m ahead and behind.
  const std::vector<Eigen::Vector2d> field{{40, -20}, {79, -20}, {79, 20}, {40, 20}};
  Segment segment = view.SegmentOf(field);
  CHECK(view.RegionOf(segment).is_fixed);
  segment.touches_border = true;
  CHECK_FALSE(view.RegionOf(segment).is_fixed);
}

}  // namespace
}  // namespace freelsd
