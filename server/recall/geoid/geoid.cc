#include "server/recall/geoid/geoid.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <proj.h>
#include <spdlog/spdlog.h>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

constexpr char kPipeline[] = "+proj=vgridshift +grids=egm96_15.gtx +multiplier=1";
// The nodes of the grid. PROJ interpolates linearly between them.
constexpr int kNodesPerDegree = 4;
constexpr int kNumRows = 180 * kNodesPerDegree;
constexpr int kNumCols = 360 * kNodesPerDegree;
// Largest number of cached cells. A flight needs only a few, but a client may request places all
// over the earth.
constexpr size_t kMaxNumCells = 20000;

// The index of the cell, and where in it, 0 to 1.
std::pair<int, double> CellOf(double nodes, int num_cells) {
  const int index = std::clamp(static_cast<int>(std::floor(nodes)), 0, num_cells - 1);
  return {index, nodes - index};
}

}  // namespace

// Reads nodes of the grid.
class Geoid::GridReader {
  struct Destroy {
    void operator()(PJ_CONTEXT* context) const { proj_context_destroy(context); }
    void operator()(PJ* transformation) const { proj_destroy(transformation); }
  };

 public:
  GridReader() : context_(proj_context_create()) {
    proj_log_level(context_.get(), PJ_LOG_NONE);
    // PROJ must not download grids, because an emergency request must not wait for a server.
    proj_context_set_enable_network(context_.get(), 0);
    ellipsoid_from_geoid_.reset(proj_create(context_.get(), kPipeline));
    if (ellipsoid_from_geoid_) return;
    spdlog::warn("PROJ has no grid egm96_15.gtx: install the package proj-data");
  }

  // Nothing if PROJ has no such grid.
  std::optional<double> HeightAt(int row, int col) const {
    if (!ellipsoid_from_geoid_) return std::nullopt;
    const double latitude_deg = static_cast<double>(row) / kNodesPerDegree - 90.0;
    const double longitude_deg = static_cast<double>(col % kNumCols) / kNodesPerDegree - 180.0;
    const PJ_COORD place = proj_coord(RadFromDeg(longitude_deg), RadFromDeg(latitude_deg), 0, 0);
    const double height = proj_trans(ellipsoid_from_geoid_.get(), PJ_FWD, place).xyz.z;
    if (!std::isfinite(height) || std::abs(height) > kMaxGeoidHeightM) return std::nullopt;
    return height;
  }

 private:
  // Destroyed in reverse order: the transformation before its context.
  std::unique_ptr<PJ_CONTEXT, Destroy> context_;
  std::unique_ptr<PJ, Destroy> ellipsoid_from_geoid_;
};

Geoid::Geoid() = default;

Geoid::~Geoid() = default;

std::optional<Geoid::Cell> Geoid::CellAt(int row, int col) {
  const int key = row * kNumCols + col;
  if (const auto found = cells_.find(key); found != cells_.end()) return found->second;
  if (!grid_) grid_ = std::make_unique<GridReader>();
  Cell cell{};
  for (int i = 0; i < 4; ++i) {
    const std::optional<double> height = grid_->HeightAt(row + i / 2, col + i % 2);
    if (!height) return std::nullopt;
    cell.at(static_cast<size_t>(i)) = *height;
  }
  if (cells_.size() >= kMaxNumCells) cells_.clear();
  cells_.emplace(key, cell);
  return cell;
}

std::optional<double> Geoid::HeightAt(double latitude_deg, double longitude_deg) {
  const double east_deg = std::remainder(longitude_deg, 360.0) + 180.0;
  const auto [row, up] = CellOf((latitude_deg + 90.0) * kNodesPerDegree, kNumRows);
  const auto [col, right] = CellOf(east_deg * kNodesPerDegree, kNumCols);
  const std::lock_guard lock(mutex_);
  const std::optional<Cell> cell = CellAt(row, col);
  if (!cell) return std::nullopt;
  const auto& [south_west, south_east, north_west, north_east] = *cell;
  return std::lerp(
      std::lerp(south_west, south_east, right), std::lerp(north_west, north_east, right), up);
}

Geoid& Egm96() {
  static Geoid geoid;
  return geoid;
}

}  // namespace freelsd
