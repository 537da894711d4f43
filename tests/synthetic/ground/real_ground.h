// Input: a surface model and an orthophoto of the same place, and outlines of what lies there.
// Output: a world in which that place lies as it is, within countryside that has no grass.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/geometry/geometry.h"
#include "tests/synthetic/world.h"

namespace freelsd {

// One pack. Rasters are as its files have them: row 0 is the northern edge, column 0 the western.
struct RealGround {
  double cell_size_m = 0.0;
  // What the pack's heights say where ours are 0: their median.
  double datum_m = 0.0;
  cv::Mat1b is_known;    // 255 where there are data; 0 where the other rasters mean nothing
  cv::Mat1f surface;     // highest thing, metres above the datum
  cv::Mat1f ground;      // below crowns, houses and cars
  cv::Mat3b photograph;  // BGR, in the light of its day
  // The photograph's colours are not those of the place.
  bool has_wrong_colors = false;
  cv::Mat1b cover;    // Cover, from the outlines; see tests/synthetic/ground/README.md
  cv::Mat1b variant;  // tells one outline from the next
};

// From $FREELSD_DATA/terrain/PACK and tests/synthetic/ground/PACK.txt. Cells are those of the
// orthophoto. Throws std::runtime_error with what is missing.
RealGround ReadRealGround(const std::string& pack);

// A part of a pack that is worth a world of its own: around a field, or around ground that tempts.
struct GroundWindow {
  std::string name;
  std::string kind;    // "field" or "decoy", by one person's eye
  cv::Point2d middle;  // column and row of the orthophoto
};
// In the order of tests/synthetic/ground/PACK.txt. Throws std::runtime_error if it names none.
std::vector<GroundWindow> ReadGroundWindows(const std::string& pack);

// What lies within `reach_m` of the window's middle, to all four sides. Its datum is the median
// height within `datum_reach_m`.
RealGround Cut(const RealGround& place,
               const GroundWindow& window,
               double reach_m,
               double datum_reach_m);

// Where a pack's middle lies in a world, and where its north points to (radians clockwise from
// the world's).
struct Placement {
  Eigen::Vector2d center_in_world = Eigen::Vector2d::Zero();
  double heading = 0.0;
};
// Chosen by the seed, near enough to the middle to be flown over.
Placement PlacementFor(uint64_t seed);

// Painted and lit. Around the place, and in its gaps, is bare soil; farther out the seed's
// countryside with all its fields ploughed. Only what is outlined as meadow is meadow.
World MakeWorldAround(const RealGround& place,
                      const Placement& placement,
                      const WorldOptions& options);

}  // namespace freelsd
