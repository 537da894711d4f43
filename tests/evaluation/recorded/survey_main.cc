// freelsd-survey: how well the poses of recorded flights fit, and the surveyed targets where there
// are any; a table in Markdown.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>

#include <CLI/CLI.hpp>

#include "server/training/pools.h"
#include "tests/evaluation/recorded/control_runs.h"

namespace freelsd {
namespace {

namespace fs = std::filesystem;

// Throws std::invalid_argument if the flights are of two pools.
void CheckPools(const std::vector<std::string>& folders) {
  const Pools pools = Pools::Read(FREELSD_SOURCE_DIR "/tests/evaluation/pools.csv");
  PoolOfRun run;
  for (const std::string& folder : folders) {
    const std::string name = fs::canonical(folder).filename().string();
    run.Add("flight " + name, pools.Of("flight", name));
  }
}

void PrintFlight(const std::string& name,
                 const RecordedFlight& flight,
                 const PairAgreement& agreement) {
  int num_connected = 0;
  for (const AdjustedView& view : flight.block.views) num_connected += view.is_connected;
  std::printf("| %s | %zu | %d | %zu | %.2f | %.0f | %.2f | %.2f | %.2f | %.2f |\n",
              name.c_str(),
              flight.images.size(),
              num_connected,
              flight.block.LargestGroup().size(),
              flight.block.rms_after_px,
              flight.block.camera.fx_px,
              flight.block.position_sd_m,
              flight.block.tilt_sd_deg,
              agreement.median_m,
              agreement.p90_m);
  std::fflush(stdout);
}

void PrintHeights(const char* where, const HeightChecks& checks) {
  std::printf(
      " Elevation map at %d of %d (%s): %.2f m RMS, largest %.2f m, %d beyond 3 deviations.",
      checks.num_known,
      checks.num_targets,
      where,
      checks.rms_m,
      checks.largest_m,
      checks.num_beyond);
}

void PrintControl(const std::string& name, const ControlErrors& errors) {
  std::printf(
      "\n%s: %d targets seen twice. Leave one out after a similarity of the others: %.2f m "
      "horizontal, %.2f m vertical (RMS). Georeferenced by the positions alone: shift east %.2f, "
      "north %.2f, up %.2f m, and without it %.2f m horizontal, %.2f m vertical.",
      name.c_str(),
      errors.num_targets,
      errors.aligned_horizontal_m,
      errors.aligned_vertical_m,
      errors.shift_in_world.x(),
      errors.shift_in_world.y(),
      errors.shift_in_world.z(),
      errors.georeferenced_horizontal_m,
      errors.georeferenced_vertical_m);
  PrintHeights("all targets", errors.map);
  PrintHeights("those seen twice, each left out", errors.map_seen_twice);
  PrintHeights("those seen once", errors.map_seen_once);
  std::puts("");
}

constexpr const char* kTargetsFile = "TargetCoordinates_wAccuracy.csv";

std::vector<TargetSighting> SightingsIn(const fs::path& folder) {
  const fs::path sightings = folder / "ImageTargets_2000x1500.csv";
  return fs::exists(sightings) ? ReadSightings(sightings.string()) : std::vector<TargetSighting>();
}

void Run(const std::vector<std::string>& folders, const std::string& model) {
  const GroundModel ground_model = ReadGroundModel(model).model;
  const PipelineOptions options;
  std::puts(
      "| flight | photographs | adjusted | in one block | reprojection px | focal length px | "
      "position sd m | "
      "tilt sd deg | pairs differ by m, median | p90 |\n|---|---|---|---|---|---|---|---|---|---|");
  std::vector<std::pair<std::string, ControlErrors>> controls;
  for (const std::string& folder : folders) {
    const std::string name = fs::path(folder).filename().string();
    const RecordedFlight flight =
        AdjustRecordedFlight(ReadRecordedFrames(folder), ground_model, options);
    PrintFlight(name, flight, AgreementOfPairs(flight, options));
    const fs::path targets = fs::path(folder) / kTargetsFile;
    if (!fs::exists(targets)) continue;
    const auto sightings = SightingsIn(folder);
    controls.emplace_back(
        name,
        CompareWithTargets(
            flight, MapOfBlock(flight, options), ReadTargets(targets.string()), sightings));
  }
  for (const auto& [name, errors] : controls) PrintControl(name, errors);
}

// The control of each flight that has targets, so often.
void RunControls(const std::vector<std::string>& folders,
                 const std::string& model,
                 size_t num_runs) {
  const GroundModel ground_model = ReadGroundModel(model).model;
  for (const std::string& folder : folders) {
    const ControlFlight flight{ReadRecordedFrames(folder),
                               ReadTargets((fs::path(folder) / kTargetsFile).string()),
                               SightingsIn(folder)};
    std::printf("%s\n\n%s", fs::path(folder).filename().c_str(), ControlHeading().c_str());
    std::vector<ControlRun> runs;
    for (const ControlTrial& trial : PlanControlRuns(num_runs, flight.recorded.frames.size())) {
      std::fflush(stdout);
      runs.push_back(RunControl(flight, trial, ground_model, PipelineOptions{}));
      std::fputs(ControlRow(runs.back()).c_str(), stdout);
    }
    std::fputs(ControlEnd(runs).c_str(), stdout);
  }
}

// What the whole of the engine costs on stored flights, stage by stage.
void RunStages(const std::vector<std::string>& folders, const std::string& model) {
  const GroundModel ground_model = ReadGroundModel(model).model;
  std::puts("| flight | photographs | stage | times | seconds |\n|---|---|---|---|---|");
  for (const std::string& folder : folders) {
    const std::string name = fs::path(folder).filename().string();
    const RecordedFrames flight = ReadRecordedFrames(folder);
    const Evaluation evaluation =
        Detect(flight.rig, flight.frames, Aircraft{}, PipelineOptions{}, ground_model);
    std::map<std::string, std::pair<int, double>> stages;
    for (const StageReport& report : evaluation.reports) {
      auto& [num_times, seconds] = stages[report.stage];
      num_times += 1;
      seconds += report.seconds;
    }
    for (const auto& [stage, cost] : stages) {
      std::printf("| %s | %zu | %s | %d | %.2f |\n",
                  name.c_str(),
                  flight.frames.size(),
                  stage.c_str(),
                  cost.first,
                  cost.second);
    }
  }
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    CLI::App app{"Fits the poses of recorded flights and prints how well they fit, as Markdown."};
    std::vector<std::string> folders;
    std::string model = FREELSD_SOURCE_DIR "/engine/ground_kind/ground_kind.onnx";
    app.add_option("FLIGHT", folders, "folders with images/ and perhaps poses.csv")
        ->required()
        ->check(CLI::ExistingDirectory);
    app.add_option("--model", model, "network of ground kinds, .onnx")->check(CLI::ExistingFile);
    bool is_timed = false;
    app.add_flag("--stages", is_timed, "prints instead what each stage of the engine costs");
    size_t num_control_runs = 0;
    app.add_option("--control-runs",
                   num_control_runs,
                   "prints instead the errors at surveyed targets in so many runs, each without "
                   "another photograph and with another tolerance of the adjustment");
    CLI11_PARSE(app, argc, argv);
    freelsd::CheckPools(folders);
    if (num_control_runs > 0) {
      freelsd::RunControls(folders, model, num_control_runs);
    } else if (is_timed) {
      freelsd::RunStages(folders, model);
    } else {
      freelsd::Run(folders, model);
    }
  } catch (const std::exception& error) {
    std::cerr << "freelsd-survey: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
