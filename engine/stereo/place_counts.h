// Private to stereo/. How many pairs show each place of the ground.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "engine/stereo/stereo.h"

namespace freelsd {

// On a raster that is coarse for speed, and with footprints on level ground.
class PlaceCounts {
 public:
  explicit PlaceCounts(const AdjustedBlock& block);
  void Add(const StereoPair& pair);
  // Of the ground that both views of the pair show: the share that fewer than `num_pairs` pairs
  // show so far; 0 if they show nothing together.
  double NeededRatio(const StereoPair& pair, int num_pairs) const;

 private:
  // The ground that both views of a pair show: its cells, and which of the cells of that part of
  // the raster.
  struct Overlap {
    cv::Rect part;
    cv::Mat1b mask;
  };
  Overlap OverlapOf(const StereoPair& pair) const;

  // Corners of what each view shows, cells; empty for a view that is not connected, or that shows
  // the horizon.
  std::vector<std::vector<cv::Point2f>> footprints_;
  cv::Mat1b counts_;
};

}  // namespace freelsd
