#include "engine/classification/features.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "engine/classification/gabor.h"
#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Avoids divisions by zero in black pixels.
constexpr float kTinyGrey = 1.0f;
// Added to grey levels before the logarithm, so that noise in shadows is not taken for texture.
constexpr float kLogOffset = 4.0f;
// Sides of the averaging windows, metres on the ground.
constexpr double kGapWindowM = 0.3;
constexpr double kFrondWindowM = 0.9;
constexpr double kLeafWindowM = 0.6;
constexpr double kTuftWindowM = 1.8;
constexpr double kBushWindowM = 4.2;
// Share of the pixels at either end of a distribution that its skewness leaves out.
constexpr double kTailRatio = 0.05;
// Least deviation of log brightness: half a grey level in a hundred.
constexpr double kTinyDeviation = 0.005;

void AppendMeanAndDeviation(const cv::Mat& channel,
                            const cv::Mat1b& mask,
                            std::vector<float>& row) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(channel, mean, deviation, mask);
  row.push_back(static_cast<float>(mean[0]));
  row.push_back(static_cast<float>(deviation[0]));
}

void AppendRgb(const cv::Mat3b& image, const cv::Mat1b& mask, std::vector<float>& row) {
  std::array<cv::Mat, 3> bgr;
  cv::split(image, bgr.data());
  for (int channel = 2; channel >= 0; --channel) {
    AppendMeanAndDeviation(bgr[static_cast<size_t>(channel)], mask, row);
  }
}

// Mean direction and deviation of hue as an angle (degrees): 359 and 1 have the mean 0. The
// deviation is sqrt(-2 ln R) of the resultant length R (Mardia).
void AppendHue(const cv::Mat1f& hue_deg, const cv::Mat1b& mask, std::vector<float>& row) {
  double sum_cos = 0.0, sum_sin = 0.0;
  int count = 0;
  for (int y = 0; y < hue_deg.rows; ++y) {
    for (int x = 0; x < hue_deg.cols; ++x) {
      if (mask(y, x) == 0) continue;
      const double hue = RadFromDeg(hue_deg(y, x));
      sum_cos += std::cos(hue);
      sum_sin += std::sin(hue);
      ++count;
    }
  }
  const double resultant = count > 0 ? std::hypot(sum_cos, sum_sin) / count : 0.0;
  double mean_deg = DegFromRad(std::atan2(sum_sin, sum_cos));
  if (mean_deg < 0.0) mean_deg += 360.0;
  row.push_back(static_cast<float>(mean_deg));
  constexpr double kMinResultant = 1e-6;
  row.push_back(static_cast<float>(
      DegFromRad(std::sqrt(-2.0 * std::log(std::clamp(resultant, kMinResultant, 1.0))))));
}

void AppendHsv(const cv::Mat3b& image, const cv::Mat1b& mask, std::vector<float>& row) {
  cv::Mat3f scaled, hsv;
  image.convertTo(scaled, CV_32F, 1.0 / 255.0);
  cv::cvtColor(scaled, hsv, cv::COLOR_BGR2HSV);
  std::array<cv::Mat, 3> channels;
  cv::split(hsv, channels.data());
  AppendHue(channels[0], mask, row);
  AppendMeanAndDeviation(channels[1], mask, row);
  AppendMeanAndDeviation(channels[2], mask, row);
}

void AppendGabor(const cv::Mat1f& grey, const cv::Mat1b& mask, std::vector<float>& row) {
  for (const cv::Mat1f& response : GaborResponses(grey, mask)) {
    AppendMeanAndDeviation(response, mask, row);
  }
}

cv::Mat1f LogGrey(const cv::Mat1b& grey) {
  cv::Mat1f table(1, 256);
  for (int level = 0; level < table.cols; ++level) {
    table(0, level) = std::log(static_cast<float>(level) + kLogOffset);
  }
  cv::Mat1f result;
  cv::LUT(grey, table, result);
  return result;
}

