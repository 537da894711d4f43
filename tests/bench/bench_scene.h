// A short flight over a synthetic farm: what the stages are measured on.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/pipeline.h"
#include "tests/synthetic/world.h"

namespace freelsd {

struct BenchScene {
  // What there is to see.
  std::shared_ptr<const World> world;
  Rig rig;
  // 752x480, 100 m above ground, 13 m apart: a video, so corners are followed, but for the leap
  // from one leg to the next.
  std::vector<Frame> frames;
  PipelineOptions options;
  // What the frontend made of them.
  Snapshot snapshot;
  AdjustedBlock block;
  StereoPair pair;
};

// The first leg's.
constexpr int kNumFramesOfLeg = 6;
// Made once, at the first call. Height above ground of its frames, metres:
constexpr double kBenchHeightM = 100.0;
const BenchScene& Scene(const std::string& model_file);

std::string SizeOf(const cv::Mat& image);

}  // namespace freelsd
