#include "engine/heights/heights.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/engine/stereo/scene.h"

namespace freelsd {
namespace {

constexpr double kFlightHeightM = 60.0;
constexpr double kMaxGroundErrorM = 0.1;

// Four legs' worth of views about the origin.
std::vector<Rigid3d> NineViews() {
  std::vector<Rigid3d> views;
  for (const double east : {-15.0, 0.0, 15.0}) {
    for (const double north : {-12.0, 0.0, 12.0}) {
      views.push_back(SceneView({east, north, kFlightHeightM}, 0.1 * east));
    }
  }
  return views;
}

Scene SceneOf(const HeightField& height, double contrast = 1.0) {
  return {SceneCamera(), height, GroundTexture(contrast)};
}

ImageSource Photographs(const Scene& scene, const AdjustedBlock& block) {
  return [&scene, &block](const std::string& id) {
    const size_t view = std::stoul(id);
    return Render(scene, block.views[view].world_from_camera, view + 1);
  };
}

// What pairs would propose: `error` above a plane that falls as the scene does.
ElevationMap Proposal(const HeightField& height, int num_cells, double error) {
  ElevationMap map;
  map.grid = {{-0.5 * num_cells, 0.5 * num_cells}, 1.0, num_cells, num_cells};
  map.elevation = cv::Mat1f(num_cells, num_cells);
  for (int row = 0; row < num_cells; ++row) {
    for (int col = 0; col < num_cells; ++col) {
      const Eigen::Vector2d place = map.grid.CellCenter(row, col);
      map.elevation(row, col) = static_cast<float>(height(place.x(), place.y()) + error);
    }
  }
  map.upper = map.elevation + 0.2f;
  map.standard_deviation = cv::Mat1f(num_cells, num_cells, 0.2f);
  map.num_points = cv::Mat1f(num_cells, num_cells, 20.0f);
  return map;
}

double Level(double, double) { return 0.0; }
double Sloping(double east, double) { return 0.1 * east; }

CannotTell CauseAt(const PhotographHeights& heights, double east, double north) {
  const auto cell = heights.grid.CellAt({east, north});
  return static_cast<CannotTell>(heights.cannot_tell(*cell));
}

TEST_CASE("heights: on a slope that the proposal misses by half a metre the ground is right") {
  const Scene scene = SceneOf(Sloping);
  const AdjustedBlock block = SceneBlock(scene, NineViews());
  const PhotographHeights heights =
      MeasureHeights(Proposal(Sloping, 24, 0.5), block, Photographs(scene, block), {});
  double sum_of_squares = 0.0;
  int num_told = 0;
  for (int row = 2; row < 22; ++row) {
    for (int col = 2; col < 22; ++col) {
      if (!std::isfinite(heights.ground(row, col))) continue;
      const Eigen::Vector2d place = heights.grid.CellCenter(row, col);
      sum_of_squares += std::pow(heights.ground(row, col) - Sloping(place.x(), place.y()), 2);
      ++num_told;
    }
  }
  CHECK(num_told > 390);
  CHECK(std::sqrt(sum_of_squares / num_told) < kMaxGroundErrorM);
}

TEST_CASE("heights: a box that no pair proposes lifts the upper height or is unknown") {
  const HeightField box = [](double east, double north) {
    return std::abs(east) < 0.6 && std::abs(north) < 0.6 ? 1.2 : 0.0;
  };
  const Scene scene = SceneOf(box);
  const AdjustedBlock block = SceneBlock(scene, NineViews());
  const ElevationMap proposal = Proposal(Level, 24, 0.0);
  const ElevationMap map =
      WithHeights(proposal, MeasureHeights(proposal, block, Photographs(scene, block), {}));
  bool is_told = false;
  for (const double east : {-0.5, 0.5}) {
    for (const double north : {-0.5, 0.5}) {
      const auto cell = map.grid.CellAt({east, north});
      is_told = is_told || std::isnan(map.standard_deviation(*cell)) || map.upper(*cell) > 0.6f;
    }
  }
  CHECK(is_told);
  CHECK(map.is_compared);
}

TEST_CASE("heights: ground without contrast and ground seen once cannot be told, and say why") {
  const Scene bare = SceneOf(Level, 0.0);
  const AdjustedBlock block = SceneBlock(bare, NineViews());
  const ElevationMap proposal = Proposal(Level, 12, 0.0);
  CHECK(CauseAt(MeasureHeights(proposal, block, Photographs(bare, block), {}), 0.5, 0.5) ==
        CannotTell::kNoContrast);
  const Scene scene = SceneOf(Level);
  const AdjustedBlock alone = SceneBlock(scene, {SceneView({0.0, 0.0, kFlightHeightM}, 0.0)});
  const PhotographHeights heights = MeasureHeights(proposal, alone, Photographs(scene, alone), {});
  CHECK(CauseAt(heights, 0.5, 0.5) == CannotTell::kTooFewViews);
  const ElevationMap map = WithHeights(proposal, heights);
  CHECK(std::isnan(map.standard_deviation(6, 6)));
  CHECK(map.elevation(6, 6) == proposal.elevation(6, 6));
}

TEST_CASE("heights: views from nearly one place have too little parallax") {
  const Scene scene = SceneOf(Level);
  std::vector<Rigid3d> views;
  for (const double east : {-2.0, 0.0, 2.0, 4.0}) {
    views.push_back(SceneView({east, 0.0, kFlightHeightM}, 0.0));
  }
  const AdjustedBlock block = SceneBlock(scene, views);
  const PhotographHeights heights =
      MeasureHeights(Proposal(Level, 12, 0.0), block, Photographs(scene, block), {});
  CHECK(CauseAt(heights, 0.5, 0.5) == CannotTell::kTooLittleParallax);
}

TEST_CASE("heights: an empty map and missing images give no heights") {
  const Scene scene = SceneOf(Level);
  const AdjustedBlock block = SceneBlock(scene, NineViews());
  CHECK(MeasureHeights({}, block, Photographs(scene, block), {}).ground.empty());
  const PhotographHeights heights = MeasureHeights(
      Proposal(Level, 12, 0.0), block, [](const std::string&) { return cv::Mat(); }, {});
  CHECK(CauseAt(heights, 0.5, 0.5) == CannotTell::kTooFewViews);
}

TEST_CASE("heights: the result does not depend on the number of threads") {
  const Scene scene = SceneOf(Sloping);
  const AdjustedBlock block = SceneBlock(scene, NineViews());
  const int num_threads = cv::getNumThreads();
  cv::Mat1f ground[2];
  for (int i = 0; i < 2; ++i) {
    cv::setNumThreads(i == 0 ? 1 : 4);
    ground[i] =
        MeasureHeights(Proposal(Sloping, 12, 0.3), block, Photographs(scene, block), {}).ground;
  }
  cv::setNumThreads(num_threads);
  CHECK(std::equal(ground[0].begin(), ground[0].end(), ground[1].begin(), [](float a, float b) {
    return a == b || (std::isnan(a) && std::isnan(b));
  }));
}

TEST_CASE("heights: options out of range are refused by name") {
  HeightsOptions options;
  options.max_num_views = 1;
  CHECK_THROWS_WITH_AS(
      options.Check(), "heights.max_num_views = 1: must be in [2, 100]", std::invalid_argument);
}

// The surface that is searched from is the proposal, which is half a metre too high here.
TEST_CASE("heights: the likelihood of one place peaks at its ground, and tells what shows it") {
  const Scene scene = SceneOf(Sloping);
  const AdjustedBlock block = SceneBlock(scene, NineViews());
  const ElevationMap proposal = Proposal(Sloping, 24, 0.5);
  const Eigen::Vector2d place(3.5, -2.5);
  const auto found = HeightLikelihoodAt(place, proposal, block, Photographs(scene, block), {});
  REQUIRE(found);
  CHECK(found->num_views >= 4);
  CHECK(found->correlation > 0.5);
  CHECK(found->baseline_ratio > 0.3);
  REQUIRE(found->heights.size() == found->log_likelihood.size());
  const auto best = std::max_element(found->log_likelihood.begin(), found->log_likelihood.end());
  CHECK(*best == 0.0);
  const auto index = static_cast<size_t>(best - found->log_likelihood.begin());
  CHECK(std::abs(found->heights[index] - Sloping(place.x(), place.y())) <= 0.25);
  // A metre beside, the photographs disagree.
  CHECK(found->log_likelihood.front() < -10.0);
  CHECK(found->log_likelihood.back() < -10.0);
}

TEST_CASE("heights: a place off the map, unseen or seen once has no likelihood") {
  const Scene scene = SceneOf(Level);
  const AdjustedBlock block = SceneBlock(scene, NineViews());
  ElevationMap proposal = Proposal(Level, 12, 0.0);
  const ImageSource images = Photographs(scene, block);
  CHECK_FALSE(HeightLikelihoodAt({100.0, 0.0}, proposal, block, images, {}));
  proposal.elevation(6, 6) = std::nanf("");
  CHECK_FALSE(HeightLikelihoodAt(proposal.grid.CellCenter(6, 6), proposal, block, images, {}));
  const AdjustedBlock alone = SceneBlock(scene, {SceneView({0.0, 0.0, kFlightHeightM}, 0.0)});
  CHECK_FALSE(HeightLikelihoodAt({2.5, 2.5}, proposal, alone, Photographs(scene, alone), {}));
}

}  // namespace
}  // namespace freelsd
