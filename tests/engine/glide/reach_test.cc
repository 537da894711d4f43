// The ground in reach against a planner of single paths, over random ground, winds and headings.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include "tests/engine/glide/path_planner.h"

namespace freelsd {
namespace {

constexpr double kFineCellM = 2.0;
constexpr int kFinePerCell = 2;
// Of the places that the planner reaches.
// Where few cells are in reach, more of them lie at its edge, whose cells are left out: 0.032 of
// 823 places. Where many winds and headings count, each fan leaves out its edges and widens the
// shadows of towers, in other directions: 0.16 of 314 places.
constexpr double kMaxDifferingRatioOfFew = 0.06;
constexpr double kMaxDifferingRatioOfMany = 0.2;
constexpr double kMaxDifferingRatio = 0.02;
constexpr double kMaxTimeErrorS = 0.02;

Aircraft Glider() { return Unpowered(*AircraftProfile("techpod"), 12.0); }

// Compilers evaluate arguments in different orders, so the numbers of a place are drawn one by one.
template <typename Distribution>
Eigen::Vector2d RandomPlace(Distribution& distribution, std::mt19937& random) {
  const double y = distribution(random);
  const double x = distribution(random);
  return {x, y};
}

// A square about the origin, flat at height 0.
FineGround FlatGround(double half_m) {
  const int num_cells = static_cast<int>(2.0 * half_m / kFineCellM);
  return {{{-half_m, half_m}, kFineCellM, num_cells, num_cells},
          cv::Mat1f(num_cells, num_cells, 0.0f),
          0.0,
          0.0};
}

cv::Rect CellsOf(const FineGround& ground, const cv::Rect2d& metres) {
  const auto cell = ground.grid.CellAt({metres.x, metres.y + metres.height});
  REQUIRE(cell);
  return {*cell,
          cv::Size(static_cast<int>(metres.width / kFineCellM),
                   static_cast<int>(metres.height / kFineCellM))};
}

// Hills, some towers, and some unseen squares.
FineGround RandomGround(double half_m, std::mt19937& random) {
  FineGround ground = FlatGround(half_m);
  std::uniform_real_distribution<double> place(-half_m, half_m), unit(0.0, 1.0);
  for (int hill = 0; hill < 12; ++hill) {
    const Eigen::Vector2d middle = RandomPlace(place, random);
    const double height = 10.0 + 70.0 * unit(random), width = 100.0 + 400.0 * unit(random);
    const auto bell = [&](double offset) {
      return static_cast<float>(std::exp(-offset * offset / (2.0 * width * width)));
    };
    cv::Mat1f along_rows(ground.grid.num_rows, 1), along_cols(1, ground.grid.num_cols);
    for (int i = 0; i < ground.grid.num_rows; ++i) {
      const Eigen::Vector2d offset = ground.grid.CellCenter(i, i) - middle;
      along_rows(i, 0) = static_cast<float>(height) * bell(offset.y());
      along_cols(0, i) = bell(offset.x());
    }
    ground.top += along_rows * along_cols;
  }
  std::uniform_int_distribution<int> cell(0, ground.grid.num_cols - 150);
  for (int tower = 0; tower < 10; ++tower) {
    const Eigen::Vector2d corner = RandomPlace(cell, random);
    const cv::Point north_west(static_cast<int>(corner.x()), static_cast<int>(corner.y()));
    ground.top(cv::Rect(north_west, cv::Size(3 + tower, 3))) += 60.0f;
  }
  double highest = 0.0;
  cv::minMaxLoc(ground.top, &ground.lowest_height, &highest);
  ground.assumed_height = highest;
  for (int hole = 0; hole < 4; ++hole) {
    const Eigen::Vector2d corner = RandomPlace(cell, random);
    const cv::Point north_west(static_cast<int>(corner.x()), static_cast<int>(corner.y()));
    ground.top(cv::Rect(north_west, cv::Size(150, 100))) = std::numeric_limits<float>::quiet_NaN();
  }
  return ground;
}

ReachGround CoarseGround(const FineGround& fine) {
  ReachGround ground;
  ground.grid = fine.grid;
  ground.grid.cell_size_m = fine.grid.cell_size_m * kFinePerCell;
  ground.grid.num_rows = fine.grid.num_rows / kFinePerCell;
  ground.grid.num_cols = fine.grid.num_cols / kFinePerCell;
  ground.top = cv::Mat1f(ground.grid.num_rows, ground.grid.num_cols, -1e9f);
  ground.is_known = cv::Mat1b(ground.top.size(), uchar{255});
  for (int row = 0; row < fine.top.rows; ++row) {
    for (int col = 0; col < fine.top.cols; ++col) {
      const cv::Point cell(col / kFinePerCell, row / kFinePerCell);
      const bool is_seen = std::isfinite(fine.top(row, col));
      const float top = is_seen ? fine.top(row, col) : static_cast<float>(fine.assumed_height);
      ground.top(cell) = std::max(ground.top(cell), top);
      if (!is_seen) ground.is_known(cell) = 0;
    }
  }
  return ground;
}

bool IsIn(const std::vector<ReachArea>& areas, const Eigen::Vector2d& place) {
  return std::any_of(areas.begin(), areas.end(), [&](const ReachArea& area) {
    return Contains(area.outer, place) &&
           std::none_of(area.holes.begin(), area.holes.end(), [&](const Polygon& hole) {
             return Contains(hole, place);
           });
  });
}

// Of places anywhere on the ground.
struct Comparison {
  int num_reached = 0;     // by the planner
  int num_missed = 0;      // of these, outside the areas
  int num_optimistic = 0;  // inside the areas, but not reached by the planner
  int num_unseen_in_known = 0;

