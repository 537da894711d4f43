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
constexpr double kContextMarginM = 22.0;
constexpr double kFineMarginM = 4.0;
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

// The part of the picture that shows the ground within `margin_m` of the strip's box.
cv::Rect PartAround(const Camera& camera,
                    const Rigid3d& world_from_camera,
                    const std::vector<Polygon>& outlines,
                    double height,
                    double margin_m) {
  Eigen::AlignedBox2d ground;
  for (const Polygon& outline : outlines) {
    for (const Eigen::Vector2d& corner : outline) ground.extend(corner);
  }
  const cv::Rect all(0, 0, camera.width_px, camera.height_px);
  Eigen::AlignedBox2d part;
  const Rigid3d camera_from_world = Inverse(world_from_camera);
  for (int i = 0; i < 4; ++i) {
    const auto type = static_cast<Eigen::AlignedBox2d::CornerType>(i);
    const Eigen::Vector2d away = (ground.corner(type) - ground.center()).cwiseSign() * margin_m;
    Eigen::Vector3d point;
    point << ground.corner(type) + away, height;
    const Eigen::Vector3d in_camera = camera_from_world * point;
    if (in_camera.z() <= 1.0) return all;
    part.extend(Eigen::Vector2d(in_camera.x() / in_camera.z() * camera.fx_px + camera.cx_px,
                                in_camera.y() / in_camera.z() * camera.fy_px + camera.cy_px));
  }
  return cv::Rect(cv::Point(int(std::floor(part.min().x())), int(std::floor(part.min().y()))),
                  cv::Point(int(std::ceil(part.max().x())), int(std::ceil(part.max().y())))) &
         all;
}

struct Exposure {
  const Renderer& renderer;
  const Camera& camera;
  // In the piece of the world.
  Rigid3d world_from_camera;
  RenderOptions options;
  int number = 0;
  CameraMotion motion;
};

void RenderPart(const Exposure& exposure, const cv::Rect& part, int supersampling, cv::Mat& image) {
  if (part.empty()) return;
  Camera camera = exposure.camera;
  camera.width_px = part.width;
  camera.height_px = part.height;
  camera.cx_px -= part.x;
  camera.cy_px -= part.y;
  RenderOptions options = exposure.options;
  options.supersampling = supersampling;
  exposure.renderer
      .Render(camera, exposure.world_from_camera, options, exposure.number, exposure.motion)
      .copyTo(image(part));
}

// As the sensor does it, for the whole picture.
void Vignette(double ratio, cv::Mat& image) {
  const double cx = 0.5 * (image.cols - 1), cy = 0.5 * (image.rows - 1);
  for (int row = 0; row < image.rows; ++row) {
    for (int col = 0; col < image.cols; ++col) {
      const double radius =
          ((col - cx) * (col - cx) + (row - cy) * (row - cy)) / (cx * cx + cy * cy);
      cv::Vec3b& color = image.at<cv::Vec3b>(row, col);
      for (int i = 0; i < 3; ++i)
        color[i] = cv::saturate_cast<uchar>(color[i] * (1.0 - ratio * radius));
    }
  }
}

// The surroundings of a strip at the time of the later pass.
class WatchedScene {
 public:
  WatchedScene(const World& world,
               const Camera& camera,
               const std::vector<Polygon>& outlines,
               const PassPlan& plan)
      : camera_(camera),
        outlines_(outlines),
        plan_(plan),
        shape_(ShapeOf(outlines)),
        height_(world.GroundHeight(shape_.middle.x(), shape_.middle.y())),
        options_(CameraOptions(plan, &jpeg_quality_)) {
    const double reach = std::hypot(shape_.half_length_m, shape_.half_width_m) + kPieceMarginM;
    piece_ = PieceOf(world,
                     shape_.middle - Eigen::Vector2d::Constant(reach),
                     shape_.middle + Eigen::Vector2d::Constant(reach));
    ChangeScene(plan.change, plan.seed, piece_.world);
    piece_.world.Light();
  }

  const StripShape& shape() const { return shape_; }
  double height() const { return height_; }

  // Most of the strip is in the photograph, and not too far away.
  bool IsWorthAPhoto(const Rigid3d& world_from_camera) const {
    return ShownRatio(camera_, world_from_camera, outlines_, height_) >= kLeastShownRatio &&
           IsNearEnough(world_from_camera, shape_.middle);
  }

