#include "tests/synthetic/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "tests/synthetic/noise.h"
#include "tests/synthetic/sensor.h"

namespace freelsd {
namespace {

// Rays of a square of so many pixels look for the top of what they can meet together.
constexpr int kTilePx = 8;
constexpr uint64_t kLeafPurpose = 403;
constexpr float kLeafContrast = 0.30f;
// A slide that no ray has: it climbs.
constexpr double kNever = std::numeric_limits<double>::quiet_NaN();

Eigen::Vector3f RadianceAt(const cv::Mat3b& grid, const Eigen::Vector2f& cell) {
  const float u = std::min(std::max(cell.x(), 0.0f), static_cast<float>(grid.cols) - 1.001f);
  const float v = std::min(std::max(cell.y(), 0.0f), static_cast<float>(grid.rows) - 1.001f);
  const int left = static_cast<int>(u), first = static_cast<int>(v);
  const float tu = u - static_cast<float>(left), tv = v - static_cast<float>(first);
  const cv::Vec3b* a = grid[first] + left;
  const cv::Vec3b* b = grid[first + 1] + left;
  Eigen::Vector3f color;
  for (int i = 0; i < 3; ++i) {
    const float south = a[0][i] + tu * (a[1][i] - a[0][i]);
    const float north = b[0][i] + tu * (b[1][i] - b[0][i]);
    color[i] = south + tv * (north - south);
  }
  return color;
}

// The sides of a crown are steep: texture that only knows the ground plan would be drawn out over
// them. Leaves and the dark between them are placed in space instead.
class Leaves {
 public:
  explicit Leaves(const World& world)
      : world_(world),
        fine_(MixSeed(world.seed, kLeafPurpose), 0.4),
        coarse_(MixSeed(world.seed, kLeafPurpose + 1), 1.4) {}

  // At a place in cells and its height.
  float Gain(const Eigen::Vector2f& cell, float height) const {
    const int last = world_.num_cells() - 1;
    const Eigen::Vector2f from_corner = cell + Eigen::Vector2f(0.5f, 0.5f);
    const int col = std::clamp(static_cast<int>(from_corner.x()), 0, last);
    const int row = std::clamp(static_cast<int>(from_corner.y()), 0, last);
    if (!world_.photographed.empty() && world_.photographed(row, col) != 0) return 1.0f;
    const Cover cover = static_cast<Cover>(world_.cover(row, col));
    if (cover != Cover::kTree && cover != Cover::kHedge) return 1.0f;
    const double origin = 0.5 * (world_.cell_size_m - world_.size_m);
    const double x = origin + world_.cell_size_m * cell.x();
    const double y = origin + world_.cell_size_m * cell.y();
    // A slanted cut through space: moves with the height as fast as with the place.
    const double u = x + 0.83 * height, v = y - 0.71 * height;
    const float gain = 1.0f + kLeafContrast * (1.2f * fine_.At(u, v) + 0.8f * coarse_.At(u, v));
    return std::clamp(gain, 0.25f, 2.2f);
  }

 private:
  const World& world_;
  Noise fine_, coarse_;
};

// A photograph's rays, by how far they move sideways per metre of descent.
class Rays {
 public:
  Rays(const Camera& camera, const Eigen::Quaterniond& world_from_camera, int num_across)
      : camera_(camera),
        rotation_(world_from_camera.toRotationMatrix()),
        num_across_(num_across),
        is_straight_(camera.distortion == DistortionModel::kNone && camera.readout.IsGlobal()) {}

  int num_per_pixel() const { return num_across_ * num_across_; }

  // In metres per metre; kNever for a ray that does not go down.
  Eigen::Vector2d Slide(int row, int col, int sample) const {
    const int sample_row = sample / num_across_, sample_col = sample % num_across_;
    const Eigen::Vector2d point_in_image(col - 0.5 + (sample_col + 0.5) / num_across_,
                                         row - 0.5 + (sample_row + 0.5) / num_across_);
    const Eigen::Vector2d normalized =
        is_straight_ ? Eigen::Vector2d((point_in_image.x() - camera_.cx_px) / camera_.fx_px,
                                       (point_in_image.y() - camera_.cy_px) / camera_.fy_px)
                     : camera_.NormalizedFromImage(point_in_image);
    const Eigen::Vector3d ray = rotation_ * normalized.homogeneous();
    if (ray.z() >= 0.0) return {kNever, kNever};
    return ray.head<2>() / -ray.z();
  }

