#include "tests/evaluation/frames/rendered_pictures.h"

#include <algorithm>

#include "tests/synthetic/renderer.h"

namespace freelsd {
namespace {

constexpr double kFrameSpacingM = 75.0;
constexpr double kLegSpacingM = 90.0;
constexpr double kTexturedCellM = 0.1;

struct SeenGround {
  cv::Mat1b cover;
  // Along the optical axis, metres.
  double median_depth_m = 0.0;
};

// What each pixel of a photograph shows; doubt outside of the world.
SeenGround SeenFrom(const Scenario& scenario, const Renderer& renderer, size_t exposure) {
  const Camera& camera = scenario.rig.camera;
  const Rigid3d world_from_camera = scenario.TrueWorldFromCamera(exposure);
  const Eigen::Vector3d axis_in_world = world_from_camera.rotation * Eigen::Vector3d::UnitZ();
  SeenGround seen;
  seen.cover = cv::Mat1b(camera.height_px, camera.width_px, static_cast<uint8_t>(Cover::kDoubt));
  cv::Mat1f depths(seen.cover.size(), 0.0f);
  cv::parallel_for_({0, camera.height_px}, [&](const cv::Range& rows) {
    for (int row = rows.start; row < rows.end; ++row) {
      for (int col = 0; col < camera.width_px; ++col) {
        const Eigen::Vector3d ray =
            world_from_camera.rotation * camera.RayFromImage(Eigen::Vector2d(col, row));
        const auto hit = renderer.FirstHit(world_from_camera.translation, ray);
        if (!hit || hit->head<2>().cwiseAbs().maxCoeff() > 0.5 * scenario.world.size_m) continue;
        seen.cover(row, col) = static_cast<uint8_t>(scenario.world.CoverAt(hit->x(), hit->y()));
        depths(row, col) =
            static_cast<float>((*hit - world_from_camera.translation).dot(axis_in_world));
      }
    }
  });
  auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.total() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  seen.median_depth_m = *middle;
  return seen;
}

}  // namespace

std::vector<WorldLook> WorldLooks(Pool pool, int num_frames) {
  ScenarioOptions painted;
  painted.num_frames = num_frames;
  painted.frame_spacing_m = kFrameSpacingM;
  painted.leg_spacing_m = kLegSpacingM;
  ScenarioOptions textured = painted;
  textured.texture = textured.conditions = "recorded";
  ScenarioOptions ground = textured;
  textured.cell_size_m = kTexturedCellM;
  ground.ground = NameOf(pool);
  return {{"painted", painted}, {"textured", textured}, {"ground", ground}};
}

std::vector<LabelledPicture> RenderPictures(uint64_t seed, const WorldLook& look, PoolOfRun& run) {
  const Pools& pools = EvaluationPools();
  run.Add("seed " + std::to_string(seed), pools.OfSeed(seed));
  const Scenario scenario = MakeScenario(seed, look.scenario, [](double) {});
  const std::string pack = scenario.ground.substr(0, scenario.ground.find('/'));
  run.Add("ground " + pack, pools.Of("ground", pack));
  const Renderer renderer(scenario.world);
  std::vector<LabelledPicture> pictures;
  for (size_t i = 0; i < scenario.frames.size(); ++i) {
    const SeenGround seen = SeenFrom(scenario, renderer, i);
    LabelledPicture picture;
    picture.name = look.name + "_" + std::to_string(seed) + "_" + std::to_string(i) +
                   (pack.empty() ? "" : "_" + pack);
    picture.look = look.name;
    picture.image = scenario.frames[i].image;
    picture.cover = seen.cover;
    picture.ground_sampling_m = seen.median_depth_m / scenario.rig.camera.MeanFocalPx();
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

}  // namespace freelsd
