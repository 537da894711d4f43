#include "engine/stereo/matching.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "engine/stereo/semi_global_matching.h"
#include "engine/stereo/window_correlation.h"

namespace freelsd {
namespace {

constexpr int kDisparityStep = 16;
constexpr int kSpeckleRangePx = 2;
// Limit of contrast stretching: more would turn noise into texture.
constexpr double kMaxGain = 4.0;

struct DisparityRange {
  int min_px = 0;
  int count = kDisparityStep;
};

DisparityRange RangeOf(const RectifiedPair& pair,
                       const DepthRange& depths,
                       const StereoOptions& options) {
  const int low = static_cast<int>(std::floor(pair.DisparityOf(depths.farthest)));
  const int high = static_cast<int>(std::ceil(pair.DisparityOf(depths.nearest)));
  int count = (high - low + kDisparityStep) / kDisparityStep * kDisparityStep;
  count = std::min(count, options.max_num_disparities / kDisparityStep * kDisparityStep);
  return {low, std::max(count, kDisparityStep)};
}

// The right image with mean and contrast of the left one. Exposure varies from frame to frame, and
// the matcher compares grey levels.
cv::Mat1b WithExposureOfLeft(const RectifiedPair& pair) {
  cv::Scalar left_mean, left_sd, right_mean, right_sd;
  cv::meanStdDev(pair.left, left_mean, left_sd, pair.is_left_inside);
  cv::meanStdDev(pair.right, right_mean, right_sd, pair.is_right_inside);
  const double gain = std::min(left_sd[0] / std::max(right_sd[0], 1.0), kMaxGain);
  cv::Mat1b matched;
  pair.right.convertTo(matched, CV_8U, gain, left_mean[0] - gain * right_mean[0]);
  return matched;
}

cv::Mat1s Match(const RectifiedPair& pair,
                const cv::Mat1b& right,
                const DisparityRange& range,
                const StereoOptions& options) {
  const int area = options.block_size_px * options.block_size_px;
  return MatchSemiGlobally(pair.left,
                           right,
                           {range.min_px,
                            range.count,
                            options.block_size_px,
                            options.p1_factor * area,
                            options.p2_factor * area,
                            options.max_left_right_difference_px,
                            options.uniqueness_ratio_percent,
                            options.speckle_size_px,
                            kSpeckleRangePx});
}

// Windows that lie completely inside the image.
cv::Mat1b WholeWindows(const cv::Mat1b& is_inside, int window_px) {
  cv::Mat1b eroded;
  const cv::Mat element =
      cv::getStructuringElement(cv::MORPH_RECT, cv::Size(window_px + 2, window_px + 2));
  cv::erode(is_inside, eroded, element, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  return eroded;
}

// Position of each left pixel in the right image.
cv::Mat2f RightFromLeft(const cv::Mat1s& disparity, int min_px) {
  cv::Mat2f table(disparity.size());
  for (int v = 0; v < table.rows; ++v) {
    for (int u = 0; u < table.cols; ++u) {
      const bool is_matched = disparity(v, u) >= min_px * kDisparityUnit;
      const float column =
          static_cast<float>(u) - static_cast<float>(disparity(v, u)) / kDisparityUnit;
      table(v, u) = cv::Vec2f(is_matched ? column : -1e4f, static_cast<float>(v));
    }
  }
  return table;
}

}  // namespace

cv::Mat1f MatchRectified(const RectifiedPair& pair,
                         const DepthRange& depths,
                         const StereoOptions& options) {
  cv::Mat1f disparity_px(pair.left.size(), std::numeric_limits<float>::quiet_NaN());
  const DisparityRange range = RangeOf(pair, depths, options);
  // The matcher needs room for block and disparities.
  if (pair.left.cols <= range.count + 2 * options.block_size_px) return disparity_px;
  const cv::Mat1b right = WithExposureOfLeft(pair);
  // A window across the border would find the border's own contrast in both images.
  const int window_px = std::max(options.block_size_px, options.correlation_window_px);
  const cv::Mat1s disparity = Match(pair, right, range, options);
  const cv::Mat2f right_from_left = RightFromLeft(disparity, range.min_px);
  cv::Mat1b right_at_left, is_right_whole;
  cv::remap(right, right_at_left, right_from_left, {}, cv::INTER_LINEAR);
  cv::remap(WholeWindows(pair.is_right_inside, window_px),
            is_right_whole,
            right_from_left,
            {},
            cv::INTER_NEAREST);
  // Windows of both images that have contrast and look alike. Windows of water, noise and burnt-out
  // ground fail this test, even if the matcher found a disparity.
  const cv::Mat1b are_alike = AlikeWindows(pair.left,
                                           right_at_left,
                                           {options.correlation_window_px,
                                            options.min_texture_grey * options.min_texture_grey,
                                            options.min_correlation});
  const cv::Mat1b is_sure =
      are_alike & is_right_whole & WholeWindows(pair.is_left_inside, window_px);
  cv::Mat1f matched;
  disparity.convertTo(matched, CV_32F, 1.0 / kDisparityUnit);
  matched.copyTo(disparity_px, is_sure);
  return disparity_px;
}

}  // namespace freelsd
