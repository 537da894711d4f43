#include "engine/segmentation/segmentation.h"

#include <cmath>
#include <random>
#include <stdexcept>

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

#include "tests/engine/camera.h"
#include "tests/engine/refusal.h"

namespace freelsd {
namespace {

constexpr double kHeightM = 100.0;

Camera TestCamera(const cv::Size& size) {
  // 0.15 m on the ground per pixel at kHeightM.
  return CenteredCamera(size.width, size.height, kHeightM / 0.15);
}

// A meadow of faint texture.
cv::Mat3b Meadow(const cv::Size& size, double sd_grey = 2.0) {
  cv::Mat3b image(size, cv::Vec3b(60, 130, 90));
  cv::Mat3s noise(size);
  cv::RNG generator(7);
  generator.fill(noise, cv::RNG::NORMAL, 0.0, sd_grey);
  cv::add(image, noise, image, cv::noArray(), CV_8U);
  return image;
}

TEST_CASE(
    "segmentation: the paper's thresholds are those of its table, and never below the floor") {
  const SegmentationOptions options;
  constexpr double kToleranceGrey = 0.1;
  CHECK(std::abs(CannyThreshold(58.0, options) - 42.7) < kToleranceGrey);
  CHECK(std::abs(CannyThreshold(200.0, options) - 22.4) < kToleranceGrey);
  CHECK(std::abs(MinEdgeDistancePx(100.0, options) - 27.6) < kToleranceGrey);
  CHECK(CannyThreshold(10.0, options) == CannyThreshold(58.0, options));
  CHECK(MinEdgeDistancePx(382.0, options) == options.paper_min_edge_distance_px);
  CHECK(MinEdgeDistancePx(1000.0, options) == options.paper_min_edge_distance_px);
}

TEST_CASE("segmentation: two fields beside a road are two regions that keep clear of it") {
  cv::Mat3b image = Meadow({800, 600});
  // 6 m of road across the image, 40 px of 0.15 m.
  cv::rectangle(image, {380, 0, 40, 600}, {190, 190, 190}, cv::FILLED);
  const Segments segments =
      SegmentFrame(image, TestCamera(image.size()), kHeightM, SegmentationOptions{});
  CHECK(segments.image_px_per_working_px == doctest::Approx(4.0));
  CHECK(segments.ground_sampling_distance_m == doctest::Approx(0.6));
  int num_fields = 0;
  for (const Segment& segment : segments.segments) {
    double min_distance_px = 1e9;
    for (const Eigen::Vector2d& point : segment.contour_in_image) {
      CHECK(point.x() >= -0.5);
      CHECK(point.x() <= image.cols - 0.5);
      min_distance_px = std::min(
          min_distance_px, std::min(std::abs(point.x() - 380.0), std::abs(point.x() - 420.0)));
    }
    if (segment.area_m2 < 1000.0) continue;
    ++num_fields;
    CHECK(segment.touches_border);
    // 1 m less the width of a working pixel.
    CHECK(min_distance_px * 0.15 > 0.4);
    CHECK(min_distance_px * 0.15 < 3.0);
  }
  CHECK(num_fields == 2);
}

TEST_CASE("segmentation: labels, areas and contours of a region agree") {
  cv::Mat3b image = Meadow({800, 600});
  // A fence around a field of 60 x 45 m that does not touch the border.
  cv::rectangle(image, {200, 150, 400, 300}, {20, 20, 20}, 12);
  const Segments segments =
      SegmentFrame(image, TestCamera(image.size()), kHeightM, SegmentationOptions{});
  bool is_found = false;
  for (size_t i = 0; i < segments.segments.size(); ++i) {
    const Segment& segment = segments.segments[i];
    CHECK(segment.label == static_cast<int>(i) + 1);
    const int num_pixels = cv::countNonZero(segments.labels == segment.label);
    CHECK(num_pixels * 0.36 == doctest::Approx(segment.area_m2));
    if (segment.touches_border) continue;
    is_found = true;
    std::vector<cv::Point2f> contour;
    for (const auto& point : segment.contour_in_image) {
      contour.emplace_back(static_cast<float>(point.x()), static_cast<float>(point.y()));
    }
    const cv::Moments moments = cv::moments(contour);
    constexpr double kCentreTolerancePx = 3.0;
    CHECK(std::abs(moments.m10 / moments.m00 - 399.5) < kCentreTolerancePx);
    CHECK(std::abs(moments.m01 / moments.m00 - 299.5) < kCentreTolerancePx);
  }
  CHECK(is_found);
}

TEST_CASE("segmentation: a lawn that fades into litter without an edge ends where green ends") {
  cv::Mat3b image = Meadow({800, 600});
  for (int x = 200; x < 800; ++x) {
    // From green to brown of the same brightness over 60 m.
    const double brown = std::min(1.0, (x - 200) / 400.0);
    for (int y = 0; y < 600; ++y) {
      cv::Vec3b& bgr = image(y, x);
      bgr[1] = cv::saturate_cast<uint8_t>(bgr[1] - 35.0 * brown);
      bgr[2] = cv::saturate_cast<uint8_t>(bgr[2] + 60.0 * brown);
    }
  }
  const Camera camera = TestCamera(image.size());
  const Segments segments = SegmentFrame(image, camera, kHeightM, SegmentationOptions{});
  const int green = segments.labels(75, 10);
  const int brown = segments.labels(75, 190);
  CHECK(green > 0);
  CHECK(brown > 0);
  CHECK(green != brown);
  SegmentationOptions joined;
  joined.split_sigma_m = 0.0;
  const Segments one = SegmentFrame(image, camera, kHeightM, joined);
  CHECK(one.labels(75, 10) == one.labels(75, 190));
}

TEST_CASE("segmentation: a frame four times darker has the same regions") {
  cv::Mat3b image = Meadow({800, 600});
  cv::rectangle(image, {380, 0, 40, 600}, {190, 190, 190}, cv::FILLED);
  cv::Mat3b dark;
  image.convertTo(dark, CV_8U, 0.25);
  const Camera camera = TestCamera(image.size());
  const Segments bright = SegmentFrame(image, camera, kHeightM, SegmentationOptions{});
  const Segments same = SegmentFrame(dark, camera, kHeightM, SegmentationOptions{});
  CHECK(bright.segments.size() == same.segments.size());
  const double num_pixels = static_cast<double>(bright.labels.total());
  CHECK(cv::countNonZero(bright.labels != same.labels) < 0.02 * num_pixels);
}

TEST_CASE("segmentation: black and burnt-out frames have no region") {
  for (const int level : {0, 5, 253, 255}) {
    const cv::Mat1b image(480, 752, static_cast<uint8_t>(level));
    CHECK(SegmentFrame(image, TestCamera(image.size()), kHeightM, SegmentationOptions{})
              .segments.empty());
  }
}

TEST_CASE("segmentation: strong noise is no region, and an image is never enlarged") {
  std::mt19937 generator(3);
  cv::Mat1b image(240, 320);
  for (uint8_t& pixel : image) pixel = generator() % 2 == 0 ? 30 : 220;
  SegmentationOptions options;
  options.ground_sampling_distance_m = 0.05;
  const Segments segments = SegmentFrame(image, TestCamera(image.size()), kHeightM, options);
  CHECK(segments.segments.empty());
  CHECK(segments.image.size() == image.size());
  CHECK(segments.ground_sampling_distance_m == doctest::Approx(0.15));
}

TEST_CASE("segmentation: paper thresholds work at the paper's focal length") {
  SegmentationOptions options;
  options.thresholds = SegmentationThresholds::kPaper;
  const cv::Mat3b image = Meadow({800, 600}, 0.5);
  const Camera camera = TestCamera(image.size());
  const Segments segments = SegmentFrame(image, camera, kHeightM, options);
  CHECK(segments.image.cols == std::lround(800 * 465.0 / camera.fx_px));
  CHECK(segments.segments.size() == 1);
}

TEST_CASE("segmentation: bad input and options are named") {
  const cv::Mat3b image = Meadow({80, 60});
  const Camera camera = TestCamera(image.size());
  CHECK_THROWS_AS(SegmentFrame(image, camera, 0.0, {}), std::invalid_argument);
  CHECK_THROWS_AS(SegmentFrame(image, camera, std::nan(""), {}), std::invalid_argument);
  CHECK_THROWS_AS(SegmentFrame(cv::Mat(), camera, kHeightM, {}), std::invalid_argument);
  CHECK_THROWS_WITH_AS(SegmentFrame(image, TestCamera({81, 60}), kHeightM, {}),
                       "segmentation: image is 80x60, camera says 81x60",
                       std::invalid_argument);
  CHECK(RefusalOf(&SegmentationOptions::canny_high, 0.0) ==
        "segmentation.canny_high = 0: must be in [1, 2000]");
  CHECK(RefusalOf(&SegmentationOptions::max_grey, 5.0) ==
        "segmentation.max_grey = 5: must be in [12, 255]");
  CHECK(
      IsRefused(&SegmentationOptions::ground_sampling_distance_m, std::nan(""), "ground_sampling"));
}

}  // namespace
}  // namespace freelsd
