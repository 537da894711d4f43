// Input: stored picture of a landing strip, seen from above, and new photographs with inexact
// poses. Output: things that stand or move on the strip and did not before. Not in the paper.
//
// Unknown is never free: a strip that a photograph does not show well enough is not compared, and
// the answer says why.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/terrain/terrain.h"

namespace freelsd {

// In error messages the fields are named `watch.…`.
struct WatchOptions {
  // --- What is compared ---
  // Finest pixel at which pictures are compared. A person is 0.5 m wide.
  double min_pixel_m = 0.1;
  // Coarsest ground sampling of a photograph that is compared, along its coarser direction.
  double max_sampling_m = 0.45;
  // Ground around the strip that helps to register the photograph.
  double context_m = 15.0;
  // Ground that higher things hide from the camera by more than this is not compared.
  double hidden_height_m = 1.0;
  // The strip counts as compared if the photograph shows at least this share of it.
  double min_compared_ratio = 0.5;

  // --- Registration ---
  // Largest displacement of the photograph on the ground by the errors of its pose and of the map,
  // largest turn, and largest share by which it appears too large or too small: errors of the
  // height above ground.
  double max_offset_m = 12.0;
  double max_turn_deg = 5.0;
  double max_scale_error_ratio = 0.04;
  // Squares of this side are matched one by one. The photograph is registered if at least
  // min_num_matches of them agree, and if they are at least min_match_ratio of all. A match needs
  // min_match_correlation. Of chance, less than 0.1 of all agree.
  double block_m = 8.0;
  int min_num_matches = 8;
  double min_match_ratio = 0.2;
  double min_match_correlation = 0.25;
  // Largest distance of a match from the common motion.
  double max_match_error_m = 0.3;
  // Details may be displaced by this after registration: errors of the map's heights, grass in the
  // wind. A colour counts as changed if it differs from all colours within this distance.
  double tolerance_m = 0.2;

  // --- Light ---
  // Side of the square in which the change of light is even. Clouds, haze and wet grass change
  // colours over larger distances.
  double light_window_m = 24.0;
  // Details are what differs from the mean over a square of this side.
  double detail_window_m = 6.0;
  // Deviation of the noise of a channel, grey levels.
  double noise_grey = 2.5;

  // --- Things ---
  // A thing may begin where the change is this many deviations of the changes of details on the
  // whole strip.
  double grow_deviations = 3.5;
  double min_area_m2 = 0.1;
  // Shares of a change that the ground around it must not have, and that the photograph itself must
  // show.
  double min_isolation_ratio = 0.4;
  double min_own_contrast_ratio = 0.4;
  // Least logarithm of the odds that a change is a thing.
  double min_evidence = 0.0;
  // Larger changes are those of the ground: that part of the strip is not compared.
  double max_size_m = 15.0;

  // --- Confirmation ---
  // A thing is told if two photographs show it, at most max_wait_s apart, and so near to each other
  // that it may have moved from one place to the other at max_speed_mps. place_error_m is the error
  // of the distance. Both evidences together, less the logarithm of the odds that two false ones
  // are so near to each other, must reach min_pair_evidence.
  double max_wait_s = 6.0;
  double max_speed_mps = 15.0;
  double place_error_m = 1.5;
  double min_pair_evidence = 3.5;

  // Throws std::invalid_argument: "watch.context_m = -1: must be in [0, 100]".
  void Check() const;
};

// A strip as it is stored. The server takes `picture` from the tiles of the flight's stored mosaic
// (the level whose pixels are nearest to min_pixel_m, but not coarser than the photographs) and the
// heights from the stored map.
struct StripPicture {
  // One cell per pixel. Should reach context_m + max_offset_m beyond the strip.
  Grid grid;
  // BGRA, not premultiplied. Alpha is 0 where no photograph shows the ground.
  cv::Mat4b picture;
  // Heights of the ground and of what stands on it (ElevationMap::upper), metres above the world
  // origin; NaN where unseen.
  Grid ground_grid;
  cv::Mat1f elevation;
  cv::Mat1f upper;
  // The strip: rectangle of the ground roll, touchdown disc. A place in any of them belongs to it.
  std::vector<Polygon> outlines;
};

// A new photograph. The pose may err by max_offset_m on the ground.
struct WatchedPhoto {
  cv::Mat image;  // BGR, full size
  Camera camera;
  Rigid3d world_from_camera;
  int64_t timestamp_us = 0;
};

enum class LookResult {
  kCompared,
  kNotShown,       // too little of the strip is in the photograph, or in the stored picture
  kTooCoarse,      // photographed from too far away
  kNotRegistered,  // the two pictures have too little in common
};

// What tells a thing.
enum class WatchCue {
  kColor,  // other colours than the ground
  kShade,  // darker or brighter than the ground, and narrow
};

// Something that the stored picture does not show.
struct NewThing {
  WatchCue cue = WatchCue::kColor;
  // In the world of the stored map, at the height of the ground.
  Eigen::Vector3d place_in_world = Eigen::Vector3d::Zero();
  // Sides of the smallest rectangle around it.
  double length_m = 0.0;
  double width_m = 0.0;
  double area_m2 = 0.0;
  // Largest change, in deviations of the changes on the strip.
  double deviations = 0.0;
  // Logarithm of the odds that it is a thing.
  double evidence = 0.0;
};

// What one photograph shows of a strip.
struct StripLook {
  LookResult result = LookResult::kNotShown;
  int64_t timestamp_us = 0;
  // Share of the strip that was compared.
  double compared_ratio = 0.0;
  // Displacement of the photograph that registration removed, at the strip's middle, metres east
  // and north.
  Eigen::Vector2d offset_in_world = Eigen::Vector2d::Zero();
  // Mean correlation of the matched squares.
  double correlation = 0.0;
  // Largest evidence first. Empty unless kCompared.
  std::vector<NewThing> things;
};

// Compares one photograph with the stored picture. Throws std::invalid_argument on bad options, on
// rasters whose sizes differ from their grids, and on an image of another size than the camera's.
// The same input gives the same result on any number of threads.
StripLook LookAtStrip(const StripPicture& strip,
                      const WatchedPhoto& photo,
                      const WatchOptions& options);

enum class StripStatus {
  kUnknown,     // no photograph could be compared lately
  kNothingNew,  // the last photographs show what the stored picture shows
  kSuspected,   // one photograph shows something new
  kOccupied,    // two photographs show something new
};

// Joins the looks at one strip. Not thread-safe.
class StripWatch {
 public:
  explicit StripWatch(const WatchOptions& options);

  struct Report {
    StripStatus status = StripStatus::kUnknown;
    // Those of the look that were confirmed, or are suspected.
    std::vector<NewThing> things;
  };
  // Looks come in the order of their times. A look that was not compared repeats the last report,
  // but what was known is forgotten after max_wait_s.
  Report Add(const StripLook& look);

 private:
  bool IsConfirmed(const NewThing& thing, int64_t timestamp_us) const;

  WatchOptions options_;
  // Compared, oldest first, at most max_wait_s old.
  std::vector<StripLook> looks_;
  Report last_;
};

}  // namespace freelsd
