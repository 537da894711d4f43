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
  // Differs: the published polynomials leave no region on sharp photographs; see kPaper.
  SegmentationThresholds thresholds = SegmentationThresholds::kGroundSampling;
  // The image is resized to this ground sampling distance first; never enlarged. This and the
  // three below: tests/evaluation/segmentation.md says what was tried.
  double ground_sampling_distance_m = 0.6;
  // And to this one for the classification, which looks at finer texture.
  double detail_sampling_distance_m = 0.3;
  double blur_sigma_px = 1.0;
  // Upper hysteresis threshold of the Canny detector, grey levels; the lower is a third of it.
  double canny_high = 105.0;
  // Edges are also sought in the two colour channels of CIE L*a*b*, stretched by this factor; 0
  // looks at grey alone, as the paper does. Differs: road, gravel and meadow may be equally bright.
  double chroma_gain = 1.0;
  // Where excess green (2G - R - B) / (R + G + B), smoothed by split_sigma_m, crosses split_level
  // there is an edge too; a sigma of 0 has none. Differs: a lawn fades into the leaf litter under
  // bare trees without any edge. Labelled grass lies above 0.07, road, soil and litter mostly below
  // 0.05.
  double split_level_ratio = 0.06;
  double split_sigma_m = 1.2;
  // Least distance of a region's pixel from an edge.
  double min_edge_distance_m = 1.0;
  // Grey levels are divided by their mean over a square of this side and multiplied by
  // reference_grey before the edges are sought, so that canny_high means the same contrast in a
  // dark frame as in a bright one. 0 takes them as they are, as the paper does.
  double contrast_window_m = 40.0;
  double reference_grey = 110.0;
  // Pixels outside this range of grey levels are in no region: black and burnt-out areas have no
  // edges because nothing was recorded there.
  double min_grey = 12.0;
  double max_grey = 250.0;
  // Smaller regions are dropped.
  double min_region_area_m2 = 100.0;
  // Paper: p_canny(h), p_dtf(h), Sec. III-C, coefficients from the highest power down, h in metres.
  std::array<double, 4> paper_canny_coefficients{-1.72e-6, 0.00148, -0.43, 62.97};
  std::array<double, 4> paper_edge_distance_coefficients{-1.23e-6, 0.0011, -0.39, 56.82};
  // Range the polynomials were fitted for; heights are clamped to it.
  double paper_min_height_m = 58.0;
  double paper_max_height_m = 382.0;
  // Focal length the polynomials are taken to hold for, and a floor, since p_dtf turns negative.
  double paper_focal_px = 465.0;
  double paper_min_edge_distance_px = 2.0;

  void Check() const;
};

// Paper thresholds at a height above ground (metres), pixels of a camera of paper_focal_px.
double CannyThreshold(double height_above_ground, const SegmentationOptions& options);
double MinEdgeDistancePx(double height_above_ground, const SegmentationOptions& options);

struct Segment {
  // Value of its pixels in Segments::labels: its place in Segments::segments, from 1.
  int label = 0;
  // Outer contour, pixels of the full-size image.
  std::vector<Eigen::Vector2d> contour_in_image;
  double area_m2 = 0.0;
  // A pixel lies on the border of the image, so that the region may go on outside.
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
  // The frame at the finer scale of detail_sampling_distance_m, or as fine as it is.
  cv::Mat3b detail_image;
  double detail_sampling_distance_m = 0.0;
  std::vector<Segment> segments;
};

// Pure. height_above_ground in metres, > 0. Pixels too dark or too bright to tell a texture from
// none are in no region: a flat black or burnt-out area has no edges but is not homogeneous ground.
Segments SegmentFrame(const cv::Mat& image,
                      const Camera& camera,
                      double height_above_ground,
                      const SegmentationOptions& options);

}  // namespace freelsd
