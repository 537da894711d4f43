#include "tests/evaluation/heights/height_run.h"

#include <chrono>
#include <utility>

#include "tests/evaluation/site_score.h"
#include "tests/evaluation/stage_scores.h"

namespace freelsd {
namespace {

double SquareMetresSeen(const ElevationMap& map) {
  const cv::Mat1b is_seen = map.elevation == map.elevation;
  return cv::countNonZero(is_seen) * map.grid.cell_size_m * map.grid.cell_size_m;
}

void CountSites(const HeightRun& run, const Evaluation& evaluation, MethodResult& result) {
  for (const Site& site : evaluation.sites) {
    if (site.plan.verdict == Verdict::kRejected) continue;
    ++result.num_accepted;
    const auto score = ScorePlan(
        run.scenario.world, run.truth, run.scenario.aircraft, site.plan, Eigen::Vector2d::Zero());
    const Verdict verdict = site.plan.verdict;
    result.num_false_safe += score && score->IsFalseSafe(verdict) && !score->IsOnlyThin(verdict);
  }
}

MethodResult ResultOf(const HeightRun& run, const Evaluation& evaluation, double seconds) {
  EngineRun as_run;
  as_run.evaluation = evaluation;
  MapOffset offset = run.offset;
  offset.height = ScoreMap(as_run, run.scenario, run.truth).detilted.plane;
  MethodResult result;
  result.score = ScoreHeights(run.scenario, run.truth, evaluation.map, evaluation.hazards, offset);
  result.total_seconds = seconds;
  result.hectares = SquareMetresSeen(evaluation.map) / 1e4;
  CountSites(run, evaluation, result);
  for (const StageReport& report : evaluation.reports) {
    result.seconds[report.stage] += report.seconds;
  }
  return result;
}

MapOffset OffsetOf(const HeightRun& run) {
  const PoseScore poses = ScorePoses(run.pairs, run.scenario);
  const MapScore map = ScoreMap(run.pairs, run.scenario, run.truth);
  return OffsetOfMap(run.scenario.world,
                     run.truth,
                     run.pairs.evaluation.map,
                     map.detilted.plane,
                     poses.shift.head<2>());
}

std::map<std::string, cv::Mat> ImagesOf(const Scenario& scenario) {
  std::map<std::string, cv::Mat> images;
  for (const Frame& frame : scenario.frames) images[frame.id] = frame.image;
  return images;
}

// The backend once more, on what the frontend of the first run left.
Evaluation EvaluateByPhotographs(const HeightRun& run, PipelineOptions options) {
  options.heights.method = HeightMethod::kPhotographs;
  const std::map<std::string, cv::Mat> images = ImagesOf(run.scenario);
  const ImageSource source = [&images](const std::string& id) { return images.at(id); };
  std::vector<Candidate> graded;
  for (const Candidate& candidate : run.pairs.snapshot.regions) {
    if (candidate.region.grade > 0.0) graded.push_back(candidate);
  }
  return EvaluateSites(run.pairs.snapshot,
                       {graded, PhotographedArea(run.pairs.snapshot)},
                       source,
                       run.scenario.aircraft,
                       options,
                       {});
}

}  // namespace

void MethodResult::Add(const MethodResult& other) {
  score.Add(other.score);
  for (const auto& [stage, stage_seconds] : other.seconds) seconds[stage] += stage_seconds;
  total_seconds += other.total_seconds;
  hectares += other.hectares;
  num_accepted += other.num_accepted;
  num_false_safe += other.num_false_safe;
}

HeightRun RunHeights(uint64_t seed,
                     const ScenarioOptions& scenario,
                     const PipelineOptions& options,
                     const Classifier& classifier) {
  HeightRun run;
  run.scenario = MakeScenario(seed, scenario, [](double) {});
  run.truth = MakeTruthMap(run.scenario.world, run.scenario.aircraft);
  PipelineOptions by_pairs = options;
  by_pairs.heights.method = HeightMethod::kPairs;
  run.pairs = RunEngine({run.scenario.rig, run.scenario.frames, run.scenario.aircraft},
                        by_pairs,
                        classifier,
                        [](double, const std::string&) { return true; });
  run.offset = OffsetOf(run);
  const auto start = std::chrono::steady_clock::now();
  run.photographs = EvaluateByPhotographs(run, options);
  const std::chrono::duration<double> backend = std::chrono::steady_clock::now() - start;
  const std::map<std::string, cv::Mat> images = ImagesOf(run.scenario);
  const ImageSource source = [&images](const std::string& id) { return images.at(id); };
  run.heights =
      MeasureHeights(run.pairs.evaluation.map, run.pairs.evaluation.block, source, options.heights);
  run.results[HeightMethod::kPairs] = ResultOf(run, run.pairs.evaluation, run.pairs.total_seconds);
  run.results[HeightMethod::kPhotographs] =
      ResultOf(run, run.photographs, run.pairs.frontend_seconds + backend.count());
  return run;
}

}  // namespace freelsd
