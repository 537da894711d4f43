#include "tests/evaluation/heights/height_scores.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// What the goals of these scores are about.
constexpr double kMinHeightM = 0.8;
constexpr double kMinWidthPx = 3.0;
constexpr double kMinParallaxPx = 1.5;
// Crowns as in young orchards and hedgerows; the rest of a wood is told apart.
constexpr double kMinCrownM = 1.5;
constexpr double kMaxCrownM = 4.0;
// Beside another kind of ground the height of a cell is not its own.
constexpr int kBorderCells = 2;
// As in things.cc: beyond it the engine takes no height for known.
constexpr float kMaxHeightSdM = 1.0f;
constexpr float kRaisedM = 0.5f;
constexpr double kWindowM = 20.0;
constexpr int64_t kMinInWindow = 30;

bool IsOpen(Cover cover) {
  return cover == Cover::kMeadow || cover == Cover::kStubble || cover == Cover::kSoil ||
         cover == Cover::kGravel || cover == Cover::kRoad;
}

std::string GroupOf(const Thing& thing) {
  if (thing.kind != Cover::kTree && thing.kind != Cover::kBareTree) return CoverName(thing.kind);
  const std::string leaves = thing.kind == Cover::kBareTree ? ", leafless" : "";
  if (thing.height < kMinCrownM) return "lower crowns" + leaves;
  return (thing.height <= kMaxCrownM ? "crowns 1.5-4 m" : "higher crowns") + leaves;
}

Eigen::Vector2d MiddleOf(const Thing& thing) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& place : thing.places) sum += place;
  return sum / static_cast<double>(thing.places.size());
}

double PixelOnGround(const Scenario& scenario, double height_above_ground) {
  return height_above_ground / scenario.rig.camera.MeanFocalPx();
}

bool IsSeen(const Scenario& scenario, const TruthMap& truth, const Eigen::Vector2d& place) {
  return scenario.seen(truth.CellAt(place)) != 0;
}

// Of the size that the goals are about.
bool Counts(const Thing& thing, const Scenario& scenario, const TruthMap& truth) {
  if (thing.height < kMinHeightM) return false;
  const Eigen::Vector2d middle = MiddleOf(thing);
  if (!IsSeen(scenario, truth, middle)) return false;
  const double ground = scenario.world.GroundHeight(middle.x(), middle.y());
  const double above = scenario.TrueWorldFromCamera(0).translation.z() - ground;
  const double pixel_m = PixelOnGround(scenario, above);
  if (thing.width < kMinWidthPx * pixel_m) return false;
  const double ratio = WidestBaselineRatio(scenario, {middle.x(), middle.y(), ground});
  return thing.height * ratio / pixel_m >= kMinParallaxPx;
}

bool IsKnown(const ElevationMap& map, int row, int col) {
  return map.IsSeen(row, col) && map.standard_deviation(row, col) <= kMaxHeightSdM;
}

struct CellError {
  double error = 0.0;
  double deviation = 0.0;
};

using Windows = std::map<std::pair<int, int>, std::vector<CellError>>;

std::pair<int, int> WindowAt(const Eigen::Vector2d& place) {
  return {static_cast<int>(std::floor(place.x() / kWindowM)),
          static_cast<int>(std::floor(place.y() / kWindowM))};
}

void AddWindow(const std::vector<CellError>& errors, OpenGroundScore& score) {
  Sums sums;
  for (const CellError& each : errors) sums.Add(each.error);
  if (sums.count < kMinInWindow) return;
  score.local_noise.Add(sums.Sd());
  for (const CellError& each : errors) {
    score.error_in_deviations.Add((each.error - sums.Mean()) / each.deviation);
  }
}

