// Input: descriptors of two images. Output: which points of one are which of the other.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "engine/tracks/keypoints.h"

namespace freelsd {

// One match: index of a point in either frame.
struct IndexPair {
  int a = 0;
  int b = 0;
};

// Mutual nearest neighbours that are clearly better than the second nearest.
std::vector<IndexPair> MatchDescriptors(const cv::Mat& a, const cv::Mat& b);
// The same among points that are within `radius` of one another.
std::vector<IndexPair> MatchDescriptorsNear(const DescribedPoints& a,
                                            const DescribedPoints& b,
                                            double radius);

}  // namespace freelsd
