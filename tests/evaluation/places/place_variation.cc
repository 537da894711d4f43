#include "tests/evaluation/places/place_variation.h"

#include <algorithm>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

const cv::Scalar kCastGains(1.10, 0.92, 1.06);
constexpr double kDarkGain = 0.6;
constexpr double kBlurSigmaWorkingPx = 1.0;
constexpr double kHazeGain = 0.75;
constexpr double kHazeGrey = 45.0;

}  // namespace

const std::vector<std::string>& PlaceVariationNames() {
  static const std::vector<std::string> kNames{"none", "cast", "dark", "blur", "haze"};
  return kNames;
}

PlaceVariation PlaceVariationNamed(const std::string& name) {
  const std::vector<std::string>& names = PlaceVariationNames();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw std::invalid_argument("'" + name + "' is no variation");
  return static_cast<PlaceVariation>(found - names.begin());
}

cv::Mat3b Varied(const cv::Mat3b& photograph, PlaceVariation variation, double px_per_working_px) {
  cv::Mat varied;
  switch (variation) {
    case PlaceVariation::kNone:
      return photograph;
    case PlaceVariation::kCast:
      cv::multiply(photograph, kCastGains, varied);
      break;
    case PlaceVariation::kDark:
      photograph.convertTo(varied, CV_8U, kDarkGain);
      break;
    case PlaceVariation::kBlur:
      cv::GaussianBlur(photograph, varied, {}, kBlurSigmaWorkingPx * px_per_working_px);
      break;
    case PlaceVariation::kHaze:
      photograph.convertTo(varied, CV_8U, kHazeGain, kHazeGrey);
      break;
  }
  return varied;
}

}  // namespace freelsd
