// Aligns the sightings of a track at full resolution: least-squares matching (Foerstner 1982;
// Gruen 1985) of small patches, in the inverse compositional form (Baker and Matthews 2004).
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/LU>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/tracks/tracks.h"

namespace freelsd {
namespace {

// Half the side of a patch.
constexpr int kRadiusPx = 10;
constexpr size_t kSidePx = 2 * kRadiusPx + 1;
constexpr size_t kNumPixels = kSidePx * kSidePx;
// Blur of both images. Without it, interpolation between pixels shifts the best match.
constexpr double kBlurPx = 1.0;
constexpr int kMaxNumSteps = 12;
constexpr double kStepTolerancePx = 0.02;

using Patch = std::array<float, kNumPixels>;

// A patch around the sighting that defines the track, normalised to mean 0 and norm 1.
struct Reference {
  size_t view = 0;
  Eigen::Vector2d point_in_image = Eigen::Vector2d::Zero();
  Patch grey{};
  Eigen::Matrix2d step_from_slopes = Eigen::Matrix2d::Zero();
};

// Slope of a patch at an inner pixel.
Eigen::Vector2d SlopeAt(const Patch& grey, size_t i) {
  return 0.5 * Eigen::Vector2d(grey[i + 1] - grey[i - 1], grey[i + kSidePx] - grey[i - kSidePx]);
}

cv::Mat1f Blurred(const cv::Mat& image) {
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::Mat1f blurred;
  grey.convertTo(blurred, CV_32F);
  cv::GaussianBlur(blurred, blurred, {}, kBlurPx);
  return blurred;
}

// Bilinear values on the grid of a patch, mapped into the image. Empty at the border.
std::optional<Patch> Sample(const cv::Mat1f& image,
                            const Eigen::Vector2d& centre,
                            const Eigen::Matrix2d& image_from_patch) {
  const double reach = kRadiusPx * image_from_patch.cwiseAbs().rowwise().sum().maxCoeff() + 1.0;
  if (!(centre.x() > reach && centre.y() > reach && centre.x() < image.cols - 1 - reach &&
        centre.y() < image.rows - 1 - reach)) {
    return std::nullopt;
  }
  Patch patch;
  size_t i = 0;
  for (int row = -kRadiusPx; row <= kRadiusPx; ++row) {
    for (int col = -kRadiusPx; col <= kRadiusPx; ++col) {
      const Eigen::Vector2d at = centre + image_from_patch * Eigen::Vector2d(col, row);
      const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
      const auto u = static_cast<float>(at.x() - x), v = static_cast<float>(at.y() - y);
      const float *upper = image[y] + x, *lower = image[y + 1] + x;
      patch[i++] = (1.0F - v) * (upper[0] + u * (upper[1] - upper[0])) +
                   v * (lower[0] + u * (lower[1] - lower[0]));
    }
  }
  return patch;
}

// To mean 0 and norm 1; false if the patch has no contrast.
bool Normalise(Patch& patch) {
  double sum = 0.0, squares = 0.0;
  for (const float value : patch) sum += value;
  const auto mean = static_cast<float>(sum / kNumPixels);
  for (float& value : patch) {
    value -= mean;
    squares += value * value;
  }
  // A standard deviation of half a grey level.
  if (squares < 0.25 * kNumPixels) return false;
  const auto factor = static_cast<float>(1.0 / std::sqrt(squares));
  for (float& value : patch) value *= factor;
  return true;
}

std::optional<Reference> ReferenceAt(const cv::Mat1f& image,
                                     size_t view,
                                     const Eigen::Vector2d& point_in_image) {
  std::optional<Patch> grey = Sample(image, point_in_image, Eigen::Matrix2d::Identity());
  if (!grey || !Normalise(*grey)) return std::nullopt;
  Reference reference{view, point_in_image, *grey};
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  for (size_t row = 1; row + 1 < kSidePx; ++row) {
    for (size_t col = 1; col + 1 < kSidePx; ++col) {
      const Eigen::Vector2d slope = SlopeAt(*grey, row * kSidePx + col);
      information += slope * slope.transpose();
    }
  }
  bool is_invertible = false;
  double determinant = 0.0;
  information.computeInverseAndDetWithCheck(reference.step_from_slopes, determinant, is_invertible);
  return is_invertible ? std::optional<Reference>(reference) : std::nullopt;
}

// Pixel of `to` that shows the same place of level ground as a pixel of `from`.
std::optional<Eigen::Vector2d> Transferred(const View& from,
                                           const Camera& from_camera,
                                           const View& to,
                                           const Camera& to_camera,
                                           const Eigen::Vector2d& point_in_image) {
  constexpr double kMinDescent = 0.2;
  const Eigen::Vector3d ray =
      from.world_from_camera.rotation * from_camera.RayFromImage(point_in_image);
  if (ray.z() > -kMinDescent) return std::nullopt;
  const Eigen::Vector3d place =
      from.world_from_camera.translation + ray * (from.height_above_ground / -ray.z());
  return to_camera.ImageFromCamera(Inverse(to.world_from_camera) * place);
}

// Linear part of that transfer: scale, rotation and perspective at a pixel.
std::optional<Eigen::Matrix2d> LinearTransfer(const View& from,
                                              const Camera& from_camera,
                                              const View& to,
                                              const Camera& to_camera,
                                              const Eigen::Vector2d& point_in_image) {
  Eigen::Matrix2d linear;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = kRadiusPx * Eigen::Vector2d::Unit(axis);
    const auto ahead = Transferred(from, from_camera, to, to_camera, point_in_image + step);
    const auto behind = Transferred(from, from_camera, to, to_camera, point_in_image - step);
    if (!ahead || !behind) return std::nullopt;
    linear.col(axis) = (*ahead - *behind) / (2.0 * kRadiusPx);
  }
  return linear;
}

// Sum of the differences of two patches, each times the slope.
Eigen::Vector2d PullOf(const Patch& seen, const Patch& grey) {
  Eigen::Vector2d pull = Eigen::Vector2d::Zero();
  for (size_t row = 1; row + 1 < kSidePx; ++row) {
    for (size_t col = 1; col + 1 < kSidePx; ++col) {
      const size_t i = row * kSidePx + col;
      pull += static_cast<double>(seen[i] - grey[i]) * SlopeAt(grey, i);
    }
  }
  return pull;
}

// The aligned pixel; empty if the patches do not become alike.
std::optional<Eigen::Vector2d> Align(const Reference& reference,
                                     const cv::Mat1f& image,
                                     const Eigen::Vector2d& start,
                                     const Eigen::Matrix2d& image_from_patch,
                                     const TracksOptions& options) {
  Eigen::Vector2d at = start;
  for (int i = 0; i < kMaxNumSteps; ++i) {
    std::optional<Patch> seen = Sample(image, at, image_from_patch);
    if (!seen || !Normalise(*seen)) return std::nullopt;
    const Eigen::Vector2d pull = PullOf(*seen, reference.grey);
    const Eigen::Vector2d step = image_from_patch * (reference.step_from_slopes * pull);
    at -= step;
    if (!((at - start).norm() <= options.max_alignment_shift_px)) return std::nullopt;
    if (step.norm() > kStepTolerancePx) continue;
    const double correlation =
        std::inner_product(seen->begin(), seen->end(), reference.grey.begin(), 0.0);
    return correlation >= options.min_alignment_correlation ? std::optional<Eigen::Vector2d>(at)
                                                            : std::nullopt;
  }
  return std::nullopt;
}

// Per track of two or more sightings, the view whose sighting is nearest to the image centre; the
// lowest one of equals.
std::map<int64_t, size_t> ReferenceViews(const std::vector<View>& views, const Camera& camera) {
  struct Nearest {
    double distance = 0.0;
    size_t view = 0;
    int num_sightings = 0;
  };
  const Eigen::Vector2d centre(camera.cx_px, camera.cy_px);
  std::map<int64_t, Nearest> nearest;
  for (size_t view = 0; view < views.size(); ++view) {
    for (const Observation& seen : views[view].observations) {
      const double distance = (seen.point_in_image - centre).norm();
      Nearest& best = nearest[seen.track_id];
      const bool is_nearer = best.num_sightings == 0 || distance < best.distance;
      if (is_nearer) best = {distance, view, best.num_sightings};
      ++best.num_sightings;
    }
  }
  std::map<int64_t, size_t> reference_views;
  for (const auto& [track, best] : nearest) {
    if (best.num_sightings > 1) reference_views.emplace(track, best.view);
  }
  return reference_views;
}

std::map<int64_t, Reference> ReferencesOf(const std::vector<View>& views,
                                          const Camera& camera,
                                          const ImageSource& images) {
  const std::map<int64_t, size_t> reference_views = ReferenceViews(views, camera);
  std::vector<std::map<int64_t, Reference>> of_views(views.size());
  cv::parallel_for_({0, static_cast<int>(views.size())}, [&](const cv::Range& range) {
    for (auto view = static_cast<size_t>(range.start); view < static_cast<size_t>(range.end);
         ++view) {
      const cv::Mat image = images(views[view].frame_id);
      if (image.empty()) continue;
      const cv::Mat1f grey = Blurred(image);
      for (const Observation& seen : views[view].observations) {
        const auto found = reference_views.find(seen.track_id);
        if (found == reference_views.end() || found->second != view) continue;
        const auto reference = ReferenceAt(grey, view, seen.point_in_image);
        if (reference) of_views[view].emplace(seen.track_id, *reference);
      }
    }
  });
  std::map<int64_t, Reference> references;
  for (auto& of_view : of_views) references.merge(of_view);
  return references;
}

struct AlignmentTask {
  const std::vector<View>& given;
  size_t view;
  const std::map<int64_t, Reference>& references;
  const Camera& camera;
  const TracksOptions& options;
};

// Aligns the sightings of one view.
void AlignView(const AlignmentTask& task,
               const ImageSource& images,
               std::vector<Observation>& observations) {
  const auto& [given, view, references, camera, options] = task;
  const cv::Mat image = images(given[view].frame_id);
  if (image.empty()) return;
  const cv::Mat1f grey = Blurred(image);
  for (Observation& seen : observations) {
    const auto found = references.find(seen.track_id);
    if (found == references.end() || found->second.view == view) continue;
    const Reference& reference = found->second;
    const View& from = given[reference.view];
    const auto linear = LinearTransfer(from,
                                       camera.With(from.readout),
                                       given[view],
                                       camera.With(given[view].readout),
                                       reference.point_in_image);
    if (!linear) continue;
    const auto aligned = Align(reference, grey, seen.point_in_image, *linear, options);
    if (aligned) seen.point_in_image = *aligned;
  }
}

}  // namespace

std::vector<View> AlignSightings(std::vector<View> views,
                                 const Camera& camera,
                                 const ImageSource& images,
                                 const TracksOptions& options) {
  const bool is_reduced = camera.width_px > options.matching_width_px;
  if (!is_reduced || options.max_alignment_shift_px == 0.0) return views;
  const std::map<int64_t, Reference> references = ReferencesOf(views, camera, images);
  const std::vector<View> given = views;
  cv::parallel_for_({0, static_cast<int>(views.size())}, [&](const cv::Range& range) {
    for (auto i = static_cast<size_t>(range.start); i < static_cast<size_t>(range.end); ++i) {
      AlignView({given, i, references, camera, options}, images, views[i].observations);
    }
  });
  return views;
}

}  // namespace freelsd
