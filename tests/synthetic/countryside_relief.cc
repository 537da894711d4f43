#include "tests/synthetic/countryside_relief.h"

#include <cmath>

#include "tests/synthetic/crops.h"

namespace freelsd {
namespace {

// Purposes of randomness; 601 and 609 are the layout's.
enum Purpose : uint64_t {
  kHills = 602,
  kRolls,
  kSwells,
  kTufts,
  kClods,
  kBushes,
  kTussocks,
};

constexpr double kHillHeightM = 20.0;
constexpr double kHillRadiusM = 62.0;

}  // namespace

CountrysideRelief::CountrysideRelief(const WorldOptions& options)
    : relief_sd_m_(options.relief_sd_m),
      hills_(MixSeed(options.seed, kHills), 150.0),
      rolls_(MixSeed(options.seed, kRolls), 60.0),
      swells_(MixSeed(options.seed, kSwells), 3.0),
      tufts_(MixSeed(options.seed, kTufts), 0.5),
      clods_(MixSeed(options.seed, kClods), 0.4),
      bushes_(MixSeed(options.seed, kBushes), 1.3),
      tussocks_(MixSeed(options.seed, kTussocks), 1.6) {}

double CountrysideRelief::GroundAt(double x, double y) const {
  const double r = (Eigen::Vector2d(x, y) - hill_).norm() / kHillRadiusM;
  return relief_sd_m_ * (hills_.At(x, y) + 0.10 * rolls_.At(x, y)) +
         kHillHeightM * std::exp(-0.5 * r * r);
}

double CountrysideRelief::GrowthAt(Cover cover, uint8_t variant, double x, double y) const {
  switch (cover) {
    case Cover::kMeadow:
      return 0.04 * tufts_.At(x, y) + 0.02 * swells_.At(x, y);
    case Cover::kCrop:
      return CropOf(variant).height_m + 0.05 * tufts_.At(x, y) + 0.03 * swells_.At(x, y);
    case Cover::kSoil:
    case Cover::kStubble:
      return 0.06 * clods_.At(x, y);
    case Cover::kScrub:
      return std::max(0.0, 0.8 + 0.35 * static_cast<double>(bushes_.At(x, y)));
    default:
      return 0.0;
  }
}

double CountrysideRelief::TussocksAt(double x, double y) const {
  return std::max(0.0, 0.25 + 0.3 * static_cast<double>(tussocks_.At(x, y)));
}

}  // namespace freelsd
