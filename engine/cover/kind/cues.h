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
  kViewLogOdds,
  kViewLogOddsNear,
  kViewLogOddsFar,
  kViewSpread,
  kVoteRatio,
  kVoteRatioNear,
  kNumViews,
  // --- Colour of the orthophoto ---
  kGreenness,
  kRedMinusBlue,
  kGreennessContrast,
  kBrightnessContrast,
  kColorOfOther,
  // --- Texture of the orthophoto ---
  kDetail,
  kDetailWide,
  kTuftTexture,
  kBushTexture,
  kGreenTexture,
  kShadow,
  // --- Things and crops in the orthophoto ---
  kObjectDeviation,
  kRowStrength,
  kRutDensity,
  kSprayed,
  kFence,
  // --- Two photographs ---
  kDisagreement,
  kDisagreementFar,
  // --- Heights ---
  kCoverHeight,
  kCoverHeightNear,
  kRoughness,
  kSlope,
  kHeightDeviation,
  kBump,
  kRise,
  kUnevenness,
  kRaisedBorder,
};
inline constexpr size_t kNumCues = 34;

// In the order of Cue; as in the files of freelsd-kinds.
extern const std::array<const char*, kNumCues> kCueNames;

struct CueInput {
  const ElevationMap& map;
  const GroundSurface& surface;
  const std::vector<GrassView>& grass_views;
  const Orthophoto& photo;
  // PhotoDisagreement; may be empty.
  cv::Mat1f disagreement;
};

// Called once for every cue that can be measured: one value per map cell, NaN where unknown.
using CueVisitor = std::function<void(Cue, const cv::Mat1f&)>;
void VisitCues(const CueInput& input, const CoverOptions& options, const CueVisitor& visit);

}  // namespace freelsd
