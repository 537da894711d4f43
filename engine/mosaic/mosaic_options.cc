#include "engine/check/check.h"
#include "engine/mosaic/mosaic.h"

namespace freelsd {

void MosaicOptions::Check() const {
  const FieldCheck check("mosaic");
  check.Inside("min_pixel_size_m", min_pixel_size_m, 0.001, 100.0);
  check.Inside("tile_size_px", tile_size_px, 64.0, 4096.0);
  check.Require((tile_size_px & (tile_size_px - 1)) == 0,
                "tile_size_px",
                tile_size_px,
                "must be a power of two");
  check.Inside("max_hole_m", max_hole_m, 0.0, 50.0);
  check.Inside("height_smoothing_m", height_smoothing_m, 0.0, 50.0);
  check.Inside("seam_cell_size_m", seam_cell_size_m, 0.01, 100.0);
  check.Inside("max_num_candidates", max_num_candidates, 1.0, 8.0);
  check.Inside("border_ratio", border_ratio, 0.0, 0.5);
  check.Inside("steepness_cost", steepness_cost, 0.0, 1000.0);
  check.Inside("border_cost", border_cost, 0.0, 1000.0);
  check.Inside("blur_cost", blur_cost, 0.0, 1000.0);
  check.Inside("exposure_cost", exposure_cost, 0.0, 1000.0);
  check.Inside("seam_cost", seam_cost, 0.0, 1000.0);
  check.Inside("hidden_cost", hidden_cost, 0.0, 1000.0);
  check.Inside("hidden_height_m", hidden_height_m, 0.0, 100.0);
  check.Inside("max_num_rounds", max_num_rounds, 0.0, 100.0);
  check.Inside("gain_sd", gain_sd, 0.001, 10.0);
  check.Inside("blend_radius_m", blend_radius_m, 0.0, 100.0);
  check.Inside("max_cache_mb", max_cache_mb, 0.0, 100000.0);
}

}  // namespace freelsd
