#include "tests/synthetic/ground/real_ground.h"

#include <algorithm>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "tests/synthetic/countryside_relief.h"
#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

// Purposes of randomness; 601 to 620 are the countryside's.
enum Purpose : uint64_t { kEast = 621, kNorth, kHeading };

constexpr double kMaxShiftM = 40.0;
// A photograph is coarse where its pixels are wider than those of a camera at 100 m.
constexpr double kCoarseCellM = 0.25;
// Nothing stands this close around the place, nor in its gaps.
constexpr double kBareM = 10.0;
// Over this distance the countryside's heights become those of the place: over 10 m a hillside
// would end at a wall.
constexpr double kBlendM = 50.0;
constexpr double kBlendBlurM = 2.0;

// The place on the world's grid; only where `is_known`.
RealGround OnGrid(const RealGround& place, const Placement& placement, const World& world) {
  const Eigen::Vector2d north = DirectionOf(placement.heading);
  const Eigen::Vector2d east(north.y(), -north.x());
  cv::Mat1f from_col(world.surface.size()), from_row(world.surface.size());
  ForEachCell(world, [&](int row, int col) {
    const Eigen::Vector2d offset =
        Eigen::Vector2d(world.CellCenter(col), world.CellCenter(row)) - placement.center_in_world;
    from_col(row, col) =
        static_cast<float>(offset.dot(east) / place.cell_size_m + 0.5 * (place.surface.cols - 1));
    from_row(row, col) =
        static_cast<float>(0.5 * (place.surface.rows - 1) - offset.dot(north) / place.cell_size_m);
  });
  RealGround on_grid;
  on_grid.cell_size_m = world.cell_size_m;
  on_grid.datum_m = place.datum_m;
  on_grid.has_wrong_colors = place.has_wrong_colors;
  const auto bring = [&](const cv::Mat& from, cv::Mat& to, int interpolation) {
    cv::remap(from, to, from_col, from_row, interpolation, cv::BORDER_CONSTANT, cv::Scalar(0));
  };
  bring(place.is_known, on_grid.is_known, cv::INTER_NEAREST);
  bring(place.cover, on_grid.cover, cv::INTER_NEAREST);
  bring(place.variant, on_grid.variant, cv::INTER_NEAREST);
  bring(place.surface, on_grid.surface, cv::INTER_LINEAR);
  bring(place.ground, on_grid.ground, cv::INTER_LINEAR);
  bring(place.photograph, on_grid.photograph, cv::INTER_LINEAR);
  return on_grid;
}

// What an engine may take for grass is bare soil, so that the place alone is judged.
void PloughFields(World& world) {
  ForEachCell(world, [&](int row, int col) {
    const Cover cover = static_cast<Cover>(world.cover(row, col));
    const bool is_crop = cover == Cover::kCrop;
    if (is_crop) world.surface(row, col) = world.ground(row, col);
    if (is_crop || cover == Cover::kMeadow || cover == Cover::kStubble || cover == Cover::kWater) {
      world.cover(row, col) = static_cast<uint8_t>(Cover::kSoil);
    }
  });
}

// What the ground around must be raised by to meet the place's at its edge.
struct Surroundings {
  cv::Mat1f distance_m;  // from the place; 0 within
  cv::Mat1f rise_m;
};

Surroundings SurroundingsOf(const RealGround& on_grid, const World& world) {
  Surroundings around;
  cv::Mat1i nearest;
  cv::distanceTransform(on_grid.is_known == 0,
                        around.distance_m,
                        nearest,
                        cv::DIST_L2,
                        cv::DIST_MASK_5,
                        cv::DIST_LABEL_PIXEL);
  around.distance_m *= world.cell_size_m;
  std::vector<float> rises(on_grid.is_known.total() + 1, 0.0f);
  for (int row = 0; row < nearest.rows; ++row) {
    for (int col = 0; col < nearest.cols; ++col) {
      if (on_grid.is_known(row, col) == 0) continue;
      rises[static_cast<size_t>(nearest(row, col))] =
          on_grid.ground(row, col) - world.ground(row, col);
    }
  }
  around.rise_m.create(nearest.size());
  ForEachCell(world, [&](int row, int col) {
    const float t = std::min(around.distance_m(row, col) / static_cast<float>(kBlendM), 1.0f);
    const float fade = 1.0f - t * t * (3.0f - 2.0f * t);
    around.rise_m(row, col) = fade * rises[static_cast<size_t>(nearest(row, col))];
  });
  cv::GaussianBlur(around.rise_m, around.rise_m, {}, kBlendBlurM / world.cell_size_m);
  return around;
}

