// Input: position without power, wind, heights of the ground. Output: the ground in reach.
//
// For each wind and heading that must be reckoned with, the aircraft turns by any angle and then
// flies straight: over ground, this is a fan of straight lines from the turn. A line ends at the
// first ground that it does not clear. Ground is in reach if it lies in all these fans.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/approach/approach.h"

namespace freelsd {

struct GlideOptions;
struct GlideStart;

// Every ray ends at the edge of the grid.
struct ReachGround {
  Grid grid;
  // Highest surface of each cell, in world z; finite everywhere. Where a part of the cell is
  // unknown, at least the height that is assumed there.
  cv::Mat1f top;
  // 255 where the height of the whole cell is known, else 0.
  cv::Mat1b is_known;
};

struct ReachLimits {
  // Height to keep above the ground, and height above it on arrival. Both hold at the end of the
  // way.
  double terrain_clearance_m = 10.0;
  double arrival_height_m = 0.0;
  // Of all polygons together. The areas are made coarser, and never larger, until this holds.
  int max_num_vertices = 4000;
  // Steps of the search along its lines, foreseen from those of its first wind and heading. The
  // search joins four cells to one until this holds. No clock counts: the same input, the same
  // cells.
  double max_work = std::numeric_limits<double>::infinity();
  // Called before the search of each wind and heading; to give up, it throws.
  std::function<void()> before_fan = [] {};
};

// A polygon without its holes. The outer ring is counter-clockwise, holes are clockwise. No ring
// crosses or touches itself or another one.
struct ReachArea {
  Polygon outer;
  std::vector<Polygon> holes;
};

struct Reach {
  // Largest first.
  std::vector<ReachArea> known;
  std::vector<ReachArea> unknown;
  // Side of the cells that were searched, in cells of the ground. Above 1, the areas are an inner
  // bound: they lie in those of a search with 1.
  int cells_per_side = 1;
};

// The worst case over the winds and headings of GlideTo. Never more than what a planner of single
// paths finds, but a little less: along each edge about two cells. Nothing is in reach if one of
// the winds is as fast as the aircraft. `aircraft` must be Unpowered.
Reach ReachOf(const GlideStart& start,
              const ReachGround& ground,
              const Aircraft& aircraft,
              const GlideOptions& options,
              const ReachLimits& limits);

// Upper bound of the distance over ground until the given height is lost.
double GreatestGlideDistance(const GlideStart& start,
                             double height_m,
                             const Aircraft& aircraft,
                             const GlideOptions& options);

}  // namespace freelsd
