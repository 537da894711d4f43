// Input: the frames of a flight. Output: the map and all that kinds of ground are told by, before
// any rule of the cover.
#pragma once

#include "engine/pipeline.h"
#include "tests/evaluation/kinds/kind_cells.h"

namespace freelsd {

struct GroundRun {
  Evaluation evaluation;
  std::vector<GrassView> grass_views;
  Orthophoto photo;
};

// Without sites. The heights are those before photographs were compared.
GroundRun RunGround(const Rig& rig,
                    const std::vector<Frame>& frames,
                    const Classifier& classifier,
                    const PipelineOptions& options);

std::array<cv::Mat1f, kNumCues> CuesOf(const GroundRun& run, const PipelineOptions& options);

}  // namespace freelsd
