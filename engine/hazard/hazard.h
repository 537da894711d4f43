// Input: elevation map and grass observations. Output: slope, roughness, grass, hazard and the
// distance to it. Paper: Sec. III-G.
#pragma once

#include <vector>

#include "engine/terrain/terrain.h"

namespace freelsd {

enum class GrassFusion { kPosterior, kPaperOr };
enum class SlopeSupport { kPlane, kPaperPca };

struct HazardOptions {
  // --- Behaviour ---
  // Posterior over the observations of a cell, or the paper's OR of all fine masks.
  GrassFusion grass_fusion = GrassFusion::kPosterior;
  double min_grass_posterior = 0.8;
  // Limits of one observation's probability: no single view is ever certain.
  double min_observation_probability = 0.1;
  double max_observation_probability = 0.9;
  // Plane fit over plane_support_m, or PCA of the 3x3 neighbourhood. Differs: 3x3 cells of 1 m are
  // mostly noise.
  SlopeSupport slope_support = SlopeSupport::kPlane;
  double plane_support_m = 9.0;
  // Share of the support's cells that must be seen.
  double min_support_ratio = 0.6;
  // Cells with a larger deviation of elevation are as good as unseen.
  double max_standard_deviation_m = 1.0;

  void Check() const;
};

// Limits that make a cell a hazard; from the aircraft.
struct HazardLimits {
  double max_slope_deg = 8.0;
  double max_roughness_m = 0.5;
};

// Fine mask of one view, in image coordinates, for projection into the map.
struct GrassView {
  Rigid3d world_from_camera;
  // Of the full-size image.
  Camera camera;
  // Working size: 0 = not classified (edges, dark, unsure), else 1 + round(254 * probability).
  cv::Mat1b mask;
  double image_px_per_mask_px = 1.0;
};

enum Hazard : uint8_t { kFree = 0, kHazard = 1, kUnseen = 2 };

struct HazardLayers {
  Grid grid;
  // Radians; NaN where unseen.
  cv::Mat1f slope;
  // Terrain ruggedness index (Riley): root of summed squared differences to 8 neighbours, metres.
  cv::Mat1f roughness;
  // Posterior probability of grass; NaN where no view classified the cell.
  cv::Mat1f grass;
  // Hazard values.
  cv::Mat1b hazard;
  // Metres from the cell's centre to the nearest centre of a cell that is not kFree; the outside of
  // the grid is unseen, so it counts.
  cv::Mat1f distance;
};

HazardLayers AssessHazards(const ElevationMap& map,
                           const std::vector<GrassView>& grass_views,
                           const HazardLimits& limits,
                           const HazardOptions& options);

// hazard and distance anew for other limits, from the layers that do not depend on them.
HazardLayers WithLimits(const ElevationMap& map,
                        const HazardLayers& layers,
                        const HazardLimits& limits,
                        const HazardOptions& options);

}  // namespace freelsd
