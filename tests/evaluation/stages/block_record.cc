#include "tests/evaluation/stages/block_record.h"

#include <algorithm>
#include <stdexcept>

namespace freelsd {
namespace {

constexpr const char* kAdjustment = "adjustment";
constexpr const char* kTerrain = "terrain";

// Reads the values of one record in the order in which they were written.
class Values {
 public:
  explicit Values(const std::vector<double>& values) : values_(values) {}
  double Next() { return values_.at(next_++); }
  size_t NextCount() { return static_cast<size_t>(Next()); }
  Eigen::Vector3d NextVector() {
    const double x = Next(), y = Next(), z = Next();
    return {x, y, z};
  }
  bool AtEnd() const { return next_ == values_.size(); }

 private:
  const std::vector<double>& values_;
  size_t next_ = 0;
};

const std::vector<double>& ValuesOf(const StageRecords& records,
                                    const std::string& stage,
                                    const std::string& quantity) {
  for (const StageRecord& record : records) {
    if (record.stage == stage && record.quantity == quantity) return record.values;
  }
  throw std::invalid_argument("stages: no record of " + stage + ": " + quantity);
}

void AppendCoordinates(std::vector<double>& values, const Eigen::Vector3d& vector) {
  values.insert(values.end(), vector.data(), vector.data() + 3);
}

std::vector<double> FramesOf(const AdjustedBlock& block,
                             const std::vector<std::string>& frame_ids) {
  std::vector<double> values;
  for (const AdjustedView& view : block.views) {
    const auto place = std::find(frame_ids.begin(), frame_ids.end(), view.frame_id);
    if (place == frame_ids.end()) throw std::invalid_argument("stages: no frame " + view.frame_id);
    values.push_back(static_cast<double>(place - frame_ids.begin()));
  }
  return values;
}

std::vector<double> PosesOf(const AdjustedBlock& block) {
  std::vector<double> values;
  for (const AdjustedView& view : block.views) {
    const auto& quaternion = view.world_from_camera.rotation.coeffs();
    values.insert(values.end(), quaternion.data(), quaternion.data() + 4);
    AppendCoordinates(values, view.world_from_camera.translation);
  }
  return values;
}

std::vector<double> SightingsOf(const AdjustedBlock& block) {
  std::vector<double> values;
  for (const AdjustedView& view : block.views) {
    values.push_back(view.is_connected ? 1.0 : 0.0);
    values.push_back(view.group);
    values.push_back(static_cast<double>(view.landmarks.size()));
    for (const size_t landmark : view.landmarks) values.push_back(static_cast<double>(landmark));
  }
  return values;
}

std::vector<double> DeviationsOf(const AdjustedBlock& block) {
  std::vector<double> values{block.tilt_sd_deg, block.position_sd_m, block.rms_after_px};
  for (const AdjustedView& view : block.views) {
    values.push_back(view.height_above_ground);
    values.push_back(view.position_sd_m);
  }
  return values;
}

std::vector<double> LandmarksOf(const AdjustedBlock& block) {
  std::vector<double> values;
  for (const Landmark& landmark : block.landmarks) {
    AppendCoordinates(values, landmark.point_in_world);
    values.push_back(landmark.height_sd_m);
    values.push_back(landmark.num_views);
  }
  return values;
}

void ReadFrames(const std::vector<double>& record,
                const std::vector<std::string>& frame_ids,
                AdjustedBlock& block) {
  for (const double index : record) {
    AdjustedView view;
    view.frame_id = frame_ids.at(static_cast<size_t>(index));
    block.views.push_back(view);
  }
}

void ReadPoses(const std::vector<double>& record, AdjustedBlock& block) {
  Values values(record);
  for (AdjustedView& view : block.views) {
    for (int i = 0; i < 4; ++i) view.world_from_camera.rotation.coeffs()[i] = values.Next();
    view.world_from_camera.translation = values.NextVector();
  }
}

void ReadSightings(const std::vector<double>& record, AdjustedBlock& block) {
  Values values(record);
  for (AdjustedView& view : block.views) {
    view.is_connected = values.Next() != 0.0;
    view.group = static_cast<int>(values.Next());
    view.landmarks.resize(values.NextCount());
    for (size_t& landmark : view.landmarks) landmark = values.NextCount();
  }
}

void ReadDeviations(const std::vector<double>& record, AdjustedBlock& block) {
  Values values(record);
  block.tilt_sd_deg = values.Next();
  block.position_sd_m = values.Next();
  block.rms_after_px = values.Next();
  for (AdjustedView& view : block.views) {
    view.height_above_ground = values.Next();
    view.position_sd_m = values.Next();
  }
}

void ReadLandmarks(const std::vector<double>& record, AdjustedBlock& block) {
  Values values(record);
  while (!values.AtEnd()) {
    Landmark landmark;
    landmark.point_in_world = values.NextVector();
    landmark.height_sd_m = values.Next();
    landmark.num_views = static_cast<int>(values.Next());
    block.landmarks.push_back(landmark);
  }
}

cv::Mat1f RasterFrom(const StageRecords& records, const std::string& quantity, const Grid& grid) {
  if (grid.num_rows == 0) return {};
  const cv::Mat1d values(ValuesOf(records, kTerrain, quantity), true);
  cv::Mat1f raster;
  values.reshape(1, grid.num_rows).convertTo(raster, CV_32F);
  return raster;
}

}  // namespace

StageRecords RecordsOf(const AdjustedBlock& block, const std::vector<std::string>& frame_ids) {
  return {{kAdjustment, "key-frames, index", FramesOf(block, frame_ids)},
          {kAdjustment, "sightings, index", SightingsOf(block)},
          {kAdjustment, "pose, quaternion and m", PosesOf(block)},
          {kAdjustment, "landmark, m", LandmarksOf(block)},
          {kAdjustment, "deviation, m and deg", DeviationsOf(block)}};
}

AdjustedBlock BlockFrom(const StageRecords& records,
                        const Camera& camera,
                        const std::vector<std::string>& frame_ids) {
  AdjustedBlock block;
  block.camera = camera;
  block.is_usable = true;
  ReadFrames(ValuesOf(records, kAdjustment, "key-frames, index"), frame_ids, block);
  ReadSightings(ValuesOf(records, kAdjustment, "sightings, index"), block);
  ReadPoses(ValuesOf(records, kAdjustment, "pose, quaternion and m"), block);
  ReadLandmarks(ValuesOf(records, kAdjustment, "landmark, m"), block);
  ReadDeviations(ValuesOf(records, kAdjustment, "deviation, m and deg"), block);
  return block;
}

StageRecords RecordsOf(const ElevationMap& map) {
  const Grid& grid = map.grid;
  return {{kTerrain,
           "grid, m and cells",
           {grid.north_west_in_world.x(),
            grid.north_west_in_world.y(),
            grid.cell_size_m,
            static_cast<double>(grid.num_rows),
            static_cast<double>(grid.num_cols),
            map.position_sd_m,
            map.tilt_sd_deg,
            map.is_compared ? 1.0 : 0.0}},
          RecordOf(kTerrain, "elevation, m", map.elevation),
          RecordOf(kTerrain, "upper height, m", map.upper),
          RecordOf(kTerrain, "deviation, m", map.standard_deviation),
          RecordOf(kTerrain, "points", map.num_points)};
}

ElevationMap MapFrom(const StageRecords& records) {
  Values values(ValuesOf(records, kTerrain, "grid, m and cells"));
  ElevationMap map;
  map.grid.north_west_in_world.x() = values.Next();
  map.grid.north_west_in_world.y() = values.Next();
  map.grid.cell_size_m = values.Next();
  map.grid.num_rows = static_cast<int>(values.Next());
  map.grid.num_cols = static_cast<int>(values.Next());
  map.position_sd_m = values.Next();
  map.tilt_sd_deg = values.Next();
  map.is_compared = values.Next() != 0.0;
  map.elevation = RasterFrom(records, "elevation, m", map.grid);
  map.upper = RasterFrom(records, "upper height, m", map.grid);
  map.standard_deviation = RasterFrom(records, "deviation, m", map.grid);
  map.num_points = RasterFrom(records, "points", map.grid);
  return map;
}

}  // namespace freelsd
