#include "tests/evaluation/proof/cell_proof.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

// The block as if the other photographs had never been taken; the poses are held.
AdjustedBlock Restricted(const AdjustedBlock& whole, const std::vector<size_t>& views) {
  AdjustedBlock block = whole;
  std::vector<bool> is_used(whole.views.size(), false), is_seen(whole.landmarks.size(), false);
  for (const size_t view : views) is_used[view] = true;
  for (size_t i = 0; i < block.views.size(); ++i) {
    AdjustedView& view = block.views[i];
    view.is_connected = view.is_connected && is_used[i];
    if (!view.is_connected) view.landmarks.clear();
    for (const size_t landmark : view.landmarks) is_seen[landmark] = true;
  }
  std::vector<size_t> places(whole.landmarks.size(), 0);
  block.landmarks.clear();
  for (size_t i = 0; i < whole.landmarks.size(); ++i) {
    places[i] = block.landmarks.size();
    if (is_seen[i]) block.landmarks.push_back(whole.landmarks[i]);
  }
  for (AdjustedView& view : block.views) {
    for (size_t& landmark : view.landmarks) landmark = places[landmark];
  }
  return block;
}

bool IsSame(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

std::vector<std::string> Different(const CellLayers& a, const CellLayers& b) {
  std::vector<std::string> names;
  for (const auto& [name, value] : a) {
    const auto other = b.find(name);
    if (other == b.end() || !IsSame(value, other->second)) names.push_back(name);
  }
  return names;
}

}  // namespace

CellLayers LayersAt(const ElevationMap& map,
                    const HazardLayers& hazards,
                    const std::vector<CueLayer>& cues,
                    const cv::Mat1b& num_views,
                    const cv::Point& cell) {
  CellLayers layers{{"elevation", map.elevation(cell)},
                    {"upper", map.upper(cell)},
                    {"standard_deviation", map.standard_deviation(cell)},
                    {"num_points", map.num_points(cell)},
                    {"slope", hazards.slope(cell)},
                    {"roughness", hazards.roughness(cell)},
                    {"grass", hazards.grass(cell)},
                    {"hazard", hazards.hazard(cell)},
                    {"distance", hazards.distance(cell)},
                    {"coverage", num_views(cell)}};
  for (const CueLayer& cue : cues) layers["cue " + cue.name] = cue.steps(cell);
  return layers;
}

CellProver::CellProver(const EngineRun& run,
                       const Aircraft& aircraft,
                       const PipelineOptions& options,
                       const ImageSource& images)
    : run_(run),
      aircraft_(aircraft),
      options_(options),
      images_(images),
      pairs_(SelectPairs(run.evaluation.block, options.stereo)),
      snapshot_indices_(
          SelectViews(
              run.snapshot, PhotographedArea(run.snapshot), options.adjustment, options.backend)
              .indices) {}

std::vector<Points> CellProver::PointsOf(const AdjustedBlock& block,
                                         std::span<const StereoPair> pairs) {
  std::vector<Points> all;
  for (const StereoPair& pair : pairs) {
    const std::pair key(pair.left, pair.right);
    const std::lock_guard lock(mutex_);
    auto found = points_.find(key);
    if (found == points_.end()) {
      const cv::Mat left = images_(block.views[pair.left].frame_id);
      const cv::Mat right = images_(block.views[pair.right].frame_id);
      found =
          points_.emplace(key, ReconstructPoints(block, pair, left, right, options_.stereo)).first;
    }
    all.push_back(found->second);
  }
  return all;
}

CellLayers CellProver::Again(const Eigen::Vector2d& place_in_world,
                             const std::vector<size_t>& views,
                             double context_m) {
  const AdjustedBlock block = Restricted(run_.evaluation.block, views);
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(context_m);
  std::vector<StageReport> reports;
  const ElevationMap map = FuseMap(
      block,
      {place_in_world - reach, place_in_world + reach},
      images_,
      options_,
      [this](const AdjustedBlock& of_block, std::span<const StereoPair> pairs) {
        return PointsOf(of_block, pairs);
      },
      reports);
  const auto cell = map.grid.CellAt(place_in_world);
  if (!cell) return {};
  const std::vector<GrassView> grass_views =
      AdjustedGrassViews(run_.snapshot, snapshot_indices_, block);
  const GroundLayers ground =
      AssessGround(map, {block, grass_views, images_}, aircraft_, options_.hazard, reports);
  return LayersAt(ground.map, ground.hazards, ground.cues, ground.num_views, *cell);
}

CellProof CellProver::Prove(const cv::Point& cell, const ProvenanceOptions& provenance) {
  const Evaluation& evaluation = run_.evaluation;
  CellProof proof;
  proof.place_in_world = evaluation.map.grid.CellCenter(cell.y, cell.x);
  const Eigen::Vector3d place(
      proof.place_in_world.x(), proof.place_in_world.y(), evaluation.map.elevation(cell));
  const double hazard_distance_m = evaluation.hazards.distance(cell);
  const Provenance named =
      ProvenanceOf(place, evaluation.block, pairs_, hazard_distance_m, provenance);
  proof.num_sources = named.sources.size();
  proof.num_context = named.context.size();
  const CellLayers whole =
      LayersAt(evaluation.map, evaluation.hazards, evaluation.cues, evaluation.num_views, cell);
  std::vector<size_t> views = named.context;
  for (const SourceView& source : named.sources) views.push_back(source.view);
  const double context_m = provenance.ContextFor(hazard_distance_m);
  proof.changed = Different(whole, Again(proof.place_in_world, views, context_m));
  if (named.sources.empty()) return proof;
  proof.largest_weight = named.sources.front().weight;
  std::erase(views, named.sources.front().view);
  proof.changed_without = Different(whole, Again(proof.place_in_world, views, context_m));
  return proof;
}

}  // namespace freelsd
