// Input: a seed. Output: a piece of countryside whose truth is known everywhere: relief, what
// stands on it, what it is made of, which fields a plane can land on.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {

// What a place is made of.
enum class Cover : uint8_t {
  kMeadow,   // mown or grazed grass: the only cover to land on
  kStubble,  // harvested crop
  kSoil,     // ploughed
  kScrub,    // bracken, knee to waist high
  kGravel,   // farm yard
  kRoad,
  kTree,
  kHedge,
  kHouse,
  kCrop,      // standing and green
  kWater,     // still, more or less full of algae
  kBareTree,  // leafless: the ground shows through
  kBoulder,
  kDitch,
  kFence,  // posts and the uncut line between them
  kPole,
  kVehicle,
  kAnimal,
  kDoubt,  // nobody can tell from the photograph: counts for nothing
};
constexpr int kNumCovers = 19;
const char* CoverName(Cover cover);
// Throws std::invalid_argument where no cover has that name.
Cover CoverNamed(const std::string& name);

struct WorldOptions {
  uint64_t seed = 1;
  // Side of the square; the origin of the world frame is its centre.
  double size_m = 600.0;
  // Ground sampling of surface and texture.
  double cell_size_m = 0.15;
  // Standard deviation of the relief (hundreds of metres long); 0 is a plane.
  double relief_sd_m = 2.0;
  double wind_speed_mps = 4.0;
  // Where the middle of the world lies.
  GeoPoint origin{47.352, 8.457, 455.0};

  // Throws std::invalid_argument: "world.size_m = 0: must be in [20, 2000]".
  void Check() const;
};

// Raised as a box with a gabled roof: `length_m` along `heading` (radians clockwise from north).
struct House {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double heading = 0.0;
  double length_m = 12.0;
  double width_m = 8.0;
  double eaves_m = 4.0;
  double ridge_m = 7.0;
  uint8_t variant = 0;
};

struct Tree {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double radius_m = 3.5;
  double height_m = 9.0;
  uint8_t variant = 0;
  // Only twigs here and there reach the crown's surface.
  bool is_leafless = false;
};

struct Hedge {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  double width_m = 1.8;
  double height_m = 2.0;
};

// A boxy thing: a car, a bale, an animal. `length_m` along `heading` (radians clockwise from
// north).
struct Block {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double heading = 0.0;
  double length_m = 4.4;
  double width_m = 1.8;
  double height_m = 1.5;
  Cover cover = Cover::kVehicle;
  uint8_t variant = 0;
};

struct Boulder {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double radius_m = 0.8;
  double height_m = 0.9;
};

struct Ditch {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  double width_m = 1.6;
  double depth_m = 0.9;
};

struct Fence {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  double height_m = 1.2;
  double spacing_m = 3.0;
};

// Poles with wires between their tops.
struct PowerLine {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  double height_m = 8.0;
  double spacing_m = 40.0;
};

// Something that is elsewhere at every exposure: a car on a lane, an animal that walks. To and fro
// along the block's heading from where it stands first. The truth knows nothing of it: it is gone
// when somebody lands.
struct Mover {
  Block block;
  double speed_mps = 1.0;
  double way_m = 20.0;

  Eigen::Vector2d PlaceAt(double seconds) const;
};

// Grids are row-major, one value per cell; row 0 is the southern edge, column 0 the western one.
// Outside the grid the edge repeats.
struct World {
  uint64_t seed = 0;
  double size_m = 0.0;
  double cell_size_m = 0.0;
  GeoPoint origin;
  Eigen::Vector2d wind_in_world = Eigen::Vector2d::Zero();
  // Unit vector towards the sun.
  Eigen::Vector3d sun_in_world = Eigen::Vector3d::UnitZ();
  // Share of the light on flat open ground that comes from the sky. Under clouds nearly all of it.
  double sky_share = 0.36;
  std::vector<Mover> movers;
  // Those that were built.
  std::vector<PowerLine> power_lines;

