#include "server/recall/other_maps/positive_evidence.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "server/recall/other_maps/map_places.h"

namespace freelsd {
namespace {

// Cues of things. The other cues say of what kind the ground is, without a calibrated probability.
constexpr std::string_view kCuesOfThings[] = {"small_object", "fence"};
constexpr double kDeviationPerMedian = 1.4826;

// Of the own heights above those of the later map.
struct Level {
  double shift_m = 0.0;
  // Robust deviation of single cells.
  double spread_m = 0.0;
};

// The later map on the own grid: unseen outside it.
SiteMap OnGridOf(const ElevationMap& own, const ShownGround& later, const Places& in_later) {
  const SiteMap& from = later.rasters.site_map;
  SiteMap on_grid = UnseenRasters(own.grid).site_map;
  for (int row = 0; row < own.grid.num_rows; ++row) {
    for (int col = 0; col < own.grid.num_cols; ++col) {
      const auto cell = from.map.grid.CellAt(in_later(own.grid.CellCenter(row, col)));
      if (!cell) continue;
      on_grid.map.elevation(row, col) = from.map.elevation(*cell);
      on_grid.map.upper(row, col) = from.map.upper(*cell);
      on_grid.map.standard_deviation(row, col) = from.map.standard_deviation(*cell);
      on_grid.map.num_points(row, col) = from.map.num_points(*cell);
      on_grid.layers.slope(row, col) = from.layers.slope(*cell);
      on_grid.layers.roughness(row, col) = from.layers.roughness(*cell);
      on_grid.layers.grass(row, col) = from.layers.grass(*cell);
    }
  }
  return on_grid;
}

std::optional<Level> LevelBetween(const ElevationMap& own,
                                  const ElevationMap& later,
                                  const EvidenceOptions& options) {
  std::vector<float> differences;
  for (int row = 0; row < own.grid.num_rows; ++row) {
    for (int col = 0; col < own.grid.num_cols; ++col) {
      const float difference = own.elevation(row, col) - later.elevation(row, col);
      if (std::isfinite(difference)) differences.push_back(difference);
    }
  }
  if (differences.size() < options.min_num_common_cells) return std::nullopt;
  const float median = ValueAtRank(differences, 0.5);
  for (float& difference : differences) difference = std::abs(difference - median);
  return Level{median, kDeviationPerMedian * ValueAtRank(differences, 0.5)};
}

double Squared(double value) { return value * value; }

double KnownOr0(double value) { return std::isfinite(value) ? value : 0.0; }

// Least difference of heights that is a change.
cv::Mat1f Tolerances(const ElevationMap& own,
                     const SiteMap& later,
                     double later_tilt_sd_deg,
                     const Level& level,
                     const EvidenceOptions& options) {
  const Eigen::Vector2d middle = MiddleOf(own.grid);
  const double tilt = RadFromDeg(std::hypot(own.tilt_sd_deg, later_tilt_sd_deg));
  cv::Mat1f tolerances(own.elevation.size());
  for (int row = 0; row < own.grid.num_rows; ++row) {
    for (int col = 0; col < own.grid.num_cols; ++col) {
      // Where the later deviation is unknown, so is the height: NaN is no change.
      const double told = Squared(KnownOr0(own.standard_deviation(row, col))) +
                          Squared(later.map.standard_deviation(row, col)) +
                          Squared(tilt * (own.grid.CellCenter(row, col) - middle).norm());
      tolerances(row, col) = static_cast<float>(options.height_sigma *
                                                std::sqrt(std::max(told, Squared(level.spread_m))));
    }
  }
  return tolerances;
}

// What the upper height may hold besides what was measured.
float AllowanceOf(const SiteMap& later) {
  const CoverOptions cover;
  const double added = std::max(cover.photo.narrow_cover_allowance_m, cover.photo.lone_allowance_m);
  return static_cast<float>(cover.upper_margin_m + (later.map.is_compared ? added : 0.0));
}

int NumCells(double length_m, const Grid& grid) {
  return static_cast<int>(std::ceil(length_m / grid.cell_size_m - 1e-9));
}

// Without parts that are smaller than what can be told from outliers.
cv::Mat1b LargeParts(const cv::Mat1b& mask, const Grid& grid, const EvidenceOptions& options) {
  const int side =
      std::max(1, static_cast<int>(std::lround(options.min_size_m / grid.cell_size_m)));
  cv::Mat1b large;
  cv::morphologyEx(mask,
                   large,
                   cv::MORPH_OPEN,
                   cv::getStructuringElement(cv::MORPH_RECT, {side, side}),
                   cv::Point(-1, -1),
                   1,
                   cv::BORDER_CONSTANT,
                   cv::Scalar::all(0));
  return large;
}

// Both maps on one grid, the later one levelled.
struct Pair {
  const SiteMap& own;
  SiteMap later;
  cv::Mat1f tolerance;
  // How far the same ground may lie apart on the two.
  int shift_cells = 0;
};

// Where something stands that did not, or is gone that was there.
cv::Mat1b ChangedHeights(const Pair& pair, const EvidenceOptions& options) {
  const ElevationMap& own = pair.own.map;
  const ElevationMap& later = pair.later.map;
  const cv::Mat1f highest = HighestWithin(own.upper, pair.shift_cells);
  const cv::Mat1f lowest = -HighestWithin(-own.elevation, pair.shift_cells);
  const float allowance = AllowanceOf(pair.later);
  cv::Mat1b stands(own.elevation.size(), uchar{0}), dug(own.elevation.size(), uchar{0});
  for (int row = 0; row < stands.rows; ++row) {
    for (int col = 0; col < stands.cols; ++col) {
      if (highest(row, col) == kNoGround) continue;
      const float most = highest(row, col) + pair.tolerance(row, col);
      const bool is_higher =
          later.elevation(row, col) > most || later.upper(row, col) > most + allowance;
      if (is_higher) stands(row, col) = 255;
      const bool is_lower = later.elevation(row, col) < lowest(row, col) - pair.tolerance(row, col);
      if (is_lower) dug(row, col) = 255;
    }
  }
  return LargeParts(stands, own.grid, options) | LargeParts(dug, own.grid, options);
}

bool AreLikeTraining(const MapRasters& later, const EvidenceOptions& options) {
  const auto views = std::find_if(later.cues.begin(), later.cues.end(), [](const CueLayer& cue) {
    return cue.name == "views";
  });
  if (views == later.cues.end()) return false;
  const int8_t least = CueStepOf(static_cast<float>(
      std::log(options.min_grass_probability / (1.0 - options.min_grass_probability))));
  size_t num_seen = 0, num_recognised = 0;
  const cv::Mat1f& elevation = later.site_map.map.elevation;
  for (int row = 0; row < elevation.rows; ++row) {
    for (int col = 0; col < elevation.cols; ++col) {
      if (std::isnan(elevation(row, col))) continue;
      ++num_seen;
      const int8_t step = views->steps(row, col);
      if (step >= least && step != CueSteps::kUnknown) ++num_recognised;
    }
  }
  return static_cast<double>(num_recognised) >=
         options.min_recognised_ratio * static_cast<double>(num_seen);
}

// Where cues of the later map say that a thing stands, and the own map recognised grass all around.
cv::Mat1b NewThings(const Pair& pair,
                    const ShownGround& later,
                    const Places& in_later,
                    const EvidenceOptions& options) {
  const Grid& grid = pair.own.map.grid;
  cv::Mat1b things(grid.num_rows, grid.num_cols, uchar{0});
  if (!AreLikeTraining(later.rasters, options)) return things;
  cv::Mat1f unfit = -pair.own.layers.grass;
  cv::patchNaNs(unfit, 0.0);
  unfit = HighestWithin(unfit, pair.shift_cells);
  for (const CueLayer& cue : later.rasters.cues) {
    if (std::find(std::begin(kCuesOfThings), std::end(kCuesOfThings), cue.name) ==
        std::end(kCuesOfThings)) {
      continue;
    }
    for (int row = 0; row < grid.num_rows; ++row) {
      for (int col = 0; col < grid.num_cols; ++col) {
        const auto cell =
            later.rasters.site_map.map.grid.CellAt(in_later(grid.CellCenter(row, col)));
        if (!cell || cue.steps(*cell) != CueSteps::kVeto) continue;
        if (-unfit(row, col) >= pair.own.layers.min_grass_posterior) things(row, col) = 255;
      }
    }
  }
  return things;
}

void CopyKnown(const cv::Mat1f& from, const cv::Mat1b& where, cv::Mat1f& to) {
  from.copyTo(to, where & (from == from));
}

// The own map with the cells that have changed.
SiteMap Changed(const Pair& pair, const cv::Mat1b& heights, const cv::Mat1b& things) {
  SiteMap changed{pair.own.map, pair.own.layers};
  for (cv::Mat1f* const layer : {&changed.map.elevation,
                                 &changed.map.upper,
                                 &changed.map.standard_deviation,
                                 &changed.layers.slope,
                                 &changed.layers.roughness,
                                 &changed.layers.grass}) {
    *layer = layer->clone();
  }
  CopyKnown(pair.later.map.elevation, heights, changed.map.elevation);
  CopyKnown(pair.later.map.upper, heights, changed.map.upper);
  CopyKnown(pair.later.map.standard_deviation, heights, changed.map.standard_deviation);
  CopyKnown(pair.later.layers.slope, heights, changed.layers.slope);
  CopyKnown(pair.later.layers.roughness, heights, changed.layers.roughness);
  CopyKnown(pair.later.layers.grass, heights, changed.layers.grass);
  changed.layers.grass.setTo(0.0f, things);
  return changed;
}

// What stands at least where the own map saw nothing: the later map's heights without its classes.
// Elsewhere the ground is the own map's, at the later one's level; unseen if the level is unknown.
SiteMap BeyondOwn(const SiteMap& own,
                  const ShownGround& later,
                  const Places& in_own,
                  const std::optional<Level>& level,
                  int shift_cells,
                  const EvidenceOptions& options) {
  const SiteMap& from = later.rasters.site_map;
  const cv::Mat1f nearby = HighestWithin(own.map.upper, shift_cells);
  const float shift = level ? static_cast<float>(level->shift_m) : std::nanf("");
  SiteMap beyond = from;
  beyond.layers.slope = cv::Mat1f(from.map.elevation.size(), 0.0f);
  beyond.layers.roughness = cv::Mat1f(from.map.elevation.size(), 0.0f);
  beyond.layers.grass = cv::Mat1f(from.map.elevation.size(), 1.0f);
  cv::Mat1f elevation = from.map.elevation.clone();
  // A matrix of its own: an expression would be written into the shared one.
  cv::Mat1f upper = from.map.upper -
                    static_cast<float>(options.height_sigma) * from.map.standard_deviation -
                    AllowanceOf(from);
  upper = cv::max(upper, elevation);
  for (int row = 0; row < from.map.grid.num_rows; ++row) {
    for (int col = 0; col < from.map.grid.num_cols; ++col) {
      const auto cell = own.map.grid.CellAt(in_own(from.map.grid.CellCenter(row, col)));
      if (!cell || nearby(*cell) == kNoGround) continue;
      elevation(row, col) = upper(row, col) = own.map.elevation(*cell) - shift;
    }
  }
  beyond.map.elevation = elevation;
  beyond.map.upper = upper;
  return beyond;
}

double DeviationOf(const ElevationMap& map, const StoredPlan& plan) {
  return std::max(KnownOr0(map.position_sd_m),
                  plan.replan.flight.options.approach.min_map_position_sd_m);
}

std::optional<PlanCheck> BrokenByChangesIn(const StoredPlan& plan,
                                           Pair pair,
                                           const Level& level,
                                           const ShownGround& later,
                                           const Places& in_later,
                                           const EvidenceOptions& options) {
  const ElevationMap& own = pair.own.map;
  const ElevationMap& later_map = later.rasters.site_map.map;
  pair.later.map.is_compared = later_map.is_compared;
  pair.tolerance = Tolerances(own, pair.later, later_map.tilt_sd_deg, level, options);
  pair.later.map.elevation += static_cast<float>(level.shift_m);
  pair.later.map.upper += static_cast<float>(level.shift_m);
  const cv::Mat1b things = NewThings(pair, later, in_later, options);
  return BrokenByChanges(plan, pair.own, Changed(pair, ChangedHeights(pair, options), things));
}

}  // namespace

std::optional<PlanCheck> BrokenByEvidence(const StoredPlan& plan,
                                          const ShownGround& own,
                                          const ShownGround& later,
                                          const EvidenceOptions& options) {
  const SiteMap& own_map = own.rasters.site_map;
  const ElevationMap& map = own_map.map;
  const ElevationMap& later_map = later.rasters.site_map.map;
  if (map.elevation.empty() || later_map.elevation.empty()) return std::nullopt;
  const double shift_m =
      options.height_sigma * std::hypot(DeviationOf(map, plan), DeviationOf(later_map, plan));
  if (shift_m > options.max_shift_m) return std::nullopt;
  const LocalFrame own_frame(own.origin), later_frame(later.origin);
  const int shift_cells = NumCells(shift_m, map.grid);
  const Places in_later(own_frame, later_frame, MiddleOf(map.grid));
  Pair pair{own_map, OnGridOf(map, later, in_later), {}, shift_cells};
  const std::optional<Level> level = LevelBetween(map, pair.later.map, options);
  if (level) {
    if (auto broken = BrokenByChangesIn(plan, std::move(pair), *level, later, in_later, options)) {
      return broken;
    }
  }
  const Places in_own(later_frame, own_frame, MiddleOf(later_map.grid));
  const PlanCheck beyond =
      CheckPlan(plan, later.origin, BeyondOwn(own_map, later, in_own, level, shift_cells, options));
  return beyond.verdict == PlanVerdict::kFails ? std::optional(beyond) : std::nullopt;
}

}  // namespace freelsd
