// Private to regions/: the region manager, on rectangles in the world frame.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "engine/regions/regions.h"

namespace freelsd {

// One segment of one view, projected onto the ground.
struct Detection {
  // Four, counter-clockwise.
  std::vector<Eigen::Vector3d> corners_in_world;
  Eigen::Vector3d centroid_in_world = Eigen::Vector3d::Zero();
  bool is_fully_visible = false;
  bool is_grass = false;
  // Area of the segment: its weight in the view's vote.
  double area_m2 = 0.0;
};

// Horizontal part of the corners.
Polygon GroundPolygon(const std::vector<Eigen::Vector3d>& corners_in_world);

struct ViewStamp {
  size_t view = 0;
  std::string frame_id;
  int64_t timestamp_us = 0;
};

// Areas that one view showed of a region.
struct ViewEvidence {
  double grass_area_m2 = 0.0;
  double other_area_m2 = 0.0;
};

struct TrackedRegion {
  Region region;
  // By view: a view counts once for merged regions, even if it saw both.
  std::map<size_t, ViewEvidence> evidence;
  bool has_new_corners = false;

  // Whether most of its views saw grass.
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
  std::vector<TrackedRegion> tracked_;  // by id
  int next_id_ = 1;
};

// Counts the views that see a place, to derive n_obs,min.
class ViewOverlap {
 public:
  // Adds the ground below the image centre and the image's footprint. A view counts once.
  void Add(size_t view, const Eigen::Vector2d& center_in_world, const Polygon& footprint);
  // Typical number of views of a place: median over the centres of all views.
  double ExpectedNumViews() const;
  // The paper's number, lowered to half of the expected views, at least the floor.
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