  double DifferingRatio() const {
    return static_cast<double>(num_missed + num_optimistic) / std::max(1, num_reached);
  }
};

Comparison Compare(const GlideStart& start,
                   const FineGround& ground,
                   const ReachLimits& limits,
                   int num_places,
                   std::mt19937& random,
                   double sampled_half_m = HUGE_VAL) {
  const Reach reach = ReachOf(start, CoarseGround(ground), Glider(), {}, limits);
  const double half_m = std::min(sampled_half_m, -ground.grid.north_west_in_world.x());
  std::uniform_real_distribution<double> offset(-half_m, half_m);
  Comparison comparison;
  for (int i = 0; i < num_places; ++i) {
    const Eigen::Vector2d place = RandomPlace(offset, random);
    const bool is_known = IsIn(reach.known, place);
    const bool is_inside = is_known || IsIn(reach.unknown, place);
    const bool is_reached = IsReached(start, place, ground, Glider(), limits);
    comparison.num_reached += is_reached ? 1 : 0;
    comparison.num_missed += is_reached && !is_inside ? 1 : 0;
    comparison.num_optimistic += is_inside && !is_reached ? 1 : 0;
    const auto cell = ground.grid.CellAt(place);
    if (is_known && cell && !std::isfinite(ground.top(*cell))) ++comparison.num_unseen_in_known;
  }
  return comparison;
}

void CheckAgreement(const Comparison& comparison, double max_differing_ratio) {
  INFO("reached ", comparison.num_reached, ", missed ", comparison.num_missed);
  CHECK(comparison.num_reached > 0);
  CHECK(comparison.num_optimistic == 0);
  CHECK(comparison.num_unseen_in_known == 0);
  CHECK(comparison.DifferingRatio() <= max_differing_ratio);
}

Comparison operator+(const Comparison& a, const Comparison& b) {
  return {a.num_reached + b.num_reached,
          a.num_missed + b.num_missed,
          a.num_optimistic + b.num_optimistic,
          a.num_unseen_in_known + b.num_unseen_in_known};
}

GlideStart RandomStart(double height, std::mt19937& random) {
  std::uniform_real_distribution<double> angle(0.0, 2.0 * kPi), speed(0.0, 7.0), offset(-200, 200);
  GlideStart start;
  start.position_in_world = {offset(random), offset(random), height};
  start.heading = angle(random);
  const Eigen::Vector2d direction = DirectionOf(angle(random));
  start.wind_in_world = speed(random) * direction;
  return start;
}

constexpr double kLongestTimeS = 1200.0;

TEST_CASE("reach: the reference's path is the one that the transit to its final heading finds") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> offset(-2000.0, 2000.0);
  const Performance performance = PerformanceOf(Glider());
  int num_compared = 0;
  for (int i = 0; i < 300; ++i) {
    const GlideStart start = RandomStart(0.0, random);
    const Eigen::Vector2d place = RandomPlace(offset, random);
    TransitTask task = TransitTaskOf(start.position_in_world.head<2>(),
                                     *start.heading,
                                     place,
                                     0.0,
                                     *start.wind_in_world,
                                     performance);
    const std::vector<Transit> transits = TransitsTo(task, performance, kLongestTimeS);
    const auto shortest =
        std::min_element(transits.begin(), transits.end(), [](const Transit& a, const Transit& b) {
          return a.time < b.time;
        });
    REQUIRE(shortest != transits.end());
    task.to.heading = task.from.heading + shortest->path.first_turn;
    const auto transit = TransitOf(task, performance);
    if (!transit) continue;
    ++num_compared;
    CHECK(transit->time == doctest::Approx(shortest->time).epsilon(kMaxTimeErrorS / 100.0));
    // Another final heading takes no less time.
    for (const double turned : {-0.5, -0.1, 0.1, 0.5}) {
      TransitTask other = task;
      other.to.heading += turned;
      const auto longer = TransitOf(other, performance);
      if (longer) CHECK(longer->time > shortest->time - kMaxTimeErrorS);
    }
  }
  CHECK(num_compared > 250);
}

TEST_CASE("reach: random ground, winds and headings: nothing more than the planner, little less") {
  Comparison all;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    const double height = 150.0 + 10.0 * seed;
    const FineGround ground = RandomGround(3000.0, random);
    all = all + Compare(RandomStart(height, random), ground, {}, 400, random);
  }
  CheckAgreement(all, kMaxDifferingRatio);
}

