#include "tests/evaluation/watch/later_world.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

enum Purpose : uint64_t {
  kSunPurpose = 601,
  kWeatherPurpose,
  kCloudPurpose,
  kGrowthPurpose,
  kPatchPurpose,
  kThingPurpose
};

bool IsGrass(const World& world, int row, int col) {
  const Cover cover = static_cast<Cover>(world.cover(row, col));
  return cover == Cover::kMeadow || cover == Cover::kStubble || cover == Cover::kCrop ||
         cover == Cover::kScrub;
}

Eigen::Vector3d SunAt(double heading, double elevation_deg) {
  const double elevation = RadFromDeg(elevation_deg);
  Eigen::Vector3d sun;
  sun << std::cos(elevation) * DirectionOf(heading), std::sin(elevation);
  return sun;
}

void MoveSun(double low_deg, double high_deg, double max_turn_deg, uint64_t seed, World& world) {
  const double turn = RadFromDeg(Uniform(seed, kSunPurpose, 20.0, max_turn_deg)) *
                      (MixSeed(seed, kSunPurpose + 100) % 2 == 0 ? 1.0 : -1.0);
  const double heading = HeadingOf(world.sun_in_world.head<2>()) + turn;
  world.sun_in_world = SunAt(heading, Uniform(seed, kSunPurpose + 200, low_deg, high_deg));
}

// Wet grass is darker and its colours are stronger, more in hollows than on mounds.
void Wet(uint64_t seed, World& world) {
  const double darkness = Uniform(seed, kWeatherPurpose, 0.70, 0.88);
  const double saturation = Uniform(seed, kWeatherPurpose + 100, 1.05, 1.25);
  const Noise patches(MixSeed(seed, kPatchPurpose), 18.0);
  ForEachCell(world, [&](int row, int col) {
    if (!IsGrass(world, row, col)) return;
    cv::Vec3b& color = world.albedo(row, col);
    const double mean = (color[0] + color[1] + color[2]) / 3.0;
    const double patch = patches.At(world.CellCenter(col), world.CellCenter(row));
    const double gain = darkness * (1.0 + 0.05 * patch);
    const double strength = saturation + 0.04 * patch;
    for (int i = 0; i < 3; ++i) {
      color[i] = cv::saturate_cast<uint8_t>(gain * (mean + strength * (color[i] - mean)));
    }
  });
}

// Half of the fine pattern is another one, and the grass is up to 0.15 m higher and greener.
void Grow(uint64_t seed, World& world) {
  cv::Mat3b smooth;
  const int side = 2 * static_cast<int>(std::lround(0.6 / world.cell_size_m)) + 1;
  cv::blur(world.albedo, smooth, {side, side});
  const Noise fine(MixSeed(seed, kGrowthPurpose), 0.3),
      middle(MixSeed(seed, kGrowthPurpose + 100), 0.8),
      coarse(MixSeed(seed, kGrowthPurpose + 200), 6.0);
  const double height_m = Uniform(seed, kGrowthPurpose + 300, 0.03, 0.15);
  const double greener = Uniform(seed, kGrowthPurpose + 400, -0.03, 0.06);
  ForEachCell(world, [&](int row, int col) {
    if (!IsGrass(world, row, col)) return;
    const double x = world.CellCenter(col), y = world.CellCenter(row);
    const double gain =
        1.0 + 0.04 * fine.At(x, y) + 0.04 * middle.At(x, y) + 0.03 * coarse.At(x, y);
    cv::Vec3b& color = world.albedo(row, col);
    for (int i = 0; i < 3; ++i) {
      const double half = 0.5 * (color[i] + smooth(row, col)[i]);
      color[i] = cv::saturate_cast<uint8_t>(gain * half * (i == 1 ? 1.0 + greener : 1.0 - greener));
    }
    world.surface(row, col) += static_cast<float>(height_m * (1.0 + 0.3 * middle.At(x, y)));
  });
}

double Draw(uint64_t seed, int number, double low, double high) {
  return Uniform(MixSeed(seed, kThingPurpose), 700 + static_cast<uint64_t>(number), low, high);
}

int Choose(uint64_t seed, int number, int count) {
  return std::min(count - 1, static_cast<int>(Draw(seed, number, 0.0, count)));
}

const std::vector<cv::Vec3b> kPaints{
    {205, 205, 205}, {48, 46, 44}, {60, 50, 170}, {160, 110, 70}, {110, 112, 115}, {70, 95, 60}};
const std::vector<cv::Vec3b> kCoats{{52, 64, 92}, {215, 220, 225}, {40, 40, 44}, {70, 100, 140}};
const std::vector<cv::Vec3b> kClothes{
    {60, 55, 55}, {190, 190, 195}, {60, 50, 170}, {150, 100, 70}, {110, 130, 150}, {50, 80, 65}};
const std::vector<cv::Vec3b> kMachines{{50, 110, 40}, {50, 45, 165}, {150, 100, 50}};
const cv::Vec3b kGlass(50, 48, 45), kTyre(38, 38, 40), kStraw(105, 155, 185), kWrap(215, 218, 215),
    kBlackWrap(42, 40, 40);

