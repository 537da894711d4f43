// Input: an evaluated flight. Output: strips as the service has them stored.
#pragma once

#include <vector>

#include "engine/mosaic/mosaic.h"
#include "engine/watch/watch.h"

namespace freelsd {

// The mosaic of a flight at its finest level, through the stored form of its tiles.
class StoredGround {
 public:
  StoredGround(const ElevationMap& map,
               const AdjustedBlock& block,
               const ImageSource& images,
               const MosaicOptions& options = {});

  // Picture and heights around a strip. Shares memory with this.
  StripPicture Around(const std::vector<Polygon>& outlines, const WatchOptions& options) const;

 private:
  ElevationMap map_;
  Grid grid_;
  cv::Mat4b picture_;
};

// Ground roll and touchdown disc of a site.
std::vector<Polygon> OutlinesOf(const Eigen::Vector2d& touchdown_in_world,
                                double disc_radius_m,
                                const std::vector<Eigen::Vector3d>& ground_roll_in_world);

}  // namespace freelsd
