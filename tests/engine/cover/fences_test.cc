#include "engine/cover/fences.h"

#include <cmath>

#include <doctest/doctest.h>

#include "tests/engine/cover/photo.h"
#include "tests/engine/hazard/assess.h"

namespace freelsd {
namespace {

using photo::AlongAndAcross;
using photo::Color;
using photo::MapGridOf;
using photo::Painted;

constexpr double kSideM = 80.0;
constexpr double kSpacingM = 3.0;
constexpr double kHalfLengthM = 30.0;
constexpr double kTurnDeg = 23.0;
const Color kPost{30.0, 50.0, 36.0};

bool IsPost(const Eigen::Vector2d& place, double turn_deg) {
  const Eigen::Vector2d at = AlongAndAcross(place, turn_deg);
  return std::abs(at.y()) < 0.25 && std::abs(at.x()) < kHalfLengthM &&
         photo::OffMultiple(at.x(), kSpacingM) < 0.25;
}

cv::Mat1b FencesOn(const Orthophoto& picture, const CoverOptions& options = {}) {
  const Grid grid = MapGridOf(picture);
  const cv::Mat1b meadow(grid.num_rows, grid.num_cols, uint8_t{255});
  return FindFences(picture, meadow, grid, options);
}

// Of the map's cells; those of a fence lie within `near_m` of its line.
double MarkedRatio(const cv::Mat1b& marked, const Grid& grid, double turn_deg, bool is_on_fence) {
  constexpr double kNearM = 1.5;
  int num_cells = 0, num_marked = 0;
  for (int row = 0; row < grid.num_rows; ++row) {
    for (int col = 0; col < grid.num_cols; ++col) {
      const Eigen::Vector2d at = AlongAndAcross(grid.CellCenter(row, col), turn_deg);
      const bool is_line = std::abs(at.y()) < 0.6 && std::abs(at.x()) < kHalfLengthM - 1.0;
      const bool is_beside = std::abs(at.y()) > kNearM;
      if (is_on_fence ? !is_line : !is_beside) continue;
      ++num_cells;
      num_marked += marked(row, col) != 0;
    }
  }
  return static_cast<double>(num_marked) / num_cells;
}

TEST_CASE("fences: a row of posts is found all along, in any direction, and nothing beside it") {
  for (const double turn_deg : {0.0, kTurnDeg, 71.0, 135.0}) {
    CAPTURE(turn_deg);
    const Orthophoto picture = Painted(kSideM, [turn_deg](const Eigen::Vector2d& place) {
      return IsPost(place, turn_deg) ? kPost : photo::kGreen;
    });
    const cv::Mat1b found = FencesOn(picture);
    CHECK(MarkedRatio(found, MapGridOf(picture), turn_deg, true) > 0.9);
    CHECK(MarkedRatio(found, MapGridOf(picture), turn_deg, false) < 0.01);
  }
}

TEST_CASE("fences: a meadow, a bush, paths and tracks, strewn dark spots and a shade are none") {
  const auto marked = [](const photo::Paint& paint) {
    return cv::countNonZero(FencesOn(Painted(kSideM, paint))) / (kSideM * kSideM);
  };
  constexpr double kMaxMarked = 0.003;
  CHECK(marked([](const Eigen::Vector2d&) { return photo::kGreen; }) < kMaxMarked);
  CHECK(marked([](const Eigen::Vector2d& place) {
          return place.norm() < 2.0 ? kPost : photo::kGreen;
        }) < kMaxMarked);
  CHECK(marked([](const Eigen::Vector2d& place) {
          const double across = AlongAndAcross(place, kTurnDeg).y();
          return std::abs(across) < 0.3 ? Color(140.0, 170.0, 150.0) : photo::kGreen;
        }) < kMaxMarked);
  CHECK(marked([](const Eigen::Vector2d& place) {
          const double across = AlongAndAcross(place, kTurnDeg).y();
          return std::abs(across) < 0.3 ? kPost : photo::kGreen;
        }) < kMaxMarked);
  CHECK(marked([](const Eigen::Vector2d& place) {
          const bool is_spot =
              photo::OffMultiple(place.x() + 5.0 * std::sin(place.y()), 11.0) < 0.3 &&
              photo::OffMultiple(place.y(), 9.0) < 0.3;
          return is_spot ? kPost : photo::kGreen;
        }) < kMaxMarked);
  CHECK(marked([](const Eigen::Vector2d& place) {
          return AlongAndAcross(place, kTurnDeg).y() > 0.0 ? Color(0.7 * photo::kGreen)
                                                           : photo::kGreen;
        }) < kMaxMarked);
}

TEST_CASE("fences: only on ground that may be meadow, but posts themselves need not be") {
  const Orthophoto picture = Painted(kSideM, [](const Eigen::Vector2d& place) {
    return IsPost(place, kTurnDeg) ? kPost : photo::kGreen;
  });
  const Grid grid = MapGridOf(picture);
  const cv::Mat1b nowhere(grid.num_rows, grid.num_cols, uint8_t{0});
  CHECK(cv::countNonZero(FindFences(picture, nowhere, grid, {})) == 0);
  cv::Mat1b meadow(grid.num_rows, grid.num_cols, uint8_t{255});
  for (int row = 0; row < grid.num_rows; ++row) {
    for (int col = 0; col < grid.num_cols; ++col) {
      if (IsPost(grid.CellCenter(row, col), kTurnDeg)) meadow(row, col) = 0;
    }
  }
  const cv::Mat1b found = FindFences(picture, meadow, grid, {});
  CHECK(MarkedRatio(found, grid, kTurnDeg, true) > 0.9);
}

TEST_CASE("fences: a picture without any noise has none") {
  const Orthophoto picture = Painted(
      kSideM, [](const Eigen::Vector2d&) { return photo::kGreen; }, 0.0);
  CHECK(cv::countNonZero(FencesOn(picture)) == 0);
}

TEST_CASE("fences: unseen ground is no line") {
  Orthophoto picture = Painted(kSideM, [](const Eigen::Vector2d&) { return photo::kGreen; });
  photo::MakeUnseen(picture, {100, 0, 2, picture.image.rows});
  CHECK(cv::countNonZero(FencesOn(picture)) == 0);
}

TEST_CASE(
    "fences: the hazard layers leave them out, with what stands out of the meadow, 0 looks for "
    "none") {
  const auto fence_and_stone = [](const Eigen::Vector2d& place) -> Color {
    if ((place - Eigen::Vector2d(20.0, 20.0)).norm() < 0.8) return {190.0, 192.0, 194.0};
    return IsPost(place, 0.0) ? kPost : photo::kGreen;
  };
  const Orthophoto picture = Painted(kSideM, fence_and_stone);
  ElevationMap map;
  map.grid = MapGridOf(picture);
  map.elevation = cv::Mat1f(map.grid.num_rows, map.grid.num_cols, 100.0f);
  map.upper = map.elevation.clone();
  map.standard_deviation = cv::Mat1f(map.elevation.size(), 0.1f);
  const std::vector<KindView> views = photo::TwoNadirViews(255);
  const auto at = [&](double east, double north) {
    return *map.grid.CellAt(Eigen::Vector2d(east, north));
  };
  const HazardLayers layers = AssessHazards(map, views, {}, {}, picture);
  const cv::Point stone = at(20.0, 20.0), beside = at(0.5, 10.5);
  CHECK(layers.hazard(stone) == kHazard);
  CHECK(layers.hazard(beside) == kFree);
  // Between two posts, which may be things of their own.
  const cv::Point between = at(1.5, 0.0);
  CHECK(layers.hazard(between) == kHazard);
  HazardOptions without;
  without.cover.min_fence_deviations = 0.0;
  CHECK(AssessHazards(map, views, {}, without, picture).hazard(between) == kFree);
}

TEST_CASE("fences: a thing is as much alone in its meadow with a fence as without") {
  const auto fence_and_stone = [](const Eigen::Vector2d& place) -> Color {
    if ((place - Eigen::Vector2d(20.0, 3.0)).norm() < 0.8) return {190.0, 192.0, 194.0};
    return IsPost(place, 0.0) ? kPost : photo::kGreen;
  };
  Orthophoto picture = Painted(kSideM, fence_and_stone);
  ElevationMap map;
  map.grid = MapGridOf(picture);
  map.elevation = cv::Mat1f(map.grid.num_rows, map.grid.num_cols, 100.0f);
  map.upper = map.elevation.clone();
  map.standard_deviation = cv::Mat1f(map.elevation.size(), 0.1f);
  // Both photographs show the same.
  picture.second_image = picture.image;
  picture.second_seen = picture.seen;
  picture.view = cv::Mat1i(map.elevation.size(), 0);
  picture.second_view = cv::Mat1i(map.elevation.size(), 1);
  const GroundSurface surface = MeasureSurface(map, {});
  CoverOptions without;
  without.min_fence_deviations = 0.0;
  const std::vector<KindView> views = photo::TwoNadirViews(255);
  const OpenCover with_fence = AssessCover(map, surface, views, {}, picture).open;
  const OpenCover without_fence = AssessCover(map, surface, views, without, picture).open;
  CHECK(with_fence.allowance_m(*map.grid.CellAt(Eigen::Vector2d(20.0, 3.0))) == 4.0f);
  CHECK(cv::countNonZero(with_fence.allowance_m != without_fence.allowance_m) == 0);
}

}  // namespace
}  // namespace freelsd
