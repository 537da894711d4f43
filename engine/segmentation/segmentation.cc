#include "engine/segmentation/segmentation.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

#include "engine/check/check.h"
#include "engine/segmentation/area_resize.h"
#include "engine/segmentation/edge_distance.h"

namespace freelsd {
namespace {

// The paper gives one Canny threshold; Canny recommends a ratio of about three.
constexpr double kCannyRatio = 3.0;
// Limits the quotient where the neighbourhood is black.
constexpr double kMinLocalMeanGrey = 4.0;
constexpr int kConnectivity = 4;
// Prevents an empty image if the height is wrong.
constexpr int kMinWorkingSidePx = 8;

double Polynomial(const std::array<double, 4>& coefficients, double x) {
  double value = 0.0;
  for (const double coefficient : coefficients) value = value * x + coefficient;
  return value;
}

double FittedHeight(double height_above_ground, const SegmentationOptions& options) {
  return std::clamp(height_above_ground, options.paper_min_height_m, options.paper_max_height_m);
}

// Thresholds of the edge detector, in pixels of the working image.
struct Thresholds {
  double canny_low = 0.0;
  double canny_high = 0.0;
  double min_edge_distance_px = 0.0;
};

// Factor (at most 1) from the full-size image to the given ground sampling distance.
double Scale(const Camera& camera, double height_above_ground, double ground_sampling_distance_m) {
  return std::min(1.0, height_above_ground / camera.MeanFocalPx() / ground_sampling_distance_m);
}

// Factor from the full-size image to the working image.
double WorkingScale(const Camera& camera,
                    double height_above_ground,
                    const SegmentationOptions& options) {
  if (options.thresholds == SegmentationThresholds::kPaper) {
    return std::min(1.0, options.paper_focal_px / camera.MeanFocalPx());
  }
  return Scale(camera, height_above_ground, options.ground_sampling_distance_m);
}

Thresholds ThresholdsFor(double height_above_ground,
                         double working_focal_px,
                         const SegmentationOptions& options) {
  if (options.thresholds == SegmentationThresholds::kPaper) {
    const double low = CannyThreshold(height_above_ground, options);
    // Distances are constant on the ground, so pixels scale with the focal length.
    const double distance_px =
        MinEdgeDistancePx(height_above_ground, options) * working_focal_px / options.paper_focal_px;
    return {low, kCannyRatio * low, distance_px};
  }
  return {options.canny_high / kCannyRatio,
          options.canny_high,
          options.min_edge_distance_m * working_focal_px / height_above_ground};
}

cv::Mat3b ColourImage(const cv::Mat& image) {
  if (image.type() == CV_8UC3) return image;
  if (image.type() != CV_8UC1) {
    throw std::invalid_argument("segmentation: the image must be 8 bit, grey or BGR");
  }
  cv::Mat3b colour;
  cv::cvtColor(image, colour, cv::COLOR_GRAY2BGR);
  return colour;
}

cv::Mat3b Resized(const cv::Mat& image, double scale) {
  if (scale >= 1.0) return ColourImage(image).clone();
  const int width = std::max(kMinWorkingSidePx, static_cast<int>(std::lround(image.cols * scale)));
  const int height = std::max(kMinWorkingSidePx, static_cast<int>(std::lround(image.rows * scale)));
  const bool is_smaller = width <= image.cols && height <= image.rows;
  if (is_smaller) return ColourImage(ReduceByArea(image, {width, height}));
  cv::Mat resized;
  cv::resize(image, resized, cv::Size(width, height), 0.0, 0.0, cv::INTER_AREA);
  return ColourImage(resized);
}

cv::Mat1b EvenExposure(const cv::Mat1b& grey, double window_px, double reference_grey) {
  const int side = std::max(3, static_cast<int>(std::lround(window_px)) | 1);
  cv::Mat1f local_mean, even;
  cv::boxFilter(grey, local_mean, CV_32F, cv::Size(side, side), {-1, -1}, true, cv::BORDER_REFLECT);
  cv::max(local_mean, kMinLocalMeanGrey, local_mean);
  cv::divide(grey, local_mean, even, reference_grey, CV_32F);
  cv::Mat1b result;
  even.convertTo(result, CV_8U);
  return result;
}

cv::Mat1b EdgesOf(const cv::Mat1b& channel, const Thresholds& thresholds, double blur_sigma_px) {
  cv::Mat1b smooth = channel;
  if (blur_sigma_px > 0.0) cv::GaussianBlur(channel, smooth, {}, blur_sigma_px);
  cv::Mat1b edges;
  cv::Canny(smooth, edges, thresholds.canny_low, thresholds.canny_high);
  return edges;
}

// Edges of the two colour channels, stretched around their neutral value.
cv::Mat1b ChromaEdges(const cv::Mat3b& image,
                      const Thresholds& thresholds,
                      const SegmentationOptions& options) {
  constexpr double kNeutral = 128.0;
  cv::Mat3b lab;
  cv::cvtColor(image, lab, cv::COLOR_BGR2Lab);
  cv::Mat1b edges(image.size(), uint8_t{0});
  for (int channel = 1; channel <= 2; ++channel) {
    cv::Mat chroma;
    cv::extractChannel(lab, chroma, channel);
    if (options.chroma_gain != 1.0) {
      chroma.convertTo(chroma, CV_8U, options.chroma_gain, kNeutral * (1.0 - options.chroma_gain));
    }
    edges |= EdgesOf(chroma, thresholds, options.blur_sigma_px);
  }
  return edges;
}

// 2G - R - B - level (R + G + B): positive where excess green exceeds the level. It is linear, so
// smoothing it equals smoothing the three channels.
cv::Mat1f GreenOverLevel(const cv::Mat3b& image, double level_ratio) {
  const auto green = static_cast<float>(2.0 - level_ratio);
  const auto others = static_cast<float>(1.0 + level_ratio);
  const auto over_level = [=](const cv::Vec3b& bgr) {
    return green * static_cast<float>(bgr[1]) - others * static_cast<float>(bgr[0] + bgr[2]);
  };
  cv::Mat1f over(image.size());
  for (int y = 0; y < image.rows; ++y) {
    std::transform(image[y], image[y] + image.cols, over[y], over_level);
  }
  return over;
}

// Both sides of the line where smoothed excess green crosses the level.
cv::Mat1b GreenEdges(const Segments& frame, const SegmentationOptions& options) {
  cv::Mat1f over = GreenOverLevel(frame.image, options.split_level_ratio);
  cv::GaussianBlur(over, over, {}, options.split_sigma_m / frame.ground_sampling_distance_m);
  const cv::Mat1b is_green = over > 0.0f;
  cv::Mat1b edges;
  cv::morphologyEx(is_green, edges, cv::MORPH_GRADIENT, cv::Mat1b(3, 3, uint8_t{1}));
  return edges;
}

cv::Mat1b Edges(const Segments& frame,
                const cv::Mat1b& grey,
                const Thresholds& thresholds,
                const SegmentationOptions& options) {
  if (options.thresholds == SegmentationThresholds::kPaper) return EdgesOf(grey, thresholds, 0.0);
  cv::Mat1b input = grey;
  if (options.contrast_window_m > 0.0) {
    input = EvenExposure(
        grey, options.contrast_window_m / frame.ground_sampling_distance_m, options.reference_grey);
  }
  cv::Mat1b edges = EdgesOf(input, thresholds, options.blur_sigma_px);
  if (options.chroma_gain > 0.0) edges |= ChromaEdges(frame.image, thresholds, options);
  if (options.split_sigma_m > 0.0) edges |= GreenEdges(frame, options);
  return edges;
}

// 255 where the nearest edge is far enough away and the sensor was neither black nor burnt out.
cv::Mat1b HomogeneousPixels(const cv::Mat1b& grey,
                            const cv::Mat1b& edges,
                            const Thresholds& thresholds,
                            const SegmentationOptions& options) {
  cv::Mat1b recorded;
  cv::inRange(grey, options.min_grey, options.max_grey, recorded);
  return FarFromEdges(edges, thresholds.min_edge_distance_px) & recorded;
}

std::vector<Eigen::Vector2d> OuterContour(const cv::Mat1b& mask,
                                          const cv::Point& offset,
                                          double image_px_per_working_px) {
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE, offset);
  std::vector<Eigen::Vector2d> contour_in_image;
  for (const cv::Point& point : contours.at(0)) {
    contour_in_image.emplace_back((point.x + 0.5) * image_px_per_working_px - 0.5,
                                  (point.y + 0.5) * image_px_per_working_px - 0.5);
  }
  return contour_in_image;
}

struct Components {
  cv::Mat1i labels;
  // One row per label: cv::ConnectedComponentsTypes.
  cv::Mat1i statistics;
};

Components ConnectedComponents(const cv::Mat1b& mask) {
  Components components;
  cv::Mat1d centroids;
  cv::connectedComponentsWithStats(
      mask, components.labels, components.statistics, centroids, kConnectivity, CV_32S);
  return components;
}

// Drops components of fewer pixels and numbers the rest from 1.
Components WithoutSmall(const Components& components, double min_num_pixels) {
  std::vector<int> new_label(static_cast<size_t>(components.statistics.rows), 0);
  Components kept;
  kept.statistics.push_back(components.statistics.row(0));
  for (int label = 1; label < components.statistics.rows; ++label) {
    if (components.statistics(label, cv::CC_STAT_AREA) < min_num_pixels) continue;
    new_label[static_cast<size_t>(label)] = kept.statistics.rows;
    kept.statistics.push_back(components.statistics.row(label));
  }
  kept.labels.create(components.labels.size());
  for (int y = 0; y < kept.labels.rows; ++y) {
    const int* row = components.labels[y];
    std::transform(row, row + kept.labels.cols, kept.labels[y], [&](int label) {
      return new_label[static_cast<size_t>(label)];
    });
  }
  return kept;
}

Segment MakeSegment(const Components& components, int label, const Segments& frame) {
  const int* row = components.statistics[label];
  const cv::Rect box(
      row[cv::CC_STAT_LEFT], row[cv::CC_STAT_TOP], row[cv::CC_STAT_WIDTH], row[cv::CC_STAT_HEIGHT]);
  const cv::Size size = components.labels.size();
  Segment segment;
  segment.label = label;
  segment.contour_in_image =
      OuterContour(components.labels(box) == label, box.tl(), frame.image_px_per_working_px);
  segment.area_m2 =
      row[cv::CC_STAT_AREA] * frame.ground_sampling_distance_m * frame.ground_sampling_distance_m;
  segment.touches_border =
      box.x == 0 || box.y == 0 || box.br().x == size.width || box.br().y == size.height;
  return segment;
}

void CheckInput(const cv::Mat& image, const Camera& camera, double height_above_ground) {
  if (image.empty()) throw std::invalid_argument("segmentation: the image is empty");
  if (image.cols != camera.width_px || image.rows != camera.height_px) {
    std::ostringstream message;
    message << "segmentation: image is " << image.cols << "x" << image.rows << ", camera says "
            << camera.width_px << "x" << camera.height_px;
    throw std::invalid_argument(message.str());
  }
  if (!std::isfinite(height_above_ground) || height_above_ground <= 0.0) {
    throw std::invalid_argument("segmentation: height above ground must be positive");
  }
}

}  // namespace

