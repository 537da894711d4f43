// Input: labelled regions of one view after the other. Output: tracked regions of interest with
// their grade. Paper: Sec. III-E.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/classification/classification.h"
#include "engine/tracks/tracks.h"

namespace freelsd {

struct RegionsOptions {
  // --- Behaviour ---
  // Area from which a region is worth a grade; normally the aircraft's. Paper: A_min.
  double min_area_m2 = 900.0;
  // Observations from which a region has a grade. Paper: n_obs,min = 10 at 4 Hz.
  // Differs: survey photographs never show a place ten times, so it is lowered to half the number
  // of views of a place that the flight lets expect, but never below min_num_observations_floor.
  int min_num_observations = 10;
  int min_num_observations_floor = 2;
  // Regions kept. Paper: "20 best", Sec. III-E3.
  int max_num_regions = 20;
  // A corner nearer to the border of the image than this counts as not fully visible.
  double border_margin_px = 2.0;

  void Check() const;
};

// State of a region after one of its observations (the paper's plots over frames).
struct RegionHistory {
  std::string frame_id;
  int64_t timestamp_us = 0;
  int num_observations = 0;
  int num_grass_observations = 0;
  double grade = 0.0;
  double area_m2 = 0.0;
};

struct Region {
  // Stable within the flight; of two merged regions the older one's stays.
  int id = 0;
  // Rectangle, counter-clockwise, world, with the ground's height.
  std::vector<Eigen::Vector3d> corners_in_world;
  bool is_fixed = false;
  int num_observations = 0;
  int num_grass_observations = 0;
  double area_m2 = 0.0;
  // 0 if too small or too seldom seen, else num_grass_observations / num_observations.
  double grade = 0.0;
  std::string first_seen_frame_id;
  std::string last_seen_frame_id;
  int64_t last_seen_us = 0;
  std::vector<RegionHistory> history;

  Polygon Footprint() const;
  Eigen::Vector3d Center() const;
};

// A region and what it remembers of its observations.
struct TrackedRegion {
  Region region;
  // Whether each view that saw it saw grass, by index of the view.
  std::map<size_t, bool> votes;
  // Whether its corners changed with the last view.
  bool is_updated = false;
};

// Ground that a view sees, world.
struct ViewFootprint {
  Polygon ground;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
};

// Remembers the regions of one flight. The result does not depend on the order of the segments
// within a view. Not thread-safe.
class Regions {
 public:
  explicit Regions(const RegionsOptions& options);
  // segments and labels belong to tracks.views()[view].
  void Update(size_t view, const Segments& segments, const Labels& labels, const Tracks& tracks);
  // Best grade first; equal grades: seen more often, then older id.
  std::vector<Region> Ranked() const;
  // n_obs,min as derived from the views so far.
  int MinNumObservations() const;

 private:
  void CountView(const std::optional<ViewFootprint>& footprint);

  RegionsOptions options_;
  std::vector<TrackedRegion> regions_;
  int next_id_ = 1;
  std::vector<ViewFootprint> footprints_;
  // How many views see the middle of each view, itself included.
  std::vector<int> num_views_of_middle_;
  int min_num_observations_ = 10;
};

}  // namespace freelsd
