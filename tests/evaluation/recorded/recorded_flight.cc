#include "tests/evaluation/recorded/recorded_flight.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "api/api.h"
#include "api/import/images/images.h"
#include "api/import/import.h"
#include "api/import/poses/poses.h"
#include "engine/ground_map.h"
#include "engine/selection/selection.h"

namespace freelsd {
namespace {

namespace fs = std::filesystem;

constexpr double kCellSizeM = 1.0;

std::string ReadFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

std::vector<fs::path> ImagesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder / "images")) files.push_back(entry.path());
  if (files.empty()) throw std::runtime_error("no images in " + folder.string());
  std::sort(files.begin(), files.end());
  return files;
}

Grid GridOver(const AdjustedBlock& block) {
  Eigen::Vector2d min = Eigen::Vector2d::Constant(1e9), max = -min;
  for (const Landmark& landmark : block.landmarks) {
    min = min.cwiseMin(landmark.point_in_world.head<2>());
    max = max.cwiseMax(landmark.point_in_world.head<2>());
  }
  return GridAround(min, max, kCellSizeM);
}

Points PointsOf(const RecordedFlight& flight,
                const StereoPair& pair,
                const StereoOptions& options) {
  const auto image_of = [&flight](size_t view) -> const cv::Mat& {
    return flight.images.at(flight.block.views[view].frame_id);
  };
  return ReconstructPoints(flight.block, pair, image_of(pair.left), image_of(pair.right), options);
}

void AppendDifferences(const ElevationMap& a, const ElevationMap& b, std::vector<float>* all) {
  const cv::Mat1f difference = cv::abs(a.elevation - b.elevation);
  for (const float value : difference) {
    if (!std::isnan(value)) all->push_back(value);
  }
}

}  // namespace

// What the file of poses says wins over the image's own tags.
RecordedFrames ReadRecordedFrames(const std::string& folder) {
  std::map<std::string, FrameMeta> poses;
  if (fs::exists(fs::path(folder) / "poses.csv")) {
    for (const auto& [name, meta] : ParsePoses(ReadFile(fs::path(folder) / "poses.csv")).poses) {
      poses[name] = meta;
    }
  }
  const ImageLimits limits;
  Rig rig;
  std::optional<LocalFrame> frame;
  std::vector<Frame> frames;
  for (const fs::path& path : ImagesIn(folder)) {
    const std::string name = path.filename().string();
    const std::string bytes = ReadFile(path);
    const ImageTags tags = ReadImageTags(bytes, SniffImage(bytes, limits));
    const auto pose = poses.find(name);
    const FrameMeta meta = pose == poses.end() ? tags.meta : Merged(pose->second, tags.meta);
    if (!frame.has_value()) {
      if (!tags.camera || !meta.position)
        throw std::runtime_error(name + ": no camera or position");
      rig.camera = *tags.camera;
      frame.emplace(*meta.position);
    }
    const auto index = static_cast<int64_t>(frames.size());
    frames.push_back(MakeFrame(name, DecodeImage(bytes, limits), meta, rig, *frame, index));
  }
  std::stable_sort(frames.begin(), frames.end(), [](const Frame& a, const Frame& b) {
    return a.timestamp_us < b.timestamp_us;
  });
  return {*frame, rig, std::move(frames)};
}

RecordedFlight AdjustRecordedFlight(const RecordedFrames& recorded,
                                    const GroundModel& ground_model,
                                    const PipelineOptions& options) {
  const auto& [frame, rig, frames] = recorded;
  RecordedFlight flight{frame, rig.camera, {}, {}, {}};
  Frontend frontend(rig, options, ground_model);
  for (const Frame& each : frames) {
    flight.images[each.id] = each.image;
    frontend.Process(each);
  }
  frontend.Flush();
  const Snapshot snapshot = frontend.TakeSnapshot();
  flight.views = snapshot.views;
  const ImageSource source = [&flight](const std::string& id) { return flight.images.at(id); };
  flight.block =
      AdjustAndTie(snapshot.views, rig.camera, source, options.tracks, options.adjustment);
  return flight;
}

PairAgreement AgreementOfPairs(const RecordedFlight& flight, const PipelineOptions& options) {
  constexpr size_t kMaxNumPairs = 30;
  const std::vector<StereoPair> pairs = SelectPairs(flight.block, options.stereo);
  const Grid grid = GridOver(flight.block);
  std::vector<ElevationMap> maps;
  const size_t step = std::max<size_t>(1, pairs.size() / kMaxNumPairs);
  for (size_t i = 0; i < pairs.size(); i += step) {
    ElevationMapBuilder builder(grid, options.terrain);
    builder.Add(PointsOf(flight, pairs[i], options.stereo));
    maps.push_back(builder.Build());
  }
  PairAgreement agreement;
  std::vector<float> all;
  for (size_t i = 0; i < maps.size(); ++i) {
    for (size_t j = i + 1; j < maps.size(); ++j) {
      const size_t before = all.size();
      AppendDifferences(maps[i], maps[j], &all);
      agreement.num_overlaps += all.size() > before;
    }
  }
  if (all.empty()) return agreement;
  std::sort(all.begin(), all.end());
  agreement.median_m = all[all.size() / 2];
  agreement.p90_m = all[all.size() * 9 / 10];
  return agreement;
}

ElevationMap MapOfBlock(const RecordedFlight& flight, const PipelineOptions& options) {
  const ImageSource source = [&flight](const std::string& id) { return flight.images.at(id); };
  std::vector<StageReport> reports;
  return ReconstructMap(
      flight.block, SeenArea(flight.block), source, options, [](double) {}, reports);
}

}  // namespace freelsd
