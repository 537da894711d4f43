#include "tests/evaluation/scores/things.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr std::array<Cover, 9> kKindsThatStand{Cover::kTree,
                                               Cover::kBareTree,
                                               Cover::kHedge,
                                               Cover::kHouse,
                                               Cover::kBoulder,
                                               Cover::kVehicle,
                                               Cover::kAnimal,
                                               Cover::kFence,
                                               Cover::kPole};
constexpr double kMinHeightM = 0.3;
constexpr double kHeightToleranceM = 1.0;
// Of low things the tolerance is this share of the height: bare ground shows no boulder.
constexpr double kToleranceOfHeight = 0.5;
// Beyond it the engine takes no height for known (SurfaceOptions, ApproachOptions).
constexpr float kMaxHeightSdM = 1.0f;

std::string ClassOf(double value, double low, double high, const char* const names[3]) {
  return value < low ? names[0] : value <= high ? names[1] : names[2];
}

// Cells of the world whose centre lies in the grid.
cv::Rect CellsWithin(const World& world, const Grid& grid) {
  const Eigen::Vector2d size(grid.num_cols * grid.cell_size_m, grid.num_rows * grid.cell_size_m);
  const Eigen::Vector2d middle =
      grid.north_west_in_world + Eigen::Vector2d(0.5, -0.5).cwiseProduct(size);
  const cv::Range cols = world.CellsAround(middle.x(), 0.5 * size.x());
  const cv::Range rows = world.CellsAround(middle.y(), 0.5 * size.y());
  return {cols.start, rows.start, cols.size(), rows.size()};
}

// Diameter of the widest circle, by the centres of cells: n cells side by side are n wide.
double WidthOf(const cv::Mat1b& mask, double cell_size) {
  cv::Mat1b padded;
  cv::copyMakeBorder(mask, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::Mat1f distance;
  cv::distanceTransform(padded, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  double largest = 0.0;
  cv::minMaxLoc(distance, nullptr, &largest);
  return (2.0 * largest - 1.0) * cell_size;
}

double HeightAt(const World& world, int row, int col) {
  return world.surface(row, col) - world.ground(row, col);
}

// `box`: of the component, in cells of the world.
Thing ThingOf(const World& world, Cover kind, const cv::Rect& box, const cv::Mat1b& mask) {
  Thing thing;
  thing.kind = kind;
  thing.width = WidthOf(mask, world.cell_size_m);
  for (int row = 0; row < box.height; ++row) {
    for (int col = 0; col < box.width; ++col) {
      if (mask(row, col) == 0) continue;
      thing.height = std::max(thing.height, HeightAt(world, box.y + row, box.x + col));
      thing.places.emplace_back(world.CellCenter(box.x + col), world.CellCenter(box.y + row));
    }
  }
  return thing;
}

Eigen::Vector2d MiddleOf(const Thing& thing) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& place : thing.places) sum += place;
  return sum / static_cast<double>(thing.places.size());
}

// Most of its ground is.
bool IsPhotographed(const Thing& thing, const Scenario& scenario) {
  const double half = 0.5 * scenario.world.size_m;
  const auto num_seen =
      std::count_if(thing.places.begin(), thing.places.end(), [&](const Eigen::Vector2d& place) {
        const int row = static_cast<int>(place.y() + half);
        const int col = static_cast<int>(place.x() + half);
        return scenario.seen(std::min(row, scenario.seen.rows - 1),
                             std::min(col, scenario.seen.cols - 1)) != 0;
      });
  return 2 * static_cast<size_t>(num_seen) >= thing.places.size();
}

bool IsKnown(const ElevationMap& map, const HazardLayers& layers, const cv::Point& cell) {
  return layers.hazard(cell) != kUnseen && map.IsSeen(cell.y, cell.x) &&
         map.standard_deviation(cell) <= kMaxHeightSdM;
}