  cv::Mat1f ground;   // bare ground, world z
  cv::Mat1f surface;  // highest thing, world z: tufts, crowns, roofs
  // Surface and wires, world z; empty where there are no wires. Wires are a tenth of a pixel thick:
  // no photograph shows them, but the truth knows of them.
  cv::Mat1f overhead;
  cv::Mat1b cover;     // Cover
  cv::Mat1b variant;   // tells one field, tree or roof from the next of its kind
  cv::Mat3b albedo;    // BGR as a camera would see it flat in the sun
  cv::Mat3b radiance;  // BGR with sun, shade and sky
  // 255 where albedo is of a photograph, which has its own light and shows its own leaves; empty
  // where none is.
  cv::Mat1b photographed;
  // That photograph is coarser than the cells.
  bool is_photograph_coarse = false;
  // 255 where albedo is a recorded texture, which shows the shade of its own blades; or empty.
  cv::Mat1b is_textured;

  int num_cells() const { return surface.rows; }
  double CellCenter(int index) const { return (index + 0.5) * cell_size_m - 0.5 * size_m; }
  // Cells (fractional) from the first cell's centre.
  double CellFrom(double coordinate) const {
    return (coordinate + 0.5 * size_m) / cell_size_m - 0.5;
  }
  // Nearest cell along one axis, clamped to the grid.
  int CellIndex(double coordinate) const;
  // Cells from `first` to `last` along one axis lie within the reach of a coordinate.
  cv::Range CellsAround(double coordinate, double reach_m) const;

  double GroundHeight(double x, double y) const;
  double SurfaceHeight(double x, double y) const;
  Cover CoverAt(double x, double y) const;
  // Highest thing of the cell, wires too.
  double TopHeight(double x, double y) const;
  bool IsWireAt(double x, double y) const;

  void Build(const House& house);
  void Plant(const Tree& tree);
  void Plant(const Hedge& hedge);
  void Put(const Block& block);
  void Put(const Boulder& boulder);
  void Dig(const Ditch& ditch);
  void Build(const Fence& fence);
  // After everything else that stands.
  void Build(const PowerLine& line);
  // Colours every cell by its cover; Light then adds slope against the sun, cast shadows and sky.
  // To be called after the last thing was built.
  void Paint();
  void Light();

  // Painted and lit, as it looks at a time, movers and all. They cast no shadow.
  World At(double seconds) const;
};

// Bilinear between cell centres; outside the grid the edge repeats.
inline float Bilinear(const cv::Mat1f& grid, double col, double row) {
  const double u = std::clamp(col, 0.0, grid.cols - 1.001);
  const double v = std::clamp(row, 0.0, grid.rows - 1.001);
  const int left = static_cast<int>(u);
  const int first = static_cast<int>(v);
  const float tu = static_cast<float>(u - left);
  const float tv = static_cast<float>(v - first);
  const float* a = grid[first] + left;
  const float* b = grid[first + 1] + left;
  const float south = a[0] + tu * (a[1] - a[0]);
  const float north = b[0] + tu * (b[1] - b[0]);
  return south + tv * (north - south);
}

// Visits every cell once, in parallel, square by square: what neighbours read of a noise's lattice
// then stays in the cache.
template <typename Visit>
void ForEachCell(const World& world, Visit visit) {
  constexpr int kSide = 32;
  const int n = world.num_cells();
  cv::parallel_for_({0, (n + kSide - 1) / kSide}, [&](const cv::Range& bands) {
    for (int band = bands.start; band < bands.end; ++band) {
      for (int left = 0; left < n; left += kSide) {
        for (int row = band * kSide; row < std::min(n, (band + 1) * kSide); ++row) {
          for (int col = left; col < std::min(n, left + kSide); ++col) visit(row, col);
        }
      }
    }
  });
}

// An even grass plane at z = 0 with nothing on it, painted and lit. For tests.
World MakeMeadowPlane(const WorldOptions& options);

// Farmland: parcels of meadow, stubble, soil, scrub and wood with hedges, trees, a road and a farm.
// The parcel in the middle is a good meadow with low cover downwind of it.
World MakeFarmland(const WorldOptions& options);

// Countryside for judging an engine: parcels of any size, meadows with and without all that makes a
// field a trap (too small, steep, rough, tall things downwind, animals, boulders, ditches, fences,
// poles), and green things that are no meadow. Nothing is arranged in favour of anyone.
World MakeCountryside(const WorldOptions& options);

}  // namespace freelsd
