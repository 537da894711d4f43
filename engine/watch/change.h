// Where a registered photograph shows other ground than the stored picture, whatever the light.
#pragma once

#include <array>

#include <opencv2/core.hpp>

#include "engine/watch/strip_canvas.h"

namespace freelsd {

// Of LightBands.
enum class Band { kBrightness, kGreenExcess, kRedBlue };
constexpr int kNumBands = 3;

// Natural logarithms.
struct BandChange {
  // Of the photograph against the stored picture.
  cv::Mat1f change;
  // Change beyond that of the light, in deviations of the changes of details on the strip, with its
  // sign; 0 where the other picture has that value within tolerance_m.
  cv::Mat1f deviations;
  // The photograph's band.
  cv::Mat1f seen;
};

struct StripChange {
  // 255 where both pictures show the ground; and where that is the strip.
  cv::Mat1b is_shown, is_compared;
  std::array<BandChange, kNumBands> bands;

  const BandChange& Of(Band band) const { return bands[static_cast<size_t>(band)]; }
};
StripChange ChangeOf(const StripCanvas& canvas,
                     const ProjectedPhoto& photo,
                     const cv::Mat1b& is_comparable,
                     const WatchOptions& options);

}  // namespace freelsd
