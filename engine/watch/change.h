// Where a registered photograph shows other ground than the stored picture, whatever the light.
#pragma once

#include <opencv2/core.hpp>

#include "engine/watch/strip_canvas.h"

namespace freelsd {

// Change of one band beyond that of the light.
struct BandChange {
  // Natural logarithm; 0 where the band has a value that the other picture has within tolerance_m.
  cv::Mat1f change;
  // The same in deviations of the changes on the strip.
  cv::Mat1f deviations;
  // Both pictures against their surroundings.
  cv::Mat1f stored_contrast, seen_contrast;
};

struct StripChange {
  // 255 where both pictures show the ground; and where that is the strip.
  cv::Mat1b is_shown, is_compared;
  BandChange green;
  BandChange brightness;
};
StripChange ChangeOf(const StripCanvas& canvas,
                     const ProjectedPhoto& photo,
                     const cv::Mat1b& is_comparable,
                     const WatchOptions& options);

}  // namespace freelsd
