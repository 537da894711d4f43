#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "engine/terrain/terrain.h"

namespace freelsd {
namespace {

// Photographs are compared as seen through a blur of this deviation: they fit to half a pixel.
constexpr double kBlurM = 0.25;
// Squares over which they are compared, and over which one may be brighter than the other as a
// whole: exposure, and how a slope shines to either side.
constexpr double kWindowM = 2.0;
constexpr double kExposureM = 8.0;
// Share of a map's cell that both must show.
constexpr float kMinShownShare = 0.5f;
// Keeps the logarithm of black finite.
constexpr float kLeastBrightness = 10.0f;
// Where nothing counts the mean is 0, not one of nothing.
constexpr double kNoWeight = 1e-6;

cv::Mat1f LogBrightness(const cv::Mat3b& image, double blur_px) {
  cv::Mat1f brightness(image.size());
  std::transform(image.begin(), image.end(), brightness.begin(), [](const cv::Vec3b& color) {
    return std::log(kLeastBrightness + float(color[0]) + float(color[1]) + float(color[2]));
  });
  cv::GaussianBlur(brightness, brightness, {}, blur_px);
  return brightness;
}

// Means over squares, of what counts.
class WindowMean {
 public:
  WindowMean(const cv::Mat1f& counts, double side_cells)
      : side_(2 * static_cast<int>(0.5 * side_cells) + 1), weight_(Box(counts) + kNoWeight) {}
  cv::Mat1f Of(const cv::Mat1f& counted) const { return Box(counted) / weight_; }

 private:
  cv::Mat1f Box(const cv::Mat1f& values) const {
    cv::Mat1f mean;
    cv::boxFilter(values, mean, CV_32F, {side_, side_});
    return mean;
  }

  int side_;
  cv::Mat1f weight_;
};

// Deviation of the logarithm of the brightnesses' ratio, by cell of the picture.
cv::Mat1f Disagreement(const Orthophoto& photo, const cv::Mat1f& counts) {
  const double cell = photo.grid.cell_size_m;
  const cv::Mat1f ratio =
      LogBrightness(photo.image, kBlurM / cell) - LogBrightness(photo.second_image, kBlurM / cell);
  const cv::Mat1f exposure = WindowMean(counts, kExposureM / cell).Of(ratio.mul(counts));
  const cv::Mat1f rest = (ratio - exposure).mul(counts);
  cv::Mat1f deviation;
  cv::sqrt(WindowMean(counts, kWindowM / cell).Of(rest.mul(rest)), deviation);
  return deviation;
}

cv::Mat DiscOf(double radius_m, double cell_size_m) {
  const int half = static_cast<int>(std::lround(radius_m / cell_size_m));
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * half + 1, 2 * half + 1});
}

}  // namespace

void MarkOpenCover(const Orthophoto& photo,
                   const cv::Mat1b& is_clear_class,
                   const TerrainOptions& options,
                   ElevationMap& map) {
  if (photo.second_image.empty() || map.elevation.empty()) return;
  cv::Mat1f counts, shown, disagreement;
  cv::Mat(photo.seen & photo.second_seen).convertTo(counts, CV_32F, 1.0 / 255.0);
  cv::resize(counts, shown, map.elevation.size(), 0.0, 0.0, cv::INTER_AREA);
  cv::resize(
      Disagreement(photo, counts), disagreement, map.elevation.size(), 0.0, 0.0, cv::INTER_AREA);
  cv::Mat1b is_open = (disagreement > options.max_photo_disagreement) & (shown >= kMinShownShare);
  is_open.setTo(uint8_t{0}, is_clear_class);
  const double cell = map.grid.cell_size_m;
  cv::morphologyEx(is_open, is_open, cv::MORPH_OPEN, DiscOf(options.min_open_cover_radius_m, cell));
  cv::dilate(is_open, is_open, DiscOf(options.open_cover_margin_m, cell));
  const cv::Mat1b is_unknown = is_open | (shown < kMinShownShare);
  map.standard_deviation.setTo(std::numeric_limits<float>::quiet_NaN(), is_unknown);
  map.is_compared = true;
}

}  // namespace freelsd
