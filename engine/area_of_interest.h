// Which ground an evaluation has to map, and which views see it. Private to the pipeline.
#pragma once

#include <limits>
#include <vector>

#include "engine/pipeline.h"

namespace freelsd {

// Horizontal, world, metres. Empty until something is added.
struct Box {
  Eigen::Vector2d min = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d max = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity());

  void Add(const Eigen::Vector2d& point);
  void Grow(double margin);
  bool IsEmpty() const;
  double DistanceTo(const Eigen::Vector2d& point) const;
  Box Intersection(const Box& other) const;
};

// Ground that a final and a circle around the regions may need, in calm and in the strongest wind.
Box AreaOfInterest(const std::vector<Region>& regions,
                   const Aircraft& aircraft,
                   double strongest_wind,
                   const BackendOptions& options);

// Largest of the winds at the regions, m/s; 0 where none is known.
double StrongestWind(const std::vector<Region>& regions,
                     const Snapshot& snapshot,
                     const WindOptions& options);

// Indices of the views that see the area, at most max_num_views (nearest first), ascending.
std::vector<size_t> ViewsOf(const Snapshot& snapshot,
                            const Box& area,
                            const BackendOptions& options);

// Ground around the landmarks of an adjusted block.
Box SeenArea(const AdjustedBlock& block);

}  // namespace freelsd
