// A stored strip on painted grass, and photographs of it in other light, with things on it.
#pragma once

#include <functional>
#include <vector>

#include "engine/watch/watch.h"
#include "tests/engine/stereo/scene.h"

namespace freelsd::watched {

constexpr double kPixelM = 0.15;
constexpr double kFlownHeightM = 60.0;

// BGR, not rounded, of a place on the ground.
using Look = std::function<cv::Vec3d(const Eigen::Vector2d& place_in_world)>;

inline cv::Vec3d Grass(const Eigen::Vector2d& place) {
  static const GroundTexture kTexture;
  const double gain = 1.0 + 0.4 * (kTexture.At(place.x(), place.y()) / 128.0 - 1.0);
  return gain * cv::Vec3d(60.0, 145.0, 120.0);
}

// A rectangle of another colour.
inline Look With(const Look& ground,
                 const Eigen::Vector2d& center,
                 const Eigen::Vector2d& size,
                 const cv::Vec3d& color) {
  return [=](const Eigen::Vector2d& place) {
    const Eigen::Vector2d offset = (place - center).cwiseAbs();
    return (2.0 * offset - size).maxCoeff() < 0.0 ? color : ground(place);
  };
}

// Factors of blue, green and red.
inline Look Lit(const Look& ground, const std::function<cv::Vec3d(const Eigen::Vector2d&)>& light) {
  return [=](const Eigen::Vector2d& place) { return ground(place).mul(light(place)); };
}

// 40 m long and 10 m wide, on level ground at 0.
inline StripPicture StoredStrip(const Look& look) {
  constexpr int kSide = 620;
  StripPicture strip;
  strip.grid = {{-0.5 * kSide * kPixelM, 0.5 * kSide * kPixelM}, kPixelM, kSide, kSide};
  strip.picture = cv::Mat4b(kSide, kSide);
  for (int row = 0; row < kSide; ++row) {
    for (int col = 0; col < kSide; ++col) {
      const cv::Vec3d color = look(strip.grid.CellCenter(row, col));
      strip.picture(row, col) = {cv::saturate_cast<uint8_t>(color[0]),
                                 cv::saturate_cast<uint8_t>(color[1]),
                                 cv::saturate_cast<uint8_t>(color[2]),
                                 255};
    }
  }
  strip.ground_grid = {{-60.0, 60.0}, 1.0, 120, 120};
  strip.elevation = cv::Mat1f(120, 120, 0.0f);
  strip.upper = cv::Mat1f(120, 120, 0.1f);
  strip.outlines = {{{-20.0, -5.0}, {20.0, -5.0}, {20.0, 5.0}, {-20.0, 5.0}}};
  return strip;
}

// Shows 78 m by 60 m of the ground, 0.15 m per pixel.
inline Camera WatchCamera() {
  Camera camera = SceneCamera();
  camera.width_px = 520;
  camera.height_px = 400;
  camera.cx_px = 259.5;
  camera.cy_px = 199.5;
  return camera;
}

// Photographed from `pose`; the engine is given that pose.
inline WatchedPhoto PhotoOf(const Look& look, const Rigid3d& pose, int64_t timestamp_us = 0) {
  WatchedPhoto photo;
  photo.camera = WatchCamera();
  photo.world_from_camera = pose;
  photo.timestamp_us = timestamp_us;
  cv::Mat3b image(photo.camera.height_px, photo.camera.width_px);
  cv::RNG random(static_cast<uint64_t>(7 + timestamp_us));
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const Eigen::Vector3d ray = pose.rotation * photo.camera.RayFromImage({double(u), double(v)});
      const Eigen::Vector2d place =
          (pose.translation - ray * (pose.translation.z() / ray.z())).head<2>();
      const cv::Vec3d color = look(place);
      for (int i = 0; i < 3; ++i) {
        image(v, u)[i] = cv::saturate_cast<uint8_t>(color[i] + random.gaussian(1.5));
      }
    }
  }
  photo.image = image;
  return photo;
}

// Above the strip, its length across the picture.
inline Rigid3d AboveStrip() { return SceneView({3.0, -2.0, kFlownHeightM}, 0.2, 2.0, -1.0); }

}  // namespace freelsd::watched
