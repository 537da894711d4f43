#include "engine/regions/segment_parts.h"

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

constexpr double kPassageM = 16.0;
constexpr double kSamplingM = 0.5;

// One segment of the white pixels; an image has four times as many pixels on a side.
Segments SegmentsOf(const cv::Mat1b& mask) {
  Segments segments;
  segments.labels = cv::Mat1i(mask.size(), 0);
  segments.labels.setTo(1, mask);
  segments.image_px_per_working_px = 4.0;
  segments.ground_sampling_distance_m = kSamplingM;
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  Segment segment;
  segment.label = 1;
  for (const cv::Point& point : contours.at(0)) {
    segment.contour_in_image.emplace_back(4.0 * point.x + 1.5, 4.0 * point.y + 1.5);
  }
  segment.area_m2 = cv::countNonZero(mask) * kSamplingM * kSamplingM;
  segments.segments.push_back(segment);
  return segments;
}

cv::Mat1b TwoFields(int gap_width_px) {
  cv::Mat1b mask(200, 300, uchar{0});
  mask(cv::Rect(20, 20, 120, 150)).setTo(255);
  mask(cv::Rect(150, 20, 130, 150)).setTo(255);
  if (gap_width_px > 0) mask(cv::Rect(140, 80, 10, gap_width_px)).setTo(255);
  return mask;
}

TEST_CASE("segment parts: two fields joined by a gap in their hedge are two") {
  const Segments segments = SegmentsOf(TwoFields(20));  // 10 m
  const std::vector<Segment> parts = PartsOf(segments, segments.segments[0], kPassageM);
  REQUIRE(parts.size() == 2);
  double area = 0.0;
  for (const Segment& part : parts) {
    area += part.area_m2;
    CHECK(part.label == 1);
    CHECK_FALSE(part.touches_border);
    // A rectangle around it holds that field alone: 60 or 65 m by 75 m, in pixels of the image.
    const double area_in_image = Area(MinAreaRectangle(part.contour_in_image));
    CHECK(area_in_image < 1.1 * 16.0 * 130.0 * 150.0);
  }
  CHECK(area > 0.97 * segments.segments[0].area_m2);
}

TEST_CASE("segment parts: fields joined by a wide opening are one, and so is what is narrow") {
  const Segments wide = SegmentsOf(TwoFields(100));  // 50 m
  CHECK(PartsOf(wide, wide.segments[0], kPassageM).size() == 1);
  cv::Mat1b strip(100, 300, uchar{0});
  strip(cv::Rect(10, 40, 280, 20)).setTo(255);  // 10 m wide
  const Segments narrow = SegmentsOf(strip);
  const std::vector<Segment> parts = PartsOf(narrow, narrow.segments[0], kPassageM);
  REQUIRE(parts.size() == 1);
  CHECK(parts[0].area_m2 == narrow.segments[0].area_m2);
}

TEST_CASE("segment parts: a gap at the end of a hedge, at the fields' own edge, is a gap") {
  cv::Mat1b mask = TwoFields(0);
  mask(cv::Rect(140, 20, 10, 20)).setTo(255);  // 10 m, along the upper edge of both
  const Segments segments = SegmentsOf(mask);
  CHECK(PartsOf(segments, segments.segments[0], kPassageM).size() == 2);
}

TEST_CASE("segment parts: a field that goes on outside the image is not worn away there") {
  cv::Mat1b mask = TwoFields(20);
  mask(cv::Rect(0, 20, 20, 150)).setTo(255);
  const Segments segments = SegmentsOf(mask);
  const std::vector<Segment> parts = PartsOf(segments, segments.segments[0], kPassageM);
  REQUIRE(parts.size() == 2);
  CHECK(parts[0].touches_border != parts[1].touches_border);
}

TEST_CASE("segment parts: a passage of nothing leaves every segment as it is") {
  const Segments segments = SegmentsOf(TwoFields(4));
  CHECK(PartsOf(segments, segments.segments[0], 0.0).size() == 1);
}

}  // namespace
}  // namespace freelsd
