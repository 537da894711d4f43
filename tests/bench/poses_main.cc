// freelsd-poses: the heights that stereo and fusion make of a rendered flight, on poses of the
// engine, of COLMAP, and on the true ones; a table in Markdown.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <fstream>
#include <functional>
#include <iostream>
#include <sstream>
#include <stdexcept>

#include <CLI/CLI.hpp>

#include "engine/ground_map.h"
#include "tests/bench/colmap_model.h"
#include "tests/evaluation/scores/elevation_error.h"
#include "tests/evaluation/stages/stage_run.h"
#include "tests/evaluation/truth_map.h"
#include "tests/synthetic/flight_files.h"

namespace freelsd {
namespace {

constexpr const char* kModelFile = FREELSD_SOURCE_DIR "/engine/ground_kind/ground_kind.onnx";
constexpr double kBeyondDeviations = 3.0;
// Cells that so many photographs show should have a height.
constexpr int kEnoughViews = 3;

std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// Of the processor, all threads: other programs disturb them less.
double SecondsOf(const std::function<void()>& work) {
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

// A flight of freelsd-render, and what is true there. The truth's world frame is that of the world;
// the flight's has its origin at the first position stated.
struct JudgedFlight {
  FlightFolder flight;
  World world;
  std::vector<SyntheticExposure> exposures;
  TruthMap truth;
  // Cells of the truth that are open ground: how many photographs show them; 0 elsewhere.
  cv::Mat1b num_views;
  Eigen::Vector3d truth_from_flight = Eigen::Vector3d::Zero();

  Rigid3d TrueWorldFromCamera(size_t exposure) const {
    Rigid3d pose = WorldFromBody(exposures[exposure].truth) * flight.rig.body_from_camera;
    pose.translation -= truth_from_flight;
    return pose;
  }
  ImageSource Images() const {
    return [this](const std::string& id) {
      const auto is_it = [&id](const Frame& frame) { return frame.id == id; };
      return std::find_if(flight.frames.begin(), flight.frames.end(), is_it)->image;
    };
  }
};

cv::Mat1b NumViewsOfOpenGround(const JudgedFlight& judged) {
  cv::Mat1b num_views(judged.truth.cover.size(), uint8_t{0});
  const Rig& rig = judged.flight.rig;
  for (const SyntheticExposure& exposure : judged.exposures) {
    const Rigid3d camera_from_truth = Inverse(WorldFromBody(exposure.truth) * rig.body_from_camera);
    for (int row = 0; row < num_views.rows; ++row) {
      for (int col = 0; col < num_views.cols; ++col) {
        if (!IsOpenGround(static_cast<Cover>(judged.truth.cover(row, col)))) continue;
        const Eigen::Vector2d place = judged.truth.CellCenter(row, col);
        const Eigen::Vector3d point(
            place.x(), place.y(), judged.world.SurfaceHeight(place.x(), place.y()));
        const auto pixel = rig.camera.ImageFromCamera(camera_from_truth * point);
        num_views(row, col) += pixel && rig.camera.IsInside(*pixel);
      }
    }
  }
  return num_views;
}

// Throws std::invalid_argument if the folder is of another seed, or of other options.
JudgedFlight ReadJudgedFlight(const std::string& folder, uint64_t seed) {
  JudgedFlight judged;
  judged.flight = ReadFlightFolder(folder, 1000000);
  WorldOptions world_options;
  world_options.seed = seed;
  FlightOptions flight_options;
  flight_options.seed = seed;
  flight_options.num_frames = static_cast<int>(judged.flight.frames.size());
  judged.world = MakeFarmland(world_options);
  judged.exposures = PlanFlight(flight_options, judged.world.wind_in_world);
  if (PosesCsv(judged.world, judged.exposures) != ReadFile(folder + "/poses.csv")) {
    throw std::invalid_argument(folder + " is not of freelsd-render --seed " +
                                std::to_string(seed) + " with its other options at their defaults");
  }
  judged.truth = MakeTruthMap(judged.world, judged.flight.aircraft);
  judged.num_views = NumViewsOfOpenGround(judged);
  judged.truth_from_flight = judged.exposures.front().reported.position_in_world -
                             judged.flight.frames.front().prior.position_in_world;
  return judged;
}

struct PosedBlock {
  std::string name;
  AdjustedBlock block;
  double seconds = 0.0;
};

// The seconds are of the whole frontend, which also looks for grass, and of the adjustment.
PosedBlock OurBlock(const JudgedFlight& judged) {
  const FlightFolder& flight = judged.flight;
  const PipelineOptions& options = flight.options;
  PosedBlock posed{"freelsd", {}, 0.0};
  posed.seconds = SecondsOf([&] {
    Frontend frontend(flight.rig, options, ReadGroundModel(kModelFile).model);
    for (const Frame& frame : flight.frames) frontend.Process(frame);
    frontend.Flush();
    const Snapshot snapshot = frontend.TakeSnapshot();
    const Selection selection =
        SelectViews(snapshot, PhotographedArea(snapshot), options.adjustment, options.backend);
    posed.block = AdjustAndTie(
        selection.views, flight.rig.camera, judged.Images(), options.tracks, options.adjustment);
  });
  return posed;
}

PosedBlock ColmapBlock(const JudgedFlight& judged, const std::string& folder, double seconds) {
  Positions positions;
  for (const Frame& frame : judged.flight.frames) {
    positions[frame.id] = frame.prior.position_in_world;
  }
  return {"COLMAP, placed by GNSS", BlockFrom(ReadColmapModel(folder), positions), seconds};
}

// The block with the true poses and its own landmarks, which then are a little off.
PosedBlock TrueBlock(const JudgedFlight& judged, AdjustedBlock block) {
  block.camera = judged.flight.rig.camera;
  for (AdjustedView& view : block.views) {
    for (size_t i = 0; i < judged.exposures.size(); ++i) {
      if (judged.exposures[i].image != view.frame_id) continue;
      view.world_from_camera = judged.TrueWorldFromCamera(i);
      view.readout = {};
    }
  }
  return {"true poses", std::move(block), 0.0};
}

// At cells of open ground that have a height.
struct JudgedMap {
  std::vector<HeightError> errors;
  std::vector<double> told_sds;
};

JudgedMap Judge(const ElevationMap& map, const JudgedFlight& judged) {
  JudgedMap result;
  for (int row = 0; row < map.grid.num_rows; ++row) {
    for (int col = 0; col < map.grid.num_cols; ++col) {
      if (!map.IsSeen(row, col)) continue;
      const Eigen::Vector2d place =
          map.grid.CellCenter(row, col) + judged.truth_from_flight.head<2>();
      if (place.cwiseAbs().maxCoeff() >= 0.5 * judged.world.size_m) continue;
      if (!IsOpenGround(static_cast<Cover>(judged.truth.cover(judged.truth.CellAt(place))))) {
        continue;
      }
      result.errors.push_back({place,
                               map.elevation(row, col) + judged.truth_from_flight.z() -
                                   judged.world.SurfaceHeight(place.x(), place.y())});
      result.told_sds.push_back(map.standard_deviation(row, col));
    }
  }
  return result;
}

// Of the open ground that enough photographs show, the share without a height.
double UnknownRatio(const ElevationMap& map, const JudgedFlight& judged) {
  int num_shown = 0, num_unknown = 0;
  for (int row = 0; row < judged.num_views.rows; ++row) {
    for (int col = 0; col < judged.num_views.cols; ++col) {
      if (judged.num_views(row, col) < kEnoughViews) continue;
      ++num_shown;
      const auto cell =
          map.grid.CellAt(judged.truth.CellCenter(row, col) - judged.truth_from_flight.head<2>());
      num_unknown += !cell || !map.IsSeen(cell->y, cell->x);
    }
  }
  return static_cast<double>(num_unknown) / std::max(1, num_shown);
}

void PrintRow(const PosedBlock& posed,
              const JudgedMap& judged,
              double unknown_ratio,
              double map_seconds) {
  const ErrorPlane plane = FitErrorPlane(judged.errors);
  std::vector<double> sizes;
  int num_beyond = 0;
  double sum = 0.0;
  for (size_t i = 0; i < judged.errors.size(); ++i) {
    const HeightError& each = judged.errors[i];
    sizes.push_back(std::abs(each.error - plane.At(each.place)));
    num_beyond += sizes.back() > kBeyondDeviations * judged.told_sds[i];
    sum += sizes.back() * sizes.back();
  }
  if (sizes.empty()) throw std::runtime_error(posed.name + ": no cell of open ground has a height");
  std::sort(sizes.begin(), sizes.end());
  const double num = static_cast<double>(sizes.size());
  std::printf(
      "| %s | %zu of %zu | %.1f | %.1f | %zu | %.2f %% | %.3f | %.3f | %.3f | %.1f %% | "
      "%.2f | %.2f |\n",
      posed.name.c_str(),
      posed.block.LargestGroup().size(),
      posed.block.views.size(),
      posed.seconds,
      map_seconds,
      sizes.size(),
      100.0 * unknown_ratio,
      sizes[sizes.size() / 2],
      std::sqrt(sum / num),
      sizes[sizes.size() * 95 / 100],
      100.0 * num_beyond / num,
      plane.At(Eigen::Vector2d::Zero()),
      plane.TiltDeg());
}

struct Arguments {
  std::string folder;
  uint64_t seed = 0;
  std::string colmap;
  double colmap_seconds = 0.0;
  int num_threads = 1;
};

void Run(const Arguments& arguments) {
  cv::setNumThreads(arguments.num_threads);
  const JudgedFlight judged = ReadJudgedFlight(arguments.folder, arguments.seed);
  std::vector<PosedBlock> blocks{OurBlock(judged)};
  if (!arguments.colmap.empty()) {
    blocks.push_back(ColmapBlock(judged, arguments.colmap, arguments.colmap_seconds));
  }
  blocks.push_back(TrueBlock(judged, blocks.front().block));
  std::puts(
      "| poses | views | poses, processor s | stereo and fusion, processor s | cells of open "
      "ground | of those three "
      "photographs show, unknown | plane off: median m | RMS m | 95 % m | beyond 3 sd | plane m "
      "| tilt deg |\n|---|---|---|---|---|---|---|---|---|---|---|---|");
  for (const PosedBlock& posed : blocks) {
    ElevationMap map;
    std::vector<StageReport> reports;
    const double seconds = SecondsOf([&] {
      map = ReconstructMap(
          posed.block,
          SeenArea(posed.block),
          judged.Images(),
          judged.flight.options,
          [](double) {},
          reports);
    });
    PrintRow(posed, Judge(map, judged), UnknownRatio(map, judged), seconds);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    CLI::App app{"Judges the heights of a rendered flight on several poses, as Markdown."};
    freelsd::Arguments arguments;
    app.add_option("FOLDER", arguments.folder, "of freelsd-render with its default options")
        ->required()
        ->check(CLI::ExistingDirectory);
    app.add_option("--seed", arguments.seed, "of that flight")->required();
    app.add_option("--colmap", arguments.colmap, "folder of a sparse model of COLMAP, as text")
        ->check(CLI::ExistingDirectory);
    app.add_option("--colmap-seconds", arguments.colmap_seconds, "processor time of that model");
    app.add_option("--threads", arguments.num_threads, "of stereo")->check(CLI::Range(1, 64));
    CLI11_PARSE(app, argc, argv);
    freelsd::Run(arguments);
  } catch (const std::exception& error) {
    std::cerr << "freelsd-poses: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
