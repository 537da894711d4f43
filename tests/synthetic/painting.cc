// Colours: what each cover looks like flat in the sun, at the camera's own brightness. Means,
// spreads and the contrast per octave follow labelled aerial photographs at 0.2 m sampling.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "tests/synthetic/noise.h"
#include "tests/synthetic/world.h"

namespace freelsd {
namespace {

using Color = std::array<float, 3>;  // BGR, 0..255

constexpr int kNumOctaves = 7;
constexpr std::array<double, kNumOctaves> kWavelengthsM{0.3, 0.6, 1.2, 2.5, 5.0, 11.0, 35.0};
constexpr uint64_t kBrightness = 200;  // + octave
constexpr uint64_t kHueFine = 220;
constexpr uint64_t kHueCoarse = 221;
constexpr uint64_t kSpots = 222;
constexpr uint64_t kRowWobble = 223;
// The variant of a field chooses the direction of its rows.
constexpr int kNumRowHeadings = 8;
constexpr double kRowHeadingStep = 0.4;

struct Look {
  // One is chosen by the variant.
  std::vector<Color> colors;
  // Standard deviation of brightness per octave, as a share of the mean.
  std::array<float, kNumOctaves> contrast;
  // Direction in BGR into which patches turn (dry grass, wet soil), per standard deviation.
  Color patch{};
  // Rows of a field: spacing and contrast.
  float row_spacing_m = 0.0f;
  float row_contrast = 0.0f;
};

// One of each cover.
const std::map<Cover, Look> kLooks{
    {Cover::kMeadow,
     {{{62, 154, 128}, {66, 151, 125}, {74, 149, 128}, {60, 147, 121}},
      {0.040f, 0.036f, 0.028f, 0.022f, 0.022f, 0.028f, 0.045f},
      {4, 1, 5},
      3.2f,
      0.010f}},
    // straw: redder than green; the second with weeds in it
    {Cover::kStubble,
     {{{118, 164, 190}, {100, 148, 172}, {132, 172, 196}},
      {0.045f, 0.035f, 0.025f, 0.020f, 0.020f, 0.025f, 0.040f},
      {-4, -1, -6},
      1.6f,
      0.04f}},
    {Cover::kSoil,
     {{{82, 104, 124}, {72, 90, 108}, {92, 118, 142}},
      {0.055f, 0.050f, 0.040f, 0.035f, 0.035f, 0.040f, 0.055f},
      {3, 4, 5},
      1.3f,
      0.055f}},
    {Cover::kScrub,
     {{{38, 106, 80}, {44, 92, 84}, {52, 100, 92}},
      {0.10f, 0.10f, 0.09f, 0.07f, 0.05f, 0.05f, 0.07f},
      {4, 0, 8},
      0.0f,
      0.0f}},
    {Cover::kGravel,
     {{{168, 176, 184}, {160, 168, 176}},
      {0.030f, 0.028f, 0.022f, 0.020f, 0.022f, 0.022f, 0.025f},
      {-2, 0, 2},
      0.0f,
      0.0f}},
    {Cover::kRoad,
     {{{182, 180, 183}, {168, 167, 171}},
      {0.022f, 0.022f, 0.020f, 0.020f, 0.020f, 0.025f, 0.030f},
      {-1, 0, 1},
      0.0f,
      0.0f}},
    {Cover::kTree,
     {{{72, 150, 106}, {62, 134, 92}, {82, 162, 118}, {74, 138, 114}, {66, 156, 94}},
      {0.16f, 0.14f, 0.11f, 0.06f, 0.04f, 0.04f, 0.06f},
      {2, 0, 5},
      0.0f,
      0.0f}},
    {Cover::kHedge,
     {{{60, 134, 94}}, {0.15f, 0.13f, 0.10f, 0.07f, 0.04f, 0.04f, 0.04f}, {2, 0, 5}}},
    {Cover::kHouse,
     {{{78, 92, 168}, {118, 114, 112}, {84, 100, 150}, {142, 138, 136}},
      {0.03f, 0.03f, 0.02f, 0.02f, 0.01f, 0.01f, 0.0f},
      {1, 1, 2}}},
    // young maize, wheat, rape before it flowers
    {Cover::kCrop,
     {{{58, 138, 96}, {72, 142, 100}, {50, 128, 104}, {60, 160, 132}},
      {0.050f, 0.045f, 0.030f, 0.020f, 0.015f, 0.018f, 0.030f},
      {3, 0, 4},
      0.75f,
      0.05f}},
    {Cover::kWater,
     {{{92, 84, 66}, {60, 110, 84}, {52, 124, 96}},  // clear, some algae, full of them
      {0.004f, 0.004f, 0.004f, 0.006f, 0.010f, 0.020f, 0.030f},
      {-3, 5, 3}}},
    {Cover::kBareTree,
     {{{84, 98, 108}, {76, 88, 96}}, {0.16f, 0.14f, 0.10f, 0.06f, 0.03f, 0.03f, 0.04f}}},
    {Cover::kBoulder,
     {{{150, 152, 152}, {128, 132, 134}}, {0.08f, 0.06f, 0.05f, 0.02f, 0.02f, 0.02f, 0.0f}}},
    {Cover::kDitch,
     {{{44, 92, 76}, {58, 82, 84}}, {0.12f, 0.10f, 0.08f, 0.05f, 0.04f, 0.04f, 0.04f}}},
    {Cover::kFence, {{{62, 128, 112}}, {0.10f, 0.08f, 0.06f, 0.04f, 0.03f, 0.03f, 0.03f}}},
    {Cover::kPole, {{{96, 104, 112}}, {}}},
    {Cover::kVehicle, {{{200, 200, 200}, {48, 46, 44}, {60, 50, 170}, {160, 110, 70}}, {}}},
    {Cover::kAnimal,
     {{{52, 64, 92}, {215, 220, 225}, {40, 40, 44}},
      {0.06f, 0.10f, 0.06f, 0.0f, 0.0f, 0.0f, 0.0f}}},
    // between meadow and scrub
    {Cover::kDoubt,
     {{{50, 130, 104}}, {0.07f, 0.07f, 0.06f, 0.05f, 0.04f, 0.04f, 0.05f}, {4, 0, 6}}},
};

class Painter {
 public:
  explicit Painter(uint64_t seed)
      : hue_fine_(MixSeed(seed, kHueFine), 2.2),
        hue_coarse_(MixSeed(seed, kHueCoarse), 13.0),
        spots_(MixSeed(seed, kSpots), 0.9),
        row_wobble_(MixSeed(seed, kRowWobble), 6.0) {
    for (int octave = 0; octave < kNumOctaves; ++octave) {
      brightness_.emplace_back(MixSeed(seed, kBrightness + octave), kWavelengthsM[octave]);
    }
    for (int i = 0; i < kNumRowHeadings; ++i) {
      row_normals_[i] << std::cos(kRowHeadingStep * i), -std::sin(kRowHeadingStep * i);
    }
    for (int cover = 0; cover < kNumCovers; ++cover) {
      looks_.push_back(kLooks.at(static_cast<Cover>(cover)));
    }
  }