 private:
  const Camera& camera_;
  Eigen::Matrix3d rotation_;
  int num_across_;
  bool is_straight_;
};

// Follows the rays of one photograph, a square of pixels at a time.
class Tracer {
 public:
  // `origin` in cells and metres.
  Tracer(const World& world,
         const HeightField& field,
         const Rays& rays,
         const Eigen::Vector3d& origin)
      : world_(world), field_(field), rays_(rays), origin_(origin), leaves_(world) {}

  void Trace(const cv::Rect& tile, cv::Mat3f& light) const {
    const std::vector<Eigen::Vector2d> slides = SlidesOf(tile);
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& slide : slides) {
      if (!std::isnan(slide.x())) box.extend(slide);
    }
    if (box.isEmpty()) return;
    const HeightRange layer = field_.LayerMetBy(origin_, box);
    const Eigen::Vector2d* slide = slides.data();
    for (int row = tile.y; row < tile.br().y; ++row) {
      for (int col = tile.x; col < tile.br().x; ++col) {
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (int sample = 0; sample < rays_.num_per_pixel(); ++sample, ++slide) {
          if (!std::isnan(slide->x())) sum += LightAlong(*slide, layer);
        }
        sum /= static_cast<float>(rays_.num_per_pixel());
        light(row, col) = cv::Vec3f(sum.x(), sum.y(), sum.z());
      }
    }
  }

 private:
  // In cells per metre, sample by sample.
  std::vector<Eigen::Vector2d> SlidesOf(const cv::Rect& tile) const {
    std::vector<Eigen::Vector2d> slides;
    slides.reserve(static_cast<size_t>(tile.area()) * static_cast<size_t>(rays_.num_per_pixel()));
    for (int row = tile.y; row < tile.br().y; ++row) {
      for (int col = tile.x; col < tile.br().x; ++col) {
        for (int sample = 0; sample < rays_.num_per_pixel(); ++sample) {
          slides.push_back(rays_.Slide(row, col, sample) / world_.cell_size_m);
        }
      }
    }
    return slides;
  }

  Eigen::Vector3f LightAlong(const Eigen::Vector2d& slide, const HeightRange& layer) const {
    const DescentRay ray = DescentThrough(layer, origin_, slide);
    const float depth = field_.HitDepth(ray);
    const Eigen::Vector2f cell = ray.CellAt(depth);
    return leaves_.Gain(cell, layer.top - depth) * RadianceAt(world_.radiance, cell);
  }

  const World& world_;
  const HeightField& field_;
  const Rays& rays_;
  Eigen::Vector3d origin_;
  Leaves leaves_;
};

// Where a moving camera is some time after (or before) a pose.
Rigid3d After(const Rigid3d& world_from_camera, const CameraMotion& motion, double seconds) {
  if (seconds == 0.0) return world_from_camera;
  const Eigen::Vector3d turn = seconds * motion.turn_rate_in_camera;
  Rigid3d after = world_from_camera;
  after.translation += seconds * motion.velocity_in_world;
  if (turn.norm() > 0.0) {
    after.rotation = world_from_camera.rotation * Eigen::AngleAxisd(turn.norm(), turn.normalized());
  }
  return after;
}

// The mean over a straight way of the picture, in pixels.
cv::Mat3f Smeared(const cv::Mat3f& light, const Eigen::Vector2d& way_px) {
  constexpr double kLeastPx = 0.1;
  if (way_px.norm() < kLeastPx) return light;
  const int reach = static_cast<int>(std::ceil(0.5 * way_px.cwiseAbs().maxCoeff()));
  cv::Mat1f kernel = cv::Mat1f::zeros(2 * reach + 1, 2 * reach + 1);
  constexpr int kNumSteps = 64;
  for (int i = 0; i < kNumSteps; ++i) {
    const Eigen::Vector2d at = ((i + 0.5) / kNumSteps - 0.5) * way_px;
    const int left = static_cast<int>(std::floor(at.x())),
              top = static_cast<int>(std::floor(at.y()));
    const double u = at.x() - left, v = at.y() - top;
    for (const auto& [col, row, weight] : {std::tuple(left, top, (1.0 - u) * (1.0 - v)),
                                           std::tuple(left + 1, top, u * (1.0 - v)),
                                           std::tuple(left, top + 1, (1.0 - u) * v),
                                           std::tuple(left + 1, top + 1, u * v)}) {
      if (weight == 0.0) continue;
      kernel(row + reach, col + reach) += static_cast<float>(weight / kNumSteps);
    }
  }
  cv::Mat3f smeared;
  cv::filter2D(light, smeared, -1, kernel, {-1, -1}, 0.0, cv::BORDER_REPLICATE);
  return smeared;
}

}  // namespace

