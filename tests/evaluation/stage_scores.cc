#include "tests/evaluation/stage_scores.h"

#include <algorithm>
#include <cmath>

#include "tests/evaluation/scores/obstruction.h"
#include "tests/synthetic/renderer.h"

namespace freelsd {
namespace {

// Pixels of a mask that are looked at: every n-th of every n-th row.
constexpr int kMaskStep = 6;
constexpr double kDuplicateOverlap = 0.3;
// Cells nearer than this to another kind of ground do not count for their kind.
constexpr int kBorderCells = 2;
// Slope of the truth is that over the support of the engine's default.
constexpr double kSlopeSupportM = 9.0;

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

double TrueSlope(const World& world, const Eigen::Vector2d& place) {
  const double half = 0.5 * kSlopeSupportM;
  const double dx = world.GroundHeight(place.x() + half, place.y()) -
                    world.GroundHeight(place.x() - half, place.y());
  const double dy = world.GroundHeight(place.x(), place.y() + half) -
                    world.GroundHeight(place.x(), place.y() - half);
  return std::atan(std::hypot(dx, dy) / kSlopeSupportM);
}

double TrueRoughness(const World& world, const Eigen::Vector2d& place) {
  const double middle = world.SurfaceHeight(place.x(), place.y());
  double sum = 0.0;
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      sum += std::pow(world.SurfaceHeight(place.x() + i, place.y() + j) - middle, 2);
    }
  }
  return std::sqrt(sum);
}

double Median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void CountHazard(MapScore& score, const TruthMap& truth, const cv::Point& cell, uint8_t hazard) {
  const bool is_faulty = truth.fault(cell) != 0;
  if (IsInsideOfKind(truth, cell.y, cell.x)) {
    ++score.hazard_of_kind[KindOf(truth, cell.y, cell.x)][hazard];
  }
  if (hazard == kUnseen) return;
  score.num_faulty += is_faulty;
  score.num_faulty_not_free += is_faulty && hazard == kHazard;
  score.num_called_hazard += hazard == kHazard;
  score.num_called_hazard_rightly += is_faulty && hazard == kHazard;
}

void ScoreMask(FrontendScore& score,
               const KindView& view,
               const Rigid3d& true_world_from_camera,
               const Renderer& renderer,
               const World& world) {
  for (int row = kMaskStep / 2; row < view.picture.grass.rows; row += kMaskStep) {
    for (int col = kMaskStep / 2; col < view.picture.grass.cols; col += kMaskStep) {
      const double scale = view.picture.image_px_per_px;
      const Eigen::Vector2d pixel((col + 0.5) * scale - 0.5, (row + 0.5) * scale - 0.5);
      const Eigen::Vector3d ray = true_world_from_camera.rotation * view.camera.RayFromImage(pixel);
      const auto hit = renderer.FirstHit(true_world_from_camera.translation, ray);
      if (!hit || hit->head<2>().cwiseAbs().maxCoeff() > 0.5 * world.size_m) continue;
      const Cover cover = world.CoverAt(hit->x(), hit->y());
      const uint8_t value = view.picture.grass(row, col);
      const size_t called = value == 0 ? 2 : value >= 128 ? 0 : 1;
      ++score.pixels_of_cover[CoverName(cover)][called];
    }
  }
}

int CountDuplicates(const std::vector<Region>& regions) {
  int num_duplicates = 0;
  for (size_t i = 0; i < regions.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (OverlapRatio(regions[i].Footprint(), regions[j].Footprint()) <= kDuplicateOverlap) {
        continue;
      }
      ++num_duplicates;
      break;
    }
  }
  return num_duplicates;
}

}  // namespace

