#include "tests/evaluation/engine_run.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <string>

namespace freelsd {
namespace {

// Share of an engine's time that the frontend takes, for the progress bar.
constexpr double kFrontendShare = 0.3;

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::vector<Candidate> Graded(const std::vector<Candidate>& regions) {
  std::vector<Candidate> graded;
  for (const Candidate& candidate : regions) {
    if (candidate.region.grade > 0.0) graded.push_back(candidate);
  }
  return graded;
}

int CountProcessed(const std::vector<FrameResult>& results) {
  return static_cast<int>(std::count_if(
      results.begin(), results.end(), [](const auto& result) { return result.is_processed; }));
}

}  // namespace

std::map<std::string, double> EngineRun::StageSeconds() const {
  std::map<std::string, double> seconds;
  for (const StageReport& report : evaluation.reports) seconds[report.stage] += report.seconds;
  return seconds;
}

std::string ModelFileFor(const PipelineOptions& options) {
  const std::string folder = FREELSD_SOURCE_DIR "/engine/";
  return folder + (options.preset == Preset::kPaper ? "classification/paper_model.yml"
                                                    : "ground_kind/ground_kind.onnx");
}

EngineRun RunEngine(const EngineInput& input,
                    const PipelineOptions& options,
                    const GroundModel& ground_model,
                    const Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  EngineRun run;
  Frontend frontend(input.rig, options, ground_model);
  std::map<std::string, cv::Mat> images;
  for (const Frame& frame : input.frames) {
    images[frame.id] = frame.image;
    run.num_processed += CountProcessed(frontend.Process(frame));
    const double done =
        static_cast<double>(images.size()) / static_cast<double>(input.frames.size());
    progress(kFrontendShare * done, "frontend");
  }
  run.num_processed += CountProcessed(frontend.Flush());
  run.frontend_seconds = SecondsSince(start);
  run.snapshot = frontend.TakeSnapshot();
  run.snapshot.obstacles = input.obstacles;
  for (const Candidate& each : run.snapshot.regions) run.regions.push_back(each.region);
  const ImageSource source = [&images](const std::string& id) { return images.at(id); };
  const EvaluateFlight as_ever = [&input](const Snapshot& snapshot,
                                          const RegionGroup& group,
                                          const ImageSource& source_of_images,
                                          const PipelineOptions& with_options,
                                          const Progress& tell) {
    return EvaluateSites(snapshot, group, source_of_images, input.aircraft, with_options, tell);
  };
  const EvaluateFlight& evaluate = input.evaluate ? input.evaluate : as_ever;
  PipelineOptions backend_options = options;
  if (input.ends_with_map) backend_options.backend.max_num_map_sites = 0;
  run.evaluation =
      evaluate(run.snapshot,
               {input.ends_with_map ? std::vector<Candidate>() : Graded(run.snapshot.regions),
                PhotographedArea(run.snapshot)},
               source,
               backend_options,
               [&](double done, const std::string& stage) {
                 return progress(kFrontendShare + (1.0 - kFrontendShare) * done, stage);
               });
  std::vector<StageReport> reports = frontend.TakeReports();
  run.evaluation.reports.insert(run.evaluation.reports.begin(), reports.begin(), reports.end());
  run.total_seconds = SecondsSince(start);
  return run;
}

}  // namespace freelsd