double MeanExcessGreen(const cv::Mat3b& image, const cv::Mat1b& mask) {
  double sum = 0.0;
  int count = 0;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      if (mask(y, x) == 0) continue;
      const cv::Vec3b& bgr = image(y, x);
      const float brightness = static_cast<float>(bgr[0] + bgr[1] + bgr[2]) + kTinyGrey;
      sum += static_cast<float>(2 * bgr[1] - bgr[2] - bgr[0]) / brightness;
      ++count;
    }
  }
  return count > 0 ? sum / count : 0.0;
}

// Mean over the part of a square window that is in the region. weight: 1 in the region, else 0.
cv::Mat1f MeanInRegion(const cv::Mat1f& values, const cv::Mat1f& weight, double window_px) {
  const int side = std::max(1, cvRound(window_px));
  const cv::Size window(side, side);
  cv::Mat1f sum, sum_of_weights;
  cv::boxFilter(values.mul(weight), sum, CV_32F, window, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::boxFilter(weight, sum_of_weights, CV_32F, window, {-1, -1}, false, cv::BORDER_CONSTANT);
  return sum / cv::max(sum_of_weights, 1.0);
}

float LogDeviation(const cv::Mat1f& values, const cv::Mat1b& mask) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(values, mean, deviation, mask);
  return static_cast<float>(std::log(deviation[0] + kTinyDeviation));
}

// (upper + lower - 2 median) / (upper - lower) of a distribution's tails: below 0 where dark gaps
// lie between evenly bright leaves; not moved by a few sheep. Deviations as small as the rounding
// of grey levels have none.
float TailSkewness(const cv::Mat1f& values, const cv::Mat1b& mask) {
  std::vector<float> inside;
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (mask(y, x) != 0) inside.push_back(values(y, x));
    }
  }
  if (inside.empty()) return 0.0f;
  const auto quantile = [&inside](double share) {
    const auto at = inside.begin() +
                    static_cast<std::ptrdiff_t>(share * static_cast<double>(inside.size() - 1));
    std::nth_element(inside.begin(), at, inside.end());
    return *at;
  };
  const float lower = quantile(kTailRatio), median = quantile(0.5),
              upper = quantile(1.0 - kTailRatio);
  return (upper + lower - 2.0f * median) /
         (upper - lower + 2.0f * static_cast<float>(kTinyDeviation));
}

// Logarithms make all of it independent of exposure.
void AppendRobust(const cv::Mat3b& image,
                  const cv::Mat1b& grey,
                  const cv::Mat1b& mask,
                  double ground_sampling_distance_m,
                  std::vector<float>& row) {
  cv::Mat1f weight;
  mask.convertTo(weight, CV_32F, 1.0 / 255.0);
  cv::threshold(weight, weight, 0.0, 1.0, cv::THRESH_BINARY);
  const cv::Mat1f log_grey = LogGrey(grey);
  const auto mean_over = [&](double window_m) {
    return MeanInRegion(log_grey, weight, window_m / ground_sampling_distance_m);
  };
  const cv::Mat1f tufts = mean_over(kTuftWindowM);
  std::array<cv::Mat1b, 3> bgr;
  cv::split(image, bgr.data());
  const double log_green = cv::mean(LogGrey(bgr[1]), mask)[0];
  row.push_back(static_cast<float>(MeanExcessGreen(image, mask)));
  row.push_back(LogDeviation(mean_over(kLeafWindowM) - tufts, mask));
  row.push_back(LogDeviation(tufts - mean_over(kBushWindowM), mask));
  row.push_back(TailSkewness(mean_over(kGapWindowM) - mean_over(kFrondWindowM), mask));
  row.push_back(static_cast<float>(cv::mean(LogGrey(bgr[2]), mask)[0] - log_green));
  row.push_back(static_cast<float>(cv::mean(LogGrey(bgr[0]), mask)[0] - log_green));
}

