// Input: a world that was photographed, a strip in it, a plan. Output: photographs of a later pass
// over the strip, with inexact poses, and what stands on the strip in each.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/watch/watch.h"
#include "tests/synthetic/world.h"

namespace freelsd {

enum class WatchEvent { kNone, kCar, kMachine, kCows, kPerson, kPeople, kBale };
constexpr int kNumWatchEvents = 7;
const char* NameOf(WatchEvent event);

// An event is told in time if it is told with so many photographs that show it.
constexpr int kNumPhotosInTime = 2;

// What else is different from the stored pass.
enum class SceneChange {
  kSameLight,
  kSunMoved,
  kLowSun,
  kOvercast,
  kCloudShadows,
  kWet,
  kHaze,
  kGrown
};
constexpr int kNumSceneChanges = 8;
const char* NameOf(SceneChange change);

struct PassPlan {
  uint64_t seed = 1;
  WatchEvent event = WatchEvent::kNone;
  SceneChange change = SceneChange::kSameLight;
  double height_m = 100.0;
  // Of the camera, forward from straight down.
  double tilt_deg = 0.0;
  // Multiplies all errors of the poses.
  double noise_scale = 1.0;
};

struct PassPhoto {
  // JPEG.
  std::vector<uchar> file;
  Camera camera;
  // As the aircraft reports it.
  Rigid3d world_from_camera;
  int64_t timestamp_us = 0;
  // Centres of new things that stand on the strip and in the photograph, true world.
  std::vector<Eigen::Vector2d> shown_things;

  WatchedPhoto Read() const;
};

// One photograph a second, in which most of the strip is shown. A pass with an event ends with the
// second photograph that shows it.
std::vector<PassPhoto> FlySecondPass(const World& world,
                                     const Camera& camera,
                                     const std::vector<Polygon>& outlines,
                                     const PassPlan& plan);

}  // namespace freelsd
