#include "engine/cover/cover.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <opencv2/core/utility.hpp>

#include "engine/cover/fences.h"
#include "engine/cover/kind_fusion.h"
#include "engine/cover/look_alikes.h"
#include "engine/cover/open_cover.h"
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

CueLayer LayerOf(const char* name, const cv::Mat1f& log_odds) {
  CueLayer layer{name, cv::Mat_<int8_t>(log_odds.size())};
  std::transform(log_odds.begin(), log_odds.end(), layer.steps.begin(), CueStepOf);
  return layer;
}

// The posterior of the views as log-odds.
cv::Mat1f LogOddsOf(const cv::Mat1f& probability) {
  cv::Mat1f log_odds(probability.size());
  std::transform(probability.begin(), probability.end(), log_odds.begin(), [](float p) {
    return std::log(p / (1.0f - p));
  });
  return log_odds;
}

// The likeliest kind of each cell, with the rules applied. `other`: of the kinds beside grass.
cv::Mat1b LikeliestKinds(const cv::Mat1f& grass, const cv::Mat1b& other) {
  constexpr float kLikelier = 0.5f;
  cv::Mat1b kinds = other.clone();
  for (int row = 0; row < kinds.rows; ++row) {
    for (int col = 0; col < kinds.cols; ++col) {
      if (!(grass(row, col) >= kLikelier)) continue;
      kinds(row, col) = LikelyKind{GroundKind::kGrass, grass(row, col)}.Packed();
    }
  }
  return kinds;
}

// Rules deny grass one after the other, and are noted.
class Denials {
 public:
  explicit Denials(GroundCover& cover) : cover_(cover) {}

  void Deny(const char* name, const cv::Mat1b& denied) {
    if (denied.empty()) return;
    cover_.grass.setTo(0.0f, denied);
    cover_.cues.push_back({name, cv::Mat_<int8_t>::zeros(denied.size())});
    cover_.cues.back().steps.setTo(CueSteps::kVeto, denied);
  }

 private:
  GroundCover& cover_;
};

struct CoverInput {
  const ElevationMap& map;
  const GroundSurface& surface;
  const std::vector<KindView>& kind_views;
  const Orthophoto& photo;
};

// Grass by the views, and by rules, each of which has a veto.
void AddGrassByRules(const CoverInput& input,
                     const CoverOptions& options,
                     MeadowCells& cells,
                     GroundCover& cover) {
  const ElevationMap& map = input.map;
  const Orthophoto& photo = input.photo;
  std::tie(cover.grass, cover.kind) = FuseKinds(map, input.kind_views, options, photo);
  cover.cues.push_back(LayerOf("views", LogOddsOf(cover.grass)));
  cv::Mat1b look_alikes;
  cv::parallel_for_({0, 2}, [&](const cv::Range& steps) {
    for (int step = steps.start; step < steps.end; ++step) {
      if (step == 0) cells.objects = FindSmallObjects(photo, map.grid, options);
      if (step == 1)
        look_alikes = FindLookAlikes(photo, map.grid, {cover.grass, cover.kind}, options);
    }
  });
  Denials denials(cover);
  denials.Deny("look_alike", look_alikes);
  // Fences and objects are still part of their meadow here.
  cells.is_meadow = cover.grass >= options.min_grass_posterior;
  denials.Deny("small_object", cells.objects);
  if (photo.image.empty() || options.min_fence_deviations == 0.0) return;
  const cv::Mat1b is_even = EvenGrass(map, input.surface, cover.grass, options);
  denials.Deny("fence", FindFences(photo, is_even, map.grid, options));
}

}  // namespace

int8_t CueStepOf(float log_odds) {
  if (std::isnan(log_odds)) return CueSteps::kUnknown;
  constexpr float kMost = CueSteps::kMost;
  return static_cast<int8_t>(std::lround(std::clamp(log_odds / CueSteps::kLogOdds, -kMost, kMost)));
}

GroundCover AssessCover(const ElevationMap& map,
                        const GroundSurface& surface,
                        const std::vector<KindView>& kind_views,
                        const CoverOptions& options,
                        Orthophoto photo) {
  options.Check();
  GroundCover cover;
  if (map.elevation.empty()) {
    std::tie(cover.grass, cover.kind) = FuseKinds(map, kind_views, options, photo);
    return cover;
  }
  const cv::Mat1f disagreement = PhotoDisagreement(photo, map.grid);
  // Nothing else needs it, and the other steps need its memory.
  photo.second_image.release();
  photo.second_seen.release();
  MeadowCells cells;
  AddGrassByRules({map, surface, kind_views, photo}, options, cells, cover);
  cover.kind = LikeliestKinds(cover.grass, cover.kind);
  cells.is_clear_class = cover.grass >= options.clear_class.min_clear_class_posterior;
  cells.is_meadow |= cells.is_clear_class;
  cover.open = FindOpenCover(disagreement, map.grid, cells, options.photo);
  return cover;
}

}  // namespace freelsd
