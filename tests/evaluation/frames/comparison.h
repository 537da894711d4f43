// Input: measures of tiles. Output: their spread, and where a world lies outside of what
// photographs show.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/evaluation/frames/tile_measures.h"

namespace freelsd {

// Linear between neighbours in order; `share` in [0, 1]. NaN if there are no values.
double Quantile(std::vector<double> values, double share);

struct Spread {
  double low = 0.0;  // 5 % lie below
  double median = 0.0;
  double high = 0.0;  // 5 % lie above
};
Spread SpreadOf(const std::vector<double>& values);

// How far a median lies outside of a spread, in widths of the spread; 0 inside. A spread is at
// least 0.01 wide.
double DistanceOutside(double median, const Spread& recorded);

struct LookTiles {
  std::vector<Measures> measures;
  // Pictures that show such tiles.
  int num_pictures = 0;
};
// Tiles of each cover and look.
using TilesOfLooks = std::map<Cover, std::map<std::string, LookTiles>>;

// Fewer tiles than this are shown and never flagged.
constexpr size_t kMinNumTiles = 10;

// {cover: {"tiles": {look: {...}}, "measures": {measure: {look: {"low", "median", "high",
// "distance_outside"}}}}}. "distance_outside" is missing for photographs and where tiles are few.
nlohmann::json CompareLooks(const TilesOfLooks& tiles);

// Tables in Markdown, one per cover, and the flags, largest first. `report` has "covers" as
// CompareLooks makes it.
std::string ComparisonAsMarkdown(const nlohmann::json& report);

}  // namespace freelsd
