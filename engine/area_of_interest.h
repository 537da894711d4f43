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

// Ground that a final and a circle around the regions may need: in calm, in the strongest of their
// winds, and where one of them has none, with the wind from behind that has to be reckoned with.
Box AreaOfInterest(const std::vector<Region>& regions,
                   const Snapshot& snapshot,
                   const Aircraft& aircraft,
                   const PipelineOptions& options);

// The key-frames that see an area.
struct Selection {
  std::vector<View> views;
  // Of the views in the snapshot, ascending.
  std::vector<size_t> indices;
  // Before those farthest from the area's middle were left out, because there were too many.
  size_t num_seeing = 0;
};
Selection SelectViews(const Snapshot& snapshot, const Box& area, const PipelineOptions& options);

// Ground around the landmarks of an adjusted block.
Box SeenArea(const AdjustedBlock& block);

}  // namespace freelsd
