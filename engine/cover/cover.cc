#include "engine/cover/cover.h"

#include <opencv2/core/utility.hpp>

#include "engine/cover/fences.h"
#include "engine/cover/grass.h"
#include "engine/cover/kind/kind.h"
#include "engine/cover/look_alikes.h"
#include "engine/cover/open_cover.h"
#include "engine/cover/overreach.h"
#include "engine/cover/raised_fields.h"
#include "engine/cover/small_objects.h"

namespace freelsd {
namespace {

// Grass on even ground. The limits are fixed and do not depend on the aircraft. Comparisons are
// written so that NaN fails them.
cv::Mat1b EvenGrass(const ElevationMap& map,
                    const GroundSurface& surface,
                    const cv::Mat1f& grass,
                    const CoverOptions& options) {
  const double max_slope = RadFromDeg(options.max_even_slope_deg - map.tilt_sd_deg);
  const double max_excess = options.max_even_roughness_m + options.upper_margin_m;
  cv::Mat1b is_even(grass.size(), uint8_t{0});
  for (int row = 0; row < is_even.rows; ++row) {
    for (int col = 0; col < is_even.cols; ++col) {
      const bool is_free = grass(row, col) >= options.min_grass_posterior &&
                           surface.slope(row, col) <= max_slope &&
                           surface.roughness(row, col) <= options.max_even_roughness_m &&
                           map.upper(row, col) - map.elevation(row, col) <= max_excess;
      if (is_free) is_even(row, col) = 255;
    }
  }
  return is_even;
}

// Grass without closed crops, overreach of segments and fences.
cv::Mat1f WithoutSoftBorders(const ElevationMap& map,
                             const GroundSurface& surface,
                             const cv::Mat1f& called_grass,
                             const CoverOptions& options,
                             const Orthophoto& photo) {
  cv::Mat1f grass = called_grass.clone();
  const cv::Mat1b is_even = EvenGrass(map, surface, grass, options);
  if (options.min_raised_step_m > 0.0) {
    grass.setTo(0.0f, RaisedFields(is_even, surface.elevation, map.grid.cell_size_m, options));
  }
  if (photo.image.empty()) return grass;
  if (options.min_overreach_deviations > 0.0) {
    grass.setTo(0.0f, OverreachingGrass(grass, photo, map.grid, options));
  }
  if (options.min_fence_deviations > 0.0) {
    grass.setTo(0.0f, FindFences(photo, is_even, map.grid, options));
  }
  return grass;
}

// Grass by rules, each of which has a veto.
cv::Mat1f GrassByRules(const ElevationMap& map,
                       const GroundSurface& surface,
                       const std::vector<GrassView>& grass_views,
                       const CoverOptions& options,
                       const Orthophoto& photo,
                       MeadowCells& cells) {
  cv::Mat1f grass = FuseGrass(map, grass_views, options);
  cv::Mat1b look_alikes;
  cv::parallel_for_({0, 2}, [&](const cv::Range& steps) {
    for (int step = steps.start; step < steps.end; ++step) {
      if (step == 0) cells.objects = FindSmallObjects(photo, map.grid, options);
      if (step == 1) look_alikes = FindLookAlikes(photo, map.grid, options);
    }
  });
  if (!look_alikes.empty()) grass.setTo(0.0f, look_alikes);
  // Fences and objects are still part of their meadow here.
  cells.is_meadow = grass >= options.min_grass_posterior;
  if (!cells.objects.empty()) grass.setTo(0.0f, cells.objects);
  return WithoutSoftBorders(map, surface, grass, options, photo);
}

}  // namespace

GroundCover AssessCover(const ElevationMap& map,
                        const GroundSurface& surface,
                        const std::vector<GrassView>& grass_views,
                        const CoverOptions& options,
                        Orthophoto photo) {
  options.Check();
  GroundCover cover;
  if (map.elevation.empty()) {
    cover.grass = FuseGrass(map, grass_views, options);
    return cover;
  }
  const cv::Mat1f disagreement = PhotoDisagreement(photo, map.grid);
  // Nothing else needs it, and the other steps need its memory.
  photo.second_image.release();
  photo.second_seen.release();
  MeadowCells cells;
  if (options.cover_method == CoverMethod::kRules) {
    cover.grass = GrassByRules(map, surface, grass_views, options, photo, cells);
  } else {
    cells.objects = FindSmallObjects(photo, map.grid, options);
    cover.grass = GrassProbability({map, surface, grass_views, photo}, options, ShippedKindModel());
    cells.is_meadow = cover.grass >= options.min_grass_posterior;
  }
  cells.is_clear_class = cover.grass >= options.clear_class.min_clear_class_posterior;
  cells.is_meadow |= cells.is_clear_class;
  cover.open = FindOpenCover(disagreement, map.grid, cells, options.photo);
  return cover;
}

}  // namespace freelsd