  cv::Vec3b ColorAt(Cover cover, uint8_t variant, double x, double y) const {
    const Look& look = looks_[static_cast<size_t>(cover)];
    const float gain = Brightness(look, x, y) * Rows(look, variant, x, y);
    const float patch = 0.6f * hue_fine_.At(x, y) + 0.8f * hue_coarse_.At(x, y);
    Color color = look.colors[variant % look.colors.size()];
    // No two fields or trees of a kind are the same.
    const float own = 1.0f + 0.02f * static_cast<float>(variant / 8 % 9 - 4);
    for (int i = 0; i < 3; ++i) color[i] = gain * own * (color[i] + patch * look.patch[i]);
    if (cover == Cover::kMeadow) color = WithFlowers(color, x, y);
    cv::Vec3b pixel;
    for (int i = 0; i < 3; ++i) pixel[i] = cv::saturate_cast<uint8_t>(color[i]);
    return pixel;
  }

 private:
  float Brightness(const Look& look, double x, double y) const {
    float gain = 1.0f;
    for (int octave = 0; octave < kNumOctaves; ++octave) {
      if (look.contrast[octave] == 0.0f) continue;
      gain += look.contrast[octave] * brightness_[octave].At(x, y);
    }
    return std::max(gain, 0.15f);
  }

  float Rows(const Look& look, uint8_t variant, double x, double y) const {
    if (look.row_spacing_m <= 0.0f) return 1.0f;
    const Eigen::Vector2d& normal = row_normals_[variant % kNumRowHeadings];
    const double across = x * normal.x() + y * normal.y() + 0.5 * row_wobble_.At(x, y);
    return 1.0f + look.row_contrast *
                      static_cast<float>(1.41 * std::sin(2.0 * kPi * across / look.row_spacing_m));
  }

  // Clover and bare spots: rare, small, pale.
  Color WithFlowers(Color color, double x, double y) const {
    constexpr float kRarity = 2.1f;
    const float excess = spots_.At(x, y) - kRarity;
    if (excess <= 0.0f) return color;
    const float share = std::min(0.35f, 0.8f * excess);
    constexpr Color kPale{130, 170, 170};
    for (int i = 0; i < 3; ++i) color[i] += share * (kPale[i] - color[i]);
    return color;
  }

  std::vector<Noise> brightness_;
  Noise hue_fine_, hue_coarse_, spots_, row_wobble_;
  std::array<Eigen::Vector2d, kNumRowHeadings> row_normals_;
  std::vector<Look> looks_;
};

}  // namespace

Eigen::Vector2d Mover::PlaceAt(double seconds) const {
  const double gone = std::fmod(speed_mps * seconds, 2.0 * way_m);
  return block.center + std::min(gone, 2.0 * way_m - gone) * DirectionOf(block.heading);
}

World World::At(double seconds) const {
  World now = *this;
  if (movers.empty()) return now;
  for (cv::Mat1b* grid : {&now.cover, &now.variant}) *grid = grid->clone();
  now.surface = surface.clone();
  now.radiance = radiance.clone();
  const Painter painter(seed);
  for (const Mover& mover : movers) {
    Block block = mover.block;
    block.center = mover.PlaceAt(seconds);
    now.Put(block);
    const double reach = 0.5 * std::hypot(block.length_m, block.width_m);
    const cv::Range rows = CellsAround(block.center.y(), reach);
    const cv::Range cols = CellsAround(block.center.x(), reach);
    for (int row = rows.start; row < rows.end; ++row) {
      for (int col = cols.start; col < cols.end; ++col) {
        if (now.surface(row, col) == surface(row, col)) continue;
        now.radiance(row, col) =
            painter.ColorAt(block.cover, block.variant, CellCenter(col), CellCenter(row));
      }
    }
  }
  return now;
}

void World::Paint() {
  const Painter painter(seed);
  albedo.create(num_cells(), num_cells());
  ForEachCell(*this, [&](int row, int col) {
    albedo(row, col) = painter.ColorAt(
        static_cast<Cover>(cover(row, col)), variant(row, col), CellCenter(col), CellCenter(row));
  });
}

}  // namespace freelsd
