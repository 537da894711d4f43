#include "server/recall/reach/reach_ground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace freelsd {
namespace {

// Step between anchors. Within it, the frame's east and north are true to a millimetre per
// kilometre.
constexpr double kAnchorStepDeg = 0.25;
constexpr double kEarthRadiusM = 6371000.0;
// Of a grid's side: an answer takes time in proportion to the square.
constexpr int kMaxNumCells = 2000;
// Of a cell of the map: a patch's cell that meets no more than that of it does not meet it.
constexpr double kTouching = 1e-6;

constexpr float kNothing = -std::numeric_limits<float>::infinity();

GeoPoint AnchorNear(const GeoPoint& place) {
  const auto rounded = [](double angle_deg) {
    return std::round(angle_deg / kAnchorStepDeg) * kAnchorStepDeg;
  };
  return {rounded(place.latitude_deg), rounded(place.longitude_deg), 0.0};
}

int FloorDiv(int value, int divisor) {
  return static_cast<int>(std::floor(static_cast<double>(value) / divisor));
}

// Columns and rows of a map from places in the frame.
class MapPlacement {
 public:
  MapPlacement(const KeptTerrain& terrain, const ReachFrame& frame) {
    const Grid& grid = terrain.grid;
    const LocalFrame local_frame(terrain.origin);
    const auto corner = [&](double col, double row) {
      const Eigen::Vector2d place =
          grid.north_west_in_world + grid.cell_size_m * Eigen::Vector2d(col, -row);
      return frame.FromGeo(local_frame.GeoFromWorld({place.x(), place.y(), 0.0}));
    };
    const double cols = grid.num_cols, rows = grid.num_rows;
    north_west_ = corner(0.0, 0.0);
    corners_ = {north_west_, corner(cols, 0.0), corner(0.0, rows), corner(cols, rows)};
    Eigen::Matrix2d frame_from_cells;
    frame_from_cells << (corners_[1] - north_west_) / cols, (corners_[2] - north_west_) / rows;
    cells_from_frame_ = frame_from_cells.inverse();
  }

  const std::array<Eigen::Vector2d, 4>& corners() const { return corners_; }
  Eigen::Vector2d CellAt(const Eigen::Vector2d& place_in_frame) const {
    return cells_from_frame_ * (place_in_frame - north_west_);
  }
  // Half the size of an upright square's box, in columns and rows.
  Eigen::Vector2d HalfBox(double half_side_m) const {
    return half_side_m * cells_from_frame_.cwiseAbs().rowwise().sum();
  }

