#include "tests/evaluation/scores/blinding.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/hazard/distance_transform.h"
#include "tests/evaluation/scores/decoys.h"
#include "tests/evaluation/scores/field_scores.h"
#include "tests/evaluation/truth_run.h"

namespace freelsd {
namespace {

constexpr double kShiftM = 5.0;
constexpr float kRaise = 2.0f;
constexpr float kFlatten = 0.0f;
constexpr size_t kMaxNumDecoys = 10;

const std::vector<std::pair<std::string, Blinding>>& NamedBlindings() {
  static const std::vector<std::pair<std::string, Blinding>> kBlindings{
      {"none", Blinding::kNone},
      {"hazards", Blinding::kHazards},
      {"shift", Blinding::kShift},
      {"kinds", Blinding::kKinds},
      {"heights", Blinding::kHeights},
      {"flat", Blinding::kFlat}};
  return kBlindings;
}

// `change` maps each value that is not kUnseen. Free ground is grass then, and hazard is none: no
// region without grass is planned on.
template <typename Change>
void ChangeHazards(HazardLayers& layers, Change change) {
  layers.hazard = layers.hazard.clone();
  layers.grass = layers.grass.clone();
  for (int row = 0; row < layers.hazard.rows; ++row) {
    for (int col = 0; col < layers.hazard.cols; ++col) {
      uint8_t& hazard = layers.hazard(row, col);
      if (hazard == kUnseen) continue;
      hazard = change(hazard);
      layers.grass(row, col) = hazard == kFree ? 1.0f : 0.0f;
    }
  }
  layers.distance = DistanceToHazard(layers.hazard, layers.grid.cell_size_m);
}

float MedianHeight(const cv::Mat1f& elevation) {
  std::vector<float> heights;
  std::copy_if(elevation.begin(), elevation.end(), std::back_inserter(heights), [](float height) {
    return std::isfinite(height);
  });
  if (heights.empty()) return 0.0f;
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  return *middle;
}

cv::Mat1f Stretched(const cv::Mat1f& heights, float median, float factor) {
  cv::Mat1f stretched = heights.clone();
  for (float& height : stretched) {
    if (height > median) height = median + factor * (height - median);
  }
  return stretched;
}

void StretchHeights(ElevationMap& map, float factor) {
  const float median = MedianHeight(map.elevation);
  map.elevation = Stretched(map.elevation, median, factor);
  map.upper = Stretched(map.upper, median, factor);
}

}  // namespace

std::vector<std::string> BlindingNames() {
  std::vector<std::string> names;
  names.reserve(NamedBlindings().size());
  for (const auto& [name, blinding] : NamedBlindings()) names.push_back(name);
  return names;
}

std::optional<Blinding> BlindingNamed(const std::string& name) {
  for (const auto& [known, blinding] : NamedBlindings()) {
    if (known == name) return blinding;
  }
  return std::nullopt;
}

std::string NameOf(Blinding blinding) {
  for (const auto& [name, known] : NamedBlindings()) {
    if (known == blinding) return name;
  }
  return "";
}

AssessedMap Blinded(const ElevationMap& map, const HazardLayers& layers, Blinding blinding) {
  AssessedMap blinded{map, layers};
  switch (blinding) {
    case Blinding::kNone:
      break;
    case Blinding::kHazards:
      ChangeHazards(blinded.layers, [](uint8_t) { return uint8_t{kFree}; });
      break;
    case Blinding::kShift:
      blinded.map.grid.north_west_in_world.x() += kShiftM;
      blinded.layers.grid = blinded.map.grid;
      break;
    case Blinding::kKinds:
      ChangeHazards(blinded.layers, [](uint8_t hazard) {
        return hazard == kFree ? uint8_t{kHazard} : uint8_t{kFree};
      });
      break;
    case Blinding::kHeights:
      StretchHeights(blinded.map, kRaise);
      break;
    case Blinding::kFlat:
      StretchHeights(blinded.map, kFlatten);
      break;
  }
  return blinded;
}

EngineRun RunBlinded(const Scenario& scenario,
                     const TruthMap& truth,
                     const Fields& fields,
                     const EngineRun& run,
                     Blinding blinding,
                     const ApproachOptions& options) {
  EngineRun blinded = run;
  AssessedMap assessed = Blinded(run.evaluation.map, run.evaluation.hazards, blinding);
  blinded.evaluation.map = std::move(assessed.map);
  blinded.evaluation.hazards = std::move(assessed.layers);
  blinded.evaluation.sites.clear();
  blinded.regions.clear();
  for (const Field& field : fields.fields) {
    blinded.regions.push_back(RegionAround(fields.label, field.id, truth));
  }
  const int first_decoy = static_cast<int>(fields.fields.size()) + 1;
  for (Region& decoy : LargestDecoys(scenario, truth, kMaxNumDecoys, first_decoy)) {
    blinded.regions.push_back(std::move(decoy));
  }
  if (blinded.evaluation.map.elevation.empty()) return blinded;
  // The limit on the risk sees slopes and heights that the blinded layers deny.
  Aircraft aircraft = scenario.aircraft;
  aircraft.max_failure_probability = 1.0;
  for (const Region& region : blinded.regions) {
    Site site;
    site.region = region;
    site.wind = run.evaluation.wind;
    site.plan = PlanApproach(blinded.evaluation.map,
                             blinded.evaluation.hazards,
                             RequestOfRun(run, scenario, region),
                             aircraft,
                             options);
    blinded.evaluation.sites.push_back(std::move(site));
  }
  return blinded;
}

}  // namespace freelsd