Renderer::Renderer(const World& world) : world_(world), field_(world.surface) {}

Eigen::Vector3d Renderer::CellsFrom(const Eigen::Vector3d& point_in_world) const {
  return {
      world_.CellFrom(point_in_world.x()), world_.CellFrom(point_in_world.y()), point_in_world.z()};
}

std::optional<Eigen::Vector3d> Renderer::FirstHit(const Eigen::Vector3d& origin_in_world,
                                                  const Eigen::Vector3d& ray_in_world) const {
  if (ray_in_world.z() >= 0.0) return std::nullopt;
  const Eigen::Vector2d slide_m = ray_in_world.head<2>() / -ray_in_world.z();
  const Eigen::Vector2d slide = slide_m / world_.cell_size_m;
  const Eigen::Vector3d origin = CellsFrom(origin_in_world);
  const HeightRange layer = field_.LayerMetBy(origin, Eigen::AlignedBox2d(slide));
  const double depth = field_.HitDepth(DescentThrough(layer, origin, slide));
  const double z = layer.top - depth;
  const Eigen::Vector2d hit_m = origin_in_world.head<2>() + (origin_in_world.z() - z) * slide_m;
  return Eigen::Vector3d(hit_m.x(), hit_m.y(), z);
}

cv::Mat Renderer::Render(const Camera& camera,
                         const Rigid3d& world_from_camera,
                         const RenderOptions& options,
                         int frame_index,
                         const CameraMotion& motion) const {
  cv::Mat3f light(camera.height_px, camera.width_px, cv::Vec3f::all(0.0f));
  const cv::Rect image(0, 0, camera.width_px, camera.height_px);
  const int num_bands = (camera.height_px + kTilePx - 1) / kTilePx;
  cv::parallel_for_({0, num_bands}, [&](const cv::Range& bands) {
    for (int band = bands.start; band < bands.end; ++band) {
      const double row = band * kTilePx + 0.5 * (kTilePx - 1);
      const double seconds = options.readout_s * (row - camera.cy_px) / camera.height_px;
      const Rigid3d pose = After(world_from_camera, motion, seconds);
      const Rays rays(camera, pose.rotation, options.supersampling);
      const Tracer tracer(world_, field_, rays, CellsFrom(pose.translation));
      for (int col = 0; col < camera.width_px; col += kTilePx) {
        tracer.Trace(cv::Rect(col, band * kTilePx, kTilePx, kTilePx) & image, light);
      }
    }
  });
  const double height =
      world_from_camera.translation.z() -
      world_.SurfaceHeight(world_from_camera.translation.x(), world_from_camera.translation.y());
  const Eigen::Vector3d moved =
      world_from_camera.rotation.conjugate() * (options.exposure_s * motion.velocity_in_world);
  const Eigen::Vector2d smear_px = camera.MeanFocalPx() / std::max(height, 1.0) * moved.head<2>();
  return Expose(Smeared(light, smear_px), options, frame_index);
}

}  // namespace freelsd
