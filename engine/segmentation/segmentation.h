// Input: image and height above ground. Output: homogeneous regions. Paper: Sec. III-C.
#pragma once

#include <array>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/flight/flight.h"

namespace freelsd {

enum class SegmentationThresholds {
  kGroundSampling,  // fixed ground sampling distance, thresholds in metres on the ground
  kPaper,           // the paper's polynomials of height, at f = 465 px
};

struct SegmentationOptions {
  // --- Behaviour ---
  // Differs: the published polynomials leave no region on sharp photographs (see kPaper).
  SegmentationThresholds thresholds = SegmentationThresholds::kGroundSampling;
  // The image is first reduced to this ground sampling distance, never enlarged. Decision 0001
  // explains this field and the three below.
  double ground_sampling_distance_m = 0.6;
  // Ground sampling distance for the classification, which needs finer texture.
  double detail_sampling_distance_m = 0.3;
  double blur_sigma_px = 1.0;
  // Upper hysteresis threshold of the Canny detector, grey levels; the lower is a third of it.
  double canny_high = 105.0;
  // Stretch of the two colour channels of CIE L*a*b* before edge detection; 0: grey only, as in the
  // paper. Differs: road, gravel and meadow may be equally bright.
  double chroma_gain = 1.0;
  // Adds edges where excess green (2G - R - B) / (R + G + B), smoothed by split_sigma_m, crosses
  // split_level_ratio. Sigma 0: none. Differs: a lawn fades into the leaf litter under bare
  // trees without an edge. Labelled grass lies above 0.07; road, soil and litter lie mostly
  // below 0.05.
  double split_level_ratio = 0.06;
  double split_sigma_m = 1.2;
  // Least distance between an edge and the pixels of a region.
  double min_edge_distance_m = 1.0;
  // Before edge detection, grey levels are divided by their mean over a square of this side and
  // multiplied by reference_grey. canny_high then means the same contrast in dark and bright
  // frames. 0: grey levels are unchanged, as in the paper.
  double contrast_window_m = 40.0;
  double reference_grey = 110.0;
  // Pixels outside this range of grey levels belong to no region: black and burnt-out areas lack
  // edges because the sensor recorded nothing.
  double min_grey = 12.0;
  double max_grey = 250.0;
  // Smaller regions are dropped.
  double min_region_area_m2 = 100.0;
  // Paper: p_canny(h), p_dtf(h), Sec. III-C, coefficients from the highest power down, h in metres.
  std::array<double, 4> paper_canny_coefficients{-1.72e-6, 0.00148, -0.43, 62.97};
  std::array<double, 4> paper_edge_distance_coefficients{-1.23e-6, 0.0011, -0.39, 56.82};
  // Range of heights of the fitted polynomials; heights are clamped to it.
  double paper_min_height_m = 58.0;
  double paper_max_height_m = 382.0;
  // Focal length that the polynomials assume, and a lower bound because p_dtf becomes negative.
  double paper_focal_px = 465.0;
  double paper_min_edge_distance_px = 2.0;

  void Check() const;
};

// Thresholds of the paper at a height above ground (metres), for a camera of paper_focal_px.
double CannyThreshold(double height_above_ground, const SegmentationOptions& options);
double MinEdgeDistancePx(double height_above_ground, const SegmentationOptions& options);

struct Segment {
  // Value of its pixels in Segments::labels: its index in Segments::segments plus 1.
  int label = 0;
  // Outer contour, pixels of the full-size image.
  std::vector<Eigen::Vector2d> contour_in_image;
  double area_m2 = 0.0;
  // A pixel lies on the border of the image, so the region may continue outside.
  bool touches_border = false;
};

struct Segments {
  // Working image: the frame resized, BGR (grey frames have three equal channels).
  cv::Mat3b image;
  // Same size: 0 = no region, else Segment::label.
  cv::Mat1i labels;
  // Pixels of the full-size image per pixel of the working image.
  double image_px_per_working_px = 1.0;
  double ground_sampling_distance_m = 0.0;
  // The frame at the finer detail_sampling_distance_m, or at full size if that is coarser.
  cv::Mat3b detail_image;
  double detail_sampling_distance_m = 0.0;
  std::vector<Segment> segments;
};

// Pure. height_above_ground in metres, > 0. Pixels outside the range of grey levels belong to no
// region: black or burnt-out areas have no edges but are not homogeneous ground.
Segments SegmentFrame(const cv::Mat& image,
                      const Camera& camera,
                      double height_above_ground,
                      const SegmentationOptions& options);

}  // namespace freelsd
