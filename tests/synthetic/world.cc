#include "tests/synthetic/world.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

void Require(bool holds, const char* field, double value, const char* constraint) {
  if (holds) return;
  std::ostringstream message;
  message << "world." << field << " = " << value << ": must be in " << constraint;
  throw std::invalid_argument(message.str());
}

// Purposes of noise, so that no two things share a pattern.
constexpr uint64_t kCrownShape = 101;
constexpr uint64_t kCrownLumps = 102;
constexpr uint64_t kHedgeTop = 103;
constexpr uint64_t kTwigs = 104;

// The crown of a broad-leaved tree seen from above reaches down to this share of its height.
constexpr double kCrownBaseRatio = 0.35;
constexpr double kCrownLumpWavelengthM = 1.1;
constexpr double kCrownLumpHeightM = 0.35;
constexpr double kCrownOutlineRatio = 0.14;
// Twigs of a leafless crown cover about a sixth of the ground; around the stem all of it.
constexpr double kTwigWavelengthM = 0.5;
constexpr float kTwigRarity = 1.0f;
constexpr double kStemRatio = 0.12;

}  // namespace

const char* CoverName(Cover cover) {
  switch (cover) {
    case Cover::kMeadow:
      return "meadow";
    case Cover::kStubble:
      return "stubble";
    case Cover::kSoil:
      return "soil";
    case Cover::kScrub:
      return "scrub";
    case Cover::kGravel:
      return "gravel";
    case Cover::kRoad:
      return "road";
    case Cover::kTree:
      return "tree";
    case Cover::kHedge:
      return "hedge";
    case Cover::kHouse:
      return "house";
    case Cover::kCrop:
      return "crop";
    case Cover::kWater:
      return "water";
    case Cover::kBareTree:
      return "bare tree";
    case Cover::kBoulder:
      return "boulder";
    case Cover::kDitch:
      return "ditch";
    case Cover::kFence:
      return "fence";
    case Cover::kPole:
      return "pole";
    case Cover::kVehicle:
      return "vehicle";
    case Cover::kAnimal:
      return "animal";
    case Cover::kDoubt:
      return "doubt";
  }
  return "unknown";
}

Cover CoverNamed(const std::string& name) {
  for (int cover = 0; cover < kNumCovers; ++cover) {
    if (name == CoverName(static_cast<Cover>(cover))) return static_cast<Cover>(cover);
  }
  throw std::invalid_argument("no cover is named " + name);
}

void WorldOptions::Check() const {
  Require(size_m >= 20.0 && size_m <= 2000.0, "size_m", size_m, "[20, 2000]");
  Require(cell_size_m >= 0.05 && cell_size_m <= 2.0, "cell_size_m", cell_size_m, "[0.05, 2]");
  Require(relief_sd_m >= 0.0 && relief_sd_m <= 20.0, "relief_sd_m", relief_sd_m, "[0, 20]");
  Require(
      wind_speed_mps >= 0.0 && wind_speed_mps <= 9.0, "wind_speed_mps", wind_speed_mps, "[0, 9]");
}

int World::CellIndex(double coordinate) const {
  const int index = static_cast<int>(std::floor((coordinate + 0.5 * size_m) / cell_size_m));
  return std::clamp(index, 0, num_cells() - 1);
}

cv::Range World::CellsAround(double coordinate, double reach_m) const {
  const double first = std::ceil(CellFrom(coordinate - reach_m));
  const double last = std::floor(CellFrom(coordinate + reach_m));
  const int begin = static_cast<int>(std::clamp(first, 0.0, static_cast<double>(num_cells())));
  const int end = static_cast<int>(std::clamp(last + 1.0, 0.0, static_cast<double>(num_cells())));
  return {begin, std::max(begin, end)};
}

double World::GroundHeight(double x, double y) const {
  return Bilinear(ground, CellFrom(x), CellFrom(y));
}

double World::SurfaceHeight(double x, double y) const {
  return Bilinear(surface, CellFrom(x), CellFrom(y));
}

Cover World::CoverAt(double x, double y) const {
  return static_cast<Cover>(cover(CellIndex(y), CellIndex(x)));
}

double World::TopHeight(double x, double y) const {
  const int row = CellIndex(y), col = CellIndex(x);
  return overhead.empty() ? surface(row, col) : overhead(row, col);
}

bool World::IsWireAt(double x, double y) const {
  const int row = CellIndex(y), col = CellIndex(x);
  return !overhead.empty() && overhead(row, col) > surface(row, col);
}

