#include "engine/cover/look_alikes.h"

#include <doctest/doctest.h>

#include "tests/engine/cover/photo.h"
#include "tests/engine/hazard/assess.h"
#include "tests/engine/refusal.h"

namespace freelsd {
namespace {

using photo::AlongAndAcross;
using photo::Color;
using photo::MapGridOf;
using photo::OffMultiple;
using photo::Paint;
using photo::Painted;

constexpr double kSideM = 120.0;
constexpr uint8_t kSurelyGrass = 255;
// Of two views: 0.9.
constexpr uint8_t kLikelyGrass = 191;
constexpr double kFieldHalfM = 30.0;
// Waves of an even water surface, grey levels.
constexpr double kWaterNoise = 0.8;

Color Brighter(double grey) { return photo::kGreen + Color(grey, grey, grey); }

Paint Meadow() {
  return [](const Eigen::Vector2d&) { return photo::kGreen; };
}

// A square field of rows, `swing` grey levels above and below the meadow around it.
Paint Rows(double turn_deg, double spacing_m, double swing) {
  return [=](const Eigen::Vector2d& place) {
    const Eigen::Vector2d at = AlongAndAcross(place, turn_deg);
    if (at.cwiseAbs().maxCoeff() > kFieldHalfM) return photo::kGreen;
    return Brighter(swing * std::sin(2.0 * kPi * at.y() / spacing_m));
  };
}

// All over the picture: lines of a width, a spacing apart.
Paint Lines(double turn_deg, double spacing_m, double width_m, double grey) {
  return [=](const Eigen::Vector2d& place) {
    const double across = AlongAndAcross(place, turn_deg).y();
    return OffMultiple(across, spacing_m) <= 0.5 * width_m ? Brighter(grey) : photo::kGreen;
  };
}

ToldKinds Told(const Grid& grid, float grass, GroundKind other) {
  const cv::Size size(grid.num_cols, grid.num_rows);
  return {cv::Mat1f(size, grass), cv::Mat1b(size, LikelyKind{other, 1.0f - grass}.Packed())};
}

int NumWithRows(const Paint& paint) {
  return cv::countNonZero(RowCrops(Painted(kSideM, paint), {}));
}

// Cells of one metre: the whole field, and nothing farther from it than the second number.
struct Cover {
  double found_ratio = 0.0;
  double farthest_m = 0.0;
};

Cover CoverOf(const cv::Mat1b& mask, const Grid& grid, double turn_deg) {
  Cover cover;
  int num_field = 0, num_found = 0;
  for (int row = 0; row < mask.rows; ++row) {
    for (int col = 0; col < mask.cols; ++col) {
      const Eigen::Vector2d at = AlongAndAcross(grid.CellCenter(row, col), turn_deg);
      const double beyond = at.cwiseAbs().maxCoeff() - kFieldHalfM;
      if (beyond < 0.0) ++num_field;
      if (beyond < 0.0 && mask(row, col)) ++num_found;
      if (mask(row, col)) cover.farthest_m = std::max(cover.farthest_m, beyond);
    }
  }
  cover.found_ratio = double(num_found) / num_field;
  return cover;
}

TEST_CASE("look-alikes: rows 0.75 m apart are found over the field, and not far from it") {
  // Squares of 12 m, averaged with their neighbours and grown by one; corner to corner.
  constexpr double kMaxBeyondM = 27.0;
  for (const double turn_deg : {0.0, 23.0, 90.0, 141.0}) {
    CAPTURE(turn_deg);
    const Orthophoto photo = Painted(kSideM, Rows(turn_deg, 0.75, 10.0));
    const Cover cover = CoverOf(RowCrops(photo, {}), photo.grid, turn_deg);
    CHECK(cover.found_ratio > 0.98);
    CHECK(cover.farthest_m < kMaxBeyondM);
  }
}

TEST_CASE(
    "look-alikes: maize, beets and potatoes have rows, soft stripes of three metres have not") {
  CHECK(NumWithRows(Rows(23.0, 0.6, 12.0)) > 0);
  CHECK(NumWithRows(Rows(23.0, 0.85, 12.0)) > 0);
  CHECK(NumWithRows(Rows(23.0, 3.0, 12.0)) == 0);
}

// Streaks of every distance, the wider the stronger: what is seen of rows whose leaves have met.
double Streaks(double across_m) {
  double grey = 0.0;
  for (const double spacing_m : {0.6, 0.75, 0.9, 1.1, 1.3, 1.6, 2.0, 2.6, 3.5}) {
    grey += 12.0 * spacing_m * std::sin(2.0 * kPi * across_m / spacing_m + 5.0 * spacing_m);
  }
  return grey;
}

// Streaks, and rows in the western half where there are some.
Paint Streaked(double streaks_deg, double rows_deg, bool has_rows) {
  return [=](const Eigen::Vector2d& place) {
    if (AlongAndAcross(place, 0.0).cwiseAbs().maxCoeff() > kFieldHalfM) return photo::kGreen;
    if (place.x() >= 0.0) return Brighter(Streaks(AlongAndAcross(place, streaks_deg).y()));
    const double across = AlongAndAcross(place, rows_deg).y();
    return Brighter(has_rows ? 20.0 * std::sin(2.0 * kPi * across / 0.75) : 0.0);
  };
}

// Of the eastern half, without what a square of the other half reaches.
double FoundInEast(const Paint& paint) {
  const Orthophoto photo = Painted(kSideM, paint);
  const cv::Mat1b mask = RowCrops(photo, {});
  int num_cells = 0, num_found = 0;
  for (int row = 0; row < mask.rows; ++row) {
    for (int col = 0; col < mask.cols; ++col) {
      const Eigen::Vector2d at = photo.grid.CellCenter(row, col);
      if (at.x() < 15.0 || at.x() > kFieldHalfM || std::abs(at.y()) > kFieldHalfM) continue;
      ++num_cells;
      num_found += mask(row, col) != 0;
    }
  }
  return double(num_found) / num_cells;
}

TEST_CASE("look-alikes: streaks beside rows of their direction are of the same field") {
  CHECK(FoundInEast(Streaked(23.0, 23.0, true)) > 0.95);
  CHECK(FoundInEast(Streaked(23.0, 23.0, false)) == 0.0);
  CHECK(FoundInEast(Streaked(23.0, 63.0, true)) < 0.3);
}

TEST_CASE("look-alikes: roads, walls, borders and noise have no rows") {
  const double turns_deg[] = {0.0, 31.0, 90.0};
  for (const double turn_deg : turns_deg) {
    CAPTURE(turn_deg);
    CHECK(NumWithRows(Lines(turn_deg, 200.0, 4.0, 80.0)) == 0);
    CHECK(NumWithRows(Lines(turn_deg, 200.0, 0.5, 120.0)) == 0);
    CHECK(NumWithRows([=](const Eigen::Vector2d& place) {
            return Brighter(AlongAndAcross(place, turn_deg).y() > 3.0 ? 60.0 : 0.0);
          }) == 0);
  }
  CHECK(NumWithRows(Meadow()) == 0);
}

TEST_CASE("look-alikes: an even green patch is water, a meadow with tufts is not") {
  Orthophoto photo = Painted(kSideM, Meadow());
  const Orthophoto even = Painted(kSideM, Meadow(), kWaterNoise);
  const cv::Rect pond(160, 120, 160, 200);  // 40 m x 50 m
  even.image(pond).copyTo(photo.image(pond));
  const cv::Mat1b water = StillWater(photo, {});
  const int rim = 12;  // half a square of detail: 3 m
  const cv::Rect inner(pond.tl() + cv::Point(rim, rim), pond.br() - cv::Point(rim, rim));
  CHECK(cv::countNonZero(water(inner)) == inner.area());
  CHECK(cv::countNonZero(water) <= pond.area());
}

TEST_CASE("look-alikes: water is water up to what was not seen of it") {
  Orthophoto photo = Painted(kSideM, Meadow(), kWaterNoise);
  for (int row = 0; row < photo.image.rows; row += 40) {
    photo::MakeUnseen(photo, {0, row, photo.image.cols, 20});
  }
  const cv::Mat1b water = StillWater(photo, {});
  CHECK(cv::countNonZero(water) == cv::countNonZero(photo.seen));
  CHECK(cv::countNonZero(water & (photo.seen == 0)) == 0);
}

TEST_CASE("look-alikes: without a picture nothing is found, and unseen ground is nothing") {
  CHECK(FindLookAlikes({}, {{0, 0}, 1.0, 20, 20}, {}, {}).empty());
  Orthophoto unseen = Painted(40.0, Rows(0.0, 0.75, 10.0));
  photo::MakeUnseen(unseen, cv::Rect({0, 0}, unseen.image.size()));
  CHECK(cv::countNonZero(FindLookAlikes(
            unseen, MapGridOf(unseen), Told(MapGridOf(unseen), 0.5f, GroundKind::kWater), {})) ==
        0);
  // Smaller than a square of the spectrum.
  CHECK(cv::countNonZero(RowCrops(Painted(8.0, Rows(0.0, 0.75, 10.0)), {})) == 0);
}

// A meadow, with in the north-west a field in rows, in the south-east a pond.
Orthophoto Countryside() {
  Orthophoto photo = Painted(160.0, [](const Eigen::Vector2d& place) {
    if (place.x() < -20.0 && place.y() > 20.0) {
      return Brighter(10.0 * std::sin(2.0 * kPi * place.x() / 0.75));
    }
    return photo::kGreen;
  });
  const Orthophoto even = Painted(
      160.0, [](const Eigen::Vector2d&) { return photo::kGreen; }, kWaterNoise);
  const cv::Rect pond(440, 480, 120, 120);  // 30 m x 30 m about (45, -55)
  even.image(pond).copyTo(photo.image(pond));
  return photo;
}

const Eigen::Vector2d kInRows(-50.0, 50.0), kInPond(45.0, -55.0);
const Eigen::Vector2d kInMeadow(-45.0, -45.0);

bool IsFoundAt(const Eigen::Vector2d& place, const CoverOptions& options) {
  static const Orthophoto kPhoto = Countryside();
  const Grid grid = MapGridOf(kPhoto);
  return FindLookAlikes(
             kPhoto, grid, Told(grid, 0.9f, GroundKind::kWater), options)(*grid.CellAt(place)) != 0;
}

TEST_CASE("look-alikes: each rule finds its own, and 0 switches it off") {
  const CoverOptions all;
  CHECK(IsFoundAt(kInRows, all));
  CHECK(IsFoundAt(kInPond, all));
  CHECK_FALSE(IsFoundAt(kInMeadow, all));
  CoverOptions no_rows, no_water;
  no_rows.min_row_strength = 0.0;
  no_water.min_detail_ratio = 0.0;
  CHECK_FALSE(IsFoundAt(kInRows, no_rows));
  CHECK(IsFoundAt(kInPond, no_rows));
  CHECK_FALSE(IsFoundAt(kInPond, no_water));
  CHECK(IsFoundAt(kInRows, no_water));
}

TEST_CASE(
    "look-alikes: ground with little detail stays grass where the views leave no room for water") {
  const Orthophoto photo = Countryside();
  const Grid grid = MapGridOf(photo);
  const cv::Point pond = *grid.CellAt(kInPond), rows = *grid.CellAt(kInRows);
  const cv::Mat1b of_sure = FindLookAlikes(photo, grid, Told(grid, 0.97f, GroundKind::kWater), {});
  const cv::Mat1b of_other = FindLookAlikes(photo, grid, Told(grid, 0.9f, GroundKind::kRough), {});
  CHECK(of_sure(pond) == 0);
  CHECK(of_other(pond) == 0);
  CHECK(of_sure(rows) == 255);
  CHECK(of_other(rows) == 255);
}

TEST_CASE("look-alikes: rows tell nothing where all views are sure of grass") {
  const Orthophoto photo = Countryside();
  const Grid grid = MapGridOf(photo);
  const cv::Point rows = *grid.CellAt(kInRows);
  CHECK(FindLookAlikes(photo, grid, Told(grid, 0.98f, GroundKind::kCrop), {})(rows) == 255);
  CHECK(FindLookAlikes(photo, grid, Told(grid, 0.987f, GroundKind::kCrop), {})(rows) == 0);
}

// Flat, and grass for every view from 200 m up.
ElevationMap FlatMapOn(const Grid& grid) {
  ElevationMap map;
  map.grid = grid;
  const cv::Size size(grid.num_cols, grid.num_rows);
  map.elevation = cv::Mat1f(size, 0.0f);
  map.upper = cv::Mat1f(size, 0.1f);
  map.standard_deviation = cv::Mat1f(size, 0.1f);
  map.num_points = cv::Mat1f(size, 50.0f);
  return map;
}

TEST_CASE("look-alikes: with a photograph such cells are hazard and no grass, under any limits") {
  const Orthophoto photo = Countryside();
  const ElevationMap map = FlatMapOn(MapGridOf(photo));
  KindView view = photo::NadirView(kLikelyGrass);
  view.picture.other =
      cv::Mat1b(view.picture.grass.size(), LikelyKind{GroundKind::kWater, 0.2f}.Packed());
  const HazardLayers without = AssessHazards(map, {2, view}, {}, {});
  const HazardLayers with = AssessHazards(map, {2, view}, {}, {}, photo);
  const HazardLayers renewed = WithLimits(map, with, {.max_slope_deg = 20.0}, {});
  for (const Eigen::Vector2d& place : {kInRows, kInPond}) {
    const cv::Point cell = *map.grid.CellAt(place);
    CHECK(without.hazard(cell) == kFree);
    CHECK(with.hazard(cell) == kHazard);
    CHECK(with.grass(cell) == 0.0f);
    CHECK(with.distance(cell) == 0.0f);
    CHECK(renewed.hazard(cell) == kHazard);
  }
  CHECK(with.hazard(*map.grid.CellAt(kInMeadow)) == kFree);
  // No cell becomes safer by a picture.
  CHECK(cv::countNonZero((with.hazard == kFree) & (without.hazard != kFree)) == 0);
}

TEST_CASE("look-alikes: a picture in which all is as it should be changes nothing") {
  const Orthophoto photo = Painted(kSideM, Meadow());
  const ElevationMap map = FlatMapOn(MapGridOf(photo));
  const HazardLayers without = AssessHazards(map, photo::TwoNadirViews(kSurelyGrass), {}, {});
  const HazardLayers with = AssessHazards(map, photo::TwoNadirViews(kSurelyGrass), {}, {}, photo);
  CHECK(cv::countNonZero(with.hazard != without.hazard) == 0);
  CHECK(cv::countNonZero(without.hazard == kFree) > 0);
}

TEST_CASE("look-alikes: options out of bounds are refused by name") {
  using O = CoverOptions;
  for (double O::*const field :
       {&O::min_row_strength, &O::min_detail_ratio, &O::min_object_deviations}) {
    CHECK(RefusalOf(field, 0.0).empty());
  }
  CHECK(IsRefused(&O::min_row_strength, std::nan(""), "min_row_strength"));
  CHECK(IsRefused(&O::min_row_spacing_m, 0.0, "min_row_spacing_m"));
  CHECK(IsRefused(&O::max_row_spacing_m, 11.0, "max_row_spacing_m"));
  CHECK(IsRefused(&O::min_detail_ratio, -0.1, "min_detail_ratio"));
  CHECK(IsRefused(&O::min_object_deviations, -1.0, "min_object_deviations"));
  CHECK(IsRefused(&O::object_surroundings_m, 0.0, "object_surroundings_m"));
  // A range that holds nothing would switch a rule off.
  CHECK(RefusalOf(&O::min_row_spacing_m, 1.0) ==
        "hazard.min_row_spacing_m = 1: must be in [0.1, 0.9]");
}

}  // namespace
}  // namespace freelsd