// What the map says over all cells of a thing.
struct Reading {
  // Upper height over the true ground, without the error of the whole map; -infinity where unseen.
  double height = -std::numeric_limits<double>::infinity();
  size_t num_unknown = 0;
  size_t num_hazard = 0;
};

Reading ReadMap(const Thing& thing,
                const World& world,
                const ElevationMap& map,
                const HazardLayers& layers,
                const MapOffset& offset) {
  Reading reading;
  for (const Eigen::Vector2d& place : thing.places) {
    const auto cell = map.grid.CellAt(place + offset.ShiftAt(place));
    if (!cell || !IsKnown(map, layers, *cell)) {
      ++reading.num_unknown;
    } else if (layers.hazard(*cell) == kHazard) {
      ++reading.num_hazard;
    }
    if (!cell || !std::isfinite(map.upper(*cell))) continue;
    const double ground = world.GroundHeight(place.x(), place.y()) + offset.height.At(place);
    reading.height = std::max(reading.height, map.upper(*cell) - ground);
  }
  return reading;
}

}  // namespace

std::string Thing::ClassName() const {
  constexpr const char* kWidths[] = {"<1", "1-3", ">3"};
  constexpr const char* kHeights[] = {"<0.5", "0.5-1.5", ">1.5"};
  return std::string(CoverName(kind)) + "/" + ClassOf(width, 1.0, 3.0, kWidths) + "/" +
         ClassOf(height, 0.5, 1.5, kHeights);
}

std::vector<Thing> ThingsWithin(const World& world, const Grid& grid) {
  constexpr int kEightNeighbours = 8;
  const cv::Rect window = CellsWithin(world, grid);
  std::vector<Thing> things;
  if (window.empty()) return things;
  for (const Cover kind : kKindsThatStand) {
    const cv::Mat1b mask = world.cover(window) == static_cast<uint8_t>(kind);
    cv::Mat1i label, stats;
    cv::Mat1d centroids;
    const int num_labels =
        cv::connectedComponentsWithStats(mask, label, stats, centroids, kEightNeighbours);
    for (int i = 1; i < num_labels; ++i) {
      const cv::Rect box(stats(i, cv::CC_STAT_LEFT),
                         stats(i, cv::CC_STAT_TOP),
                         stats(i, cv::CC_STAT_WIDTH),
                         stats(i, cv::CC_STAT_HEIGHT));
      Thing thing = ThingOf(world, kind, box + window.tl(), label(box) == i);
      if (thing.height > kMinHeightM) things.push_back(std::move(thing));
    }
  }
  return things;
}

ThingFate FateOfThing(const Thing& thing,
                      const World& world,
                      const ElevationMap& map,
                      const HazardLayers& layers,
                      const MapOffset& offset) {
  const Reading reading = ReadMap(thing, world, map, layers, offset);
  const double tolerance = std::min(kHeightToleranceM, kToleranceOfHeight * thing.height);
  if (reading.height >= thing.height - tolerance) return ThingFate::kFound;
  const size_t num_places = thing.places.size();
  if (2 * reading.num_unknown >= num_places) return ThingFate::kUnknown;
  if (2 * (reading.num_unknown + reading.num_hazard) >= num_places) return ThingFate::kHazard;
  return ThingFate::kMissed;
}

ThingScores ScoreThings(const Scenario& scenario,
                        const ElevationMap& map,
                        const HazardLayers& layers,
                        const MapOffset& offset) {
  ThingScores scores;
  if (map.elevation.empty()) return scores;
  for (const Thing& thing : ThingsWithin(scenario.world, map.grid)) {
    if (!IsPhotographed(thing, scenario)) continue;
    const ThingFate fate = FateOfThing(thing, scenario.world, map, layers, offset);
    ++scores.counts[thing.ClassName()][static_cast<size_t>(fate)];
    if (fate == ThingFate::kMissed) {
      scores.missed.emplace_back(thing.ClassName(), MiddleOf(thing));
    }
  }
  return scores;
}

}  // namespace freelsd
