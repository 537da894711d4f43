#include "engine/classification/features.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "engine/classification/gabor.h"
#include "engine/classification/log_levels.h"
#include "engine/classification/texture.h"
#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Avoids divisions by zero in black pixels.
constexpr float kTinyGrey = 1.0f;

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

// Mean direction and deviation of hue as an angle (degrees): the mean of 359 and 1 is 0. The
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

// Mean logarithms of blue, green and red.
std::array<double, 3> MeanLogs(const cv::Mat3b& image, const cv::Mat1b& mask) {
  std::array<std::array<int, 256>, 3> histograms{};
  for (int y = 0; y < image.rows; ++y) {
    const cv::Vec3b* pixels = image[y];
    const uint8_t* inside = mask[y];
    for (int x = 0; x < image.cols; ++x) {
      if (inside[x] == 0) continue;
      for (size_t channel = 0; channel < 3; ++channel) {
        ++histograms[channel][pixels[x][static_cast<int>(channel)]];
      }
    }
  }
  std::array<double, 3> means{};
  for (size_t channel = 0; channel < 3; ++channel) {
    double sum = 0.0, count = 0.0;
    for (size_t level = 0; level < 256; ++level) {
      sum += static_cast<double>(LogOfLevel()[level]) * histograms[channel][level];
      count += histograms[channel][level];
    }
    means[channel] = count > 0.0 ? sum / count : 0.0;
  }
  return means;
}

double MeanExcessGreen(const cv::Mat3b& image, const cv::Mat1b& mask) {
  double sum = 0.0;
  int count = 0;
  for (int y = 0; y < image.rows; ++y) {
    const cv::Vec3b* pixels = image[y];
    const uint8_t* inside = mask[y];
    for (int x = 0; x < image.cols; ++x) {
      if (inside[x] == 0) continue;
      const cv::Vec3b& bgr = pixels[x];
      const float brightness = static_cast<float>(bgr[0] + bgr[1] + bgr[2]) + kTinyGrey;
      sum += static_cast<float>(2 * bgr[1] - bgr[2] - bgr[0]) / brightness;
      ++count;
    }
  }
  return count > 0 ? sum / count : 0.0;
}

// Logarithms make all features independent of exposure.
void AppendRobust(const cv::Mat3b& image,
                  const cv::Mat1b& grey,
                  const cv::Mat1b& mask,
                  double ground_sampling_distance_m,
                  std::vector<float>& row) {
  const Texture texture = TextureOf(grey, mask, ground_sampling_distance_m);
  const std::array<double, 3> logs = MeanLogs(image, mask);
  row.push_back(static_cast<float>(MeanExcessGreen(image, mask)));
  row.push_back(texture.leaf_log_deviation);
  row.push_back(texture.tuft_log_deviation);
  row.push_back(texture.gap_skewness);
  row.push_back(static_cast<float>(logs[2] - logs[1]));
  row.push_back(static_cast<float>(logs[0] - logs[1]));
}

// The region and its surroundings within reach of the filters.
cv::Rect BoxOf(const cv::Mat1b& mask, int radius_px) {
  cv::Rect box = cv::boundingRect(mask);
  box.x -= radius_px;
  box.y -= radius_px;
  box.width += 2 * radius_px;
  box.height += 2 * radius_px;
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
// Fern in the sun has -0.2 or less; of 144 pastures, only one has. The bound is not learnt, because
// the values of small tiles of grass scatter more.
constexpr float kLeastGrassSkewness = -0.19f;
// The margins differ. A more vivid green may be due to the camera or the season, but a bluer or
// greyer colour is another material. Without a margin for blue, crowns that a soft photograph shows
// without texture are not taken for lawn (decision 0030). Less texture may be due to a softer lens,
// but more texture is no meadow.
constexpr std::array<RangeMargin, 6> kRobustMargins{{{0.15f, 0.5f},
                                                     {0.3f, 0.15f},
                                                     {0.3f, 0.15f},
                                                     {0.5f, 0.5f, kLeastGrassSkewness},
                                                     {0.5f, 0.15f},
                                                     {0.5f, 0.0f}}};

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
  // Robust features need no surroundings. The radius of 1 avoids an empty box.
  const cv::Rect box = BoxOf(mask, feature_set == FeatureSet::kRobust ? 1 : kGaborRadiusPx);
  const cv::Mat3b patch = image(box);
  const cv::Mat1b inside = mask(box);
  cv::Mat1b grey;
  cv::cvtColor(patch, grey, cv::COLOR_BGR2GRAY);
  std::vector<float> row;
  const bool is_paper = feature_set == FeatureSet::kPaper18;
  const bool is_rgb_hsv = feature_set == FeatureSet::kRgbHsv || is_paper;
  if (feature_set == FeatureSet::kRgb || is_rgb_hsv) AppendRgb(patch, inside, row);
  if (feature_set == FeatureSet::kHsv || is_rgb_hsv) AppendHsv(patch, inside, row);
  if (is_paper) AppendGabor(cv::Mat1f(grey), inside, row);
  if (feature_set == FeatureSet::kRobust) {
    AppendRobust(patch, grey, inside, ground_sampling_distance_m, row);
  }
  return row;
}

}  // namespace freelsd
