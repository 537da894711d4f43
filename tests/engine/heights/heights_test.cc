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

// The surface that is searched from is the proposal, which is half a metre too high here.
TEST_CASE("heights: the likelihood of one place peaks at its ground, and tells what shows it") {
  const Scene scene = SceneOf(Sloping);
  const AdjustedBlock block = SceneBlock(scene, NineViews());
  const ElevationMap proposal = Proposal(Sloping, 24, 0.5);
  const Eigen::Vector2d place(3.5, -2.5);
  const auto found = HeightLikelihoodAt(place, proposal, block, Photographs(scene, block));
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
  CHECK_FALSE(HeightLikelihoodAt({100.0, 0.0}, proposal, block, images));
  proposal.elevation(6, 6) = std::nanf("");
  CHECK_FALSE(HeightLikelihoodAt(proposal.grid.CellCenter(6, 6), proposal, block, images));
  const AdjustedBlock alone = SceneBlock(scene, {SceneView({0.0, 0.0, kFlightHeightM}, 0.0)});
  CHECK_FALSE(HeightLikelihoodAt({2.5, 2.5}, proposal, alone, Photographs(scene, alone)));
}

}  // namespace
}  // namespace freelsd
