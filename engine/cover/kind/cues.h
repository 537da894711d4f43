// Input: the map, its surface, the views' masks and the orthophoto. Output: cues, which are
// measures of the ground that tell grass to land on from other ground. No cue decides alone
// (kind.h).
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "engine/cover/cover.h"

namespace freelsd {

enum class Cue {
  // --- Masks of the views ---
  // Mean log-odds of grass, of the cell and around it.
  kViewLogOdds,
  kViewLogOddsNear,
  // --- Orthophoto ---
  // Excess green, less that of the surroundings.
  kGreennessContrast,
  // Logarithm of the deviation of brightness or greenness within a band of sizes.
  kDetail,
  kTuftTexture,
  kGreenTexture,
  // Log brightness of the darkest part, less that of the surroundings.
  kShadow,
  // --- Crops in the orthophoto ---
  kRowStrength,
  kRutDensity,
  kSprayed,
  // --- Heights ---
  // Upper height above elevation, around the cell.
  kCoverHeight,
  // Logarithms.
  kRoughness,
  kHeightDeviation,
  kUnevenness,
  // Share of the border of even ground that stands above what is beside it.
  kRaisedBorder,
};
inline constexpr size_t kNumCues = 15;

// In the order of Cue; as in the files of freelsd-kinds.
extern const std::array<const char*, kNumCues> kCueNames;

struct CueInput {
  const ElevationMap& map;
  const GroundSurface& surface;
  const std::vector<GrassView>& grass_views;
  const Orthophoto& photo;
};

// Called once for every cue that can be measured: one value per map cell, NaN where unknown.
using CueVisitor = std::function<void(Cue, const cv::Mat1f&)>;
void VisitCues(const CueInput& input, const CoverOptions& options, const CueVisitor& visit);

}  // namespace freelsd