void FillGrids(World& world, const RealGround& on_grid, const WorldOptions& options) {
  const Surroundings around = SurroundingsOf(on_grid, world);
  const CountrysideRelief relief(options);
  ForEachCell(world, [&](int row, int col) {
    if (on_grid.is_known(row, col) != 0) {
      world.ground(row, col) = on_grid.ground(row, col);
      world.surface(row, col) = on_grid.surface(row, col);
      world.cover(row, col) = on_grid.cover(row, col);
      world.variant(row, col) = on_grid.variant(row, col);
      return;
    }
    world.ground(row, col) += around.rise_m(row, col);
    world.surface(row, col) += around.rise_m(row, col);
    if (around.distance_m(row, col) > kBareM) return;
    const double x = world.CellCenter(col), y = world.CellCenter(row);
    world.cover(row, col) = static_cast<uint8_t>(Cover::kSoil);
    world.variant(row, col) = 0;
    world.surface(row, col) =
        world.ground(row, col) + static_cast<float>(relief.GrowthAt(Cover::kSoil, 0, x, y));
  });
}

float MeanBrightness(const cv::Mat3b& picture, const cv::Mat1b& mask) {
  const cv::Scalar mean = cv::mean(picture, mask);
  return static_cast<float>(std::max(mean[0] + mean[1] + mean[2], 1.0));
}

// A photograph has its own sun and shade. Of a coarse one, crowns have leaves in space instead:
// along their sides it would be drawn out.
void Show(const RealGround& on_grid, bool is_coarse, World& world) {
  const cv::Mat1b is_shown = on_grid.is_known != 0;
  if (on_grid.has_wrong_colors) {
    const cv::Mat3b hue = world.albedo.clone();
    const float usual =
        MeanBrightness(hue, is_shown) / MeanBrightness(on_grid.photograph, is_shown);
    ForEachCell(world, [&](int row, int col) {
      if (is_shown(row, col) == 0) return;
      const cv::Vec3b &seen = on_grid.photograph(row, col), &painted = hue(row, col);
      const float gain = usual * static_cast<float>(seen[0] + seen[1] + seen[2]) /
                         static_cast<float>(std::max(1, painted[0] + painted[1] + painted[2]));
      for (int i = 0; i < 3; ++i) {
        world.albedo(row, col)[i] = cv::saturate_cast<uint8_t>(gain * painted[i]);
      }
    });
  } else {
    on_grid.photograph.copyTo(world.albedo, is_shown);
  }
  world.photographed = is_shown;
  world.is_photograph_coarse = is_coarse;
  if (!is_coarse) return;
  world.photographed.setTo(0,
                           (world.cover == static_cast<uint8_t>(Cover::kTree)) |
                               (world.cover == static_cast<uint8_t>(Cover::kHedge)));
}

}  // namespace

Placement PlacementFor(uint64_t seed) {
  Placement placement;
  placement.center_in_world << Uniform(seed, kEast, -kMaxShiftM, kMaxShiftM),
      Uniform(seed, kNorth, -kMaxShiftM, kMaxShiftM);
  placement.heading = Uniform(seed, kHeading, 0.0, 2.0 * kPi);
  return placement;
}

World MakeWorldAround(const RealGround& place,
                      const Placement& placement,
                      const WorldOptions& options) {
  World world = MakeCountryside(options);
  // Lanes and wires would end at the place.
  world.movers.clear();
  world.overhead.release();
  const RealGround on_grid = OnGrid(place, placement, world);
  PloughFields(world);
  FillGrids(world, on_grid, options);
  world.Paint();
  Show(on_grid, place.cell_size_m > kCoarseCellM, world);
  world.Light();
  return world;
}

}  // namespace freelsd
