#include "engine/regions/segment_parts.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Working pixels that hold the contour, and one more all around, where the image has one: that is
// not of the segment, and its edge there is an edge.
cv::Rect BoxAround(const Segment& segment, const Segments& segments) {
  Eigen::Vector2d low = segment.contour_in_image.front(), high = low;
  for (const Eigen::Vector2d& point : segment.contour_in_image) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  const auto pixel = [&](double coordinate) {
    return static_cast<int>(
        std::lround((coordinate + 0.5) / segments.image_px_per_working_px - 0.5));
  };
  const cv::Rect box(cv::Point(pixel(low.x()) - 1, pixel(low.y()) - 1),
                     cv::Point(pixel(high.x()) + 2, pixel(high.y()) + 2));
  return box & cv::Rect(0, 0, segments.labels.cols, segments.labels.rows);
}

// Touches the border of the box that is the border of the image.
bool TouchesBorder(const cv::Mat1b& part, const cv::Rect& box, const cv::Size& image) {
  return (box.x == 0 && cv::countNonZero(part.col(0)) > 0) ||
         (box.y == 0 && cv::countNonZero(part.row(0)) > 0) ||
         (box.br().x == image.width && cv::countNonZero(part.col(part.cols - 1)) > 0) ||
         (box.br().y == image.height && cv::countNonZero(part.row(part.rows - 1)) > 0);
}

std::vector<Eigen::Vector2d> LongestContour(const cv::Mat1b& part,
                                            const cv::Rect& box,
                                            double image_px_per_working_px) {
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(part, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE, box.tl());
  const auto longest =
      std::max_element(contours.begin(), contours.end(), [](const auto& a, const auto& b) {
        return cv::contourArea(a) < cv::contourArea(b);
      });
  std::vector<Eigen::Vector2d> contour_in_image;
  for (const cv::Point& point : *longest) {
    contour_in_image.emplace_back((point.x + 0.5) * image_px_per_working_px - 0.5,
                                  (point.y + 0.5) * image_px_per_working_px - 0.5);
  }
  return contour_in_image;
}

}  // namespace

std::vector<Segment> PartsOf(const Segments& segments,
                             const Segment& segment,
                             double min_passage_m) {
  const double radius_px = 0.5 * min_passage_m / segments.ground_sampling_distance_m;
  const bool has_pixels = !segments.labels.empty() && !segment.contour_in_image.empty();
  if (!(radius_px >= 1.0) || !has_pixels) return {segment};
  const cv::Rect box = BoxAround(segment, segments);
  const cv::Mat1b mask = segments.labels(box) == segment.label;
  cv::Mat1f to_edge, to_core;
  cv::distanceTransform(mask, to_edge, cv::DIST_L2, cv::DIST_MASK_5);
  const cv::Mat1b core = to_edge > radius_px;
  if (cv::countNonZero(core) == 0) return {segment};
  // Every pixel goes with the core that is nearest, as far as the core was worn away.
  cv::Mat1i nearest;
  cv::distanceTransform(
      ~core, to_core, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_CCOMP);
  double num_cores = 0.0;
  cv::minMaxLoc(nearest, nullptr, &num_cores);
  if (num_cores <= 1.0) return {segment};
  std::vector<Segment> parts;
  const double pixel_area_m2 =
      segments.ground_sampling_distance_m * segments.ground_sampling_distance_m;
  for (int label = 1; label <= static_cast<int>(num_cores); ++label) {
    const cv::Mat1b part = mask & (nearest == label) & (to_core <= radius_px + 1.0);
    const int num_pixels = cv::countNonZero(part);
    if (num_pixels == 0) continue;
    Segment made;
    made.label = segment.label;
    made.contour_in_image = LongestContour(part, box, segments.image_px_per_working_px);
    made.area_m2 = num_pixels * pixel_area_m2;
    made.touches_border = TouchesBorder(part, box, segments.labels.size());
    parts.push_back(std::move(made));
  }
  return parts;
}

}  // namespace freelsd
