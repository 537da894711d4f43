#include "engine/segmentation/segmentation.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Lower hysteresis threshold of the Canny detector as a share of the upper one.
constexpr double kCannyLowShare = 1.0 / 3.0;
// The paper gives one threshold: it is the lower, and Canny's advice of 1:3 makes the upper.
constexpr double kPaperHighFactor = 3.0;
// Grey levels outside which the sensor shows nothing: no edges there, but no homogeneous ground.
constexpr int kMinGrey = 8;
constexpr int kMaxGrey = 250;
constexpr int kMinWorkingSidePx = 16;

double Polynomial(const std::array<double, 4>& coefficients, double x) {
  double value = 0.0;
  for (const double coefficient : coefficients) value = value * x + coefficient;
  return value;
}

double ClampedHeight(double height_above_ground, const SegmentationOptions& options) {
  return std::clamp(height_above_ground, options.paper_min_height_m, options.paper_max_height_m);
}

// Size, thresholds and scale of one frame's segmentation.
struct Plan {
  double scale = 1.0;  // working pixels per pixel of the full-size image
  double ground_sampling_distance = 0.0;
  double canny_high = 0.0;
  double min_edge_distance_px = 0.0;
};

Plan PlanFor(const Camera& camera, double height_above_ground, const SegmentationOptions& options) {
  const double native = height_above_ground / camera.MeanFocalPx();
  Plan plan;
  if (options.thresholds == SegmentationThresholds::kPaper) {
    plan.scale = std::min(1.0, options.paper_focal_px / camera.MeanFocalPx());
    plan.canny_high = kPaperHighFactor * CannyThreshold(height_above_ground, options);
    plan.min_edge_distance_px = MinEdgeDistancePx(height_above_ground, options);
  } else {
    plan.scale = std::min(1.0, native / options.ground_sampling_distance_m);
    plan.canny_high = options.canny_high;
    plan.min_edge_distance_px = options.min_edge_distance_m / (native / plan.scale);
  }
  plan.ground_sampling_distance = native / plan.scale;
  return plan;
}

cv::Mat3b WorkingImage(const cv::Mat& image, double scale) {
  cv::Mat resized;
  const cv::Size size(std::max(kMinWorkingSidePx, cvRound(image.cols * scale)),
                      std::max(kMinWorkingSidePx, cvRound(image.rows * scale)));
  cv::resize(image, resized, size, 0, 0, cv::INTER_AREA);
  if (resized.channels() == 1) cv::cvtColor(resized, resized, cv::COLOR_GRAY2BGR);
  return resized;
}

cv::Mat1b EdgesOf(const cv::Mat& channel, const Plan& plan, double blur_sigma_px) {
  cv::Mat smooth = channel;
  if (blur_sigma_px > 0.0) cv::GaussianBlur(channel, smooth, {}, blur_sigma_px);
  cv::Mat1b edges;
  cv::Canny(smooth, edges, plan.canny_high * kCannyLowShare, plan.canny_high);
  return edges;
}

// The colour channels around their neutral value, stretched.
void AddChromaEdges(const cv::Mat3b& image,
                    const Plan& plan,
                    const SegmentationOptions& options,
                    cv::Mat1b& edges) {
  constexpr double kNeutral = 128.0;
  cv::Mat3b lab;
  cv::cvtColor(image, lab, cv::COLOR_BGR2Lab);
  for (int channel = 1; channel <= 2; ++channel) {
    cv::Mat chroma;
    cv::extractChannel(lab, chroma, channel);
    chroma.convertTo(chroma, CV_8U, options.chroma_gain, kNeutral * (1.0 - options.chroma_gain));
    edges |= EdgesOf(chroma, plan, options.blur_sigma_px);
  }
}

// Pixels farther from any edge than the threshold. The border of the image is no edge.
cv::Mat1b HomogeneousMask(const cv::Mat3b& image,
                          const Plan& plan,
                          const SegmentationOptions& options) {
  cv::Mat1b grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  const bool is_paper = options.thresholds == SegmentationThresholds::kPaper;
  cv::Mat1b edges = EdgesOf(grey, plan, is_paper ? 0.0 : options.blur_sigma_px);
  if (!is_paper && options.chroma_gain > 0.0) AddChromaEdges(image, plan, options, edges);
  edges.setTo(255, (grey < kMinGrey) | (grey > kMaxGrey));
  cv::Mat1f distance;
  cv::distanceTransform(edges == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance > plan.min_edge_distance_px;
}

bool TouchesBorder(const cv::Rect& box, const cv::Size& size) {
  return box.x == 0 || box.y == 0 || box.x + box.width == size.width ||
         box.y + box.height == size.height;
}

std::vector<Eigen::Vector2d> OuterContour(const cv::Mat1i& components,
                                          int component,
                                          const cv::Rect& box,
                                          const cv::Size2d& image_px_per_working_px) {
  std::vector<std::vector<cv::Point>> contours;
  const cv::Mat1b mask = components(box) == component;
  cv::findContours(mask, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE, box.tl());
  std::vector<Eigen::Vector2d> contour_in_image;
  for (const auto& contour : contours) {
    for (const cv::Point& point : contour) {
      contour_in_image.emplace_back((point.x + 0.5) * image_px_per_working_px.width - 0.5,
                                    (point.y + 0.5) * image_px_per_working_px.height - 0.5);
    }
  }
  return contour_in_image;
}

void Require(bool holds, const char* field, double value, const char* constraint) {
  if (holds) return;
  throw std::invalid_argument(std::string("segmentation.") + field + " = " + std::to_string(value) +
                              ": " + constraint);
}

}  // namespace