  // As a file. `yaw`: where the aircraft flies.
  std::vector<uchar> Photographed(const Rigid3d& world_from_camera, double yaw, int second) const {
    const World now = At(second);
    const Renderer renderer(now);
    Exposure exposure{renderer,
                      camera_,
                      Moved(world_from_camera, -piece_.middle_in_world),
                      options_,
                      second + kMaxNumSeconds,
                      {}};
    exposure.options.vignetting_ratio = 0.0;
    exposure.motion.velocity_in_world.head<2>() = kGroundSpeedMps * DirectionOf(yaw);
    const auto part = [&](double margin_m) {
      return PartAround(camera_, world_from_camera, outlines_, height_, margin_m);
    };
    // Rays cost most: what lies farther from the strip than the engine looks stays grey, and what
    // only helps to register gets one ray for each pixel.
    cv::Mat image(camera_.height_px, camera_.width_px, CV_8UC3, cv::Scalar::all(100.0));
    RenderPart(exposure, part(kContextMarginM), 1, image);
    RenderPart(exposure, part(kFineMarginM), options_.supersampling, image);
    Vignette(options_.vignetting_ratio, image);
    std::vector<uchar> bytes;
    cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, jpeg_quality_});
    return bytes;
  }

  std::vector<Eigen::Vector2d> ShownThings(const Rigid3d& world_from_camera, int second) const {
    const Rigid3d camera_from_world = Inverse(world_from_camera);
    std::vector<Eigen::Vector2d> shown;
    for (const ColoredBlock& thing : ThingsAt(plan_.event, shape_, plan_.seed, second)) {
      const Eigen::Vector2d& center = thing.block.center;
      if (IsOnStrip(outlines_, center) && IsNearEnough(world_from_camera, center) &&
          IsShown(camera_, camera_from_world, {center.x(), center.y(), height_})) {
        shown.push_back(center);
      }
    }
    return shown;
  }

 private:
  bool IsNearEnough(const Rigid3d& world_from_camera, const Eigen::Vector2d& place) const {
    const double distance = (world_from_camera.translation.head<2>() - place).norm();
    const double depth = std::hypot(distance, plan_.height_m);
    return depth * depth / plan_.height_m / camera_.MeanFocalPx() <= kCoarsestSamplingM;
  }

  World At(int second) const {
    World now = piece_.world;
    const std::vector<ColoredBlock> things = ThingsAt(plan_.event, shape_, plan_.seed, second);
    if (things.empty() && plan_.change != SceneChange::kCloudShadows) return now;
    now.surface = now.surface.clone();
    now.albedo = now.albedo.clone();
    now.cover = now.cover.clone();
    now.variant = now.variant.clone();
    now.is_textured = now.is_textured.clone();
    now.radiance = cv::Mat3b();
    for (ColoredBlock thing : things) {
      thing.block.center -= piece_.middle_in_world;
      PutColored(thing, now);
    }
    now.Light();
    if (plan_.change == SceneChange::kCloudShadows) ShadeByClouds(plan_.seed, second, now);
    return now;
  }

  const Camera& camera_;
  const std::vector<Polygon>& outlines_;
  const PassPlan plan_;
  const StripShape shape_;
  const double height_;
  int jpeg_quality_ = 92;
  const RenderOptions options_;
  WorldPiece piece_;
};

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

WatchedPhoto PassPhoto::Read() const {
  return {cv::imdecode(file, cv::IMREAD_COLOR), camera, world_from_camera, timestamp_us};
}

std::vector<PassPhoto> FlySecondPass(const World& world,
                                     const Camera& camera,
                                     const std::vector<Polygon>& outlines,
                                     const PassPlan& plan) {
  const WatchedScene scene(world, camera, outlines, plan);
  Pass pass(plan, scene.shape().middle, scene.height());
  Rigid3d body_from_camera = Rig().body_from_camera;
  body_from_camera.rotation =
      Eigen::AngleAxisd(RadFromDeg(plan.tilt_deg), Eigen::Vector3d::UnitY()) *
      body_from_camera.rotation;
  std::vector<PassPhoto> photos;
  int num_showing = 0;
  for (int second = -kMaxNumSeconds; second <= kMaxNumSeconds; ++second) {
    const AutopilotSample truth = pass.TrueAt(second);
    const AutopilotSample reported = pass.Reported(truth);
    const Rigid3d world_from_camera = WorldFromBody(truth) * body_from_camera;
    if (!scene.IsWorthAPhoto(world_from_camera)) continue;
    photos.push_back({scene.Photographed(world_from_camera, truth.attitude.yaw, second),
                      camera,
                      WorldFromBody(reported) * body_from_camera,
                      int64_t{second} * 1'000'000,
                      scene.ShownThings(world_from_camera, second)});
    num_showing += !photos.back().shown_things.empty();
    if (num_showing == kNumPhotosInTime) break;
  }
  return photos;
}

}  // namespace freelsd
