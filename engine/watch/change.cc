#include "engine/watch/change.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"
#include "engine/watch/light_bands.h"

namespace freelsd {
namespace {

// Both pictures are smoothed by this much, so that one that is less sharp shows no change.
constexpr double kSmoothingPx = 0.8;
// Changes that stand out by more are left out of the light's, deviations.
constexpr float kOutlier = 2.5f;
constexpr int kNumRounds = 2;
// Of a normal distribution: deviation per median of the absolute values.
constexpr float kDeviationPerMedian = 1.4826f;

cv::Mat3f Smooth(const cv::Mat3f& picture) {
  cv::Mat3f smooth;
  cv::GaussianBlur(picture, smooth, {}, kSmoothingPx, kSmoothingPx, cv::BORDER_REPLICATE);
  return smooth;
}

// Deviation about 0, from the median.
float RobustDeviation(const cv::Mat1f& values, const cv::Mat1b& counts) {
  std::vector<float> sizes;
  for (int row = 0; row < values.rows; ++row) {
    for (int col = 0; col < values.cols; ++col) {
      if (counts(row, col) != 0) sizes.push_back(std::abs(values(row, col)));
    }
  }
  if (sizes.empty()) return 0.0f;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return kDeviationPerMedian * *middle;
}

// Mean over the surroundings without what stands out from them.
cv::Mat1f Surroundings(const cv::Mat1f& values, const cv::Mat1b& counts, int side_px) {
  cv::Mat1b kept = counts.clone();
  cv::Mat1f mean = MaskedMean(values, kept, side_px);
  for (int round = 0; round < kNumRounds; ++round) {
    const cv::Mat1f rest = values - mean;
    const float limit = kOutlier * RobustDeviation(rest, counts);
    kept = counts & (cv::abs(rest) <= limit);
    mean = MaskedMean(values, kept, side_px);
  }
  return mean;
}

// Distance of each value to the range of the other picture's values nearby, with its sign.
cv::Mat1f BeyondRange(const cv::Mat1f& values, const cv::Mat1f& others, int radius_px) {
  const cv::Mat disc =
      cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius_px + 1, 2 * radius_px + 1});
  cv::Mat1f low, high;
  cv::erode(others, low, disc);
  cv::dilate(others, high, disc);
  return cv::max(values - high, 0.0f) + cv::min(values - low, 0.0f);
}

// The two pictures' values of one band.
struct BandPair {
  const cv::Mat1f& stored;
  const cv::Mat1f& seen;
  const cv::Mat1f& stored_noise;
  const cv::Mat1f& seen_noise;
};

// Smoothing leaves this share of the variance of noise.
constexpr float kNoiseLeft = 0.25f;

BandChange ChangeOfBand(const BandPair& band,
                        const StripChange& where,
                        double pixel_m,
                        const WatchOptions& options) {
  BandChange result;
  const cv::Mat1f difference = band.seen - band.stored;
  const cv::Mat1f light =
      Surroundings(difference, where.is_shown, BoxSide(options.light_window_m / pixel_m));
  result.change = difference;
  const cv::Mat1f detail =
      difference -
      Surroundings(difference, where.is_shown, BoxSide(options.detail_window_m / pixel_m));
  const float common = RobustDeviation(detail, where.is_compared);
  cv::Mat1f deviation;
  cv::sqrt(kNoiseLeft * (band.stored_noise.mul(band.stored_noise) +
                         band.seen_noise.mul(band.seen_noise)) +
               common * common,
           deviation);
  const int radius_px = std::max(1, static_cast<int>(std::lround(options.tolerance_m / pixel_m)));
  result.deviations = BeyondRange(band.seen - light, band.stored, radius_px) / deviation;
  result.change.setTo(0.0f, where.is_shown == 0);
  result.deviations.setTo(0.0f, where.is_shown == 0);
  result.seen = band.seen;
  return result;
}

}  // namespace

StripChange ChangeOf(const StripCanvas& canvas,
                     const ProjectedPhoto& photo,
                     const cv::Mat1b& is_comparable,
                     const WatchOptions& options) {
  const double pixel_m = canvas.grid.cell_size_m;
  const LightBands stored = BandsOf(Smooth(canvas.picture), options.noise_grey);
  const LightBands seen = BandsOf(Smooth(photo.picture), options.noise_grey);
  StripChange change;
  change.is_shown = canvas.is_shown & photo.is_shown & is_comparable;
  change.is_compared = change.is_shown & canvas.is_strip;
  const std::array<BandPair, kNumBands> pairs{
      BandPair{stored.brightness, seen.brightness, stored.brightness_noise, seen.brightness_noise},
      BandPair{stored.green_excess, seen.green_excess, stored.green_noise, seen.green_noise},
      BandPair{stored.red_blue, seen.red_blue, stored.red_blue_noise, seen.red_blue_noise}};
  for (size_t i = 0; i < pairs.size(); ++i) {
    change.bands[i] = ChangeOfBand(pairs[i], change, pixel_m, options);
  }
  return change;
}

}  // namespace freelsd