Eigen::Vector2d At(const StripShape& strip, double along, double across) {
  const Eigen::Vector2d forward = DirectionOf(strip.heading);
  return strip.middle + along * forward + across * Eigen::Vector2d(forward.y(), -forward.x());
}

// Drives onto the strip from its end or side and stops, or drives on along it.
ColoredBlock Driving(const ColoredBlock& vehicle,
                     const StripShape& strip,
                     uint64_t seed,
                     double seconds) {
  const double speed = Draw(seed, 1, 2.0, 7.0);
  const double stop = Draw(seed, 2, -0.7, 0.7) * strip.half_length_m;
  const double across = Draw(seed, 3, -0.6, 0.6) * strip.half_width_m;
  const double sign = Choose(seed, 4, 2) == 0 ? 1.0 : -1.0;
  ColoredBlock moved = vehicle;
  // Until it stops, at a time around the middle of the pass; half of them never do.
  const double ahead = speed * (seconds - Draw(seed, 5, -1.0, 1.0));
  const double gone = Choose(seed, 6, 2) == 0 ? ahead : std::min(ahead, 0.0);
  const bool is_along = Choose(seed, 7, 3) > 0 || Choose(seed, 6, 2) == 0;
  moved.block.center =
      is_along ? At(strip, stop + sign * gone, across) : At(strip, stop, across + sign * gone);
  moved.block.heading = strip.heading + (is_along ? 0.0 : 0.5 * kPi);
  return moved;
}

// Walks about a place on the strip.
ColoredBlock Walking(const ColoredBlock& walker,
                     const StripShape& strip,
                     uint64_t seed,
                     double seconds,
                     double speed) {
  ColoredBlock moved = walker;
  moved.block.heading = Draw(seed, 10, 0.0, 2.0 * kPi);
  moved.block.center = At(strip,
                          Draw(seed, 11, -0.8, 0.8) * strip.half_length_m,
                          Draw(seed, 12, -0.7, 0.7) * strip.half_width_m) +
                       speed * seconds * DirectionOf(moved.block.heading);
  return moved;
}

ColoredBlock MakeBlock(double length, double width, double height, std::vector<cv::Vec3b> colors) {
  ColoredBlock thing;
  thing.block.length_m = length;
  thing.block.width_m = width;
  thing.block.height_m = height;
  thing.colors = std::move(colors);
  return thing;
}

std::vector<ColoredBlock> Walkers(WatchEvent event,
                                  const StripShape& strip,
                                  uint64_t seed,
                                  double seconds) {
  const bool is_herd = event == WatchEvent::kCows;
  const int count = is_herd ? 3 + Choose(seed, 20, 4) : event == WatchEvent::kPeople ? 3 : 1;
  std::vector<ColoredBlock> things;
  for (int i = 0; i < count; ++i) {
    const uint64_t own = MixSeed(seed, 7000 + static_cast<uint64_t>(i));
    const cv::Vec3b& coat =
        kCoats[static_cast<size_t>(Choose(own, 21, static_cast<int>(kCoats.size())))];
    const cv::Vec3b& cloth =
        kClothes[static_cast<size_t>(Choose(own, 22, static_cast<int>(kClothes.size())))];
    things.push_back(
        Walking(is_herd ? MakeBlock(2.3, 0.75, 1.4, {coat}) : MakeBlock(0.5, 0.4, 1.75, {cloth}),
                strip,
                own,
                seconds,
                is_herd ? Draw(own, 23, 0.2, 1.0) : 1.2));
  }
  return things;
}

}  // namespace

WorldPiece PieceOf(const World& world, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  const double reach = 0.5 * (high - low).maxCoeff();
  const Eigen::Vector2d middle = 0.5 * (low + high);
  const int side =
      std::min(world.num_cells(), 2 * static_cast<int>(std::ceil(reach / world.cell_size_m)));
  const int left = std::clamp(world.CellIndex(middle.x()) - side / 2, 0, world.num_cells() - side);
  const int first = std::clamp(world.CellIndex(middle.y()) - side / 2, 0, world.num_cells() - side);
  const cv::Rect cells(left, first, side, side);
  WorldPiece piece;
  piece.world = world;
  piece.world.movers.clear();
  piece.world.size_m = side * world.cell_size_m;
  piece.middle_in_world = {world.CellCenter(left) + 0.5 * (side - 1) * world.cell_size_m,
                           world.CellCenter(first) + 0.5 * (side - 1) * world.cell_size_m};
  const auto cut = [&](auto& grid) {
    if (!grid.empty()) grid = grid(cells).clone();
  };
  cut(piece.world.ground), cut(piece.world.surface), cut(piece.world.overhead);
  cut(piece.world.cover), cut(piece.world.variant), cut(piece.world.albedo);
  cut(piece.world.radiance), cut(piece.world.photographed), cut(piece.world.is_textured);
  return piece;
}

