#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "engine/classification/classification.h"
#include "engine/classification/gabor.h"
#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

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

void AppendGabor(const cv::Mat3b& image, const cv::Mat1b& mask, std::vector<float>& row) {
  cv::Mat1b grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  for (const cv::Mat1f& response : GaborResponses(cv::Mat1f(grey), mask)) {
    AppendMeanAndDeviation(response, mask, row);
  }
}

// The region and its surroundings within reach of the filters.
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
};
constexpr NamedSet kSets[] = {{FeatureSet::kRgb, "rgb", 6},
                              {FeatureSet::kHsv, "hsv", 6},
                              {FeatureSet::kRgbHsv, "rgbhsv", 12},
                              {FeatureSet::kPaper18, "paper18", 18}};

}  // namespace

size_t NumFeatures(FeatureSet feature_set) {
  for (const NamedSet& set : kSets) {
    if (set.feature_set == feature_set) return set.num_features;
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
                                  FeatureSet feature_set) {
  const cv::Rect box = BoxOf(mask);
  const cv::Mat3b patch = image(box);
  const cv::Mat1b inside = mask(box);
  std::vector<float> row;
  const bool is_paper = feature_set == FeatureSet::kPaper18;
  const bool is_rgb_hsv = feature_set == FeatureSet::kRgbHsv || is_paper;
  if (feature_set == FeatureSet::kRgb || is_rgb_hsv) AppendRgb(patch, inside, row);
  if (feature_set == FeatureSet::kHsv || is_rgb_hsv) AppendHsv(patch, inside, row);
  if (is_paper) AppendGabor(patch, inside, row);
  return row;
}

}  // namespace freelsd