TEST_CASE("reach: low above the ground, the turns count") {
  Comparison all;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    std::mt19937 random(100 + seed);
    const FineGround ground = FlatGround(900.0);
    all = all + Compare(RandomStart(50.0 + 5.0 * seed, random), ground, {}, 500, random);
  }
  CheckAgreement(all, kMaxDifferingRatioOfFew);
}

TEST_CASE("reach: an arrival higher than the clearance leaves holes on hills") {
  std::mt19937 random(9);
  const FineGround ground = RandomGround(3000.0, random);
  ReachLimits limits;
  limits.arrival_height_m = 60.0;
  CheckAgreement(Compare(RandomStart(250.0, random), ground, limits, 600, random),
                 kMaxDifferingRatio);
}

TEST_CASE("reach: unknown heading and wind") {
  Comparison any_heading, any_wind;
  for (unsigned seed = 17; seed <= 19; ++seed) {
    std::mt19937 random(seed);
    const FineGround ground = RandomGround(2500.0, random);
    GlideStart start = RandomStart(220.0, random);
    start.heading.reset();
    any_heading = any_heading + Compare(start, ground, {}, 150, random, 1500.0);
    start.wind_in_world.reset();
    any_wind = any_wind + Compare(start, ground, {}, 100, random, 1000.0);
  }
  CheckAgreement(any_heading, kMaxDifferingRatioOfFew);
  CheckAgreement(any_wind, kMaxDifferingRatioOfMany);
}

// Edges that cross or touch, of all rings of an area, other than neighbours in a ring.
int NumContacts(const ReachArea& area) {
  struct Edge {
    Eigen::Vector2d begin, end;
    size_t ring, index, num_edges;
  };
  std::vector<Edge> edges;
  std::vector<Polygon> rings{area.outer};
  rings.insert(rings.end(), area.holes.begin(), area.holes.end());
  for (size_t ring = 0; ring < rings.size(); ++ring) {
    const size_t count = rings[ring].size();
    for (size_t i = 0; i < count; ++i) {
      edges.push_back({rings[ring][i], rings[ring][(i + 1) % count], ring, i, count});
    }
  }
  const auto side = [](const Edge& edge, const Eigen::Vector2d& point) {
    const Eigen::Vector2d a = edge.end - edge.begin, b = point - edge.begin;
    return a.x() * b.y() - a.y() * b.x();
  };
  int num_contacts = 0;
  for (size_t i = 0; i < edges.size(); ++i) {
    for (size_t j = i + 1; j < edges.size(); ++j) {
      const Edge& a = edges[i];
      const Edge& b = edges[j];
      const bool are_neighbours =
          a.ring == b.ring &&
          (b.index == a.index + 1 || (a.index == 0 && b.index + 1 == b.num_edges));
      if (are_neighbours) continue;
      if (std::max(a.begin.x(), a.end.x()) < std::min(b.begin.x(), b.end.x()) ||
          std::max(b.begin.x(), b.end.x()) < std::min(a.begin.x(), a.end.x()) ||
          std::max(a.begin.y(), a.end.y()) < std::min(b.begin.y(), b.end.y()) ||
          std::max(b.begin.y(), b.end.y()) < std::min(a.begin.y(), a.end.y())) {
        continue;
      }
      if (side(a, b.begin) * side(a, b.end) <= 0.0 && side(b, a.begin) * side(b, a.end) <= 0.0) {
        ++num_contacts;
      }
    }
  }
  return num_contacts;
}

