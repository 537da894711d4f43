#include "engine/check/check.h"
#include "engine/selection/selection.h"

namespace freelsd {

void BackendOptions::Check() const {
  const FieldCheck check("backend");
  check.Require(
      backend_period_frames >= 1, "backend_period_frames", backend_period_frames, "must be >= 1");
  check.Require(num_backend_candidates >= 1,
                "num_backend_candidates",
                num_backend_candidates,
                "must be >= 1");
  check.Inside("max_surroundings_m", max_surroundings_m, 0.0, 2000.0);
  check.Inside("max_group_extent_m", max_group_extent_m, 0.0, 3000.0);
  check.Inside("max_num_map_sites", max_num_map_sites, 0, 1000);
  check.Inside("map_site_extent_m", map_site_extent_m, 10.0, 10000.0);
  check.Require(max_num_views >= 2, "max_num_views", max_num_views, "must be >= 2");
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
