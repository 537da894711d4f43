#include "tests/evaluation/given/given_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "engine/ground_map.h"
#include "engine/mosaic/mosaic.h"
#include "tests/evaluation/given/true_poses.h"

namespace freelsd {
namespace {

constexpr float kGivenDeviationM = 0.05f;
constexpr float kUnknownHeight = std::numeric_limits<float>::quiet_NaN();

struct NamedGiven {
  const char* name;
  bool Given::*is_given;
};
constexpr std::array<NamedGiven, 4> kNamedGiven{{{"poses", &Given::poses},
                                                 {"kinds", &Given::kinds},
                                                 {"heights", &Given::heights},
                                                 {"wind", &Given::wind}}};

void GiveWind(Snapshot& snapshot,
              std::vector<Candidate>& regions,
              const Eigen::Vector2d& wind_in_world) {
  for (WindSample& sample : snapshot.wind_samples) sample.wind_in_world = wind_in_world;
  for (std::vector<Candidate>* candidates : {&snapshot.regions, &regions}) {
    for (Candidate& candidate : *candidates) {
      if (!candidate.wind) continue;
      candidate.wind->wind_in_world = wind_in_world;
      candidate.wind->spread_mps = 0.0;
    }
  }
}

// Up to the map, with true poses.
Evaluation MapWithTruePoses(const Snapshot& snapshot,
                            const Box& area,
                            const ImageSource& images,
                            const GivenTruth& truth,
                            const Aircraft& aircraft,
                            const PipelineOptions& options) {
  Evaluation evaluation;
  const Selection selection = SelectViews(snapshot, area, options.adjustment, options.backend);
  if (selection.views.size() < 2) return evaluation;
  evaluation.block = AdjustAndTie(
      selection.views, snapshot.rig.camera, images, options.tracks, options.adjustment);
  if (!evaluation.block.is_usable) return evaluation;
  evaluation.block = WithTruePoses(std::move(evaluation.block), truth.scenario);
  const ElevationMap map = ReconstructMap(
      evaluation.block, area, images, options, [](double) {}, evaluation.reports);
  const std::vector<KindView> kind_views =
      AdjustedKindViews(snapshot, selection.indices, evaluation.block);
  GroundLayers ground = AssessGround(
      map, {evaluation.block, kind_views, images}, aircraft, options.hazard, evaluation.reports);
  evaluation.map = std::move(ground.map);
  evaluation.hazards = std::move(ground.hazards);
  evaluation.cues = std::move(ground.cues);
  evaluation.num_views = std::move(ground.num_views);
  return evaluation;
}

bool IsInWorld(const Eigen::Vector2d& place, const TruthMap& truth) {
  return place.cwiseAbs().maxCoeff() < 0.5 * truth.size_m;
}

void GiveHeights(Evaluation& evaluation, const GivenTruth& given, const SurfaceOptions& options) {
  const auto& [which, scenario, truth] = given;
  ElevationMap& map = evaluation.map;
  for (int row = 0; row < map.grid.num_rows; ++row) {
    for (int col = 0; col < map.grid.num_cols; ++col) {
      const Eigen::Vector2d place = map.grid.CellCenter(row, col);
      if (!IsInWorld(place, truth)) continue;
      const cv::Point cell = truth.CellAt(place);
      if (scenario.seen(cell) == 0 && !map.IsSeen(row, col)) continue;
      // The height of a leafless tree is unknown, as it is on maps without error.
      const bool is_open = truth.cover(cell) == static_cast<uint8_t>(Cover::kBareTree);
      const World& world = scenario.world;
      map.elevation(row, col) =
          static_cast<float>(is_open ? world.GroundHeight(place.x(), place.y())
                                     : world.SurfaceHeight(place.x(), place.y()));
      map.upper(row, col) = std::max(map.elevation(row, col), truth.top(cell));
      map.standard_deviation(row, col) = is_open ? kUnknownHeight : kGivenDeviationM;
      if (!std::isfinite(map.num_points(row, col))) map.num_points(row, col) = 1.0f;
    }
  }
  map.tilt_sd_deg = 0.0;
  const GroundSurface surface = MeasureSurface(map, options);
  evaluation.hazards.slope = surface.slope;
  evaluation.hazards.roughness = surface.roughness;
  evaluation.num_views = NumViewsOf(map, evaluation.block);
}

void GiveKinds(Evaluation& evaluation, const TruthMap& truth) {
  HazardLayers& layers = evaluation.hazards;
  for (int row = 0; row < layers.grid.num_rows; ++row) {
    for (int col = 0; col < layers.grid.num_cols; ++col) {
      const Eigen::Vector2d place = layers.grid.CellCenter(row, col);
      if (!IsInWorld(place, truth)) continue;
      const Cover cover = static_cast<Cover>(truth.cover(truth.CellAt(place)));
      if (cover == Cover::kDoubt) continue;
      layers.grass(row, col) = cover == Cover::kMeadow ? 1.0f : 0.0f;
    }
  }
}

// Rounded and with hazards, as a finished map is.
void Finish(Evaluation& evaluation, const Aircraft& aircraft, const HazardOptions& options) {
  AssessedMap rounded = Rounded(evaluation.map, evaluation.hazards);
  evaluation.map = std::move(rounded.map);
  evaluation.hazards = WithLimits(
      evaluation.map, rounded.layers, {aircraft.max_slope_deg, aircraft.max_roughness_m}, options);
}

}  // namespace

std::vector<std::string> NamesOfGiven() {
  std::vector<std::string> names;
  names.reserve(kNamedGiven.size());
  for (const auto& [name, is_given] : kNamedGiven) names.emplace_back(name);
  return names;
}

Given Given::Of(const std::vector<std::string>& names) {
  Given given;
  for (const std::string& each : names) {
    const auto named = std::find_if(kNamedGiven.begin(), kNamedGiven.end(), [&](const auto& known) {
      return known.name == each;
    });
    if (named == kNamedGiven.end()) throw std::invalid_argument("--given " + each + ": unknown");
    given.*named->is_given = true;
  }
  return given;
}

EvaluateFlight EvaluateGiven(const GivenTruth& truth, const Aircraft& aircraft) {
  return [truth, &aircraft](Snapshot& snapshot,
                            const RegionGroup& group,
                            const ImageSource& images,
                            const PipelineOptions& options,
                            const Progress& progress) {
    std::vector<Candidate> regions = group.regions;
    const Given& given = truth.given;
    if (given.wind) GiveWind(snapshot, regions, truth.scenario.world.wind_in_world);
    PipelineOptions map_options = options;
    map_options.backend.max_num_map_sites = 0;
    Evaluation evaluation =
        given.poses
            ? MapWithTruePoses(snapshot, group.area, images, truth, aircraft, options)
            : EvaluateSites(snapshot, {{}, group.area}, images, aircraft, map_options, progress);
    evaluation.wind =
        WindAt(0.5 * (group.area.min + group.area.max), snapshot.wind_samples, options.wind);
    if (evaluation.map.elevation.empty()) return evaluation;
    if (given.heights) GiveHeights(evaluation, truth, options.hazard.surface);
    if (given.kinds) GiveKinds(evaluation, truth.truth);
    if (given.heights || given.kinds) Finish(evaluation, aircraft, options.hazard);
    PlanOnMap(snapshot, regions, aircraft, options, evaluation);
    return evaluation;
  };
}

}  // namespace freelsd
