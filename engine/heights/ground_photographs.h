// Private to heights/. Photographs at the sampling of the ground, without exposure.
#pragma once

#include <list>
#include <memory>
#include <utility>

#include "engine/adjustment/adjustment.h"
#include "engine/heights/heights.h"

namespace freelsd {

struct GroundPhotograph {
  // Log brightness less its mean over a wide square, so that exposure, shading of the lens and haze
  // do not count. Empty if the frame has no image.
  cv::Mat1f detail;
  // Of the camera's pixels.
  double scale = 1.0;
};

// Keeps the photographs that were used last.
class GroundPhotographs {
 public:
  GroundPhotographs(const AdjustedBlock& block,
                    const ImageSource& images,
                    double ground_sampling_distance_m);
  std::shared_ptr<const GroundPhotograph> Of(size_t view);

 private:
  const AdjustedBlock& block_;
  const ImageSource& images_;
  double sampling_m_;
  std::list<std::pair<size_t, std::shared_ptr<const GroundPhotograph>>> latest_;
};

}  // namespace freelsd