void World::Build(const House& house) {
  const double reach = 0.5 * std::hypot(house.length_m, house.width_m) + cell_size_m;
  const Eigen::Vector2d along = DirectionOf(house.heading);
  const Eigen::Vector2d across(along.y(), -along.x());
  // A house stands level, at the height of the ground under its middle.
  const double floor = GroundHeight(house.center.x(), house.center.y());
  const double half_length = 0.5 * house.length_m, half_width = 0.5 * house.width_m;
  const cv::Range rows = CellsAround(house.center.y(), reach);
  const cv::Range cols = CellsAround(house.center.x(), reach);
  for (int row = rows.start; row < rows.end; ++row) {
    for (int col = cols.start; col < cols.end; ++col) {
      const Eigen::Vector2d offset(CellCenter(col) - house.center.x(),
                                   CellCenter(row) - house.center.y());
      const double u = std::abs(offset.dot(along)), v = std::abs(offset.dot(across));
      if (u > half_length || v > half_width) continue;
      const double rise = (house.ridge_m - house.eaves_m) * (1.0 - v / half_width);
      surface(row, col) = static_cast<float>(floor + house.eaves_m + rise);
      cover(row, col) = static_cast<uint8_t>(Cover::kHouse);
      variant(row, col) = house.variant;
    }
  }
}

void World::Plant(const Tree& tree) {
  const Noise shape(MixSeed(seed, kCrownShape), 0.55 * tree.radius_m);
  const Noise lumps(MixSeed(seed, kCrownLumps), kCrownLumpWavelengthM);
  const Noise twigs(MixSeed(seed, kTwigs), kTwigWavelengthM);
  const double base = kCrownBaseRatio * tree.height_m;
  const double reach = 1.5 * tree.radius_m;
  const cv::Range rows = CellsAround(tree.center.y(), reach);
  const cv::Range cols = CellsAround(tree.center.x(), reach);
  for (int row = rows.start; row < rows.end; ++row) {
    for (int col = cols.start; col < cols.end; ++col) {
      const double x = CellCenter(col), y = CellCenter(row);
      const double distance = std::hypot(x - tree.center.x(), y - tree.center.y());
      const double radius = tree.radius_m * (1.0 + kCrownOutlineRatio * shape.At(x, y));
      const double ratio = distance / std::max(radius, 0.1);
      if (ratio >= 1.0) continue;
      const double dome = base + (tree.height_m - base) * std::sqrt(1.0 - ratio * ratio);
      const double bump = kCrownLumpHeightM * (lumps.At(x, y) + 1.5 * shape.At(x, y));
      const double top = ground(row, col) + std::max(dome + bump, 1.0);
      if (top <= surface(row, col)) continue;
      cover(row, col) = static_cast<uint8_t>(tree.is_leafless ? Cover::kBareTree : Cover::kTree);
      variant(row, col) = tree.variant;
      const bool is_gap = tree.is_leafless && twigs.At(x, y) < kTwigRarity && ratio > kStemRatio;
      if (!is_gap) surface(row, col) = static_cast<float>(top);
    }
  }
}

void World::Plant(const Hedge& hedge) {
  const Noise lumps(MixSeed(seed, kHedgeTop), kCrownLumpWavelengthM);
  const Eigen::Vector2d span = hedge.end - hedge.start;
  const double length = span.norm();
  if (length <= 0.0) return;
  const Eigen::Vector2d along = span / length;
  const Eigen::Vector2d middle = 0.5 * (hedge.start + hedge.end);
  const cv::Range rows = CellsAround(middle.y(), 0.5 * length + hedge.width_m);
  const cv::Range cols = CellsAround(middle.x(), 0.5 * length + hedge.width_m);
  for (int row = rows.start; row < rows.end; ++row) {
    for (int col = cols.start; col < cols.end; ++col) {
      const Eigen::Vector2d offset(CellCenter(col) - middle.x(), CellCenter(row) - middle.y());
      if (std::abs(offset.dot(along)) > 0.5 * length) continue;
      const double across = std::abs(offset.x() * along.y() - offset.y() * along.x());
      const double bump = lumps.At(CellCenter(col), CellCenter(row));
      if (across > 0.5 * hedge.width_m * (1.0 + 0.2 * bump)) continue;
      const double top = ground(row, col) + hedge.height_m * (1.0 + 0.12 * bump);
      if (top <= surface(row, col)) continue;
      surface(row, col) = static_cast<float>(top);
      cover(row, col) = static_cast<uint8_t>(Cover::kHedge);
      variant(row, col) = 0;
    }
  }
}

}  // namespace freelsd
