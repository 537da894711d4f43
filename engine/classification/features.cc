#include "engine/classification/features.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Paper Sec. III-D: sigma, aspect ratio, phase, wavelengths (px), four orientations.
constexpr double kGaborSigmaPx = 4.0;
constexpr double kGaborAspectRatio = 0.02;
constexpr double kGaborPhase = 0.0;
constexpr std::array<double, 3> kGaborWavelengthsPx{0.5, 1.0, 5.0};
constexpr int kNumGaborOrientations = 4;
constexpr int kGaborSizePx = 31;
// Room around a region that the largest filter needs.
constexpr int kMarginPx = kGaborSizePx / 2;
// Avoids divisions by zero in black regions.
constexpr float kTinyGrey = 1.0f;
// Windows of local contrast, metres on the ground: tufts and clumps.
constexpr std::array<double, 2> kContrastWindowsM{0.9, 2.7};

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

// One kernel for all orientations: "the mean of the extracted values" is read pixel by pixel, and a
// mean of linear filters is one linear filter.
cv::Mat MeanGaborKernel(double wavelength_px) {
  cv::Mat sum;
  for (int i = 0; i < kNumGaborOrientations; ++i) {
    const cv::Mat kernel = cv::getGaborKernel({kGaborSizePx, kGaborSizePx},
                                              kGaborSigmaPx,
                                              kPi * i / kNumGaborOrientations,
                                              wavelength_px,
                                              kGaborAspectRatio,
                                              kGaborPhase,
                                              CV_32F);
    sum = sum.empty() ? kernel : sum + kernel;
  }
  return sum / kNumGaborOrientations;
}

void AppendGabor(const cv::Mat1f& grey, const cv::Mat1b& mask, std::vector<float>& row) {
  static const std::array<cv::Mat, 3> kKernels{MeanGaborKernel(kGaborWavelengthsPx[0]),
                                               MeanGaborKernel(kGaborWavelengthsPx[1]),
                                               MeanGaborKernel(kGaborWavelengthsPx[2])};
  for (const cv::Mat& kernel : kKernels) {
    cv::Mat response;
    cv::filter2D(grey, response, CV_32F, kernel);
    AppendMeanAndDeviation(response, mask, row);
  }
}

// Colour without brightness: shares of red and green, and excess green 2g - r - b.
void AppendChromaticity(const cv::Mat3b& image, const cv::Mat1b& mask, std::vector<float>& row) {
  cv::Mat1f red(image.size()), green(image.size()), excess(image.size());
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const cv::Vec3b& bgr = image(y, x);
      const float sum = static_cast<float>(bgr[0] + bgr[1] + bgr[2]) + kTinyGrey;
      red(y, x) = bgr[2] / sum;
      green(y, x) = bgr[1] / sum;
      excess(y, x) = (2.0f * bgr[1] - bgr[2] - bgr[0]) / sum;
    }
  }
  AppendMeanAndDeviation(red, mask, row);
  AppendMeanAndDeviation(green, mask, row);
  AppendMeanAndDeviation(excess, mask, row);
}

// Contrast relative to brightness: of the whole region, and within windows of fixed ground size.
void AppendContrast(const cv::Mat1f& grey,
                    const cv::Mat1b& mask,
                    double ground_sampling_distance_m,
                    std::vector<float>& row) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(grey, mean, deviation, mask);
  const float brightness = static_cast<float>(mean[0]) + kTinyGrey;
  row.push_back(static_cast<float>(deviation[0]) / brightness);
  for (const double window_m : kContrastWindowsM) {
    const int window = 2 * static_cast<int>(0.5 * window_m / ground_sampling_distance_m) + 1;
    cv::Mat1f local_mean, local_squares, local_deviation;
    cv::blur(grey, local_mean, {window, window});
    cv::blur(grey.mul(grey), local_squares, {window, window});
    cv::sqrt(cv::max(local_squares - local_mean.mul(local_mean), 0.0f), local_deviation);
    row.push_back(static_cast<float>(cv::mean(local_deviation, mask)[0]) / brightness);
  }
}

void AppendRobust(const cv::Mat3b& image,
                  const cv::Mat1f& grey,
                  const cv::Mat1b& mask,
                  double ground_sampling_distance_m,
                  std::vector<float>& row) {
  std::vector<float> hsv;
  AppendHsv(image, mask, hsv);
  // Hue and saturation; value is exposure.
  row.insert(row.end(), hsv.begin(), hsv.begin() + 4);
  AppendChromaticity(image, mask, row);
  AppendContrast(grey, mask, ground_sampling_distance_m, row);
}

// The region and its surroundings as far as the filters reach.
cv::Rect BoxOf(const cv::Mat1b& mask) {
  cv::Rect box = cv::boundingRect(mask);
  box.x -= kMarginPx;
  box.y -= kMarginPx;
  box.width += 2 * kMarginPx;
  box.height += 2 * kMarginPx;
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
                              {FeatureSet::kPaper18, "paper18", 18},
                              {FeatureSet::kRobust, "robust", 13}};

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
    AppendRobust(patch, grey, inside, ground_sampling_distance_m, row);
  }
  return row;
}

}  // namespace freelsd
