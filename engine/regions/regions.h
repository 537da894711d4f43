// Input: labelled regions of each view in turn. Output: tracked regions of interest with their
// grade. Paper: Sec. III-E.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/classification/classification.h"
#include "engine/tracks/tracks.h"

namespace freelsd {

struct RegionsOptions {
  // --- Behaviour ---
  // Least area of a graded region; normally the aircraft's. Paper: A_min.
  double min_area_m2 = 900.0;
  // Least number of observations of a graded region. Paper: n_obs,min = 10 at 4 Hz. Differs: survey
  // photographs never show a place ten times. The limit is lowered to half of the expected views of
  // a place, but not below min_num_observations_floor.
  int min_num_observations = 10;
  int min_num_observations_floor = 2;
  // A grass region and a non-grass region are merged only if their rectangles overlap by this share
  // (intersection over union). Differs: the paper only requires that one rectangle contains the
  // centre of the other. Rectangles around winding woods and roads would then absorb the fields
  // between them. Paper: 0.
  double min_overlap_of_unlike_ratio = 0.3;
  // A fully visible segment fixes a region's corners only if it covers this share of the region.
  // Differs: the paper accepts any fully visible segment. A small patch between two shadows could
  // then shrink a field (decision 0005). Paper: 0.
  double min_fixing_overlap_ratio = 0.5;
  // Largest number of regions. Paper: "20 best", Sec. III-E3.
  int max_num_regions = 20;
  // A segment with a corner nearer to the image border than this is not fully visible.
  double border_margin_px = 2.0;
  // Largest distance between the camera and a corner of a segment, as a multiple of the height
  // above ground. A segment with a farther corner is ignored. Differs: the paper's cameras look
  // down more steeply.
  double max_viewing_distance_ratio = 10.0;

  void Check() const;
};

// State of a region after one of its observations. The paper plots these values over the frames.
struct RegionHistory {
  std::string frame_id;
  int64_t timestamp_us = 0;
  int num_observations = 0;
  int num_grass_observations = 0;
  double grade = 0.0;
  double area_m2 = 0.0;
};

// The id of ground that lies in no tracked region.
constexpr int kNoRegion = 0;

struct Region {
  // Stable within the flight, from 1. Merged regions keep the older id.
  int id = kNoRegion;
  // Four corners, counter-clockwise, world, with the ground's height. The rectangle is projected
  // from the image, so its angles are not exactly 90 deg.
  std::vector<Eigen::Vector3d> corners_in_world;
  bool is_fixed = false;
  int num_observations = 0;
  int num_grass_observations = 0;
  double area_m2 = 0.0;
  // 0 if the region is too small or has too few observations, else num_grass_observations /
  // num_observations.
  double grade = 0.0;
  std::string first_seen_frame_id;
  std::string last_seen_frame_id;
  int64_t last_seen_us = 0;
  std::vector<RegionHistory> history;

  Polygon Footprint() const;
  Eigen::Vector3d Center() const;
};

// Tracks the regions of one flight. The result does not depend on the order of the segments within
// a view. A view counts as at most one observation of a region, even if it shows several segments
// of the region, or if regions are merged. It is an observation of grass if most of the area that
// the view shows is grass. Not thread-safe.
class Regions {
 public:
  explicit Regions(const RegionsOptions& options);
  ~Regions();
  Regions(Regions&&) noexcept;
  Regions& operator=(Regions&&) noexcept;
  // `segments` and `labels` belong to tracks.views()[view].
  void Update(size_t view, const Segments& segments, const Labels& labels, const Tracks& tracks);
  // Order: higher grade, then more observations, then older id. At most max_num_regions. Regions
  // with too few observations come last and never displace graded ones.
  std::vector<Region> Ranked() const;
  // n_obs,min, derived from the views so far.
  int MinNumObservations() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace freelsd
