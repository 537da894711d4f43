#include "server/training/segmentation_scores.h"

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "server/training/labelled_regions.h"

namespace freelsd {
namespace {

using Json = nlohmann::ordered_json;

// One labelled pixel is enough for a region to have a class.
constexpr double kAnyLabel = 0.0;

Json Ratio(double part, double whole) {
  if (whole > 0.0) return part / whole;
  return nullptr;
}

// Sums over regions, in labelled pixels.
struct Tally {
  double agreeing = 0.0;
  double labelled = 0.0;
  double grass_region_agreeing = 0.0;
  double grass_region_labelled = 0.0;
  double covered_sum = 0.0;
  int num_photographs_with_grass = 0;
};

void AddRegion(double grass, double other, Tally& tally) {
  tally.agreeing += std::max(grass, other);
  tally.labelled += grass + other;
  if (grass <= other) return;
  tally.grass_region_agreeing += grass;
  tally.grass_region_labelled += grass + other;
}

void AddPhotograph(const LabelledRegions& regions, Tally& tally) {
  std::vector<double> grass(regions.classes.size() + 1, 0.0), other(grass);
  for (int y = 0; y < regions.mask.rows; ++y) {
    for (int x = 0; x < regions.mask.cols; ++x) {
      const int surface_class = regions.mask(y, x);
      const auto label = static_cast<size_t>(regions.segments.labels(y, x));
      if (surface_class == kGrassClass) {
        grass[label] += 1.0;
      } else if (TellsGrass(surface_class)) {
        other[label] += 1.0;
      }
    }
  }
  double covered = 0.0;
  for (size_t label = 1; label < grass.size(); ++label) {
    AddRegion(grass[label], other[label], tally);
    covered += grass[label];
  }
  if (covered + grass[0] == 0.0) return;
  tally.covered_sum += covered / (covered + grass[0]);
  ++tally.num_photographs_with_grass;
}

Json AsJson(const Tally& tally) {
  return {{"covered", Ratio(tally.covered_sum, tally.num_photographs_with_grass)},
          {"purity", Ratio(tally.agreeing, tally.labelled)},
          {"grass_purity", Ratio(tally.grass_region_agreeing, tally.grass_region_labelled)}};
}

}  // namespace

Json SegmentationScores(const Photographs& photographs, const SegmentationOptions& options) {
  Tally all;
  std::map<std::string, Tally> by_place;
  for (const LabelledPhotograph& photograph : photographs) {
    const LabelledRegions regions = CutPhotograph(photograph, options, kAnyLabel);
    AddPhotograph(regions, all);
    AddPhotograph(regions, by_place[photograph.place]);
  }
  Json scores;
  scores["all"] = AsJson(all);
  for (const auto& [place, tally] : by_place) scores[place] = AsJson(tally);
  return scores;
}

}  // namespace freelsd