TEST_CASE("reach: rings neither cross nor touch, have their sense, and are few enough corners") {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(40 + seed);
    const FineGround ground = RandomGround(3000.0, random);
    ReachLimits limits;
    limits.max_num_vertices = seed % 2 == 0 ? 4000 : 400;
    limits.arrival_height_m = seed % 3 == 0 ? 80.0 : 0.0;
    const Reach reach =
        ReachOf(RandomStart(180.0, random), CoarseGround(ground), Glider(), {}, limits);
    CHECK_FALSE(reach.known.empty());
    size_t num_vertices = 0;
    for (const auto* areas : {&reach.known, &reach.unknown}) {
      for (const ReachArea& area : *areas) {
        CHECK(SignedArea(area.outer) > 0.0);
        CHECK(NumContacts(area) == 0);
        num_vertices += area.outer.size();
        for (const Polygon& hole : area.holes) {
          CHECK(SignedArea(hole) < 0.0);
          CHECK(Contains(area.outer, hole.front()));
          num_vertices += hole.size();
        }
      }
    }
    CHECK(num_vertices <= static_cast<size_t>(limits.max_num_vertices));
  }
}

TEST_CASE("reach: a hill hides what lies behind it, and nothing beside it") {
  FineGround ground = FlatGround(2600.0);
  ground.top(CellsOf(ground, {-200.0, 800.0, 400.0, 40.0})) = 190.0f;
  GlideStart start;
  start.position_in_world = {0.0, 0.0, 200.0};
  start.heading = 0.0;
  start.wind_in_world = Eigen::Vector2d::Zero();
  const Reach reach = ReachOf(start, CoarseGround(ground), Glider(), {}, {});
  CHECK(IsIn(reach.known, {0.0, 700.0}));
  CHECK_FALSE(IsIn(reach.known, {0.0, 820.0}));
  CHECK_FALSE(IsIn(reach.known, {0.0, 1500.0}));
  CHECK_FALSE(IsIn(reach.known, {300.0, 1500.0}));
  CHECK(IsIn(reach.known, {600.0, 1500.0}));
  CHECK(IsIn(reach.known, {0.0, -1500.0}));
}

TEST_CASE("reach: straight ahead in still air it ends at height over glide ratio") {
  const FineGround ground = FlatGround(2600.0);
  GlideStart start;
  start.position_in_world = {0.0, 0.0, 160.0};
  start.heading = 0.0;
  start.wind_in_world = Eigen::Vector2d::Zero();
  const Reach reach = ReachOf(start, CoarseGround(ground), Glider(), {}, {});
  // 10 m of clearance are kept.
  constexpr double kMaxShortfallM = 20.0;
  CHECK(IsIn(reach.known, {0.0, 12.0 * 150.0 - kMaxShortfallM}));
  CHECK_FALSE(IsIn(reach.known, {0.0, 12.0 * 150.0}));
}

TEST_CASE("reach: nothing in a wind as fast as the aircraft, or below the clearance") {
  const FineGround ground = FlatGround(500.0);
  GlideStart start;
  start.position_in_world = {0.0, 0.0, 200.0};
  start.heading = 0.0;
  start.wind_in_world = Eigen::Vector2d(14.0, 0.0);
  CHECK(ReachOf(start, CoarseGround(ground), Glider(), {}, {}).known.empty());
  start.wind_in_world = Eigen::Vector2d::Zero();
  start.position_in_world.z() = 5.0;
  CHECK(ReachOf(start, CoarseGround(ground), Glider(), {}, {}).known.empty());
}

}  // namespace
}  // namespace freelsd
