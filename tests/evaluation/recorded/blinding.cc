#include "tests/evaluation/recorded/blinding.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "engine/hazard/distance_transform.h"
#include "tests/evaluation/recorded/ground_heights.h"

namespace freelsd {
namespace {

constexpr double kShiftEastM = 5.0;

void SetClasses(AssessedMap* map, Hazard free_becomes) {
  HazardLayers& layers = map->layers;
  layers.hazard = layers.hazard.clone();
  layers.grass = layers.grass.clone();
  for (int row = 0; row < layers.hazard.rows; ++row) {
    for (int col = 0; col < layers.hazard.cols; ++col) {
      uint8_t& hazard = layers.hazard(row, col);
      if (hazard == kUnseen) continue;
      hazard = hazard == kFree ? free_becomes : kFree;
      layers.grass(row, col) = hazard == kFree ? 1.0f : 0.0f;
    }
  }
  layers.distance = DistanceToHazard(layers.hazard, layers.grid.cell_size_m);
}

void Shift(AssessedMap* map) {
  map->map.grid.north_west_in_world.x() += kShiftEastM;
  map->layers.grid.north_west_in_world.x() += kShiftEastM;
}

void DoubleHeights(AssessedMap* map) {
  const double median = GroundHeights(map->map.grid, map->map.elevation).median();
  for (cv::Mat1f* heights : {&map->map.elevation, &map->map.upper}) {
    *heights = heights->clone();
    for (float& height : *heights) {
      if (height > median) height = static_cast<float>(median + 2.0 * (height - median));
    }
  }
}

void Flatten(AssessedMap* map) {
  const auto median = static_cast<float>(GroundHeights(map->map.grid, map->map.elevation).median());
  for (cv::Mat1f* heights : {&map->map.elevation, &map->map.upper}) {
    *heights = heights->clone();
    for (float& height : *heights) {
      if (!std::isnan(height)) height = median;
    }
  }
}

}  // namespace

std::vector<Blinding> AllBlindings() {
  return {
      Blinding::kHazards, Blinding::kShift, Blinding::kKinds, Blinding::kHeights, Blinding::kFlat};
}

const char* NameOf(Blinding blinding) {
  switch (blinding) {
    case Blinding::kHazards:
      return "hazards";
    case Blinding::kShift:
      return "shift";
    case Blinding::kKinds:
      return "kinds";
    case Blinding::kHeights:
      return "heights";
    case Blinding::kFlat:
      break;
  }
  return "flat";
}

Blinding BlindingNamed(const std::string& name) {
  for (const Blinding blinding : AllBlindings()) {
    if (name == NameOf(blinding)) return blinding;
  }
  throw std::invalid_argument("--blind: \"" + name + "\" is not a blinding");
}

AssessedMap Blinded(AssessedMap map, Blinding blinding) {
  switch (blinding) {
    case Blinding::kHazards:
      SetClasses(&map, kFree);
      break;
    case Blinding::kShift:
      Shift(&map);
      break;
    case Blinding::kKinds:
      SetClasses(&map, kHazard);
      break;
    case Blinding::kHeights:
      DoubleHeights(&map);
      break;
    case Blinding::kFlat:
      Flatten(&map);
      break;
  }
  return map;
}

}  // namespace freelsd
