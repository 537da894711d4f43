// Smaller things that stand or lie on the ground.
#include <algorithm>
#include <cmath>

#include "tests/synthetic/world.h"

namespace freelsd {
namespace {

// Calls `visit(row, col, along, across)` for the cells within a rectangle about a line.
template <typename Visit>
void AlongLine(const World& world,
               const Eigen::Vector2d& start,
               const Eigen::Vector2d& end,
               double half_width,
               Visit visit) {
  const Eigen::Vector2d span = end - start;
  const double length = span.norm();
  if (length <= 0.0) return;
  const Eigen::Vector2d forward = span / length;
  const Eigen::Vector2d middle = 0.5 * (start + end);
  const double reach_x = 0.5 * std::abs(span.x()) + half_width;
  const double reach_y = 0.5 * std::abs(span.y()) + half_width;
  const cv::Range rows = world.CellsAround(middle.y(), reach_y);
  const cv::Range cols = world.CellsAround(middle.x(), reach_x);
  for (int row = rows.start; row < rows.end; ++row) {
    for (int col = cols.start; col < cols.end; ++col) {
      const Eigen::Vector2d offset =
          Eigen::Vector2d(world.CellCenter(col), world.CellCenter(row)) - start;
      const double along = offset.dot(forward);
      const double across = offset.x() * forward.y() - offset.y() * forward.x();
      if (along < 0.0 || along > length || std::abs(across) > half_width) continue;
      visit(row, col, along, across);
    }
  }
}

// Distance along a line to the nearest of posts at that spacing.
double ToNearestPost(double along, double spacing) {
  const double phase = std::fmod(along, spacing);
  return std::min(phase, spacing - phase);
}

}  // namespace

void World::Put(const Block& block) {
  const Eigen::Vector2d half = 0.5 * block.length_m * DirectionOf(block.heading);
  AlongLine(*this,
            block.center - half,
            block.center + half,
            0.5 * block.width_m,
            [&](int row, int col, double along, double) {
              // Lower in front and behind, as cars and cows are.
              const double end = std::min(along, block.length_m - along);
              const double share = end < 0.2 * block.length_m ? 0.65 : 1.0;
              const double top = ground(row, col) + share * block.height_m;
              if (top <= surface(row, col)) return;
              surface(row, col) = static_cast<float>(top);
              cover(row, col) = static_cast<uint8_t>(block.cover);
              variant(row, col) = block.variant;
            });
}

void World::Put(const Boulder& boulder) {
  const cv::Range rows = CellsAround(boulder.center.y(), boulder.radius_m);
  const cv::Range cols = CellsAround(boulder.center.x(), boulder.radius_m);
  for (int row = rows.start; row < rows.end; ++row) {
    for (int col = cols.start; col < cols.end; ++col) {
      const double ratio =
          std::hypot(CellCenter(col) - boulder.center.x(), CellCenter(row) - boulder.center.y()) /
          boulder.radius_m;
      if (ratio >= 1.0) continue;
      const double top = ground(row, col) + boulder.height_m * std::sqrt(1.0 - ratio * ratio);
      if (top <= surface(row, col)) continue;
      surface(row, col) = static_cast<float>(top);
      cover(row, col) = static_cast<uint8_t>(Cover::kBoulder);
    }
  }
}

void World::Dig(const Ditch& ditch) {
  const double half_width = 0.5 * ditch.width_m;
  AlongLine(
      *this, ditch.start, ditch.end, half_width, [&](int row, int col, double, double across) {
        const double depth = ditch.depth_m * (1.0 - std::abs(across) / half_width);
        ground(row, col) -= static_cast<float>(depth);
        surface(row, col) = ground(row, col);
        cover(row, col) = static_cast<uint8_t>(Cover::kDitch);
      });
}

void World::Build(const Fence& fence) {
  const double half_width = 0.5 * cell_size_m + 0.05;
  AlongLine(*this, fence.start, fence.end, half_width, [&](int row, int col, double along, double) {
    if (surface(row, col) > ground(row, col) + fence.height_m) return;
    cover(row, col) = static_cast<uint8_t>(Cover::kFence);
    const bool is_post = ToNearestPost(along, fence.spacing_m) <= 0.5 * cell_size_m;
    if (is_post) surface(row, col) = ground(row, col) + static_cast<float>(fence.height_m);
  });
}

void World::Build(const PowerLine& line) {
  power_lines.push_back(line);
  if (overhead.empty()) overhead = surface.clone();
  constexpr double kPoleHalfWidthM = 0.15;
  constexpr double kWireHalfWidthM = 0.6;
  AlongLine(*this,
            line.start,
            line.end,
            kWireHalfWidthM,
            [&](int row, int col, double along, double across) {
              const float top = ground(row, col) + static_cast<float>(line.height_m);
              overhead(row, col) = std::max(overhead(row, col), top);
              const double reach = std::max(kPoleHalfWidthM, 0.5 * cell_size_m);
              const bool is_pole =
                  ToNearestPost(along, line.spacing_m) <= reach && std::abs(across) <= reach;
              if (!is_pole || top <= surface(row, col)) return;
              surface(row, col) = top;
              cover(row, col) = static_cast<uint8_t>(Cover::kPole);
            });
}

}  // namespace freelsd
