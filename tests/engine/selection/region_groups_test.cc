// Which regions share a map, and which views take part.
#include <algorithm>

#include <doctest/doctest.h>

#include "engine/selection/selection.h"
#include "tests/engine/camera.h"

namespace freelsd {
namespace {

Candidate RegionAt(int id, double east, double north) {
  Region region;
  region.id = id;
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(-20, -20), {20, -20}, {20, 20}, {-20, 20}}) {
    region.corners_in_world.emplace_back(east + corner.x(), north + corner.y(), 0.0);
  }
  return {region, std::nullopt};
}

// Looking down from 100 m, every `spacing` metres along a line to the east; neighbours share
// tracks.
Snapshot LineFlight(int num_views, double spacing) {
  Snapshot snapshot;
  Camera& camera = snapshot.rig.camera;
  camera = CenteredCamera(752, 480, 450.0);
  for (int i = 0; i < num_views; ++i) {
    View view;
    view.frame_id = std::to_string(i);
    view.timestamp_us = i;
    view.world_from_camera.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()));
    view.world_from_camera.translation = {i * spacing, 0.0, 100.0};
    view.prior_position_in_world = view.world_from_camera.translation;
    view.height_above_ground = 100.0;
    for (int k = 0; k < 20; ++k) {
      view.observations.push_back({1000 * i + k, Eigen::Vector2d(30.0 * k, 200.0)});
      if (i > 0)
        view.observations.push_back({1000 * (i - 1) + k, Eigen::Vector2d(30.0 * k, 100.0)});
    }
    snapshot.views.push_back(view);
  }
  return snapshot;
}

size_t NumRegions(const std::vector<RegionGroup>& groups) {
  size_t count = 0;
  for (const RegionGroup& group : groups) count += group.regions.size();
  return count;
}

TEST_CASE("region groups: a small flight has one map of all photographed ground") {
  const Snapshot snapshot = LineFlight(10, 30.0);
  const std::vector<Candidate> regions{RegionAt(7, 200, 0), RegionAt(3, 0, 0), RegionAt(5, 100, 0)};
  const auto groups = GroupRegions(snapshot, regions, {});
  REQUIRE(groups.size() == 1);
  CHECK(groups[0].regions[0].region.id == 7);
  CHECK(groups[0].regions[1].region.id == 3);
  // Half the diagonal of an image at 100 m is about 99 m.
  CHECK(groups[0].area.min.x() == doctest::Approx(-99.0).epsilon(0.02));
  CHECK(groups[0].area.max.x() == doctest::Approx(270.0 + 99.0).epsilon(0.02));
  const auto without_regions = GroupRegions(snapshot, {}, {});
  REQUIRE(without_regions.size() == 1);
  CHECK(without_regions[0].regions.empty());
  CHECK(without_regions[0].area.min == groups[0].area.min);
  CHECK(GroupRegions({}, {}, {}).empty());
}

TEST_CASE("region groups: in a long flight near ones share a map, best first, far ones do not") {
  const Snapshot snapshot = LineFlight(310, 30.0);
  std::vector<Candidate> regions{RegionAt(7, 200, 0), RegionAt(3, 0, 0), RegionAt(5, 100, 0)};
  regions.push_back(RegionAt(1, 9000, 0));
  regions.push_back(RegionAt(2, 0, 20000));
  const auto groups = GroupRegions(snapshot, regions, {});
  REQUIRE(groups.size() == 3);
  CHECK(NumRegions(groups) == regions.size());
  const auto near = std::find_if(groups.begin(), groups.end(), [](const RegionGroup& group) {
    return group.regions.size() == 3;
  });
  REQUIRE(near != groups.end());
  CHECK(near->regions[0].region.id == 7);
  CHECK(near->area.max.x() == doctest::Approx(220.0 + 400.0));
  CHECK(GroupRegions(snapshot, {}, {}).empty());
}

TEST_CASE("region groups: those that need too many views are split, and none is lost") {
  const Snapshot snapshot = LineFlight(60, 30.0);
  PipelineOptions options;
  options.backend.max_num_views = 20;
  options.backend.max_surroundings_m = 50.0;
  std::vector<Candidate> regions;
  regions.reserve(8);
  for (int i = 0; i < 8; ++i) regions.push_back(RegionAt(i, 200.0 * i, 0.0));
  const auto groups = GroupRegions(snapshot, regions, options);
  CHECK(groups.size() > 1);
  CHECK(NumRegions(groups) == regions.size());
  for (const RegionGroup& group : groups) {
    const Selection selection =
        SelectViews(snapshot, group.area, options.adjustment, options.backend);
    CHECK(selection.num_seeing == selection.views.size());
    CHECK(selection.views.size() >= 2);
  }
}

TEST_CASE("region groups: of too many views those about the region's middle are taken") {
  const Snapshot snapshot = LineFlight(60, 30.0);
  PipelineOptions options;
  options.backend.max_num_views = 10;
  options.backend.max_surroundings_m = 200.0;
  const Box area = AreaAround({RegionAt(1, 900, 0)}, options.backend);
  const Selection selection = SelectViews(snapshot, area, options.adjustment, options.backend);
  CHECK(selection.views.size() == 10);
  CHECK(selection.num_seeing > 10);
  CHECK(std::is_sorted(selection.indices.begin(), selection.indices.end()));
  for (const View& view : selection.views) {
    CHECK(std::abs(view.world_from_camera.translation.x() - 900.0) < 300.0);
  }
}

}  // namespace
}  // namespace freelsd
