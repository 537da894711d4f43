// Segments of meadow that reach over a soft border into other ground.
#include "engine/cover/overreach.h"

#include <limits>

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

#include "tests/engine/cover/photo.h"
#include "tests/engine/hazard/assess.h"

namespace freelsd {
namespace {

using photo::Color;

constexpr double kSideM = 120.0;
const Color kStubble{78.0, 112.0, 128.0};
// What nobody could tell from the meadow by its colour.
const Color kSameGreen{62.0, 121.0, 75.0};

// The southern half is other ground.
Orthophoto TwoGrounds(const Color& south) {
  return photo::Painted(kSideM, [&](const Eigen::Vector2d& place) -> Color {
    return place.y() < 0.0 ? south : photo::kGreen;
  });
}

// The views told it but for 20 m by 15 m at the border.
cv::Mat1f ToldButForABulge(const Grid& grid) {
  cv::Mat1f grass(grid.num_rows, grid.num_cols, 0.99f);
  grass(cv::Rect(0, 60, 120, 60)).setTo(0.02f);
  grass(cv::Rect(50, 60, 20, 15)).setTo(0.99f);
  return grass;
}

const cv::Rect kBulge{51, 62, 18, 11};

TEST_CASE("overreach: a bulge of other ground's colour is no grass, and the meadow stays") {
  const Orthophoto photo = TwoGrounds(kStubble);
  const Grid grid = photo::MapGridOf(photo);
  const cv::Mat1f grass = ToldButForABulge(grid);
  const cv::Mat1b found = OverreachingGrass(grass, photo, grid, {});
  CHECK(cv::countNonZero(found(kBulge)) == kBulge.area());
  CHECK(cv::countNonZero(found.rowRange(0, 58)) == 0);
  CHECK(cv::countNonZero(found & (grass < 0.5f)) == 0);
}

TEST_CASE("overreach: a bulge behind a rim that nobody could class is found as well") {
  const Orthophoto photo = TwoGrounds(kStubble);
  const Grid grid = photo::MapGridOf(photo);
  cv::Mat1f grass = ToldButForABulge(grid);
  const cv::Mat1b is_bulge = grass >= 0.95f;
  cv::Mat1b wider;
  cv::dilate(is_bulge, wider, cv::Mat1b::ones(7, 7));
  grass.setTo(std::numeric_limits<float>::quiet_NaN(), wider & ~is_bulge & (grass < 0.5f));
  const cv::Mat1b found = OverreachingGrass(grass, photo, grid, {});
  CHECK(cv::countNonZero(found(kBulge)) == kBulge.area());
}

TEST_CASE("overreach: finer cells move nothing aside") {
  const Orthophoto photo = TwoGrounds(kStubble);
  Grid grid = photo::MapGridOf(photo);
  cv::Mat1f grass;
  cv::resize(ToldButForABulge(grid), grass, {}, 2.0, 2.0, cv::INTER_NEAREST);
  grid.cell_size_m *= 0.5;
  grid.num_rows *= 2;
  grid.num_cols *= 2;
  const cv::Mat1b found = OverreachingGrass(grass, photo, grid, {});
  const cv::Rect bulge(2 * kBulge.x, 2 * kBulge.y, 2 * kBulge.width, 2 * kBulge.height);
  CHECK(cv::countNonZero(found(bulge)) == bulge.area());
  CHECK(cv::countNonZero(found.rowRange(0, 116)) == 0);
}

TEST_CASE("overreach: grounds of one colour are left as the views have them") {
  const Orthophoto photo = TwoGrounds(kSameGreen);
  const Grid grid = photo::MapGridOf(photo);
  CHECK(cv::countNonZero(OverreachingGrass(ToldButForABulge(grid), photo, grid, {})) == 0);
}

TEST_CASE("overreach: where no other ground is told, or little of it, nothing is found") {
  const Orthophoto photo = TwoGrounds(kStubble);
  const Grid grid = photo::MapGridOf(photo);
  cv::Mat1f grass(grid.num_rows, grid.num_cols, 0.99f);
  CHECK(cv::countNonZero(OverreachingGrass(grass, photo, grid, {})) == 0);
  grass(cv::Rect(40, 70, 9, 9)).setTo(0.02f);
  CHECK(cv::countNonZero(OverreachingGrass(grass, photo, grid, {})) == 0);
}

TEST_CASE("overreach: what the picture does not show stays as it is") {
  Orthophoto photo = TwoGrounds(kStubble);
  const Grid grid = photo::MapGridOf(photo);
  // The western half of the bulge.
  photo::MakeUnseen(photo, {200, 240, 40, 60});
  const cv::Mat1b found = OverreachingGrass(ToldButForABulge(grid), photo, grid, {});
  CHECK(cv::countNonZero(found(cv::Rect(51, 62, 7, 11))) == 0);
  CHECK(cv::countNonZero(found(cv::Rect(62, 62, 6, 11))) == 66);
}

TEST_CASE("overreach: the hazard layers leave it out, and 0 leaves the rule out") {
  const Orthophoto photo = TwoGrounds(kStubble);
  ElevationMap map;
  map.grid = photo::MapGridOf(photo);
  map.elevation = cv::Mat1f(map.grid.num_rows, map.grid.num_cols, 100.0f);
  map.upper = map.elevation.clone();
  map.standard_deviation = cv::Mat1f(map.elevation.size(), 0.1f);
  // Of the middle 100 m by 100 m; the bulge is sure grass in both views.
  GrassView view = photo::NadirView(255);
  view.mask.rowRange(50, 100).setTo(1);
  view.mask(cv::Rect(40, 50, 20, 15)).setTo(255);
  const std::vector<GrassView> views{view, view};
  const cv::Point bulge = *map.grid.CellAt(Eigen::Vector2d(0.0, -7.0));
  const cv::Point meadow = *map.grid.CellAt(Eigen::Vector2d(0.0, 20.0));
  const HazardLayers layers = AssessHazards(map, views, {}, {}, photo);
  CHECK(layers.hazard(bulge) == kHazard);
  CHECK(layers.hazard(meadow) == kFree);
  HazardOptions without;
  without.cover.min_overreach_deviations = 0.0;
  CHECK(AssessHazards(map, views, {}, without, photo).hazard(bulge) == kFree);
}

}  // namespace
}  // namespace freelsd
