// Input: outlines on the ground. Output: what is seen there, cell by cell, and how far their
// outlines can be trusted.
#pragma once

#include <string>
#include <vector>

#include "engine/terrain/terrain.h"
#include "tests/evaluation/fields/ground_heights.h"
#include "tests/evaluation/fields/outlines.h"

namespace freelsd {

// An outline of one photograph, projected on the ground.
struct GroundOutline {
  std::string id;
  OutlineKind kind = OutlineKind::kDoubt;
  double height_m = 0.0;
  std::string photograph;
  // Two corners are a line.
  Polygon outline;
  // The outline was projected that far above the ground.
  double raise_m = 0.0;
};

// All views of one id. Land is where all views agree; everything else is where any view shows it.
struct LabelledObject {
  std::string id;
  OutlineKind kind = OutlineKind::kDoubt;
  // The largest of its views.
  double height_m = 0.0;
  std::vector<GroundOutline> views;
  // Cells of the grid of LabelledGround, and 255 where the object is.
  cv::Rect cells;
  cv::Mat1b mask;

  // Nobody may touch down there.
  bool IsDanger() const { return kind == OutlineKind::kRefuse || !IsGround(kind); }
};

// Up to this height the views of a thing differ by less than the tolerance of an outline.
constexpr double kMaxLowHeightM = 2.0;

// How far the views of one id differ on the ground.
struct Disagreement {
  int num_pairs = 0;
  // Mean distance from points on one border to the other border, metres: over the pairs.
  double median_m = 0.0;
  double largest_m = 0.0;
  // Area of the intersection divided by that of the union: mean over the pairs of ground.
  double mean_overlap_ratio = 0.0;
};

struct LabelledGround {
  Grid grid;
  // By id.
  std::vector<LabelledObject> objects;
  // 255 where an object of land is and none of danger.
  cv::Mat1b free_land;
  // Metres to the nearest cell of land.
  cv::Mat1f distance_to_land;
  // Without what stands on it.
  GroundHeights bare_heights;
  // Of ground and low things, and of things above kMaxLowHeightM: those lean in photographs.
  Disagreement disagreement, tall_disagreement;
  // Share of the height of tall things at which their outlines were taken.
  double tall_share = 0.0;
  // An outline may be this far off: root of position_sd_m^2 + (median disagreement)^2.
  double tolerance_m = 0.0;
};

// `map`: of the run that projected the outlines. `position_sd_m`: of its block.
LabelledGround MakeLabelledGround(const std::vector<GroundOutline>& outlines,
                                  const ElevationMap& map,
                                  double position_sd_m);

}  // namespace freelsd