PoseScore ScorePoses(const EngineRun& run, const Scenario& scenario) {
  PoseScore score;
  const AdjustedBlock& block = run.evaluation.block;
  score.rms_before_px = block.rms_before_px;
  score.rms_after_px = block.rms_after_px;
  const auto exposure_of_id = ExposureOfId(scenario);
  std::vector<Eigen::Vector3d> errors;
  for (const AdjustedView& view : block.views) {
    ++score.num_views;
    if (!view.is_connected) continue;
    ++score.num_connected;
    const size_t i = exposure_of_id.at(view.frame_id);
    const Rigid3d truth = scenario.TrueWorldFromCamera(i);
    const Rigid3d before =
        WorldFromBody(scenario.exposures[i].reported) * scenario.rig.body_from_camera;
    const Eigen::Vector3d error = view.world_from_camera.translation - truth.translation;
    const Eigen::Vector3d error_before = before.translation - truth.translation;
    errors.push_back(error);
    score.shift += error;
    score.horizontal_before.Add(error_before.head<2>().norm());
    score.horizontal_after.Add(error.head<2>().norm());
    score.vertical_before.Add(error_before.z());
    score.vertical_after.Add(error.z());
    score.attitude_before.Add(DegFromRad(AngleBetween(before.rotation, truth.rotation)));
    score.attitude_after.Add(
        DegFromRad(AngleBetween(view.world_from_camera.rotation, truth.rotation)));
  }
  if (errors.empty()) return score;
  score.shift /= static_cast<double>(errors.size());
  for (const Eigen::Vector3d& error : errors) {
    score.horizontal_within.Add((error - score.shift).head<2>().norm());
  }
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
      CountHazard(score, truth, cell, layers.hazard(row, col));
      if (!map.IsSeen(row, col)) continue;
      const Cover cover = static_cast<Cover>(truth.cover(cell));
      const int8_t by_views = run.evaluation.cues.front().steps(row, col);
      if (by_views != CueSteps::kUnknown) {
        const double log_odds = by_views * CueSteps::kLogOdds;
        score.grass_by_views.Add(1.0 / (1.0 + std::exp(-log_odds)), cover == Cover::kMeadow);
      }
      if (IsOpenGround(cover)) {
        errors.push_back(map.elevation(row, col) -
                         scenario.world.SurfaceHeight(place.x(), place.y()));
        errors_of_places.push_back({place, errors.back()});
      }
      if (truth.free_distance(cell) < kSlopeSupportM) continue;  // trees reach into the support
      score.slope_error.Add(DegFromRad(layers.slope(row, col) - TrueSlope(scenario.world, place)));
      score.roughness_error.Add(layers.roughness(row, col) - TrueRoughness(scenario.world, place));
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

FrontendScore ScoreFrontend(const EngineRun& run, const Scenario& scenario) {
  FrontendScore score;
  const Renderer renderer(scenario.world);
  const auto exposure_of_id = ExposureOfId(scenario);
  std::map<int64_t, int> views_of_track;
  for (size_t i = 0; i < run.snapshot.views.size(); ++i) {
    const View& view = run.snapshot.views[i];
    for (const Observation& observation : view.observations) ++views_of_track[observation.track_id];
    if (i >= run.snapshot.kinds.size() || run.snapshot.kinds[i].grass.empty()) continue;
    ScoreMask(
        score,
        {view.world_from_camera, run.snapshot.rig.camera.With(view.readout), run.snapshot.kinds[i]},
        scenario.TrueWorldFromCamera(exposure_of_id.at(view.frame_id)),
        renderer,
        scenario.world);
  }
  for (const auto& [track, num_views] : views_of_track) score.track_length.Add(num_views);
  score.num_regions = static_cast<int>(run.regions.size());
  score.num_duplicates = CountDuplicates(run.regions);
  for (const Region& region : run.regions) {
    score.num_graded += region.grade > 0.0;
    for (const Eigen::Vector3d& corner : region.corners_in_world) {
      score.coarse_height_error.Add(corner.z() -
                                    scenario.world.GroundHeight(corner.x(), corner.y()));
    }
  }
  return score;
}

}  // namespace freelsd