void ChangeScene(SceneChange change, uint64_t seed, World& world) {
  switch (change) {
    case SceneChange::kSunMoved:
      MoveSun(28.0, 60.0, 120.0, seed, world);
      break;
    case SceneChange::kLowSun:
      MoveSun(12.0, 24.0, 120.0, seed, world);
      break;
    case SceneChange::kOvercast:
      world.sky_share = 0.92;
      break;
    case SceneChange::kWet:
      MoveSun(28.0, 60.0, 60.0, seed, world);
      Wet(seed, world);
      break;
    case SceneChange::kGrown:
      MoveSun(28.0, 60.0, 60.0, seed, world);
      Grow(seed, world);
      break;
    case SceneChange::kSameLight:
    case SceneChange::kHaze:
    case SceneChange::kCloudShadows:
      break;
  }
}

void ShadeByClouds(uint64_t seed, double seconds, World& world) {
  World cloudy = world;
  cloudy.sky_share = 0.95;
  cloudy.radiance = cv::Mat3b();
  cloudy.Light();
  const Noise clouds(MixSeed(seed, kCloudPurpose), Uniform(seed, kCloudPurpose + 100, 25.0, 70.0));
  const Eigen::Vector2d wind =
      8.0 * DirectionOf(Uniform(seed, kCloudPurpose + 200, 0.0, 2.0 * kPi));
  // Of the sun's light outside; the edges of clouds are some metres wide.
  constexpr double kCloudLight = 0.45, kSoftness = 0.5;
  ForEachCell(world, [&](int row, int col) {
    const double x = world.CellCenter(col) - wind.x() * seconds;
    const double y = world.CellCenter(row) - wind.y() * seconds;
    const double share = std::clamp(0.5 + clouds.At(x, y) / kSoftness, 0.0, 1.0);
    cv::Vec3b& light = world.radiance(row, col);
    for (int i = 0; i < 3; ++i) {
      light[i] = cv::saturate_cast<uint8_t>((1.0 - share) * light[i] +
                                            share * kCloudLight * cloudy.radiance(row, col)[i]);
    }
  });
}

void PutColored(const ColoredBlock& thing, World& world) {
  const Block& block = thing.block;
  const double reach = 0.5 * std::hypot(block.length_m, block.width_m) + world.cell_size_m;
  const cv::Range rows = world.CellsAround(block.center.y(), reach);
  const cv::Range cols = world.CellsAround(block.center.x(), reach);
  if (rows.empty() || cols.empty()) return;
  const cv::Mat1f before = world.surface(rows, cols).clone();
  world.Put(block);
  const Eigen::Vector2d forward = DirectionOf(block.heading);
  const auto num_parts = static_cast<double>(thing.colors.size());
  for (int row = rows.start; row < rows.end; ++row) {
    for (int col = cols.start; col < cols.end; ++col) {
      if (world.surface(row, col) == before(row - rows.start, col - cols.start)) continue;
      const Eigen::Vector2d place(world.CellCenter(col), world.CellCenter(row));
      const double share = (place - block.center).dot(forward) / block.length_m + 0.5;
      const auto part = static_cast<size_t>(std::clamp(share * num_parts, 0.0, num_parts - 1.0));
      world.albedo(row, col) = thing.colors[part];
      if (!world.is_textured.empty()) world.is_textured(row, col) = 0;
      if (!world.photographed.empty()) world.photographed(row, col) = 0;
    }
  }
}

std::vector<ColoredBlock> ThingsAt(WatchEvent event,
                                   const StripShape& strip,
                                   uint64_t seed,
                                   double seconds) {
  switch (event) {
    case WatchEvent::kNone:
      return {};
    case WatchEvent::kCar: {
      const cv::Vec3b& paint = kPaints[static_cast<size_t>(Choose(seed, 30, int(kPaints.size())))];
      return {Driving(MakeBlock(4.4, 1.8, 1.5, {paint, kGlass, paint, paint, kGlass, paint}),
                      strip,
                      seed,
                      seconds)};
    }
    case WatchEvent::kMachine: {
      const cv::Vec3b& paint =
          kMachines[static_cast<size_t>(Choose(seed, 31, int(kMachines.size())))];
      return {Driving(
          MakeBlock(4.6, 2.3, 2.8, {kTyre, kGlass, paint, paint, paint}), strip, seed, seconds)};
    }
    case WatchEvent::kBale: {
      const int kind = Choose(seed, 32, 5);
      ColoredBlock bale = MakeBlock(1.4,
                                    1.3,
                                    1.3,
                                    {kind < 3    ? kStraw
                                     : kind == 3 ? kWrap
                                                 : kBlackWrap});
      return {Walking(bale, strip, seed, 0.0, 0.0)};
    }
    case WatchEvent::kCows:
    case WatchEvent::kPerson:
    case WatchEvent::kPeople:
      return Walkers(event, strip, seed, seconds);
  }
  return {};
}

}  // namespace freelsd
