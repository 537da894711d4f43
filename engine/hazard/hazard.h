// Input: elevation map, its surface, and the cover of the ground. Output: slope, roughness, grass,
// hazard and the distance to the nearest hazard. Paper: Sec. III-G.
#pragma once

#include <array>
#include <limits>

#include "engine/cover/cover.h"

namespace freelsd {

struct HazardOptions {
  SurfaceOptions surface;
  CoverOptions cover;

  void Check() const;
};

// Limits of the aircraft. A cell that exceeds one of these limits is a hazard.
struct HazardLimits {
  // Reduced by the deviation of the map's tilt (ElevationMap), because the whole map may be tilted.
  double max_slope_deg = 8.0;
  double max_roughness_m = 0.5;
};

// - kUnseen: elevation, slope or roughness is unknown or too uncertain.
// - kHazard: seen, and one of these: not grass, without a class, too steep, too rough, an object.
// - kFree: all others.
enum Hazard : uint8_t { kFree = 0, kHazard = 1, kUnseen = 2 };

struct HazardLayers {
  Grid grid;
  // Radians; NaN where unseen.
  cv::Mat1f slope;
  // Terrain ruggedness index (Riley): square root of the sum of squared height differences to the 8
  // neighbours, metres.
  cv::Mat1f roughness;
  // As in GroundCover. `kind` is empty on maps that were stored before there were kinds.
  cv::Mat1f grass;
  cv::Mat1b kind;
  // Hazard values.
  cv::Mat1b hazard;
  // Exact distance, metres, from the cell's centre to the nearest centre of a cell that is not
  // kFree. Cells outside the grid count as unseen.
  cv::Mat1f distance;
  // A cell with at least this posterior of grass has a clear class (ClearClassOptions).
  double min_clear_class_posterior = ClearClassOptions{}.min_clear_class_posterior;
  // A cell with at least this posterior of grass is grass (CoverOptions).
  double min_grass_posterior = CoverOptions{}.min_grass_posterior;
  // A cell whose upper height is farther above its elevation holds an object (CellRulesAt).
  double max_object_height_m = HazardLimits{}.max_roughness_m + CoverOptions{}.upper_margin_m;
};

// The conditions that a free cell meets. kSeen: elevation, slope and roughness are known well
// enough.
enum class CellCondition { kSeen, kGrass, kNotSteep, kNotRough, kNoObject };

// Result of checking one condition in one cell.
struct CellRule {
  CellCondition condition = CellCondition::kSeen;
  bool passed = false;
  // kSeen: standard deviation of elevation. kGrass: posterior. kNotSteep: slope, radians.
  // kNotRough: roughness. kNoObject: upper height above elevation, metres. NaN where unknown.
  double value = std::numeric_limits<double>::quiet_NaN();
  // Least allowed value for kGrass, largest allowed value for the other conditions.
  double limit = 0.0;
};
// In the order of CellCondition. A cell is kUnseen if the first rule fails, and kFree if all rules
// pass.
using CellRules = std::array<CellRule, 5>;
CellRules CellRulesAt(const ElevationMap& map,
                      const HazardLayers& layers,
                      const cv::Point& cell,
                      const HazardLimits& limits,
                      const HazardOptions& options);

// A map and its layers, on the same grid.
struct AssessedMap {
  ElevationMap map;
  HazardLayers layers;
};

// Steps of the values of a finished map. A map is rounded before anything is planned on it, so that
// a plan on the stored map equals the plan made at once.
struct MapSteps {
  // Heights and deviations, metres. All are multiples of 2^-7, which a float holds exactly.
  static constexpr float kHeightM = 1.0f / 128.0f;
  static constexpr float kSlope = 1.0f / 4096.0f;  // radians
  static constexpr float kRoughnessM = 1.0f / 512.0f;
  // Posterior of grass.
  static constexpr float kGrass = 1.0f / 254.0f;
  // Values in units of these steps are at most this, in a tile or above the elevation.
  static constexpr int kMaxNumSteps = 65000;
};

// Elevation is rounded to the nearest step. All other values are rounded to the unsafe side: upper
// height, deviation, slope and roughness up, number of points and posterior of grass down. A value
// that needs more than kMaxNumSteps becomes unknown, or, if it counts from the elevation, the
// largest one. Hazard and distance stay: apply WithLimits.
AssessedMap Rounded(const ElevationMap& map, const HazardLayers& layers);

// A copy of a part of a map. `cells` lie in its grid.
AssessedMap WindowOf(const ElevationMap& map, const HazardLayers& layers, const cv::Rect& cells);

// The finished map: with its cover, rounded, and with its layers.
AssessedMap AssessHazards(const ElevationMap& map,
                          const GroundSurface& surface,
                          const GroundCover& cover,
                          const HazardLimits& limits,
                          const HazardOptions& options);

// Computes hazard and distance again for other limits; the other layers do not depend on limits.
HazardLayers WithLimits(const ElevationMap& map,
                        const HazardLayers& layers,
                        const HazardLimits& limits,
                        const HazardOptions& options);

}  // namespace freelsd
