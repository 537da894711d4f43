// Private to regions/: tracks regions as rectangles in the world frame.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "engine/regions/regions.h"

namespace freelsd {

// One segment of one view, projected onto the ground.
struct Detection {
  // Four corners, counter-clockwise.
  std::vector<Eigen::Vector3d> corners_in_world;
  Eigen::Vector3d centroid_in_world = Eigen::Vector3d::Zero();
  bool is_fully_visible = false;
  bool is_grass = false;
  // Area of the segment. It is the segment's weight in the vote of the view.
  double area_m2 = 0.0;
};

// The horizontal coordinates of the corners.
Polygon GroundPolygon(const std::vector<Eigen::Vector3d>& corners_in_world);

struct ViewStamp {
  size_t view = 0;
  std::string frame_id;
  int64_t timestamp_us = 0;
};

// Areas of grass and of other ground that one view showed within a region.
struct ViewEvidence {
  double grass_area_m2 = 0.0;
  double other_area_m2 = 0.0;
};

struct TrackedRegion {
  Region region;
  // Key: index of the view. If merged regions were seen by the same view, that view counts once.
  std::map<size_t, ViewEvidence> evidence;
  bool has_new_corners = false;

  // True if more than half of its views showed mostly grass.
  bool IsGrass() const;
};

class RegionTracker {
 public:
  explicit RegionTracker(const RegionsOptions& options) : options_(options) {}
  void Update(const ViewStamp& stamp, std::vector<Detection> detections, int min_num_observations);
  std::vector<Region> Ranked() const;

 private:
  void Assign(const ViewStamp& stamp, const std::vector<Detection>& detections);
  bool MergeOnce();
  void Grade(const ViewStamp& stamp, int min_num_observations);
  void DropWorst(int min_num_observations);

  RegionsOptions options_;
  std::vector<TrackedRegion> tracked_;  // ascending id
  int next_id_ = 1;
};

// Counts the views that see a place, to determine the minimum number of observations (n_obs,min).
class ViewOverlap {
 public:
  // Adds the ground point at the image centre and the footprint of the image. Each view is added
  // only once.
  void Add(size_t view, const Eigen::Vector2d& center_in_world, const Polygon& footprint);
  // Typical number of views that see one place: the median over the centres of all views.
  double ExpectedNumViews() const;
  // min_num_observations (the paper's value), but at most half of ExpectedNumViews(), and at least
  // min_num_observations_floor.
  int MinNumObservations(const RegionsOptions& options) const;

 private:
  struct Entry {
    Eigen::Vector2d center_in_world;
    Polygon footprint;
    int num_views = 1;
  };
  std::set<size_t> views_;
  std::vector<Entry> entries_;
};

struct Regions::State {
  explicit State(const RegionsOptions& regions_options)
      : options(regions_options), tracker(regions_options) {}
  RegionsOptions options;
  RegionTracker tracker;
  ViewOverlap overlap;
};

}  // namespace freelsd
