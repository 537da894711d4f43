#include "engine/tracks/keypoints.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "engine/tracks/corners.h"
#include "engine/tracks/sift.h"

namespace freelsd {
namespace {

// Lucas-Kanade: the window sees texture of a meadow, the pyramid reaches displacements of about
// ten windows.
const cv::Size kWindow(17, 17);
constexpr int kNumPyramidLevels = 4;
constexpr int kMaxNumIterations = 10;
constexpr double kIterationTolerancePx = 0.03;
// Corner quality relative to the best of the image; low, because grass beside a roof still counts.
constexpr double kCornerQuality = 0.002;
// Grass and dark frames have little contrast; Lowe asks for 0.03.
constexpr float kMinContrast = 0.005F;
// Cells over which keypoints are spread, per axis.
constexpr int kNumGridCells = 8;
// Root-SIFT entries are in [0, 1] and rarely above one half: stored as bytes.
constexpr double kDescriptorScale = 400.0;

cv::Mat GreyOf(const cv::Mat& image) {
  if (image.channels() == 1) return image.clone();
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

int CellOf(const cv::Point2f& place, cv::Size size) {
  const auto index = [](float at, int length) {
    return std::clamp(static_cast<int>(at * kNumGridCells) / length, 0, kNumGridCells - 1);
  };
  return index(place.y, size.height) * kNumGridCells + index(place.x, size.width);
}

// A blob as it is described: turned to one of its directions.
struct Keypoint {
  const Blob* blob = nullptr;
  float direction_deg = 0.0F;
};

std::vector<Keypoint> KeypointsOf(const Blob& blob, const std::vector<Octave>& octaves) {
  std::vector<Keypoint> keypoints;
  for (const float direction_deg : DirectionsOf(blob, octaves)) {
    keypoints.push_back({&blob, direction_deg});
  }
  return keypoints;
}

// Best keypoints of every cell of a grid, so that one bush does not take them all; the best others
// where cells have too few. Directions of a blob are sought only when its turn comes: most are
// never needed. All there are, if they are not too many, are in order of place.
std::vector<Keypoint> Spread(const std::vector<Blob>& blobs,
                             const std::vector<Octave>& octaves,
                             cv::Size size,
                             size_t max_count) {
  std::vector<size_t> filled(kNumGridCells * kNumGridCells, 0);
  const size_t share = max_count / filled.size() + 1;
  std::vector<Keypoint> chosen;
  // A blob, and how many of its directions are chosen already.
  std::vector<std::pair<const Blob*, size_t>> spare;
  for (const Blob& blob : blobs) {
    if (chosen.size() > max_count) break;
    size_t& num_here = filled[static_cast<size_t>(CellOf(blob.PlaceInImage(), size))];
    const size_t room = share - num_here;
    if (room == 0) {
      spare.emplace_back(&blob, 0);
      continue;
    }
    const std::vector<Keypoint> keypoints = KeypointsOf(blob, octaves);
    const size_t num_chosen = std::min(room, keypoints.size());
    chosen.insert(chosen.end(), keypoints.begin(), keypoints.begin() + num_chosen);
    num_here += num_chosen;
    if (num_chosen < keypoints.size()) spare.emplace_back(&blob, num_chosen);
  }
  for (const auto& [blob, num_chosen] : spare) {
    if (chosen.size() > max_count) break;
    const std::vector<Keypoint> keypoints = KeypointsOf(*blob, octaves);
    chosen.insert(chosen.end(), keypoints.begin() + num_chosen, keypoints.end());
  }
  if (chosen.size() > max_count) {
    chosen.resize(max_count);
    return chosen;
  }
  std::stable_sort(chosen.begin(), chosen.end(), [](const Keypoint& a, const Keypoint& b) {
    const cv::Point2f place_a = a.blob->PlaceInImage(), place_b = b.blob->PlaceInImage();
    return std::tuple(place_a.x, place_a.y) < std::tuple(place_b.x, place_b.y);
  });
  return chosen;
}

// Hellinger kernel: square root of the L1-normalised descriptor.
void TakeRoots(const Descriptor& descriptor, uchar* root) {
  const double sum = std::max(std::accumulate(descriptor.begin(), descriptor.end(), 0.0), 1e-6);
  for (size_t i = 0; i < descriptor.size(); ++i) {
    root[i] = cv::saturate_cast<uchar>(std::sqrt(descriptor[i] / sum) * kDescriptorScale);
  }
}

}  // namespace

Eigen::Vector2d TrackingImage::FullFromReduced(const cv::Point2f& point) const {
  return {(point.x + 0.5) / scale - 0.5, (point.y + 0.5) / scale - 0.5};
}

cv::Point2f TrackingImage::ReducedFromFull(const Eigen::Vector2d& point) const {
  return {static_cast<float>((point.x() + 0.5) * scale - 0.5),
          static_cast<float>((point.y() + 0.5) * scale - 0.5)};
}

TrackingImage ReduceForTracking(const cv::Mat& image, const TracksOptions& options) {
  TrackingImage reduced;
  reduced.scale = std::min(1.0, static_cast<double>(options.matching_width_px) / image.cols);
  if (reduced.scale == 1.0) {
    reduced.grey = GreyOf(image);
    return reduced;
  }
  cv::Mat small;
  const cv::Size size(options.matching_width_px,
                      std::max(1, static_cast<int>(std::lround(image.rows * reduced.scale))));
  cv::resize(image, small, size, 0.0, 0.0, cv::INTER_AREA);
  reduced.grey = GreyOf(small);
  return reduced;
}

std::vector<Eigen::Vector2d> FindCorners(const TrackingImage& image,
                                         const std::vector<Eigen::Vector2d>& existing,
                                         const TracksOptions& options) {
  const int missing = options.max_num_corners - static_cast<int>(existing.size());
  if (missing <= 0) return {};
  // A quarter of the mean spacing keeps corners apart but lets textured patches be used.
  const double area = static_cast<double>(image.grey.total());
  const double spacing = 0.5 * std::sqrt(area / options.max_num_corners);
  cv::Mat mask(image.grey.size(), CV_8U, cv::Scalar(255));
  for (const Eigen::Vector2d& point : existing) {
    cv::circle(mask, image.ReducedFromFull(point), static_cast<int>(spacing), 0, cv::FILLED);
  }
  std::vector<Eigen::Vector2d> points;
  for (const cv::Point& corner :
       StrongestCorners(image.grey, {mask, missing, kCornerQuality, spacing})) {
    points.push_back(image.FullFromReduced(corner));
  }
  return points;
}

TrackingImage WithPyramid(TrackingImage image) {
  if (image.pyramid.empty()) {
    cv::buildOpticalFlowPyramid(image.grey, image.pyramid, kWindow, kNumPyramidLevels);
  }
  return image;
}

std::vector<std::optional<Eigen::Vector2d>> FollowCorners(
    const TrackingImage& from,
    const TrackingImage& to,
    const std::vector<Eigen::Vector2d>& points,
    const std::vector<Eigen::Vector2d>& guesses,
    const TracksOptions& options) {
  std::vector<std::optional<Eigen::Vector2d>> followed(points.size());
  if (points.empty()) return followed;
  std::vector<cv::Point2f> start, there, back;
  for (const Eigen::Vector2d& point : points) start.push_back(from.ReducedFromFull(point));
  for (const Eigen::Vector2d& guess : guesses) there.push_back(to.ReducedFromFull(guess));
  const int flags = guesses.empty() ? 0 : cv::OPTFLOW_USE_INITIAL_FLOW;
  const cv::TermCriteria criteria(
      cv::TermCriteria::COUNT + cv::TermCriteria::EPS, kMaxNumIterations, kIterationTolerancePx);
  std::vector<uchar> found, found_back;
  cv::calcOpticalFlowPyrLK(from.pyramid,
                           to.pyramid,
                           start,
                           there,
                           found,
                           cv::noArray(),
                           kWindow,
                           kNumPyramidLevels,
                           criteria,
                           flags);
  back = start;
  cv::calcOpticalFlowPyrLK(to.pyramid,
                           from.pyramid,
                           there,
                           back,
                           found_back,
                           cv::noArray(),
                           kWindow,
                           kNumPyramidLevels,
                           criteria,
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  const cv::Rect2f inside(
      0.0F, 0.0F, static_cast<float>(to.grey.cols - 1), static_cast<float>(to.grey.rows - 1));
  for (size_t i = 0; i < points.size(); ++i) {
    if (!found[i] || !found_back[i] || !inside.contains(there[i])) continue;
    if (cv::norm(back[i] - start[i]) > options.max_forward_backward_error_px) continue;
    followed[i] = to.FullFromReduced(there[i]);
  }
  return followed;
}

DescribedPoints DescribeKeypoints(const TrackingImage& image, const TracksOptions& options) {
  const std::vector<Octave> octaves = ScaleSpaceOf(image.grey, kMinOctaveSidePx);
  const std::vector<Blob> blobs = FindBlobs(octaves, kMinContrast);
  const std::vector<Keypoint> keypoints =
      Spread(blobs, octaves, image.grey.size(), static_cast<size_t>(options.max_num_keypoints));
  DescribedPoints described;
  if (keypoints.empty()) return described;
  described.descriptors.create(static_cast<int>(keypoints.size()), kNumDescriptorEntries, CV_8U);
  for (const Keypoint& keypoint : keypoints) {
    const auto row = static_cast<int>(described.points.size());
    TakeRoots(Describe(*keypoint.blob, keypoint.direction_deg, octaves),
              described.descriptors.ptr<uchar>(row));
    described.points.push_back(image.FullFromReduced(keypoint.blob->PlaceInImage()));
  }
  return described;
}

}  // namespace freelsd
