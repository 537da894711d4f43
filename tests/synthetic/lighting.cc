// Light: direct sun by the slope of the surface and cast shadows, and the sky.
#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "tests/synthetic/world.h"

namespace freelsd {
namespace {

// The sky is bluer than the sun, gains of B, G, R; both together are white.
constexpr float kSkyTint[3] = {1.15f, 1.0f, 0.90f};
// Shadow edges are soft: over this depth below the shadow's upper edge the sun fades.
constexpr float kPenumbraM = 0.25f;
constexpr float kMaxGain = 1.7f;

// Height below which each cell lies in the shade of something nearer to the sun. Swept away from
// the sun, one line of cells after the other.
cv::Mat1f ShadeHeight(const World& world) {
  const int n = world.num_cells();
  const Eigen::Vector3d sun = world.sun_in_world;
  const bool by_rows = std::abs(sun.y()) >= std::abs(sun.x());
  const double major = by_rows ? sun.y() : sun.x();
  const double minor = by_rows ? sun.x() : sun.y();
  const double shift = minor / std::abs(major);  // cells sideways towards the sun per line
  const float drop = static_cast<float>(world.cell_size_m * sun.z() / std::abs(major));
  const int towards_sun = major > 0.0 ? 1 : -1;
  // The sun shines through a leafless crown.
  cv::Mat1f caster = world.surface.clone();
  world.ground.copyTo(caster, world.cover == static_cast<uint8_t>(Cover::kBareTree));
  cv::Mat1f surface = by_rows ? caster : cv::Mat1f(caster.t());
  cv::Mat1f shade(n, n, -1e6f);
  for (int step = 1; step < n; ++step) {
    const int line = towards_sun > 0 ? n - 1 - step : step;
    const int previous = line + towards_sun;
    for (int i = 0; i < n; ++i) {
      const double source = std::clamp(i + shift, 0.0, n - 1.001);
      const int left = static_cast<int>(source);
      const float t = static_cast<float>(source - left);
      const float a = std::max(surface(previous, left), shade(previous, left));
      const float b = std::max(surface(previous, left + 1), shade(previous, left + 1));
      shade(line, i) = a + t * (b - a) - drop;
    }
  }
  return by_rows ? shade : cv::Mat1f(shade.t());
}

// What is seen of low growth from afar: tussocks, not blades.
cv::Mat1f Relief(const World& world) {
  constexpr float kTallestM = 0.6f;
  constexpr double kReachM = 0.45;
  const int side = 2 * static_cast<int>(std::lround(kReachM / world.cell_size_m)) + 1;
  cv::Mat1f growth = cv::min(world.surface - world.ground, kTallestM);
  cv::boxFilter(growth, growth, CV_32F, {side, side});
  return world.ground + growth;
}

// Upward normal by central differences. A recorded texture has the shade of its own blades: there
// the normal is that of `relief`.
Eigen::Vector3f NormalAt(const World& world, const cv::Mat1f& relief, int row, int col) {
  const bool is_textured = !world.is_textured.empty() && world.is_textured(row, col) != 0;
  const cv::Mat1f& height = is_textured ? relief : world.surface;
  const int n = world.num_cells();
  const int west = std::max(col - 1, 0), east = std::min(col + 1, n - 1);
  const int south = std::max(row - 1, 0), north = std::min(row + 1, n - 1);
  const float cell = static_cast<float>(world.cell_size_m);
  const float dx = (height(row, east) - height(row, west)) / (cell * (east - west));
  const float dy = (height(north, col) - height(south, col)) / (cell * (north - south));
  return Eigen::Vector3f(-dx, -dy, 1.0f).normalized();
}

// How much of the sun a surface takes, 1 for flat ground. Leaves in a crown face all ways and let
// light through, so that crowns are shaded more gently than walls.
float Facing(Cover cover, const Eigen::Vector3f& normal, const Eigen::Vector3f& sun) {
  constexpr float kFoliageDiffuse = 0.6f;
  const float facing = std::max(0.0f, normal.dot(sun)) / sun.z();
  const bool is_foliage = cover == Cover::kTree || cover == Cover::kBareTree ||
                          cover == Cover::kHedge || cover == Cover::kScrub;
  return is_foliage ? kFoliageDiffuse + (1.0f - kFoliageDiffuse) * facing : facing;
}

}  // namespace

void World::Light() {
  const cv::Mat1f relief = is_textured.empty() ? ground : Relief(*this);
  const cv::Mat1f shade = ShadeHeight(*this);
  const Eigen::Vector3f sun = sun_in_world.cast<float>();
  const float sky_part = static_cast<float>(sky_share);
  radiance.create(num_cells(), num_cells());
  cv::parallel_for_({0, num_cells()}, [&](const cv::Range& rows) {
    for (int row = rows.start; row < rows.end; ++row) {
      for (int col = 0; col < num_cells(); ++col) {
        if (!photographed.empty() && photographed(row, col) != 0) {
          radiance(row, col) = albedo(row, col);
          continue;
        }
        const Eigen::Vector3f normal = NormalAt(*this, relief, row, col);
        const float depth = shade(row, col) - surface(row, col);
        const float lit = 1.0f - std::clamp(depth / kPenumbraM, 0.0f, 1.0f);
        const float direct =
            (1.0f - sky_part) * lit * Facing(static_cast<Cover>(cover(row, col)), normal, sun);
        const float sky = sky_part * (0.4f + 0.6f * normal.z());
        for (int i = 0; i < 3; ++i) {
          const float sun_tint = (1.0f - sky_part * kSkyTint[i]) / (1.0f - sky_part);
          const float gain = std::min(direct * sun_tint + sky * kSkyTint[i], kMaxGain);
          radiance(row, col)[i] = cv::saturate_cast<uint8_t>(gain * albedo(row, col)[i]);
        }
      }
    }
  });
}

}  // namespace freelsd
