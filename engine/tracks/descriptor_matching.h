// Input: descriptors of two images. Output: pairs of points that show the same place.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "engine/tracks/keypoints.h"

namespace freelsd {

// One match: the index of a point in each image.
struct IndexPair {
  int a = 0;
  int b = 0;
};

// Mutual nearest neighbours that pass Lowe's ratio test in both directions.
std::vector<IndexPair> MatchDescriptors(const cv::Mat& a, const cv::Mat& b);
// Like MatchDescriptors, but matches only points that are within `radius` of each other.
std::vector<IndexPair> MatchDescriptorsNear(const DescribedPoints& a,
                                            const DescribedPoints& b,
                                            double radius);

}  // namespace freelsd
