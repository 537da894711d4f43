// What one view's detections do to the tracked regions (paper Sec. III-E). Knows no images.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "engine/regions/regions.h"

namespace freelsd {

// A segment brought to the ground.
struct Detection {
  // Rectangle, counter-clockwise, world.
  std::vector<Eigen::Vector3d> corners_in_world;
  Eigen::Vector2d centroid_in_world = Eigen::Vector2d::Zero();
  bool is_fully_visible = false;
  bool is_grass = false;
};

struct ViewStamp {
  size_t view = 0;
  std::string frame_id;
  int64_t timestamp_us = 0;
};

// Adds the observation of one view to every region it re-detects, starts regions for the other
// detections, and merges. Independent of the order of detections and of regions.
void UpdateRegions(const ViewStamp& stamp,
                   const std::vector<Detection>& detections,
                   std::vector<TrackedRegion>& regions,
                   int& next_id);

// Grade, and the history entry of the regions that `stamp` observed.
void GradeRegions(const ViewStamp& stamp,
                  int min_num_observations,
                  const RegionsOptions& options,
                  std::vector<TrackedRegion>& regions);

// Keeps the best max_num_regions; among equal grades the longest unseen go first.
void KeepBest(int max_num_regions, std::vector<TrackedRegion>& regions);

}  // namespace freelsd
