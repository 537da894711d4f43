// A textured height field, rendered by casting one ray per sample, and a block of views over it.
#pragma once

#include <cmath>
#include <functional>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/stereo/stereo.h"
#include "tests/engine/camera.h"

namespace freelsd {

using HeightField = std::function<double(double east, double north)>;

// Grey of the ground: random cells of three sizes, so that it has contrast at every scale.
class GroundTexture {
 public:
  explicit GroundTexture(double contrast = 1.0) : contrast_(contrast), cells_(512, 512) {
    cv::RNG random(11);
    random.fill(cells_, cv::RNG::UNIFORM, 0.0, 1.0);
  }

  double At(double east, double north) const {
    const double sum = Smooth(east / 0.35, north / 0.35) + Smooth(east / 1.1, north / 1.1 + 91.0) +
                       0.7 * Smooth(east / 4.0 + 37.0, north / 4.0);
    return 128.0 + contrast_ * 110.0 * (sum / 2.7 - 0.5) * 2.0;
  }

 private:
  double Cell(int x, int y) const { return cells_(y & 511, x & 511); }
  double Smooth(double x, double y) const {
    const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
    const double u = x - x0, v = y - y0;
    return (1 - v) * ((1 - u) * Cell(x0, y0) + u * Cell(x0 + 1, y0)) +
           v * ((1 - u) * Cell(x0, y0 + 1) + u * Cell(x0 + 1, y0 + 1));
  }

  double contrast_;
  cv::Mat1f cells_;
};

struct Scene {
  Camera camera;
  HeightField height;
  GroundTexture texture;
  double max_height_m = 12.0;
  double noise_sd_grey = 1.0;
};

// First point of the ground on the ray of a pixel, found by marching down and halving.
inline Eigen::Vector3d Hit(const Scene& scene,
                           const Rigid3d& world_from_camera,
                           const Eigen::Vector2d& pixel) {
  constexpr double kStepM = 0.4;
  const Eigen::Vector3d ray = world_from_camera.rotation * scene.camera.RayFromImage(pixel);
  const Eigen::Vector3d& origin = world_from_camera.translation;
  const auto above = [&](double t) {
    const Eigen::Vector3d p = origin + t * ray;
    return p.z() - scene.height(p.x(), p.y());
  };
  double far = (origin.z() - scene.max_height_m) / -ray.z();
  while (above(far) > 0.0 && far < 1000.0) far += kStepM;
  double near = far - kStepM;
  for (int i = 0; i < 8; ++i) {
    const double middle = 0.5 * (near + far);
    (above(middle) > 0.0 ? near : far) = middle;
  }
  return origin + 0.5 * (near + far) * ray;
}

inline cv::Mat Render(const Scene& scene, const Rigid3d& world_from_camera, uint64_t seed) {
  cv::Mat1f grey(scene.camera.height_px, scene.camera.width_px);
  for (int v = 0; v < grey.rows; ++v) {
    for (int u = 0; u < grey.cols; ++u) {
      double sum = 0.0;
      for (const double shift : {-0.25, 0.25}) {
        const Eigen::Vector3d p = Hit(scene, world_from_camera, {u + shift, v - shift});
        sum += scene.texture.At(p.x(), p.y());
      }
      grey(v, u) = static_cast<float>(0.5 * sum);
    }
  }
  cv::Mat1f noise(grey.size());
  cv::RNG random(seed);
  random.fill(noise, cv::RNG::NORMAL, 0.0, scene.noise_sd_grey);
  cv::Mat image;
  cv::Mat(grey + noise).convertTo(image, CV_8U);
  return image;
}

inline Camera SceneCamera() { return CenteredCamera(376, 300, 400.0); }

// Camera that looks down with its image top along the heading (radians), then tilted.
inline Rigid3d SceneView(const Eigen::Vector3d& position,
                         double heading,
                         double pitch_deg = 0.0,
                         double roll_deg = 0.0) {
  const Eigen::Quaterniond body_from_camera(0.7071067811865476, 0, 0, 0.7071067811865476);
  return {WorldFromNed() * NedFromBody({RadFromDeg(roll_deg), RadFromDeg(pitch_deg), heading}) *
              body_from_camera,
          position};
}

// Views with true poses that share a lattice of exact landmarks.
inline AdjustedBlock SceneBlock(const Scene& scene, const std::vector<Rigid3d>& world_from_camera) {
  AdjustedBlock block;
  block.camera = scene.camera;
  block.is_usable = true;
  for (const Rigid3d& pose : world_from_camera) {
    block.views.push_back(
        {std::to_string(block.views.size()),
         pose,
         {},
         pose.translation.z() - scene.height(pose.translation.x(), pose.translation.y()),
         true,
         0,
         0.1,
         {}});
  }
  for (double east = -60.0; east <= 60.0; east += 8.0) {
    for (double north = -60.0; north <= 60.0; north += 8.0) {
      const Eigen::Vector3d point(east, north, scene.height(east, north));
      for (AdjustedView& view : block.views) {
        const auto pixel = scene.camera.ImageFromCamera(Inverse(view.world_from_camera) * point);
        if (pixel && scene.camera.IsInside(*pixel))
          view.landmarks.push_back(block.landmarks.size());
      }
      block.landmarks.push_back({point, 0.1, 2});
    }
  }
  return block;
}

}  // namespace freelsd
