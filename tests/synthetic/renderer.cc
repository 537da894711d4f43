#include "tests/synthetic/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <opencv2/imgproc.hpp>

#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

// Sides of the blocks, in cells, coarse to fine.
constexpr int kBlockCells[] = {128, 16};
// Where the ray is below a block's top it is tried every half cell, then the hit is closed in on.
constexpr double kStepCells = 0.5;
constexpr int kNumRefinements = 4;
constexpr uint64_t kSensorPurpose = 401;
constexpr uint64_t kExposurePurpose = 402;
constexpr uint64_t kLeafPurpose = 403;
constexpr float kLeafContrast = 0.30f;

cv::Mat1f BlockTops(const cv::Mat1f& surface, int side) {
  const int n = (surface.rows + side - 1) / side;
  cv::Mat1f tops(n, n);
  for (int row = 0; row < n; ++row) {
    for (int col = 0; col < n; ++col) {
      // Bilinear heights reach one cell beyond the block, and rays are followed half a cell beyond.
      const cv::Rect block(col * side - 2, row * side - 2, side + 4, side + 4);
      double highest = 0.0;
      cv::minMaxLoc(surface(block & cv::Rect(0, 0, surface.cols, surface.rows)), nullptr, &highest);
      tops(row, col) = static_cast<float>(highest);
    }
  }
  return tops;
}

// A ray in cells, by metres of descent from where it enters the layer in which things stand.
struct Descent {
  Eigen::Vector2d entry;
  Eigen::Vector2d slide;  // cells per metre
  double top;             // world z at descent 0

  Eigen::Vector2d CellAt(double depth) const { return entry + depth * slide; }
  double Clearance(const cv::Mat1f& surface, double depth) const {
    const Eigen::Vector2d cell = CellAt(depth);
    return top - depth - Bilinear(surface, cell.x(), cell.y());
  }
  // Depth at which the ray leaves its block sideways.
  double LeavesBlockAt(double depth, const cv::Point& block, int side) const {
    const Eigen::Vector2d cell = CellAt(depth);
    double leaves = std::numeric_limits<double>::infinity();
    if (slide.x() != 0.0) {
      leaves = (side * (block.x + (slide.x() > 0.0)) - cell.x()) / slide.x();
    }
    if (slide.y() != 0.0) {
      leaves = std::min(leaves, (side * (block.y + (slide.y() > 0.0)) - cell.y()) / slide.y());
    }
    return depth + leaves;
  }
};

// Depth of the surface between a place above it and one in or below it (false position).
double CloseIn(const cv::Mat1f& surface, const Descent& descent, double above, double below) {
  double over = descent.Clearance(surface, above);
  double under = descent.Clearance(surface, below);
  for (int i = 0; i < kNumRefinements && over - under > 0.0; ++i) {
    const double guess = above + (below - above) * over / (over - under);
    const double clearance = descent.Clearance(surface, guess);
    if (clearance > 0.0) {
      above = guess;
      over = clearance;
    } else {
      below = guess;
      under = clearance;
    }
  }
  return over - under > 0.0 ? above + (below - above) * over / (over - under) : below;
}

Eigen::Vector3f RadianceAt(const cv::Mat3b& grid, double col, double row) {
  const double u = std::clamp(col, 0.0, grid.cols - 1.001);
  const double v = std::clamp(row, 0.0, grid.rows - 1.001);
  const int left = static_cast<int>(u), first = static_cast<int>(v);
  const float tu = static_cast<float>(u - left), tv = static_cast<float>(v - first);
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
  explicit Leaves(uint64_t seed)
      : fine_(MixSeed(seed, kLeafPurpose), 0.4), coarse_(MixSeed(seed, kLeafPurpose + 1), 1.4) {}

  float Gain(const World& world, const Eigen::Vector3d& point) const {
    const Cover cover = world.CoverAt(point.x(), point.y());
    if (cover != Cover::kTree && cover != Cover::kHedge) return 1.0f;
    // A slanted cut through space: moves with the height as fast as with the place.
    const double u = point.x() + 0.83 * point.z(), v = point.y() - 0.71 * point.z();
    const float gain = 1.0f + kLeafContrast * (1.2f * fine_.At(u, v) + 0.8f * coarse_.At(u, v));
    return std::clamp(gain, 0.25f, 2.2f);
  }

 private:
  Noise fine_, coarse_;
};

double Exposure(const RenderOptions& options, int frame_index) {
  const Noise slow(MixSeed(options.seed, kExposurePurpose), 15.0);
  const double wander = std::clamp(0.5 * slow.At(frame_index, 0.0), -1.0, 1.0);
  return 1.0 + options.exposure_drift_ratio * wander;
}

