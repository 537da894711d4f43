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
  // Differs: with the paper's polynomials, sharp photographs give no regions.
  SegmentationThresholds thresholds = SegmentationThresholds::kGroundSampling;
  // The image is first reduced to this ground sampling distance. It is never enlarged. Decision
  // 0001 explains this field and the three below.
  double ground_sampling_distance_m = 0.6;
  // Ground sampling distance of the image for classification, which needs finer texture.
  double detail_sampling_distance_m = 0.3;
  double blur_sigma_px = 1.0;
  // Upper hysteresis threshold of the Canny detector, grey levels. The lower one is a third of it.
  double canny_high = 105.0;
  // Gain of the two colour channels of CIE L*a*b* before edge detection. 0: grey only, as in the
  // paper. Differs: road, gravel and meadow may be equally bright.
  double chroma_gain = 1.0;
  // Adds edges where excess green (2G - R - B) / (R + G + B) crosses split_level_ratio. Excess
  // green is first smoothed by a Gaussian with deviation split_sigma_m. split_sigma_m = 0: no such
  // edges. Differs: the paper's detector finds no edge between a lawn and the leaf litter under
  // bare trees. Labelled grass lies above 0.07; road, soil and litter lie mostly below 0.05.
  double split_level_ratio = 0.06;
  double split_sigma_m = 1.2;
  // Least distance between an edge and the pixels of a region.
  double min_edge_distance_m = 1.0;
  // Before edge detection, grey levels are divided by their mean over a square of this side and
  // multiplied by reference_grey. canny_high then means the same contrast in dark and bright
  // frames. 0: grey levels are unchanged, as in the paper.
  double contrast_window_m = 40.0;
  double reference_grey = 110.0;
  // Pixels outside this range of grey levels belong to no region. Black and burnt-out areas have no
  // edges only because the sensor recorded nothing there.
  double min_grey = 12.0;
  double max_grey = 250.0;
  // Smaller regions are dropped.
  double min_region_area_m2 = 100.0;
  // Coefficients of the paper's p_canny(h) and p_dtf(h), Sec. III-C, highest power first; h in
  // metres.
  std::array<double, 4> paper_canny_coefficients{-1.72e-6, 0.00148, -0.43, 62.97};
  std::array<double, 4> paper_edge_distance_coefficients{-1.23e-6, 0.0011, -0.39, 56.82};
  // Range of heights to which the polynomials were fitted. Heights are clamped to it.
  double paper_min_height_m = 58.0;
  double paper_max_height_m = 382.0;
  // Focal length for which the polynomials hold, and a lower bound of p_dtf. Without the bound,
  // p_dtf would become negative.
  double paper_focal_px = 465.0;
  double paper_min_edge_distance_px = 2.0;

  void Check() const;
};

// Thresholds of the paper at a height above ground (metres), for a camera with paper_focal_px.
double CannyThreshold(double height_above_ground, const SegmentationOptions& options);
double MinEdgeDistancePx(double height_above_ground, const SegmentationOptions& options);

struct Segment {
  // Value of its pixels in Segments::labels: its index in Segments::segments plus 1.
  int label = 0;
  // Outer contour, pixels of the full-size image.
  std::vector<Eigen::Vector2d> contour_in_image;
  double area_m2 = 0.0;
  // True if a pixel lies on the border of the image: the region may continue outside.
  bool touches_border = false;
};

struct Segments {
  // Working image: the frame resized, BGR (grey frames have three equal channels).
  cv::Mat3b image;
  // Same size as `image`. 0 = no region, else Segment::label.
  cv::Mat1i labels;
  // Pixels of the full-size image per pixel of the working image.
  double image_px_per_working_px = 1.0;
  double ground_sampling_distance_m = 0.0;
  // The frame at detail_sampling_distance_m, or at full size if that is coarser.
  cv::Mat3b detail_image;
  double detail_sampling_distance_m = 0.0;
  std::vector<Segment> segments;
};

// Has no side effects. height_above_ground in metres, > 0.
Segments SegmentFrame(const cv::Mat& image,
                      const Camera& camera,
                      double height_above_ground,
                      const SegmentationOptions& options);

}  // namespace freelsd
