// Input: a painted and lit world, a camera and where it is. Output: the photograph.
#pragma once

#include <cstdint>
#include <optional>

#include <opencv2/core.hpp>

#include "engine/flight/flight.h"
#include "tests/synthetic/height_field.h"
#include "tests/synthetic/world.h"

namespace freelsd {

struct RenderOptions {
  uint64_t seed = 1;
  // Rays per pixel are the square of this.
  int supersampling = 2;
  double lens_blur_px = 0.5;
  // Standard deviation of the sensor's noise, of 255.
  double sensor_noise = 1.8;
  // Slow change of exposure over a flight: largest share.
  double exposure_drift_ratio = 0.06;
  // Every few photographs the camera chooses another exposure: largest share.
  double exposure_step_ratio = 0.0;
  // Brightness lost in the corners; negative: in the middle.
  double vignetting_ratio = 0.08;
  // Share of the light that the air adds in place of the ground's.
  double haze_ratio = 0.0;
  // White balance: gains of blue, green and red.
  cv::Vec3f color_gain = {1.0f, 1.0f, 1.0f};
  // While the shutter is open the picture moves by `exposure_s` times the camera's speed.
  double exposure_s = 0.0;
  // From the first row to the last one (rolling shutter); 0 if all are exposed at once.
  double readout_s = 0.0;
};

// How the camera moves at the middle of a photograph.
struct CameraMotion {
  Eigen::Vector3d velocity_in_world = Eigen::Vector3d::Zero();
  // Rotation vector of the camera per second, camera frame, radians.
  Eigen::Vector3d turn_rate_in_camera = Eigen::Vector3d::Zero();
};

class Renderer {
 public:
  // Keeps a reference to the world, which must outlive it and not change.
  explicit Renderer(const World& world);

  // 8 bit BGR. `frame_index` chooses noise and exposure: same index, same bytes. The pose is that
  // of the middle row.
  cv::Mat Render(const Camera& camera,
                 const Rigid3d& world_from_camera,
                 const RenderOptions& options,
                 int frame_index,
                 const CameraMotion& motion = {}) const;

  // First point of the surface on a ray from above; nothing for a ray that does not go down.
  std::optional<Eigen::Vector3d> FirstHit(const Eigen::Vector3d& origin_in_world,
                                          const Eigen::Vector3d& ray_in_world) const;

 private:
  // A place in cells (x, y) and metres (z).
  Eigen::Vector3d CellsFrom(const Eigen::Vector3d& point_in_world) const;

  const World& world_;
  HeightField field_;
};

}  // namespace freelsd
