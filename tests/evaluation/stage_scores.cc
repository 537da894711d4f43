#include "tests/evaluation/stage_scores.h"

#include <algorithm>
#include <cmath>

#include "tests/evaluation/scores/obstruction.h"
#include "tests/synthetic/renderer.h"

namespace freelsd {
namespace {

// Pixels of a mask that are looked at: every n-th of every n-th row.
constexpr int kMaskStep = 6;
// Cells nearer than this to another kind of ground do not count for their kind.
constexpr int kBorderCells = 2;

std::map<std::string, size_t> ExposureOfId(const Scenario& scenario) {
  std::map<std::string, size_t> exposure_of_id;
  for (size_t i = 0; i < scenario.exposures.size(); ++i) {
    exposure_of_id[scenario.exposures[i].image] = i;
  }
  return exposure_of_id;
}

std::string KindOf(const TruthMap& truth, int row, int col) {
  const std::string fault = NameOfFault(truth, {col, row});
  return fault.empty() ? "landable" : fault;
}

bool IsInsideOfKind(const TruthMap& truth, int row, int col) {
  for (int i = -kBorderCells; i <= kBorderCells; ++i) {
    for (int j = -kBorderCells; j <= kBorderCells; ++j) {
      const int r = row + i, c = col + j;
      if (r < 0 || c < 0 || r >= truth.fault.rows || c >= truth.fault.cols) return false;
      if (truth.fault(r, c) != truth.fault(row, col)) return false;
      if (truth.cover(r, c) != truth.cover(row, col)) return false;
    }
  }
  return true;
}

bool IsOpenGround(Cover cover) {
  return cover == Cover::kMeadow || cover == Cover::kStubble || cover == Cover::kSoil ||
         cover == Cover::kGravel || cover == Cover::kRoad;
}

double Median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void ScoreMask(RocCounts& regions,
               const GrassView& view,
               const Rigid3d& true_world_from_camera,
               const Renderer& renderer,
               const World& world) {
  std::array<std::array<int64_t, 2>, 256> grass_of_value{};
  for (int row = kMaskStep / 2; row < view.mask.rows; row += kMaskStep) {
    for (int col = kMaskStep / 2; col < view.mask.cols; col += kMaskStep) {
      const double scale = view.image_px_per_mask_px;
      const Eigen::Vector2d pixel((col + 0.5) * scale - 0.5, (row + 0.5) * scale - 0.5);
      const Eigen::Vector3d ray = true_world_from_camera.rotation * view.camera.RayFromImage(pixel);
      const auto hit = renderer.FirstHit(true_world_from_camera.translation, ray);
      if (!hit || hit->head<2>().cwiseAbs().maxCoeff() > 0.5 * world.size_m) continue;
      const bool is_meadow = world.CoverAt(hit->x(), hit->y()) == Cover::kMeadow;
      ++grass_of_value[view.mask(row, col)][is_meadow];
    }
  }
  for (size_t value = 1; value < grass_of_value.size(); ++value) {
    const auto [num_other, num_grass] = grass_of_value[value];
    if (num_other + num_grass == 0) continue;
    regions.Add((static_cast<double>(value) - 1.0) / 254.0, num_grass > num_other);
  }
}

}  // namespace

PoseScore ScorePoses(const EngineRun& run, const Scenario& scenario) {
  PoseScore score;
  const AdjustedBlock& block = run.evaluation.block;
  score.rms_after_px = block.rms_after_px;
  score.num_views = static_cast<int>(block.views.size());
  const auto exposure_of_id = ExposureOfId(scenario);
  for (const AdjustedView& view : block.views) {
    if (!view.is_connected) continue;
    ++score.num_connected;
    const Rigid3d truth = scenario.TrueWorldFromCamera(exposure_of_id.at(view.frame_id));
    score.shift += view.world_from_camera.translation - truth.translation;
  }
  if (score.num_connected > 0) score.shift /= score.num_connected;
  return score;
}

MapScore ScoreMap(const EngineRun& run, const Scenario& scenario, const TruthMap& truth) {
  MapScore score;
  const ElevationMap& map = run.evaluation.map;
  const HazardLayers& layers = run.evaluation.hazards;
  const double half = 0.5 * scenario.world.size_m;
  std::vector<double> errors;
  std::vector<HeightError> errors_of_places;
  for (int row = 0; row < map.grid.num_rows; ++row) {
    for (int col = 0; col < map.grid.num_cols; ++col) {
      const Eigen::Vector2d place = map.grid.CellCenter(row, col);
      if (place.cwiseAbs().maxCoeff() >= half) continue;
      const cv::Point cell = truth.CellAt(place);
      if (IsInsideOfKind(truth, cell.y, cell.x)) {
        ++score.hazard_of_kind[KindOf(truth, cell.y, cell.x)][layers.hazard(row, col)];
      }
      if (!map.IsSeen(row, col)) continue;
      const Cover cover = static_cast<Cover>(truth.cover(cell));
      if (IsOpenGround(cover)) {
        errors.push_back(map.elevation(row, col) -
                         scenario.world.SurfaceHeight(place.x(), place.y()));
        errors_of_places.push_back({place, errors.back()});
      }
    }
  }
  score.elevation_median_error = Median(errors);
  score.detilted = Detilt(errors_of_places);
  for (const double error : errors) {
    score.elevation_error.Add(error);
    score.elevation_error_unbiased.Add(error - score.elevation_median_error);
  }
  return score;
}

RocCounts ScoreRegions(const EngineRun& run, const Scenario& scenario) {
  RocCounts regions;
  const Renderer renderer(scenario.world);
  const auto exposure_of_id = ExposureOfId(scenario);
  for (size_t i = 0; i < run.snapshot.views.size(); ++i) {
    const View& view = run.snapshot.views[i];
    if (i >= run.snapshot.grass_masks.size() || run.snapshot.grass_masks[i].size.empty()) continue;
    const PackedMask& packed = run.snapshot.grass_masks[i];
    ScoreMask(regions,
              {view.world_from_camera,
               run.snapshot.rig.camera.With(view.readout),
               packed.Unpack(),
               packed.image_px_per_mask_px},
              scenario.TrueWorldFromCamera(exposure_of_id.at(view.frame_id)),
              renderer,
              scenario.world);
  }
  return regions;
}

}  // namespace freelsd