OpenGroundScore ScoreOpenGround(const Scenario& scenario,
                                const TruthMap& truth,
                                const ElevationMap& map,
                                const MapOffset& offset) {
  OpenGroundScore score;
  const cv::Mat1b is_open = OpenGround(truth) & scenario.seen;
  Windows windows;
  for (int row = 0; row < map.grid.num_rows; ++row) {
    for (int col = 0; col < map.grid.num_cols; ++col) {
      const Eigen::Vector2d on_map = map.grid.CellCenter(row, col);
      // One shift for all: steps between shifts of tiles would look like noise on a slope.
      const Eigen::Vector2d place = on_map - offset.shift;
      if (place.cwiseAbs().maxCoeff() >= 0.5 * truth.size_m) continue;
      if (is_open(truth.CellAt(place)) == 0) continue;
      ++score.num_cells;
      if (!IsKnown(map, row, col)) {
        ++score.num_unknown;
        continue;
      }
      score.num_raised += map.upper(row, col) - map.elevation(row, col) > kRaisedM;
      const double error = map.elevation(row, col) -
                           scenario.world.SurfaceHeight(place.x(), place.y()) -
                           offset.height.At(place);
      windows[WindowAt(place)].push_back({error, map.standard_deviation(row, col)});
    }
  }
  for (const auto& [window, errors] : windows) AddWindow(errors, score);
  return score;
}

}  // namespace

void HeightScore::Add(const HeightScore& other) {
  open.local_noise.Add(other.open.local_noise);
  open.error_in_deviations.Add(other.open.error_in_deviations);
  open.num_cells += other.open.num_cells;
  open.num_unknown += other.open.num_unknown;
  open.num_raised += other.open.num_raised;
  for (const auto& [group, counts] : other.things) {
    for (size_t i = 0; i < counts.size(); ++i) things[group][i] += counts[i];
  }
  missed.insert(missed.end(), other.missed.begin(), other.missed.end());
}

cv::Mat1b OpenGround(const TruthMap& truth) {
  cv::Mat1b is_open(truth.cover.size(), uint8_t{0});
  std::transform(truth.cover.begin(), truth.cover.end(), is_open.begin(), [](uint8_t cover) {
    return IsOpen(static_cast<Cover>(cover)) ? uint8_t{255} : uint8_t{0};
  });
  const int side = 2 * kBorderCells + 1;
  cv::erode(is_open, is_open, cv::Mat1b::ones(side, side));
  return is_open;
}

double WidestBaselineRatio(const Scenario& scenario, const Eigen::Vector3d& place_in_world) {
  std::vector<Eigen::Vector3d> cameras;
  for (size_t i = 0; i < scenario.exposures.size(); ++i) {
    const Rigid3d world_from_camera = scenario.TrueWorldFromCamera(i);
    const Eigen::Vector3d in_camera = Inverse(world_from_camera) * place_in_world;
    const auto pixel = scenario.rig.camera.ImageFromCamera(in_camera);
    if (pixel && scenario.rig.camera.IsInside(*pixel)) {
      cameras.push_back(world_from_camera.translation);
    }
  }
  double widest = 0.0;
  for (const Eigen::Vector3d& a : cameras) {
    for (const Eigen::Vector3d& b : cameras) {
      widest = std::max(widest, (a - b).head<2>().norm() / (a.z() - place_in_world.z()));
    }
  }
  return widest;
}

HeightScore ScoreHeights(const Scenario& scenario,
                         const TruthMap& truth,
                         const ElevationMap& map,
                         const HazardLayers& layers,
                         const MapOffset& offset) {
  HeightScore score;
  if (map.elevation.empty()) return score;
  score.open = ScoreOpenGround(scenario, truth, map, offset);
  for (const Thing& thing : ThingsWithin(scenario.world, map.grid)) {
    if (!Counts(thing, scenario, truth)) continue;
    const ThingFate fate = FateOfThing(thing, scenario.world, map, layers, offset);
    ++score.things[GroupOf(thing)][static_cast<size_t>(fate)];
    if (fate == ThingFate::kHazard || fate == ThingFate::kMissed) {
      score.missed.emplace_back(GroupOf(thing), MiddleOf(thing));
    }
  }
  return score;
}

}  // namespace freelsd