// Lens and sensor: blur, darker corners, exposure, noise.
cv::Mat Expose(const cv::Mat3f& light, const RenderOptions& options, int frame_index) {
  cv::Mat3f blurred = light;
  if (options.lens_blur_px > 0.0) {
    cv::GaussianBlur(
        light, blurred, {}, options.lens_blur_px, options.lens_blur_px, cv::BORDER_REPLICATE);
  }
  const double exposure = Exposure(options, frame_index);
  const double cx = 0.5 * (light.cols - 1), cy = 0.5 * (light.rows - 1);
  const double corner = cx * cx + cy * cy;
  std::mt19937_64 random(MixSeed(MixSeed(options.seed, kSensorPurpose), frame_index));
  std::normal_distribution<float> noise(0.0f, static_cast<float>(options.sensor_noise));
  cv::Mat3b image(light.size());
  for (int row = 0; row < light.rows; ++row) {
    for (int col = 0; col < light.cols; ++col) {
      const double radius = ((col - cx) * (col - cx) + (row - cy) * (row - cy)) / corner;
      const float gain = static_cast<float>(exposure * (1.0 - options.vignetting_ratio * radius));
      for (int i = 0; i < 3; ++i) {
        const float value =
            gain * blurred(row, col)[i] + (options.sensor_noise > 0.0 ? noise(random) : 0.0f);
        image(row, col)[i] = cv::saturate_cast<uint8_t>(value);
      }
    }
  }
  return image;
}

// Depth down to which nothing can be hit; `depth` itself where that is not known.
double FreeUntil(const std::vector<cv::Mat1f>& block_tops,
                 const Descent& descent,
                 double depth,
                 double step) {
  const Eigen::Vector2d cell = descent.CellAt(depth);
  for (size_t level = 0; level < block_tops.size(); ++level) {
    const int side = kBlockCells[level];
    const cv::Mat1f& tops = block_tops[level];
    const cv::Point block(std::clamp(static_cast<int>(cell.x()) / side, 0, tops.cols - 1),
                          std::clamp(static_cast<int>(cell.y()) / side, 0, tops.rows - 1));
    const double block_depth = descent.top - tops(block);
    if (depth >= block_depth) continue;
    const double leaves = descent.LeavesBlockAt(depth, block, side);
    return std::min(block_depth, std::max(leaves, depth + step));
  }
  return depth;
}

}  // namespace

Renderer::Renderer(const World& world) : world_(world) {
  for (const int side : kBlockCells) block_tops_.push_back(BlockTops(world.surface, side));
  cv::minMaxLoc(world.surface, &lowest_, &highest_);
}

std::optional<Eigen::Vector3d> Renderer::FirstHit(const Eigen::Vector3d& origin_in_world,
                                                  const Eigen::Vector3d& ray_in_world) const {
  if (ray_in_world.z() >= 0.0) return std::nullopt;
  const Eigen::Vector2d slide_m = ray_in_world.head<2>() / -ray_in_world.z();
  Descent descent;
  descent.top = std::min(highest_, origin_in_world.z());
  const Eigen::Vector2d entry_m =
      origin_in_world.head<2>() + (origin_in_world.z() - descent.top) * slide_m;
  descent.entry = {world_.CellFrom(entry_m.x()), world_.CellFrom(entry_m.y())};
  descent.slide = slide_m / world_.cell_size_m;
  const double limit = descent.top - lowest_;
  const double step = kStepCells / std::max(descent.slide.norm(), 1e-9);
  double above = 0.0, depth = 0.0;
  while (depth < limit) {
    const double free = FreeUntil(block_tops_, descent, depth, step);
    if (free <= depth && descent.Clearance(world_.surface, depth) <= 0.0) break;
    above = depth;
    depth = free > depth ? free : depth + step;
  }
  depth = CloseIn(world_.surface, descent, above, std::min(depth, limit));
  const Eigen::Vector2d hit_m = entry_m + depth * slide_m;
  return Eigen::Vector3d(hit_m.x(), hit_m.y(), descent.top - depth);
}

cv::Mat Renderer::Render(const Camera& camera,
                         const Rigid3d& world_from_camera,
                         const RenderOptions& options,
                         int frame_index) const {
  cv::Mat3f light(camera.height_px, camera.width_px);
  const Leaves leaves(world_.seed);
  const int num = options.supersampling;
  const Eigen::Matrix3d rotation = world_from_camera.rotation.toRotationMatrix();
  cv::parallel_for_({0, camera.height_px}, [&](const cv::Range& rows) {
    for (int row = rows.start; row < rows.end; ++row) {
      for (int col = 0; col < camera.width_px; ++col) {
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (int sample = 0; sample < num * num; ++sample) {
          const Eigen::Vector2d point_in_image(col - 0.5 + (sample % num + 0.5) / num,
                                               row - 0.5 + (sample / num + 0.5) / num);
          const Eigen::Vector3d ray =
              rotation * camera.NormalizedFromImage(point_in_image).homogeneous();
          const auto hit = FirstHit(world_from_camera.translation, ray);
          if (!hit) continue;
          sum += leaves.Gain(world_, *hit) *
                 RadianceAt(world_.radiance, world_.CellFrom(hit->x()), world_.CellFrom(hit->y()));
        }
        sum /= static_cast<float>(num * num);
        light(row, col) = cv::Vec3f(sum.x(), sum.y(), sum.z());
      }
    }
  });
  return Expose(light, options, frame_index);
}

}  // namespace freelsd