 private:
  Eigen::Vector2d north_west_;
  std::array<Eigen::Vector2d, 4> corners_;
  Eigen::Matrix2d cells_from_frame_;
};

// Altitude of the zero of the map's heights: its frame is a plane, and the Earth curves away.
double AltitudeOfZero(const KeptTerrain& terrain, int row, int col) {
  return terrain.origin.altitude_m +
         terrain.grid.CellCenter(row, col).squaredNorm() / (2.0 * kEarthRadiusM);
}

struct Cells {
  float top = kNothing;
  bool is_known = true;
};

// The map's cells that a patch's cell meets.
Cells CellsIn(const KeptTerrain& terrain,
              const Eigen::Vector2d& middle,
              const Eigen::Vector2d& half) {
  const auto first = [](double value) { return static_cast<int>(std::floor(value + kTouching)); };
  const auto last = [](double value) { return static_cast<int>(std::ceil(value - kTouching)) - 1; };
  Cells cells;
  for (int row = first(middle.y() - half.y()); row <= last(middle.y() + half.y()); ++row) {
    for (int col = first(middle.x() - half.x()); col <= last(middle.x() + half.x()); ++col) {
      const bool is_inside =
          row >= 0 && col >= 0 && row < terrain.grid.num_rows && col < terrain.grid.num_cols;
      if (!is_inside || terrain.is_seen(row, col) == 0) cells.is_known = false;
      if (is_inside && std::isfinite(terrain.upper(row, col))) {
        cells.top = std::max(cells.top, terrain.upper(row, col));
      }
    }
  }
  return cells;
}

GroundPatch MakePatch(const std::shared_ptr<const KeptTerrain>& terrain, const ReachFrame& frame) {
  const MapPlacement placement(*terrain, frame);
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& corner : placement.corners()) box.extend(corner);
  GroundPatch patch{terrain, frame.anchor(), {}, {}, {}};
  patch.north_west = {static_cast<int>(std::floor(box.min().x() / kPatchCellM)),
                      static_cast<int>(std::floor(-box.max().y() / kPatchCellM))};
  const cv::Size size(
      static_cast<int>(std::ceil(box.max().x() / kPatchCellM)) - patch.north_west.x,
      static_cast<int>(std::ceil(-box.min().y() / kPatchCellM)) - patch.north_west.y);
  patch.top = cv::Mat1f(size, kNothing);
  patch.is_known = cv::Mat1b(size, uchar{0});
  patch.lowest = std::numeric_limits<double>::infinity();
  patch.highest = -patch.lowest;
  const Eigen::Vector2d half = placement.HalfBox(0.5 * kPatchCellM);
  for (int row = 0; row < size.height; ++row) {
    for (int col = 0; col < size.width; ++col) {
      const Eigen::Vector2d place =
          kPatchCellM *
          Eigen::Vector2d(patch.north_west.x + col + 0.5, -(patch.north_west.y + row + 0.5));
      const Eigen::Vector2d middle = placement.CellAt(place);
      const Cells cells = CellsIn(*terrain, middle, half);
      if (cells.top == kNothing) continue;
      const double altitude =
          static_cast<double>(cells.top) +
          AltitudeOfZero(*terrain, static_cast<int>(middle.y()), static_cast<int>(middle.x()));
      patch.top(row, col) = static_cast<float>(altitude);
      patch.is_known(row, col) = cells.is_known ? 255 : 0;
      patch.lowest = std::min(patch.lowest, altitude);
      patch.highest = std::max(patch.highest, altitude);
    }
  }
  return patch;
}

// Of the grid: columns and rows of patch cells, and how many of them a cell's side has.
struct CellBlock {
  cv::Point north_west;
  int size = 1;
};

// Adds one map: the highest surface counts. A cell is known where one map sees it as a whole.
void AddPatch(const PlacedPatch& placed, const CellBlock& block, ReachGround& ground) {
  const GroundPatch& patch = *placed.patch;
  const cv::Point offset = patch.north_west - block.north_west;
  const cv::Rect whole(0, 0, ground.grid.num_cols, ground.grid.num_rows);
  const cv::Point first(FloorDiv(offset.x, block.size), FloorDiv(offset.y, block.size));
  const cv::Point last(FloorDiv(offset.x + patch.top.cols - 1, block.size),
                       FloorDiv(offset.y + patch.top.rows - 1, block.size));
  const cv::Rect met = cv::Rect(first, last + cv::Point(1, 1)) & whole;
  for (int row = met.y; row < met.br().y; ++row) {
    for (int col = met.x; col < met.br().x; ++col) {
      const cv::Point begin = cv::Point(col, row) * block.size - offset;
      const cv::Rect wanted(begin, cv::Size(block.size, block.size));
      const cv::Rect seen = wanted & cv::Rect({0, 0}, patch.top.size());
      bool is_known = seen == wanted;
      float top = kNothing;
      for (int y = seen.y; y < seen.br().y; ++y) {
        for (int x = seen.x; x < seen.br().x; ++x) {
          top = std::max(top, patch.top(y, x));
          is_known = is_known && patch.is_known(y, x) != 0;
        }
      }
      ground.top(row, col) =
          std::max(ground.top(row, col), top + static_cast<float>(placed.added_m));
      if (is_known) ground.is_known(row, col) = 255;
    }
  }
}

bool Meets(const GroundPatch& patch, const CellBlock& block, const Grid& grid) {
  const cv::Rect of_grid(block.north_west, cv::Size(grid.num_cols, grid.num_rows) * block.size);
  return !(cv::Rect(patch.north_west, patch.top.size()) & of_grid).empty();
}

}  // namespace