void SegmentationOptions::Check() const {
  const FieldCheck check("segmentation");
  check.Inside("ground_sampling_distance_m", ground_sampling_distance_m, 0.02, 5.0);
  check.Inside("detail_sampling_distance_m", detail_sampling_distance_m, 0.02, 5.0);
  check.Inside("blur_sigma_px", blur_sigma_px, 0.0, 20.0);
  check.Inside("canny_high", canny_high, 1.0, 2000.0);
  check.Inside("chroma_gain", chroma_gain, 0.0, 20.0);
  check.Inside("split_level_ratio", split_level_ratio, -2.0, 2.0);
  check.Inside("split_sigma_m", split_sigma_m, 0.0, 100.0);
  check.Inside("min_edge_distance_m", min_edge_distance_m, 0.0, 50.0);
  check.Inside("contrast_window_m", contrast_window_m, 0.0, 1000.0);
  check.Inside("reference_grey", reference_grey, 1.0, 255.0);
  check.Inside("min_grey", min_grey, 0.0, 255.0);
  check.Inside("max_grey", max_grey, min_grey, 255.0);
  check.Inside("min_region_area_m2", min_region_area_m2, 1.0, 1e6);
  check.Inside("paper_min_height_m", paper_min_height_m, 1.0, 1000.0);
  check.Inside("paper_max_height_m", paper_max_height_m, paper_min_height_m, 1000.0);
  check.Inside("paper_focal_px", paper_focal_px, 10.0, 10000.0);
  check.Inside("paper_min_edge_distance_px", paper_min_edge_distance_px, 0.0, 100.0);
}

