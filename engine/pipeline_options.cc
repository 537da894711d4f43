#include <stdexcept>
#include <string>

#include "engine/pipeline.h"

namespace freelsd {

void BackendOptions::Check() const {
  const auto require = [](bool holds, const std::string& message) {
    if (!holds) throw std::invalid_argument("backend." + message);
  };
  require(backend_period_frames >= 1,
          "backend_period_frames = " + std::to_string(backend_period_frames) + ": must be >= 1");
  require(num_backend_candidates >= 1,
          "num_backend_candidates = " + std::to_string(num_backend_candidates) + ": must be >= 1");
  require(max_surroundings_m >= 0.0 && max_surroundings_m <= 2000.0,
          "max_surroundings_m = " + std::to_string(max_surroundings_m) + ": must be in [0, 2000]");
  require(max_group_extent_m >= 0.0 && max_group_extent_m <= 3000.0,
          "max_group_extent_m = " + std::to_string(max_group_extent_m) + ": must be in [0, 3000]");
  require(max_num_further_fields >= 0 && max_num_further_fields <= 1000,
          "max_num_further_fields = " + std::to_string(max_num_further_fields) +
              ": must be in [0, 1000]");
  require(further_field_extent_m >= 10.0 && further_field_extent_m <= 10000.0,
          "further_field_extent_m = " + std::to_string(further_field_extent_m) +
              ": must be in [10, 10000]");
  require(max_num_views >= 2,
          "max_num_views = " + std::to_string(max_num_views) + ": must be >= 2");
}

void PipelineOptions::Check() const {
  tracks.Check();
  segmentation.Check();
  classification.Check();
  regions.Check();
  wind.Check();
  adjustment.Check();
  stereo.Check();
  terrain.Check();
  hazard.Check();
  approach.Check();
  backend.Check();
}

}  // namespace freelsd