ReachFrame::ReachFrame(const GeoPoint& place) : place_(place), local_frame_(AnchorNear(place)) {
  constexpr double kStepDeg = 1e-4;
  const double towards = place.latitude_deg > 0.0 ? -kStepDeg : kStepDeg;
  const GeoPoint other{place.latitude_deg + towards, place.longitude_deg, 0.0};
  north_ = HeadingOf((FromGeo(other) - FromGeo(place)) * (towards > 0.0 ? 1.0 : -1.0));
}

Eigen::Vector2d ReachFrame::FromGeo(const GeoPoint& place) const {
  return local_frame_.WorldFromGeo({place.latitude_deg, place.longitude_deg, 0.0}).head<2>();
}

GeoPoint ReachFrame::ToGeo(const Eigen::Vector2d& place_in_frame) const {
  const double below = place_in_frame.squaredNorm() / (2.0 * kEarthRadiusM);
  GeoPoint geo = local_frame_.GeoFromWorld({place_in_frame.x(), place_in_frame.y(), -below});
  geo.longitude_deg =
      place_.longitude_deg + std::remainder(geo.longitude_deg - place_.longitude_deg, 360.0);
  geo.altitude_m = 0.0;
  return geo;
}

std::shared_ptr<const GroundPatch> GroundPatches::PatchOf(
    const MapRow& row, const std::shared_ptr<const KeptTerrain>& terrain, const ReachFrame& frame) {
  // A stored map never changes.
  constexpr int64_t kVersion = 0;
  {
    const std::lock_guard lock(mutex_);
    const auto* const kept = patches_.Find(row.id, kVersion);
    if (kept != nullptr && (*kept)->terrain.lock() == terrain &&
        (*kept)->anchor.latitude_deg == frame.anchor().latitude_deg &&
        (*kept)->anchor.longitude_deg == frame.anchor().longitude_deg) {
      return *kept;
    }
  }
  auto patch = std::make_shared<const GroundPatch>(MakePatch(terrain, frame));
  if (!std::isfinite(patch->lowest)) return nullptr;
  const std::lock_guard lock(mutex_);
  patches_.Keep(row.id, kVersion, 5 * patch->top.total(), patch);
  return patch;
}

NearbyGround GroundAround(const Eigen::Vector2d& place_in_frame,
                          double half_size_m,
                          const std::vector<PlacedPatch>& patches) {
  NearbyGround nearby;
  CellBlock block;
  block.size =
      std::max(1, static_cast<int>(std::ceil(2.0 * half_size_m / kPatchCellM / kMaxNumCells)));
  Grid& grid = nearby.ground.grid;
  grid.cell_size_m = kPatchCellM * block.size;
  const int half_num = static_cast<int>(std::ceil(half_size_m / grid.cell_size_m)) + 2;
  grid.num_rows = grid.num_cols = 2 * half_num;
  block.north_west = {
      static_cast<int>(std::floor(place_in_frame.x() / kPatchCellM)) - half_num * block.size,
      static_cast<int>(std::floor(-place_in_frame.y() / kPatchCellM)) - half_num * block.size};
  grid.north_west_in_world = kPatchCellM * Eigen::Vector2d(block.north_west.x, -block.north_west.y);
  nearby.ground.top = cv::Mat1f(grid.num_rows, grid.num_cols, kNothing);
  nearby.ground.is_known = cv::Mat1b(grid.num_rows, grid.num_cols, uchar{0});
  nearby.assumed_altitude_m = -std::numeric_limits<double>::infinity();
  for (const PlacedPatch& placed : patches) {
    if (!Meets(*placed.patch, block, grid)) continue;
    AddPatch(placed, block, nearby.ground);
    nearby.assumed_altitude_m =
        std::max(nearby.assumed_altitude_m, placed.patch->highest + placed.added_m);
    ++nearby.num_maps;
  }
  cv::Mat1f raised;
  cv::max(nearby.ground.top, nearby.assumed_altitude_m, raised);
  raised.copyTo(nearby.ground.top, nearby.ground.is_known == 0);
  return nearby;
}

}  // namespace freelsd
