#include "engine/next_look/leg_views.h"

#include <cmath>

#include <doctest/doctest.h>

#include "tests/engine/tracks/textured_plane.h"

namespace freelsd {
namespace {

constexpr double kHeightM = 100.0;
constexpr double kSpacingM = 30.0;

// Photographs that show a place on flat ground at z = 0, each projected on its own.
int NumProjected(const Rig& rig, const LegLine& leg, const Eigen::Vector2d& place) {
  int num_views = 0;
  for (double along = 0.0; along <= leg.length_m; along += kSpacingM) {
    const Eigen::Vector2d at = leg.from_in_world + along * DirectionOf(leg.heading);
    const Rigid3d world_from_body{WorldFromNed() * NedFromBody({0.0, 0.0, leg.heading}),
                                  {at.x(), at.y(), kHeightM}};
    const Rigid3d camera_from_world = Inverse(world_from_body * rig.body_from_camera);
    const Eigen::Vector3d point = camera_from_world * Eigen::Vector3d(place.x(), place.y(), 0.0);
    const auto pixel = rig.camera.ImageFromCamera(point);
    num_views += pixel && rig.camera.IsInside(*pixel) ? 1 : 0;
  }
  return num_views;
}

TEST_CASE("next look: cells are shown as often as photographs of the leg project onto them") {
  const Rig rig = VideoRig();
  const PhotoShape shape(rig, kHeightM);
  CHECK(shape.Extent().x() == doctest::Approx(480.0 / 465.0 * kHeightM).epsilon(0.01));
  CHECK(shape.Extent().y() == doctest::Approx(752.0 / 465.0 * kHeightM).epsilon(0.01));
  const Grid grid = GridAround({-300.0, -300.0}, {300.0, 300.0}, 5.0);
  for (const double heading_deg : {0.0, 40.0, 200.0}) {
    const LegLine leg{{-40.0, 25.0}, RadFromDeg(heading_deg), 180.0};
    const LegViews views = ViewsOf(leg, shape, kSpacingM, grid);
    int num_different = 0, num_shown = 0;
    for (int row = 0; row < grid.num_rows; ++row) {
      for (int col = 0; col < grid.num_cols; ++col) {
        const cv::Point cell(col, row);
        const int told = views.cells.contains(cell)
                             ? static_cast<int>(views.num_views(cell - views.cells.tl()))
                             : 0;
        const int projected = NumProjected(rig, leg, grid.CellCenter(row, col));
        num_shown += projected > 0 ? 1 : 0;
        num_different += told != projected ? 1 : 0;
      }
    }
    CAPTURE(heading_deg);
    REQUIRE(num_shown > 1000);
    // Cells at the edge of a photograph, where steps across the leg are rounded.
    CHECK(num_different < 0.05 * num_shown);
  }
}

TEST_CASE(
    "next look: a camera that sees the horizon shows no ground farther than it can be mapped") {
  Rig rig = VideoRig();
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(RadFromDeg(70.0), Eigen::Vector3d::UnitX()));
  rig.body_from_camera.rotation = rig.body_from_camera.rotation * tilt;
  const PhotoShape shape(rig, kHeightM);
  CHECK(shape.max().x() <= std::tan(RadFromDeg(60.0)) * kHeightM + 1e-6);
  CHECK(shape.max().allFinite());
  CHECK(shape.max().x() > 100.0);
}

}  // namespace
}  // namespace freelsd
