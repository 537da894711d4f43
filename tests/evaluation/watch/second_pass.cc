#include "tests/evaluation/watch/second_pass.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <opencv2/imgcodecs.hpp>

#include "tests/evaluation/watch/later_world.h"
#include "tests/synthetic/conditions/conditions.h"
#include "tests/synthetic/flight_plan.h"
#include "tests/synthetic/noise.h"
#include "tests/synthetic/renderer.h"

namespace freelsd {
namespace {

constexpr uint64_t kPassPurpose = 611;
constexpr double kGroundSpeedMps = 13.0;
constexpr int kMaxNumSeconds = 14;
// Around the strip: what registration needs, and what throws shadows.
constexpr double kPieceMarginM = 45.0;
constexpr double kLeastShownRatio = 0.7;
// Photographs from too far away count for nothing: WatchOptions::max_sampling_m.
const double kCoarsestSamplingM = WatchOptions().max_sampling_m;

// The way of the aircraft and the errors of its poses.
class Pass {
 public:
  Pass(const PassPlan& plan, const Eigen::Vector2d& middle, double ground_height)
      : plan_(plan),
        middle_(middle),
        ground_height_(ground_height),
        random_(MixSeed(plan.seed, kPassPurpose)) {
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    heading_ = kPi * uniform(random_);
    beside_m_ = 0.3 * plan.height_m * uniform(random_);
    for (double& drift : drift_m_) drift = noise_.position_drift_m * normal_(random_);
    drift_m_[2] += uniform(random_) < 0.0 ? noise_.altitude_bias_m : -noise_.altitude_bias_m;
    yaw_drift_ = RadFromDeg(noise_.yaw_drift_deg) * normal_(random_);
  }

  AutopilotSample TrueAt(double seconds) {
    const Eigen::Vector2d forward = DirectionOf(heading_);
    const Eigen::Vector2d right(forward.y(), -forward.x());
    // A camera that looks ahead sees the strip before the aircraft is there.
    const double ahead = plan_.height_m * std::tan(RadFromDeg(plan_.tilt_deg));
    AutopilotSample sample;
    sample.position_in_world << middle_ + (kGroundSpeedMps * seconds - ahead) * forward +
                                    beside_m_ * right,
        ground_height_ + plan_.height_m + normal_(random_);
    sample.attitude.roll = RadFromDeg(2.5) * normal_(random_);
    sample.attitude.pitch = RadFromDeg(1.5) * normal_(random_);
    sample.attitude.yaw = heading_ + RadFromDeg(5.0) * normal_(random_);
    return sample;
  }

  AutopilotSample Reported(const AutopilotSample& truth) {
    AutopilotSample sample = truth;
    const double scale = plan_.noise_scale;
    for (int axis = 0; axis < 3; ++axis) {
      sample.position_in_world[axis] +=
          scale * (drift_m_[axis] + noise_.position_white_m * normal_(random_));
    }
    sample.attitude.roll += scale * RadFromDeg(noise_.roll_pitch_deg) * normal_(random_);
    sample.attitude.pitch += scale * RadFromDeg(noise_.roll_pitch_deg) * normal_(random_);
    sample.attitude.yaw += scale * yaw_drift_;
    return sample;
  }

