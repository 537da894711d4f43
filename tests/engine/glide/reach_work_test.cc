// The budget of a search for the ground in reach: beyond it the cells are larger, and the areas an
// inner bound.
#include <algorithm>
#include <random>
#include <stdexcept>

#include <doctest/doctest.h>

#include "engine/glide/glide.h"

namespace freelsd {
namespace {

constexpr int kNumCells = 1200;
constexpr double kCellSizeM = 4.0;
constexpr double kStartHeightM = 190.0;

Aircraft Sinking() { return Unpowered(*AircraftProfile("techpod"), 12.0); }

// Towers, ridges and holes in a map on rolling ground.
ReachGround Ragged(std::mt19937& random) {
  ReachGround ground;
  const double half_m = 0.5 * kNumCells * kCellSizeM;
  ground.grid = {{-half_m, half_m}, kCellSizeM, kNumCells, kNumCells};
  ground.top = cv::Mat1f(kNumCells, kNumCells);
  ground.is_known = cv::Mat1b(kNumCells, kNumCells, uchar{255});
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double phase = 6.0 * unit(random);
  for (int row = 0; row < kNumCells; ++row) {
    for (int col = 0; col < kNumCells; ++col) {
      ground.top(row, col) =
          static_cast<float>(20.0 * std::sin(0.02 * row + phase) * std::cos(0.017 * col));
    }
  }
  for (int i = 0; i < 60; ++i) {
    const int width = 1 + static_cast<int>(40 * unit(random) * unit(random));
    const int length = 1 + static_cast<int>(9 * unit(random));
    const int row = static_cast<int>((kNumCells - 50) * unit(random));
    const int col = static_cast<int>((kNumCells - 50) * unit(random));
    ground.top(cv::Rect(col, row, width, length)) +=
        static_cast<float>(20.0 + 130.0 * unit(random));
    ground.is_known(cv::Rect(row, col, length, width)) = 0;
  }
  return ground;
}

GlideStart Somewhere(std::mt19937& random, bool is_wind_known, bool is_heading_known) {
  std::uniform_real_distribution<double> angle(0.0, 2.0 * kPi), speed(0.0, 6.0);
  GlideStart start;
  start.position_in_world = {0.0, 0.0, kStartHeightM};
  const double heading = angle(random);
  if (is_heading_known) start.heading = heading;
  const Eigen::Vector2d direction = DirectionOf(angle(random));
  if (is_wind_known) start.wind_in_world = speed(random) * direction;
  return start;
}

bool IsInside(const std::vector<ReachArea>& areas, const Eigen::Vector2d& place) {
  return std::any_of(areas.begin(), areas.end(), [&](const ReachArea& area) {
    return Contains(area.outer, place) &&
           std::none_of(area.holes.begin(), area.holes.end(), [&](const Polygon& hole) {
             return Contains(hole, place);
           });
  });
}

// Just inside the corners and the edges of an area, where it would first be too large.
std::vector<Eigen::Vector2d> PlacesAlong(const ReachArea& area) {
  std::vector<Eigen::Vector2d> places;
  std::vector<Polygon> rings{area.outer};
  rings.insert(rings.end(), area.holes.begin(), area.holes.end());
  for (const Polygon& ring : rings) {
    for (size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d along = ring[(i + 1) % ring.size()] - ring[i];
      const Eigen::Vector2d left(-along.y(), along.x());
      const double length = along.norm();
      for (const double share : {0.02, 0.5, 0.98}) {
        places.emplace_back(ring[i] + share * along + 0.3 * left / length);
      }
    }
  }
  return places;
}

Reach Searched(const GlideStart& start, const ReachGround& ground, double max_work) {
  ReachLimits limits;
  limits.max_num_vertices = 10'000'000;
  limits.max_work = max_work;
  return ReachOf(start, ground, Sinking(), {}, limits);
}

// Places of the coarse areas that the fine ones lack.
int NumBeyond(const std::vector<ReachArea>& coarse,
              const std::vector<std::vector<ReachArea>>& fine) {
  int num_beyond = 0;
  for (const ReachArea& area : coarse) {
    for (const Eigen::Vector2d& place : PlacesAlong(area)) {
      if (!IsInside(coarse, place)) continue;
      num_beyond += std::none_of(
          fine.begin(), fine.end(), [&](const auto& areas) { return IsInside(areas, place); });
    }
  }
  return num_beyond;
}

TEST_CASE("reach: larger cells never show ground that the fine ones refuse") {
  constexpr double kLeastShare = 0.5;
  // Three winds, three winds with 16 headings, nine winds.
  constexpr double kNumFans[] = {3, 3, 48, 9};
  for (unsigned seed = 1; seed <= 24; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    const ReachGround ground = Ragged(random);
    const GlideStart start = Somewhere(random, seed % 4 != 3, seed % 4 != 2);
    const Reach fine = Searched(start, ground, std::numeric_limits<double>::infinity());
    CHECK(fine.cells_per_side == 1);
    REQUIRE_FALSE(fine.known.empty());
    for (const double steps_of_fan : {5e4, 2e4, 5e3}) {
      CAPTURE(steps_of_fan);
      const Reach coarse = Searched(start, ground, kNumFans[seed % 4] * steps_of_fan);
      CHECK(coarse.cells_per_side > 1);
      CHECK(NumBeyond(coarse.known, {fine.known}) == 0);
      CHECK(NumBeyond(coarse.unknown, {fine.known, fine.unknown}) == 0);
      if (coarse.cells_per_side > 2 || seed % 4 > 1) continue;
      REQUIRE_FALSE(coarse.known.empty());
      CHECK(Area(coarse.known.front().outer) > kLeastShare * Area(fine.known.front().outer));
    }
  }
}

TEST_CASE("reach: a search within its budget is the same to the last bit") {
  std::mt19937 random(21);
  const ReachGround ground = Ragged(random);
  const GlideStart start = Somewhere(random, true, true);
  const Reach unlimited = Searched(start, ground, std::numeric_limits<double>::infinity());
  const Reach limited = Searched(start, ground, 1e12);
  REQUIRE(limited.known.size() == unlimited.known.size());
  for (size_t i = 0; i < limited.known.size(); ++i) {
    CHECK(limited.known[i].outer == unlimited.known[i].outer);
    CHECK(limited.known[i].holes == unlimited.known[i].holes);
  }
}

TEST_CASE("reach: a search that nobody wants any more stops before the next wind or heading") {
  std::mt19937 random(22);
  const ReachGround ground = Ragged(random);
  int num_fans = 0;
  ReachLimits limits;
  limits.before_fan = [&num_fans] {
    if (++num_fans == 3) throw std::runtime_error("nobody waits");
  };
  CHECK_THROWS_AS(ReachOf(Somewhere(random, false, false), ground, Sinking(), {}, limits),
                  std::runtime_error);
  CHECK(num_fans == 3);
}

}  // namespace
}  // namespace freelsd
