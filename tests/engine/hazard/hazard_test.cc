#include "engine/hazard/hazard.h"

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/engine/cover/photo.h"
#include "tests/engine/hazard/assess.h"

namespace freelsd {
namespace {

using photo::NadirView;
using photo::TwoNadirViews;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr uint8_t kSurelyGrass = 255;
constexpr uint8_t kSurelyNot = 1;

ElevationMap MapOf(int num_cells, const std::function<double(double, double)>& height) {
  const double half = num_cells / 2.0;
  ElevationMap map;
  map.grid = {{-half, half}, 1.0, num_cells, num_cells};
  map.elevation = cv::Mat1f(map.grid.num_rows, map.grid.num_cols);
  for (int row = 0; row < map.grid.num_rows; ++row) {
    for (int col = 0; col < map.grid.num_cols; ++col) {
      const Eigen::Vector2d place = map.grid.CellCenter(row, col);
      map.elevation(row, col) = static_cast<float>(height(place.x(), place.y()));
    }
  }
  map.upper = map.elevation + 0.1;
  map.standard_deviation = cv::Mat1f(map.elevation.size(), 0.1f);
  map.num_points = cv::Mat1f(map.elevation.size(), 50.0f);
  return map;
}

ElevationMap Tilted(int num_cells, double slope_deg, double aspect_deg) {
  const Eigen::Vector2d uphill = DirectionOf(RadFromDeg(aspect_deg));
  const double rise = std::tan(RadFromDeg(slope_deg));
  return MapOf(num_cells, [=](double east, double north) {
    return 100.0 + rise * uphill.dot(Eigen::Vector2d(east, north));
  });
}

ElevationMap FlatMap(int num_cells) { return Tilted(num_cells, 0.0, 0.0); }

void MakeUnseen(ElevationMap& map, int row, int col) {
  map.elevation(row, col) = map.upper(row, col) = kNaN;
  map.standard_deviation(row, col) = map.num_points(row, col) = kNaN;
}

HazardLayers Assess(const ElevationMap& map, const HazardOptions& options = {}) {
  return AssessHazards(map, TwoNadirViews(kSurelyGrass), {}, options);
}

TEST_CASE("hazard: an even plane keeps its slope within 0.1 degrees at eight aspects") {
  constexpr double kMaxSlopeErrorDeg = 0.1;
  for (const SlopeSupport support : {SlopeSupport::kPlane, SlopeSupport::kPaperPca}) {
    HazardOptions options;
    options.surface.slope_support = support;
    for (int aspect_deg = 0; aspect_deg < 360; aspect_deg += 45) {
      for (const double slope_deg : {0.0, 3.0, 8.0, 30.0}) {
        const HazardLayers layers = Assess(Tilted(21, slope_deg, aspect_deg), options);
        CHECK(std::abs(DegFromRad(layers.slope(10, 10)) - slope_deg) < kMaxSlopeErrorDeg);
        // Near the border, with part of the support outside, too.
        CHECK(std::abs(DegFromRad(layers.slope(2, 10)) - slope_deg) < kMaxSlopeErrorDeg);
      }
    }
  }
}

TEST_CASE("hazard: the plane fit forgives noise that ruins the 3x3 neighbourhood") {
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0.0f, 0.2f);
  ElevationMap map = FlatMap(60);
  for (float& height : map.elevation) height += noise(random);
  HazardOptions paper;
  paper.surface.slope_support = SlopeSupport::kPaperPca;
  const cv::Mat1f plane = Assess(map).slope, pca = Assess(map, paper).slope;
  const cv::Rect inner(5, 5, 50, 50);
  CHECK(DegFromRad(cv::mean(plane(inner))[0]) < 1.0);
  CHECK(DegFromRad(cv::mean(pca(inner))[0]) > 4.0);
}

TEST_CASE("hazard: the ruggedness of an even plane of 8 degrees is 0.34 m") {
  for (const double aspect_deg : {0.0, 90.0, 137.0}) {
    CHECK(Assess(Tilted(11, 8.0, aspect_deg)).roughness(5, 5) ==
          doctest::Approx(0.344).epsilon(0.003));
  }
}

TEST_CASE("hazard: ruggedness needs all nine cells") {
  ElevationMap map = FlatMap(11);
  MakeUnseen(map, 5, 5);
  const HazardLayers layers = Assess(map);
  for (int row = 0; row < 11; ++row) {
    for (int col = 0; col < 11; ++col) {
      const bool is_border = row == 0 || col == 0 || row == 10 || col == 10;
      const bool is_near_hole = std::abs(row - 5) <= 1 && std::abs(col - 5) <= 1;
      CHECK(std::isnan(layers.roughness(row, col)) == (is_border || is_near_hole));
      if (is_border || is_near_hole) CHECK(layers.hazard(row, col) == kUnseen);
    }
  }
}

TEST_CASE("hazard: finer cells do not slacken the roughness limit") {
  ElevationMap map = Tilted(41, 8.0, 90.0);
  map.grid.cell_size_m = 0.25;
  map.elevation = (map.elevation - 100.0) * 0.25 + 100.0;
  map.upper = map.elevation.clone();
  CHECK(Assess(map).roughness(20, 20) == doctest::Approx(0.344).epsilon(0.003));
}

TEST_CASE("hazard: flat seen grass is free, and each fault alone makes its cell unsafe") {
  const HazardLayers layers = Assess(FlatMap(31));
  CHECK(layers.hazard(15, 15) == kFree);
  CHECK(layers.distance(15, 15) == doctest::Approx(15.0));

  ElevationMap uncertain = FlatMap(31);
  uncertain.standard_deviation(15, 15) = 1.5f;
  CHECK(Assess(uncertain).hazard(15, 15) == kUnseen);
  uncertain.standard_deviation(15, 15) = kNaN;
  CHECK(Assess(uncertain).hazard(15, 15) == kUnseen);

  ElevationMap pole = FlatMap(31);
  pole.upper(15, 15) = pole.elevation(15, 15) + 4.0f;
  CHECK(Assess(pole).hazard(15, 15) == kHazard);
  CHECK(Assess(pole).hazard(15, 16) == kFree);
  pole.upper(15, 15) = kNaN;
  CHECK(Assess(pole).hazard(15, 15) != kFree);

  CHECK(Assess(Tilted(31, 8.2, 45.0)).hazard(15, 15) == kHazard);
  CHECK(Assess(Tilted(31, 7.8, 45.0)).hazard(15, 15) == kFree);

  ElevationMap step = FlatMap(31);
  step.elevation(15, 15) += 0.6f;
  step.upper(15, 15) += 0.6f;
  CHECK(Assess(step).hazard(15, 15) == kHazard);

  CHECK(AssessHazards(FlatMap(31), {}, {}, {}).hazard(15, 15) == kHazard);
  CHECK(AssessHazards(FlatMap(31), {NadirView(kSurelyNot)}, {}, {}).hazard(15, 15) == kHazard);
}

TEST_CASE("hazard: unknown is never safe: holes shrink the distance to hazard or leave it") {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> place(0, 39);
  std::normal_distribution<float> noise(0.0f, 0.03f);
  ElevationMap map = Tilted(40, 4.0, 30.0);
  for (float& height : map.elevation) height += noise(random);
  HazardLayers before = Assess(map);
  REQUIRE(cv::countNonZero(before.hazard == kFree) > 900);
  for (int round = 0; round < 40; ++round) {
    for (int i = 0; i < 5; ++i) MakeUnseen(map, place(random), place(random));
    const HazardLayers after = Assess(map);
    for (int row = 0; row < 40; ++row) {
      for (int col = 0; col < 40; ++col) {
        if (!map.IsSeen(row, col)) REQUIRE(after.hazard(row, col) == kUnseen);
        // A hole may move the fitted plane, but on even ground no cell becomes safer by it.
        if (before.hazard(row, col) == kUnseen) REQUIRE(after.hazard(row, col) == kUnseen);
      }
    }
    REQUIRE(cv::countNonZero(after.distance > before.distance + 1e-4) == 0);
    before = after;
  }
}

TEST_CASE("hazard: an empty or wholly unseen map has no free cell") {
  const HazardLayers none = AssessHazards(ElevationMap{}, TwoNadirViews(kSurelyGrass), {}, {});
  CHECK(none.hazard.empty());
  ElevationMap unseen = FlatMap(9);
  for (int i = 0; i < 81; ++i) MakeUnseen(unseen, i / 9, i % 9);
  const HazardLayers layers = Assess(unseen);
  CHECK(cv::countNonZero(layers.hazard != kUnseen) == 0);
  CHECK(cv::countNonZero(layers.distance) == 0);
}

TEST_CASE("hazard: the distance is exact against every pair of cells") {
  std::mt19937 random(3);
  for (const double share : {0.0, 0.002, 0.05, 0.5, 1.0}) {
    ElevationMap map = FlatMap(37);
    std::bernoulli_distribution is_blocked(share);
    for (float& upper : map.upper) {
      if (is_blocked(random)) upper += 10.0f;
    }
    const HazardLayers layers = Assess(map);
    double max_error = 0.0;
    for (int cell = 0; cell < 37 * 37; ++cell) {
      const int row = cell / 37, col = cell % 37;
      int nearest = 1 << 20;
      for (int r = -1; r <= 37; ++r) {
        for (int c = -1; c <= 37; ++c) {
          const bool is_outside = r < 0 || c < 0 || r == 37 || c == 37;
          if (!is_outside && layers.hazard(r, c) == kFree) continue;
          nearest = std::min(nearest, (r - row) * (r - row) + (c - col) * (c - col));
        }
      }
      max_error = std::max(max_error, std::abs(layers.distance(row, col) - std::sqrt(nearest)));
    }
    CHECK(max_error < 1e-5);
  }
}

TEST_CASE("hazard: masks land where they were seen: north up, east right") {
  KindView view = NadirView(kSurelyNot);
  view.picture.grass(cv::Rect(50, 0, 50, 50)).setTo(kSurelyGrass);  // image top right = north-east
  const HazardLayers layers = AssessHazards(FlatMap(60), {view}, {}, {});
  CHECK(layers.grass(10, 50) > 0.8);
  CHECK(layers.grass(10, 10) < 0.2);
  CHECK(layers.grass(50, 50) < 0.2);
  CHECK(layers.grass(50, 10) < 0.2);
}

TEST_CASE("hazard: a distorted camera's mask is met where the camera sees the cell") {
  KindView view = NadirView(kSurelyNot);
  view.camera.distortion = DistortionModel::kRadTan;
  view.camera.coefficients = {-0.2, 0.0, 0.0, 0.0};
  const Eigen::Vector3d place(30.5, 20.5, 100.0);
  const auto pixel = view.camera.ImageFromCamera(Inverse(view.world_from_camera) * place);
  REQUIRE(pixel);
  const int x = static_cast<int>(std::lround((pixel->x() + 0.5) / 4.0 - 0.5));
  const int y = static_cast<int>(std::lround((pixel->y() + 0.5) / 4.0 - 0.5));
  view.picture.grass(y, x) = kSurelyGrass;
  const ElevationMap map = FlatMap(80);
  const cv::Point cell = *map.grid.CellAt(place.head<2>());
  HazardOptions options;
  options.cover.kind_smoothing_m = 0.0;
  const HazardLayers layers = AssessHazards(map, {view}, {}, options);
  CHECK(layers.grass(cell) > 0.8);
  CHECK(cv::countNonZero(layers.grass > 0.5) < 4);
}

TEST_CASE(
    "hazard: with 5 % false positives of 20 views, OR calls most cells grass, the posterior none") {
  std::mt19937 random(11);
  std::bernoulli_distribution is_false(0.05);
  std::vector<KindView> on_soil, on_grass;
  for (int i = 0; i < 20; ++i) {
    KindView soil = NadirView(kSurelyNot), grass = NadirView(kSurelyGrass);
    for (int pixel = 0; pixel < 100 * 100; ++pixel) {
      if (is_false(random)) soil.picture.grass(pixel / 100, pixel % 100) = kSurelyGrass;
      if (is_false(random)) grass.picture.grass(pixel / 100, pixel % 100) = kSurelyNot;
    }
    on_soil.push_back(soil);
    on_grass.push_back(grass);
  }
  const ElevationMap map = FlatMap(80);
  HazardOptions paper;
  paper.cover.grass_fusion = GrassFusion::kPaperOr;
  paper.cover.kind_smoothing_m = 0.0;
  const double num_cells = 80.0 * 80.0;
  const auto grass_share = [&](const std::vector<KindView>& views, const HazardOptions& options) {
    return cv::countNonZero(AssessHazards(map, views, {}, options).grass >= 0.8) / num_cells;
  };
  CHECK(grass_share(on_soil, paper) == doctest::Approx(0.64).epsilon(0.05));
  CHECK(grass_share(on_soil, {}) == 0.0);
  CHECK(grass_share(on_grass, {}) > 0.999);
}

TEST_CASE("hazard: one view alone leaves a tenth of doubt, two that agree a hundredth") {
  const ElevationMap map = FlatMap(20);
  const std::vector<KindView> one{NadirView(kSurelyGrass)};
  CHECK(AssessHazards(map, one, {}, {}).grass(10, 10) == doctest::Approx(0.9).epsilon(0.01));
  const HazardLayers two = AssessHazards(map, TwoNadirViews(kSurelyGrass), {}, {});
  CHECK(two.grass(10, 10) == doctest::Approx(0.99).epsilon(0.01));
  CHECK(two.hazard(10, 10) == kFree);
}

TEST_CASE("hazard: a slip of the network within a meadow heals, a road through it stays") {
  KindView view = NadirView(kSurelyGrass);
  view.picture.grass(60, 30) = 120;
  view.picture.grass.col(50).setTo(kSurelyNot);
  view.picture.grass.col(51).setTo(kSurelyNot);
  const ElevationMap map = FlatMap(80);
  const Orthophoto photo = photo::Painted(80.0, [](const Eigen::Vector2d& place) {
    const bool is_road = place.x() >= 0.0 && place.x() < 2.0;
    return is_road ? photo::Color(110.0, 115.0, 120.0) : photo::kGreen;
  });
  const HazardLayers layers = AssessHazards(map, {2, view}, {}, {}, photo);
  const auto grass_at = [&](double east, double north) {
    return layers.grass(*map.grid.CellAt({east, north}));
  };
  CHECK(grass_at(-19.5, -10.5) >= 0.8);
  CHECK(grass_at(0.5, 0.5) < 0.2);
  CHECK(grass_at(1.5, 20.5) < 0.2);
  CHECK(grass_at(20.5, 0.5) > 0.95);
}

TEST_CASE("hazard: many agreeing views never make certainty, and a tie is not grass") {
  const ElevationMap map = FlatMap(20);
  const std::vector<KindView> many(50, NadirView(kSurelyGrass));
  CHECK(AssessHazards(map, many, {}, {}).grass(10, 10) < 0.9999);
  const std::vector<KindView> tie{NadirView(kSurelyGrass), NadirView(kSurelyNot)};
  CHECK(AssessHazards(map, tie, {}, {}).grass(10, 10) == doctest::Approx(0.5));
  CHECK(AssessHazards(map, tie, {}, {}).hazard(10, 10) == kHazard);
}

TEST_CASE(
    "hazard: pixels that were not classified do not vote, and one slip among many is no class") {
  const ElevationMap map = FlatMap(20);
  std::vector<KindView> views(9, NadirView(0));
  CHECK(std::isnan(AssessHazards(map, views, {}, {}).grass(10, 10)));
  views.push_back(NadirView(kSurelyGrass));
  CHECK(std::isnan(AssessHazards(map, views, {}, {}).grass(10, 10)));
  CHECK(AssessHazards(map, {NadirView(0), NadirView(kSurelyGrass)}, {}, {}).grass(10, 10) > 0.8);
}

TEST_CASE("hazard: other limits on stored layers give what a new assessment gives") {
  const ElevationMap map = MapOf(60, [](double east, double north) {
    return 3.0 * std::sin(east / 8.0) + 2.0 * std::cos(north / 5.0);
  });
  const std::vector<KindView> views = TwoNadirViews(kSurelyGrass);
  const HazardLimits steep{.max_slope_deg = 15.0, .max_roughness_m = 0.9};
  const HazardLayers anew = AssessHazards(map, views, steep, {});
  const HazardLayers renewed = WithLimits(map, AssessHazards(map, views, {}, {}), steep, {});
  CHECK(cv::countNonZero(anew.hazard != renewed.hazard) == 0);
  CHECK(cv::countNonZero(anew.distance != renewed.distance) == 0);
  CHECK(cv::countNonZero(anew.hazard == kFree) > 0);
  CHECK_THROWS_AS(WithLimits(FlatMap(5), anew, steep, {}), std::invalid_argument);
}

TEST_CASE("hazard: Check names field, value and constraint") {
  const auto is_refused = [](const auto& change) {
    HazardOptions options;
    change(options);
    try {
      options.Check();
    } catch (const std::invalid_argument&) {
      return true;
    }
    return false;
  };
  CHECK_FALSE(is_refused([](HazardOptions&) {}));
  CHECK(is_refused([](HazardOptions& o) { o.cover.min_grass_posterior = 0.4; }));
  CHECK(is_refused([](HazardOptions& o) { o.cover.min_observation_probability = 0.0; }));
  CHECK(is_refused([](HazardOptions& o) { o.cover.max_observation_probability = 1.0; }));
  CHECK(is_refused([](HazardOptions& o) { o.cover.max_num_independent_views = 0.0; }));
  CHECK(is_refused([](HazardOptions& o) { o.cover.clear_class.min_clear_class_posterior = 2; }));
  CHECK(is_refused([](HazardOptions& o) { o.cover.min_vote_ratio = 1.1; }));
  CHECK(is_refused([](HazardOptions& o) { o.surface.plane_support_m = std::nan(""); }));
  CHECK(is_refused([](HazardOptions& o) { o.surface.min_support_ratio = 0.0; }));
  CHECK(is_refused([](HazardOptions& o) { o.surface.roughness_spacing_m = 0.0; }));
  CHECK(is_refused([](HazardOptions& o) { o.cover.upper_margin_m = -1.0; }));
  CHECK(is_refused([](HazardOptions& o) { o.surface.max_standard_deviation_m = 0.0; }));
  CHECK(is_refused([](HazardOptions& o) { o.cover.fence_filter_length_m = 1.0; }));
  CHECK(is_refused([](HazardOptions& o) { o.cover.min_num_posts = -1; }));
  CHECK(is_refused([](HazardOptions& o) { o.cover.min_fence_deviations = -1.0; }));
  CHECK(is_refused([](HazardOptions& o) { o.cover.min_post_deviations = -1.0; }));
  HazardOptions options;
  options.surface.plane_support_m = 0.0;
  CHECK_THROWS_WITH_AS(
      options.Check(), "hazard.plane_support_m = 0: must be in [0.1, 100]", std::invalid_argument);
  CHECK_THROWS_AS(AssessHazards(FlatMap(5), {}, {.max_slope_deg = -1.0}, {}),
                  std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
