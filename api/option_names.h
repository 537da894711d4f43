// Shared by options_table.h and ground_options_table.h: the names of enum values in JSON, and a
// concept for the parameters of VisitFields.
#pragma once

#include <concepts>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/pipeline.h"

namespace freelsd {

// Satisfied by `Options` and `const Options`: one VisitFields serves to parse and to print.
template <class T, class Options>
concept Of = std::same_as<std::remove_const_t<T>, Options>;

// Names of an enum's values in JSON.
template <class Enum>
using EnumNames = std::vector<std::pair<Enum, std::string_view>>;

// Without kNone: who wants no preset gives none.
inline EnumNames<Preset> NamesOf(Preset) { return {{Preset::kPaper, "paper"}}; }

inline EnumNames<SegmentationThresholds> NamesOf(SegmentationThresholds) {
  return {{SegmentationThresholds::kGroundSampling, "ground_sampling"},
          {SegmentationThresholds::kPaper, "paper"}};
}

inline EnumNames<CoverMethod> NamesOf(CoverMethod) {
  return {{CoverMethod::kRules, "rules"}, {CoverMethod::kEvidence, "evidence"}};
}

inline EnumNames<GrassFusion> NamesOf(GrassFusion) {
  return {{GrassFusion::kPosterior, "posterior"}, {GrassFusion::kPaperOr, "paper"}};
}

inline EnumNames<HeightMethod> NamesOf(HeightMethod) {
  return {{HeightMethod::kPairs, "pairs"}, {HeightMethod::kPhotographs, "photographs"}};
}

inline EnumNames<SlopeSupport> NamesOf(SlopeSupport) {
  return {{SlopeSupport::kPlane, "plane"}, {SlopeSupport::kPaperPca, "paper"}};
}

}  // namespace freelsd
