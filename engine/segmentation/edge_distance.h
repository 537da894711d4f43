// Private to segmentation/. Pixels that are far from every edge.
#pragma once

#include <opencv2/core.hpp>

namespace freelsd {

// 255 where the distance to the nearest edge (255, elsewhere 0) is larger than distance_px, else 0;
// as cv::distanceTransform with DIST_L2 and DIST_MASK_5 measures it.
cv::Mat1b FarFromEdges(const cv::Mat1b& edges, double distance_px);

}  // namespace freelsd
