#include "engine/heights/ground_photographs.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// About 3 MB each at 0.2 m from 100 m.
constexpr size_t kMaxNumPhotographs = 64;
// Keeps the logarithm of black finite, and the noise of shade small.
constexpr float kLeastBrightness = 10.0f;
// Half a pixel: photographs are resampled at different phases, which must not look like a change.
constexpr double kBlurPx = 0.7;
// Exposure and shading vary more slowly, things faster.
constexpr double kExposureM = 6.0;

cv::Mat1f LogBrightness(const cv::Mat& image) {
  std::array<float, 256> logarithms{};
  for (size_t level = 0; level < logarithms.size(); ++level) {
    logarithms[level] = std::log(kLeastBrightness + static_cast<float>(level));
  }
  cv::Mat1b grey;
  if (image.channels() == 1) {
    grey = image;
  } else {
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  }
  cv::Mat1f brightness(grey.size());
  std::transform(grey.begin(), grey.end(), brightness.begin(), [&](uint8_t level) {
    return logarithms[level];
  });
  return brightness;
}

GroundPhotograph Prepared(const cv::Mat& image, double pixel_m, double sampling_m) {
  GroundPhotograph photograph;
  cv::Mat scaled = image;
  const double factor = pixel_m / sampling_m;
  // Slightly coarser pixels are as good as scaled ones.
  if (factor < 0.75) {
    cv::resize(image, scaled, {}, factor, factor, cv::INTER_AREA);
    photograph.scale = static_cast<double>(scaled.cols) / image.cols;
  }
  cv::Mat1f detail = LogBrightness(scaled);
  cv::GaussianBlur(detail, detail, {}, kBlurPx);
  const int side = BoxSide(kExposureM * photograph.scale / pixel_m);
  detail -= BoxMean(detail, side, BoxBorder::kMirrored);
  photograph.detail = detail;
  return photograph;
}

}  // namespace

GroundPhotographs::GroundPhotographs(const AdjustedBlock& block,
                                     const ImageSource& images,
                                     double ground_sampling_distance_m)
    : block_(block), images_(images), sampling_m_(ground_sampling_distance_m) {}

std::shared_ptr<const GroundPhotograph> GroundPhotographs::Of(size_t view) {
  const auto known = std::find_if(
      latest_.begin(), latest_.end(), [view](const auto& each) { return each.first == view; });
  if (known != latest_.end()) {
    latest_.splice(latest_.begin(), latest_, known);
    return latest_.front().second;
  }
  const AdjustedView& adjusted = block_.views[view];
  const cv::Mat image = images_(adjusted.frame_id);
  auto photograph = std::make_shared<GroundPhotograph>();
  if (image.size() == cv::Size(block_.camera.width_px, block_.camera.height_px)) {
    const double pixel_m = adjusted.height_above_ground / block_.camera.MeanFocalPx();
    *photograph = Prepared(image, pixel_m, sampling_m_);
  }
  latest_.emplace_front(view, photograph);
  if (latest_.size() > kMaxNumPhotographs) latest_.pop_back();
  return photograph;
}

}  // namespace freelsd
