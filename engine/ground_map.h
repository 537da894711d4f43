// Input: adjusted block, images. Output: elevation map, by pairs of photographs, and its layers.
// Paper: III-F, G.
#pragma once

#include <functional>
#include <vector>

#include "engine/selection/selection.h"

namespace freelsd {

// Of the seen part of the area; an empty map if nothing was seen. `progress` is called with the
// share of pairs that are done, and may throw.
ElevationMap ReconstructMap(const AdjustedBlock& block,
                            const Box& area,
                            const ImageSource& images,
                            const PipelineOptions& options,
                            const std::function<void(double done_ratio)>& progress,
                            std::vector<StageReport>& reports);

struct GroundLayers {
  ElevationMap map;
  HazardLayers hazards;
  std::vector<CueLayer> cues;
  cv::Mat1b num_views;
};
struct GroundPhotos {
  const AdjustedBlock& block;
  const std::vector<KindView>& kind_views;
  const ImageSource& images;
};
// Completes the map and computes its layers: shape of the ground, cover and hazard.
GroundLayers AssessGround(const ElevationMap& map,
                          const GroundPhotos& photos,
                          const Aircraft& aircraft,
                          HazardOptions options,
                          std::vector<StageReport>& reports);

}  // namespace freelsd
