#include "engine/provenance/provenance.h"

#include <stdexcept>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

// Views straight down from 100 m, each showing 100 m by 100 m.
AdjustedBlock BlockAt(const std::vector<double>& easts_m) {
  AdjustedBlock block;
  block.camera.width_px = block.camera.height_px = 100;
  block.camera.fx_px = block.camera.fy_px = 100.0;
  block.camera.cx_px = block.camera.cy_px = 49.5;
  for (const double east_m : easts_m) {
    AdjustedView view;
    view.world_from_camera = {Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0), {east_m, 0.0, 100.0}};
    view.is_connected = true;
    block.views.push_back(view);
  }
  return block;
}

TEST_CASE("provenance: what shows a place comes first, the wider pair weighs more") {
  const AdjustedBlock block = BlockAt({0.0, 10.0, 40.0, 70.0, 200.0, 400.0});
  const std::vector<StereoPair> pairs{{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}};
  const Provenance provenance = ProvenanceOf({20.0, 0.0, 0.0}, block, pairs, 0.0, {10.0, 0.0});
  // Views 0 to 2 show it; view 3 begins at 20 m, beside its middle pixel.
  REQUIRE(provenance.sources.size() >= 3);
  CHECK(provenance.sources[0].view == 1);
  double sum = 0.0;
  for (const SourceView& source : provenance.sources) sum += source.weight;
  CHECK(sum == doctest::Approx(1.0));
  for (const SourceView& source : provenance.sources) {
    if (source.view == 0) CHECK(source.pixel.x() == doctest::Approx(69.5));
    if (source.view == 2) CHECK(source.pixel.x() == doctest::Approx(29.5));
  }
}

TEST_CASE("provenance: context is what shows ground around, and its partners, and no more") {
  const AdjustedBlock block = BlockAt({0.0, 10.0, 75.0, 200.0, 400.0});
  const std::vector<StereoPair> pairs{{0, 1}, {2, 3}, {3, 4}};
  const Provenance provenance = ProvenanceOf({0.0, 0.0, 0.0}, block, pairs, 0.0, {40.0, 0.0});
  CHECK(provenance.sources.size() == 2);
  // View 2 shows ground from 25 m on; view 3 was matched with it.
  CHECK(provenance.context == std::vector<size_t>{2, 3});
  // The nearest hazard is far, and what is behind it counts.
  const Provenance far = ProvenanceOf({0.0, 0.0, 0.0}, block, pairs, 130.0, {40.0, 30.0});
  CHECK(far.context == std::vector<size_t>{2, 3, 4});
}

TEST_CASE("provenance: without pairs all weights are 0, and views that fit nowhere do not count") {
  AdjustedBlock block = BlockAt({0.0, 10.0});
  block.views[1].is_connected = false;
  const Provenance provenance = ProvenanceOf({0.0, 0.0, 0.0}, block, {}, 0.0, {});
  REQUIRE(provenance.sources.size() == 1);
  CHECK(provenance.sources[0].weight == 0.0);
  CHECK_THROWS_AS(ProvenanceOf({0.0, 0.0, 0.0}, block, {}, 0.0, {.context_m = -1.0}),
                  std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