// The region and its surroundings as far as the filters reach.
cv::Rect BoxOf(const cv::Mat1b& mask) {
  cv::Rect box = cv::boundingRect(mask);
  box.x -= kGaborRadiusPx;
  box.y -= kGaborRadiusPx;
  box.width += 2 * kGaborRadiusPx;
  box.height += 2 * kGaborRadiusPx;
  return box & cv::Rect({0, 0}, mask.size());
}

struct NamedSet {
  FeatureSet feature_set;
  const char* name;
  size_t num_features;
  size_t num_forest_features;
};
constexpr NamedSet kSets[] = {{FeatureSet::kRgb, "rgb", 6, 6},
                              {FeatureSet::kHsv, "hsv", 6, 6},
                              {FeatureSet::kRgbHsv, "rgbhsv", 12, 12},
                              {FeatureSet::kPaper18, "paper18", 18, 18},
                              {FeatureSet::kRobust, "robust", 6, 4}};

constexpr RangeMargin kRangeMargin{0.15f, 0.15f};
// Fern in sun has -0.2 and less, of 144 pastures one. Not learnt: small tiles of grass scatter
// more.
constexpr float kLeastGrassSkewness = -0.19f;
// More vivid green is another camera or season, bluer or greyer is another material. Less texture
// is a softer lens, more of it is no meadow.
constexpr std::array<RangeMargin, 6> kRobustMargins{{{0.15f, 0.5f},
                                                     {0.3f, 0.15f},
                                                     {0.3f, 0.15f},
                                                     {0.5f, 0.5f, kLeastGrassSkewness},
                                                     {0.5f, 0.15f},
                                                     {0.5f, 0.15f}}};

}  // namespace

RangeMargin MarginOf(FeatureSet feature_set, size_t feature) {
  return feature_set == FeatureSet::kRobust ? kRobustMargins[feature] : kRangeMargin;
}

size_t NumFeatures(FeatureSet feature_set) {
  for (const NamedSet& set : kSets) {
    if (set.feature_set == feature_set) return set.num_features;
  }
  return 0;
}

size_t NumForestFeatures(FeatureSet feature_set) {
  for (const NamedSet& set : kSets) {
    if (set.feature_set == feature_set) return set.num_forest_features;
  }
  return 0;
}

std::string NameOf(FeatureSet feature_set) {
  for (const NamedSet& set : kSets) {
    if (set.feature_set == feature_set) return set.name;
  }
  return "";
}

std::optional<FeatureSet> FeatureSetNamed(const std::string& name) {
  for (const NamedSet& set : kSets) {
    if (name == set.name) return set.feature_set;
  }
  return std::nullopt;
}

std::vector<float> RegionFeatures(const cv::Mat3b& image,
                                  const cv::Mat1b& mask,
                                  double ground_sampling_distance_m,
                                  FeatureSet feature_set) {
  const cv::Rect box = BoxOf(mask);
  const cv::Mat3b patch = image(box);
  const cv::Mat1b inside = mask(box);
  cv::Mat1f grey;
  cv::Mat1b grey_levels;
  cv::cvtColor(patch, grey_levels, cv::COLOR_BGR2GRAY);
  grey_levels.convertTo(grey, CV_32F);
  std::vector<float> row;
  const bool is_paper = feature_set == FeatureSet::kPaper18;
  const bool is_rgb_hsv = feature_set == FeatureSet::kRgbHsv || is_paper;
  if (feature_set == FeatureSet::kRgb || is_rgb_hsv) AppendRgb(patch, inside, row);
  if (feature_set == FeatureSet::kHsv || is_rgb_hsv) AppendHsv(patch, inside, row);
  if (is_paper) AppendGabor(grey, inside, row);
  if (feature_set == FeatureSet::kRobust) {
    AppendRobust(patch, grey_levels, inside, ground_sampling_distance_m, row);
  }
  return row;
}

}  // namespace freelsd
