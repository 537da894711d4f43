#include "engine/footprint/footprint.h"

#include <limits>

namespace freelsd {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kNumBorderSamples = 16;
// Lenses bend the border between its samples by less than this share of the footprint.
constexpr double kFootprintMargin = 0.02;
// Rays that are flatter than this show the horizon, or nearly.
constexpr double kMinDescent = 0.02;
// Where ground is taken as level, flatter rays end too far from where they should.
constexpr double kMinCornerDescent = 0.2;

}  // namespace

HeightRange HeightRangeOf(const cv::Mat1f& heights) {
  HeightRange range{kInfinity, -kInfinity};
  const cv::Mat1b is_known(heights == heights);
  if (cv::countNonZero(is_known) == 0) return range;
  cv::minMaxLoc(heights, &range.lowest_m, &range.highest_m, nullptr, nullptr, is_known);
  return range;
}

Footprint FootprintOf(const Camera& camera,
                      const Rigid3d& world_from_camera,
                      double lowest_m,
                      double highest_m) {
  const Eigen::Vector3d& eye = world_from_camera.translation;
  Footprint everything{Eigen::Vector2d::Constant(-kInfinity), Eigen::Vector2d::Constant(kInfinity)};
  if (eye.z() <= highest_m) return everything;
  Footprint footprint{everything.max_in_world, everything.min_in_world};
  for (int i = 0; i < 4 * kNumBorderSamples; ++i) {
    const double along = double(i % kNumBorderSamples) / kNumBorderSamples;
    const double right = camera.width_px - 1.0, bottom = camera.height_px - 1.0;
    const Eigen::Vector2d corners[] = {{0.0, 0.0}, {right, 0.0}, {right, bottom}, {0.0, bottom}};
    const int side = i / kNumBorderSamples;
    const Eigen::Vector2d pixel = (1.0 - along) * corners[side] + along * corners[(side + 1) % 4];
    const Eigen::Vector3d ray = world_from_camera.rotation * camera.RayFromImage(pixel);
    if (!(ray.z() < -kMinDescent)) return everything;
    for (const double height : {lowest_m, highest_m}) {
      const Eigen::Vector2d place = (eye + ray * ((height - eye.z()) / ray.z())).head<2>();
      footprint.min_in_world = footprint.min_in_world.cwiseMin(place);
      footprint.max_in_world = footprint.max_in_world.cwiseMax(place);
    }
  }
  const Eigen::Vector2d margin =
      kFootprintMargin * (footprint.max_in_world - footprint.min_in_world);
  return {footprint.min_in_world - margin, footprint.max_in_world + margin};
}

std::vector<Eigen::Vector2d> CornersOnGround(const Camera& camera,
                                             const Rigid3d& world_from_camera,
                                             double height_above_ground) {
  const double right = camera.width_px - 1.0, bottom = camera.height_px - 1.0;
  std::vector<Eigen::Vector2d> corners;
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(0.0, 0.0),
                                       Eigen::Vector2d(right, 0.0),
                                       Eigen::Vector2d(right, bottom),
                                       Eigen::Vector2d(0.0, bottom)}) {
    const Eigen::Vector3d ray = world_from_camera.rotation * camera.RayFromImage(pixel);
    if (ray.z() > -kMinCornerDescent) return {};
    corners.push_back(world_from_camera.translation.head<2>() +
                      ray.head<2>() * (height_above_ground / -ray.z()));
  }
  return corners;
}

}  // namespace freelsd
