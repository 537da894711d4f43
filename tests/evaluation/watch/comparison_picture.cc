#include "tests/evaluation/watch/comparison_picture.h"

#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/watch/change.h"
#include "engine/watch/registration.h"
#include "engine/watch/strip_canvas.h"

namespace freelsd {
namespace {

cv::Mat3b Marked(const cv::Mat3f& picture, const cv::Mat1b& is_strip, const cv::Mat1b& is_changed) {
  cv::Mat3b marked;
  picture.convertTo(marked, CV_8U);
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(is_strip.clone(), outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  cv::drawContours(marked, outlines, -1, {255, 255, 255}, 1);
  if (!is_changed.empty()) {
    cv::findContours(is_changed.clone(), outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    cv::drawContours(marked, outlines, -1, {0, 0, 255}, 1);
  }
  return marked;
}

}  // namespace

void WriteComparison(const StripPicture& strip,
                     const WatchedPhoto& photo,
                     const WatchOptions& options,
                     const std::string& file) {
  const StripGround ground(strip);
  const auto sampling = SamplingAt(photo, ground, ExtentOf(strip).Middle());
  if (!sampling) return;
  const StripCanvas canvas = MakeCanvas(strip, *sampling, options);
  const auto registration = Register(photo, ground, canvas, options);
  const ProjectedPhoto projected = Project(
      photo, ground, canvas, registration ? registration->displacement : [](double, double) {
        return Eigen::Vector2d(0.0, 0.0);
      });
  const cv::Mat1b all(canvas.picture.size(), uchar{255});
  const StripChange change = ChangeOf(canvas, projected, all, options);
  // Changes of brightness red, of green against red and blue green, of red against blue blue.
  std::vector<cv::Mat1b> shown(kNumBands);
  constexpr double kGreyPerDeviation = 20.0;
  for (const auto& [channel, band] :
       {std::pair(2, Band::kBrightness), {1, Band::kGreenExcess}, {0, Band::kRedBlue}}) {
    const cv::Mat1f size = cv::abs(change.Of(band).deviations);
    size.convertTo(shown[static_cast<size_t>(channel)], CV_8U, kGreyPerDeviation);
  }
  cv::Mat3b changes;
  cv::merge(shown, changes);
  std::vector<cv::Mat> parts{
      Marked(canvas.picture, canvas.is_strip, {}),
      Marked(projected.picture,
             canvas.is_strip,
             (cv::abs(change.Of(Band::kBrightness).deviations) >= options.grow_deviations) &
                 change.is_compared),
      changes};
  cv::Mat joined;
  cv::hconcat(parts, joined);
  cv::resize(joined, joined, {}, 2.0, 2.0, cv::INTER_NEAREST);
  cv::putText(joined,
              registration
                  ? "registered, correlation " + std::to_string(registration->correlation) +
                        ", rest " + std::to_string(registration->error_m) + " m"
                  : "not registered",
              {8, 20},
              cv::FONT_HERSHEY_SIMPLEX,
              0.5,
              {255, 255, 255});
  cv::imwrite(file, joined);
}

}  // namespace freelsd