void SegmentationOptions::Check() const {
  Require(ground_sampling_distance_m >= 0.02 && ground_sampling_distance_m <= 5.0,
          "ground_sampling_distance_m",
          ground_sampling_distance_m,
          "must be in [0.02, 5]");
  Require(blur_sigma_px >= 0.0 && blur_sigma_px <= 20.0,
          "blur_sigma_px",
          blur_sigma_px,
          "must be in [0, 20]");
  Require(canny_high > 0.0, "canny_high", canny_high, "must be positive");
  Require(
      chroma_gain >= 0.0 && chroma_gain <= 20.0, "chroma_gain", chroma_gain, "must be in [0, 20]");
  Require(min_edge_distance_m >= 0.0, "min_edge_distance_m", min_edge_distance_m, "must be >= 0");
  Require(min_region_area_m2 > 0.0, "min_region_area_m2", min_region_area_m2, "must be positive");
  Require(paper_min_height_m > 0.0 && paper_min_height_m < paper_max_height_m,
          "paper_min_height_m",
          paper_min_height_m,
          "must be positive and below paper_max_height_m");
  Require(paper_focal_px > 0.0, "paper_focal_px", paper_focal_px, "must be positive");
  Require(paper_min_edge_distance_px >= 0.0,
          "paper_min_edge_distance_px",
          paper_min_edge_distance_px,
          "must be >= 0");
}

double CannyThreshold(double height_above_ground, const SegmentationOptions& options) {
  return Polynomial(options.paper_canny_coefficients, ClampedHeight(height_above_ground, options));
}

double MinEdgeDistancePx(double height_above_ground, const SegmentationOptions& options) {
  return std::max(options.paper_min_edge_distance_px,
                  Polynomial(options.paper_edge_distance_coefficients,
                             ClampedHeight(height_above_ground, options)));
}

Segments SegmentFrame(const cv::Mat& image,
                      const Camera& camera,
                      double height_above_ground,
                      const SegmentationOptions& options) {
  if (image.empty() || !(height_above_ground > 0.0)) {
    throw std::invalid_argument("segmentation: needs an image and a height above ground > 0");
  }
  const Plan plan = PlanFor(camera, height_above_ground, options);
  Segments segments;
  segments.image = WorkingImage(image, plan.scale);
  const cv::Size size = segments.image.size();
  const cv::Size2d image_px(static_cast<double>(image.cols) / size.width,
                            static_cast<double>(image.rows) / size.height);
  segments.image_px_per_working_px = image_px.width;
  segments.ground_sampling_distance_m = plan.ground_sampling_distance;
  cv::Mat1i components, statistics;
  cv::Mat1d centroids;
  const int num_components = cv::connectedComponentsWithStats(
      HomogeneousMask(segments.image, plan, options), components, statistics, centroids, 4, CV_32S);
  const double cell_area = plan.ground_sampling_distance * plan.ground_sampling_distance;
  std::vector<int> label_of_component(static_cast<size_t>(num_components), 0);
  for (int component = 1; component < num_components; ++component) {
    const double area = statistics(component, cv::CC_STAT_AREA) * cell_area;
    if (area < options.min_region_area_m2) continue;
    const cv::Rect box(statistics(component, cv::CC_STAT_LEFT),
                       statistics(component, cv::CC_STAT_TOP),
                       statistics(component, cv::CC_STAT_WIDTH),
                       statistics(component, cv::CC_STAT_HEIGHT));
    const int label = static_cast<int>(segments.segments.size()) + 1;
    label_of_component[static_cast<size_t>(component)] = label;
    segments.segments.push_back({label,
                                 OuterContour(components, component, box, image_px),
                                 area,
                                 TouchesBorder(box, size)});
  }
  segments.labels.create(size);
  std::transform(components.begin(), components.end(), segments.labels.begin(), [&](int component) {
    return label_of_component[static_cast<size_t>(component)];
  });
  return segments;
}

}  // namespace freelsd
