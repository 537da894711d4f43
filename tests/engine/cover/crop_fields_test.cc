// From the sprayed ground that was found to the field it is.
#include "engine/cover/crop_fields.h"

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

#include "tests/engine/cover/photo.h"

namespace freelsd {
namespace {

using photo::Color;

const Color kCrop{58.0, 138.0, 96.0};
const Color kHedge{30.0, 62.0, 40.0};
constexpr double kSideM = 120.0;

// A crop from -35 to 15 east and -30 to 30 north; beyond a hedge of 4 m east of it the same green.
Orthophoto Crop() {
  return photo::Painted(kSideM, [](const Eigen::Vector2d& place) -> Color {
    if (std::abs(place.y()) > 30.0 || place.x() < -35.0) return photo::kGreen;
    if (place.x() > 15.0 && place.x() < 19.0) return kHedge;
    return kCrop;
  });
}

// What tracks told of it: a box of the map, in metres from west and north.
cv::Mat1b Sprayed(const Grid& grid, const cv::Rect& cells) {
  cv::Mat1b mask = cv::Mat1b::zeros(grid.num_rows, grid.num_cols);
  mask(cells).setTo(255);
  return mask;
}

bool IsIn(const cv::Mat1b& mask, const Grid& grid, double east, double north) {
  return mask(*grid.CellAt(Eigen::Vector2d(east, north))) != 0;
}

TEST_CASE("crop fields: the rest of the field is added up to its border, and nothing beyond") {
  const Orthophoto photo = Crop();
  const Grid grid = photo::MapGridOf(photo);
  const cv::Mat1b sprayed = Sprayed(grid, {40, 40, 25, 40});
  const cv::Mat1b whole = WithRestOfField(sprayed, photo, grid, {});
  CHECK(cv::countNonZero(sprayed & ~whole) == 0);
  for (const double north : {-27.0, 0.0, 27.0}) {
    CHECK(IsIn(whole, grid, -32.0, north));
    CHECK(IsIn(whole, grid, 12.0, north));
    CHECK_FALSE(IsIn(whole, grid, -40.0, north));
    CHECK_FALSE(IsIn(whole, grid, 22.0, north));
  }
  CHECK_FALSE(IsIn(whole, grid, 0.0, 35.0));
  CHECK_FALSE(IsIn(whole, grid, 0.0, -35.0));
}

TEST_CASE("crop fields: no farther than half of the widest sprayer") {
  const Orthophoto photo = Crop();
  const Grid grid = photo::MapGridOf(photo);
  CoverOptions options;
  options.max_working_width_m = 20.0;
  const cv::Mat1b whole = WithRestOfField(Sprayed(grid, {40, 40, 15, 40}), photo, grid, options);
  CHECK(IsIn(whole, grid, 3.0, 0.0));
  CHECK_FALSE(IsIn(whole, grid, 9.0, 0.0));
}

TEST_CASE("crop fields: what was not seen is of no field, and nothing comes of nothing") {
  Orthophoto photo = Crop();
  const Grid grid = photo::MapGridOf(photo);
  // From 5 east on.
  photo::MakeUnseen(photo, {260, 0, 220, 480});
  const cv::Mat1b whole = WithRestOfField(Sprayed(grid, {40, 40, 20, 40}), photo, grid, {});
  CHECK(IsIn(whole, grid, 2.0, 0.0));
  CHECK_FALSE(IsIn(whole, grid, 8.0, 0.0));
  const cv::Mat1b none = cv::Mat1b::zeros(grid.num_rows, grid.num_cols);
  CHECK(cv::countNonZero(WithRestOfField(none, photo, grid, {})) == 0);
}

}  // namespace
}  // namespace freelsd
