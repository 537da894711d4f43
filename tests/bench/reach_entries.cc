// The ground in reach, on grids as the server makes them of 40 stored maps.
#include <cmath>
#include <memory>
#include <random>
#include <string>

#include "engine/glide/glide.h"
#include "tests/bench/contest.h"

namespace freelsd {
namespace {

constexpr int kNumMaps = 40;
constexpr double kMapSizeM = 600.0;
// Of a grid's side, and steps of its cells, as in server/recall/reach/reach_ground.cc.
constexpr int kMaxNumCells = 2000;
constexpr double kCellStepM = 2.0;
constexpr double kHighestM = 20.0;

Aircraft Glider() { return Unpowered(*AircraftProfile("techpod"), 12.0); }

GlideStart StartAt(double height_m) {
  GlideStart start;
  start.position_in_world = {0.0, 0.0, height_m};
  start.heading = 0.3;
  start.wind_in_world = Eigen::Vector2d(3.0, 4.0);
  return start;
}

// Rolling ground below 20 m where a map is; elsewhere 20 m are assumed.
ReachGround GroundBelow(const GlideStart& start) {
  const double half_m =
      GreatestGlideDistance(start, start.position_in_world.z(), Glider(), GlideOptions{});
  ReachGround ground;
  Grid& grid = ground.grid;
  grid.cell_size_m =
      kCellStepM * std::max(1.0, std::ceil(2.0 * half_m / kCellStepM / kMaxNumCells));
  grid.num_rows = grid.num_cols = 2 * static_cast<int>(std::ceil(half_m / grid.cell_size_m));
  grid.north_west_in_world = 0.5 * grid.num_cols * grid.cell_size_m * Eigen::Vector2d(-1.0, 1.0);
  const cv::Size size(grid.num_cols, grid.num_rows);
  ground.top = cv::Mat1f(size, static_cast<float>(kHighestM));
  ground.is_known = cv::Mat1b(size, uchar{0});
  std::mt19937 random(5);
  const int side = static_cast<int>(kMapSizeM / grid.cell_size_m);
  for (int map = 0; map < kNumMaps; ++map) {
    const auto place = [&] { return static_cast<int>(random() % (grid.num_cols - side)); };
    const int west = place(), north = place();
    ground.is_known(cv::Rect(west, north, side, side)) = 255;
  }
  for (int row = 0; row < grid.num_rows; ++row) {
    for (int col = 0; col < grid.num_cols; ++col) {
      if (ground.is_known(row, col) == 0) continue;
      const Eigen::Vector2d middle = grid.CellCenter(row, col);
      ground.top(row, col) = static_cast<float>(
          0.5 * kHighestM + 6.0 * std::sin(middle.x() / 90.0) + 4.0 * std::cos(middle.y() / 70.0));
    }
  }
  return ground;
}

Contest ReachAt(const std::string& name, double height_m, bool is_heading_known) {
  GlideStart start = StartAt(height_m);
  if (!is_heading_known) start.heading.reset();
  const auto ground = std::make_shared<const ReachGround>(GroundBelow(start));
  const std::string cells = std::to_string(ground->grid.num_cols);
  const std::string size = cells + "x" + cells + " cells of " +
                           std::to_string(std::lround(ground->grid.cell_size_m)) + " m";
  return {name,
          size,
          [=] {
            const Reach reach = ReachOf(start, *ground, Glider(), GlideOptions{}, ReachLimits{});
            Consume(static_cast<double>(reach.known.size()));
          },
          "",
          {}};
}

}  // namespace

std::vector<Entry> ReachEntries() {
  return {
      {"reach_300m", [] { return ReachAt("reach_300m", 300.0, true); }},
      {"reach_1000m", [] { return ReachAt("reach_1000m", 1000.0, true); }},
      {"reach_300m_turns", [] { return ReachAt("reach_300m_turns", 300.0, false); }},
  };
}

}  // namespace freelsd