 private:
  PassPlan plan_;
  Eigen::Vector2d middle_;
  double ground_height_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  FlightOptions noise_;
  double heading_ = 0.0, beside_m_ = 0.0, yaw_drift_ = 0.0;
  double drift_m_[3] = {};
};

bool IsOnStrip(const std::vector<Polygon>& outlines, const Eigen::Vector2d& place) {
  return std::any_of(outlines.begin(), outlines.end(), [&](const Polygon& outline) {
    return Contains(outline, place);
  });
}

bool IsShown(const Camera& camera, const Rigid3d& camera_from_world, const Eigen::Vector3d& point) {
  const Eigen::Vector3d in_camera = camera_from_world * point;
  if (in_camera.z() <= 0.0) return false;
  const auto pixel = camera.ImageFromCamera(in_camera);
  return pixel && camera.IsInside(*pixel, 2.0);
}

double ShownRatio(const Camera& camera,
                  const Rigid3d& world_from_camera,
                  const std::vector<Polygon>& outlines,
                  double height) {
  const Rigid3d camera_from_world = Inverse(world_from_camera);
  int num_shown = 0, num_all = 0;
  for (const Polygon& outline : outlines) {
    for (const Eigen::Vector2d& corner : outline) {
      ++num_all;
      num_shown += IsShown(camera, camera_from_world, {corner.x(), corner.y(), height});
    }
  }
  return double(num_shown) / num_all;
}

StripShape ShapeOf(const std::vector<Polygon>& outlines) {
  Polygon corners;
  for (const Polygon& each : outlines) corners.insert(corners.end(), each.begin(), each.end());
  const Polygon box = MinAreaRectangle(corners);
  StripShape shape;
  shape.middle = Centroid(box);
  const Eigen::Vector2d a = box[1] - box[0], b = box[2] - box[1];
  const bool is_a = a.norm() >= b.norm();
  shape.heading = HeadingOf(is_a ? a : b);
  shape.half_length_m = 0.5 * std::max(a.norm(), b.norm());
  shape.half_width_m = 0.5 * std::min(a.norm(), b.norm());
  return shape;
}

Rigid3d Moved(const Rigid3d& pose, const Eigen::Vector2d& by) {
  Rigid3d moved = pose;
  moved.translation.head<2>() += by;
  return moved;
}

RenderOptions CameraOptions(const PassPlan& plan, int* jpeg_quality) {
  Conditions conditions = RecordedConditions(plan.seed);
  if (plan.change == SceneChange::kHaze) {
    conditions.camera.haze_ratio = static_cast<float>(Uniform(plan.seed, 641, 0.05, 0.20));
    conditions.camera.exposure_step_ratio = 0.3;
  }
  conditions.camera.readout_s = 0.0;
  *jpeg_quality = conditions.jpeg_quality;
  return conditions.camera;
}

}  // namespace

const char* NameOf(WatchEvent event) {
  constexpr const char* kNames[kNumWatchEvents] = {
      "none", "car", "machine", "cows", "person", "people", "bale"};
  return kNames[static_cast<int>(event)];
}

const char* NameOf(SceneChange change) {
  constexpr const char* kNames[kNumSceneChanges] = {
      "same light", "sun moved", "low sun", "overcast", "cloud shadows", "wet", "haze", "grown"};
  return kNames[static_cast<int>(change)];
}

std::vector<PassPhoto> FlySecondPass(const World& world,
                                     const Camera& camera,
                                     const std::vector<Polygon>& outlines,
                                     const PassPlan& plan) {
  const StripShape shape = ShapeOf(outlines);
  const double reach = std::hypot(shape.half_length_m, shape.half_width_m) + kPieceMarginM;
  WorldPiece piece = PieceOf(world,
                             shape.middle - Eigen::Vector2d::Constant(reach),
                             shape.middle + Eigen::Vector2d::Constant(reach));
  ChangeScene(plan.change, plan.seed, piece.world);
  piece.world.Light();
  const double height = world.GroundHeight(shape.middle.x(), shape.middle.y());
  Pass pass(plan, shape.middle, height);
  Rigid3d body_from_camera = Rig().body_from_camera;
  body_from_camera.rotation =
      Eigen::AngleAxisd(RadFromDeg(plan.tilt_deg), Eigen::Vector3d::UnitY()) *
      body_from_camera.rotation;
  int jpeg_quality = 92;
  const RenderOptions options = CameraOptions(plan, &jpeg_quality);
  std::vector<PassPhoto> photos;
  for (int second = -kMaxNumSeconds; second <= kMaxNumSeconds; ++second) {
    const AutopilotSample truth = pass.TrueAt(second);
    const AutopilotSample reported = pass.Reported(truth);
    const Rigid3d world_from_camera = WorldFromBody(truth) * body_from_camera;
    if (ShownRatio(camera, world_from_camera, outlines, height) < kLeastShownRatio) continue;
    const double distance = (truth.position_in_world.head<2>() - shape.middle).norm();
    const double depth = std::hypot(distance, plan.height_m);
    if (depth * depth / plan.height_m / camera.MeanFocalPx() > kCoarsestSamplingM) continue;
    World now = piece.world;
    const std::vector<ColoredBlock> things = ThingsAt(plan.event, shape, plan.seed, second);
    if (!things.empty() || plan.change == SceneChange::kCloudShadows) {
      now.surface = now.surface.clone();
      now.albedo = now.albedo.clone();
      now.cover = now.cover.clone();
      now.variant = now.variant.clone();
      now.is_textured = now.is_textured.clone();
      now.radiance = cv::Mat3b();
      for (ColoredBlock thing : things) {
        thing.block.center -= piece.middle_in_world;
        PutColored(thing, now);
      }
      now.Light();
      if (plan.change == SceneChange::kCloudShadows) ShadeByClouds(plan.seed, second, now);
    }
    CameraMotion motion;
    motion.velocity_in_world.head<2>() = kGroundSpeedMps * DirectionOf(truth.attitude.yaw);
    const cv::Mat image = Renderer(now).Render(camera,
                                               Moved(world_from_camera, -piece.middle_in_world),
                                               options,
                                               second + kMaxNumSeconds,
                                               motion);
    std::vector<uchar> bytes;
    cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, jpeg_quality});
    PassPhoto photo;
    photo.photo = {cv::imdecode(bytes, cv::IMREAD_COLOR),
                   camera,
                   WorldFromBody(reported) * body_from_camera,
                   int64_t{second} * 1'000'000};
    const Rigid3d camera_from_world = Inverse(world_from_camera);
    for (const ColoredBlock& thing : things) {
      const Eigen::Vector2d& center = thing.block.center;
      if (IsOnStrip(outlines, center) &&
          IsShown(camera, camera_from_world, {center.x(), center.y(), height})) {
        photo.shown_things.push_back(center);
      }
    }
    photos.push_back(std::move(photo));
  }
  return photos;
}

}  // namespace freelsd