double CannyThreshold(double height_above_ground, const SegmentationOptions& options) {
  return Polynomial(options.paper_canny_coefficients, FittedHeight(height_above_ground, options));
}

double MinEdgeDistancePx(double height_above_ground, const SegmentationOptions& options) {
  return std::max(options.paper_min_edge_distance_px,
                  Polynomial(options.paper_edge_distance_coefficients,
                             FittedHeight(height_above_ground, options)));
}

Segments SegmentFrame(const cv::Mat& image,
                      const Camera& camera,
                      double height_above_ground,
                      const SegmentationOptions& options) {
  options.Check();
  CheckInput(image, camera, height_above_ground);
  Segments segments;
  const double detail_scale =
      Scale(camera, height_above_ground, options.detail_sampling_distance_m);
  segments.detail_image = Resized(image, detail_scale);
  segments.detail_sampling_distance_m =
      height_above_ground / camera.MeanFocalPx() * image.cols / segments.detail_image.cols;
  segments.image = Resized(image, WorkingScale(camera, height_above_ground, options));
  segments.image_px_per_working_px = static_cast<double>(image.cols) / segments.image.cols;
  const double working_focal_px = camera.MeanFocalPx() / segments.image_px_per_working_px;
  segments.ground_sampling_distance_m = height_above_ground / working_focal_px;

  cv::Mat1b grey;
  cv::cvtColor(segments.image, grey, cv::COLOR_BGR2GRAY);
  const Thresholds thresholds = ThresholdsFor(height_above_ground, working_focal_px, options);
  const cv::Mat1b edges = Edges(segments, grey, thresholds, options);
  const cv::Mat1b homogeneous = HomogeneousPixels(grey, edges, thresholds, options);
  const double pixel_area_m2 =
      segments.ground_sampling_distance_m * segments.ground_sampling_distance_m;
  const Components components =
      WithoutSmall(ConnectedComponents(homogeneous), options.min_region_area_m2 / pixel_area_m2);
  segments.labels = components.labels;
  for (int label = 1; label < components.statistics.rows; ++label) {
    segments.segments.push_back(MakeSegment(components, label, segments));
  }
  return segments;
}

}  // namespace freelsd
