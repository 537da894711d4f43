// Input: labelled regions of one view after the other. Output: tracked regions of interest with
// their grade. Paper: Sec. III-E.
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
  // Area from which a region is worth a grade; normally the aircraft's. Paper: A_min.
  double min_area_m2 = 900.0;
  // Observations from which a region has a grade. Paper: n_obs,min = 10 at 4 Hz.
  // Differs: survey photographs never show a place ten times, so it is lowered to half the number
  // of views of a place that the flight lets expect, but never below min_num_observations_floor.
  int min_num_observations = 10;
  int min_num_observations_floor = 2;
  // A region of grass and one of something else are the same place only if their rectangles overlap
  // by this share (common over union). Differs: the paper asks for a centre inside the other's
  // corners alone; rectangles around winding woods and roads then swallow the fields between them.
  // 0 is the paper's.
  double min_overlap_of_unlike_ratio = 0.3;
  // A view of all of a region fixes its corners only where it covers this share of what was known
  // of it. Differs: the paper takes any segment that is fully visible, and so a patch of 400 m2
  // between two shadows makes an end of the field around it. 0 is the paper's.
  double min_fixing_overlap_ratio = 0.5;
  // Regions kept. Paper: "20 best", Sec. III-E3.
  int max_num_regions = 20;
  // A corner nearer to the border of the image than this counts as not fully visible.
  double border_margin_px = 2.0;
  // A corner seen from farther than this many heights above ground is too uncertain: the region is
  // skipped in that view. Differs: the paper's cameras do not look that flat.
  double max_viewing_distance_ratio = 10.0;

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
  // Four corners of the rectangle (projected from the image, so not quite one), counter-clockwise,
  // world, with the ground's height.
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

// Remembers the regions of one flight. The result does not depend on the order of the segments
// within a view. A view counts once for a region, however many segments hit it and whatever was
// merged; it counts as grass when most of the area seen is grass. Not thread-safe.
class Regions {
 public:
  explicit Regions(const RegionsOptions& options);
  ~Regions();
  Regions(Regions&&) noexcept;
  Regions& operator=(Regions&&) noexcept;
  // segments and labels belong to tracks.views()[view].
  void Update(size_t view, const Segments& segments, const Labels& labels, const Tracks& tracks);
  // Best grade first; equal grades: seen more often, then older id. At most max_num_regions;
  // regions seen too seldom for a grade come last and do not push out graded ones.
  std::vector<Region> Ranked() const;
  // n_obs,min as derived from the views so far.
  int MinNumObservations() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace freelsd
