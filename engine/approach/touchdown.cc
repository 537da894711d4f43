#include "engine/approach/touchdown.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace freelsd {
namespace {

// Sort key of a touchdown.
struct Place {
  double hazard_distance;
  double squared_to_middle;
  int row;
  int col;

  // Equal distances: nearer to the middle first, then in the order of the map.
  bool operator<(const Place& other) const {
    if (hazard_distance != other.hazard_distance) return hazard_distance > other.hazard_distance;
    if (squared_to_middle != other.squared_to_middle) {
      return squared_to_middle < other.squared_to_middle;
    }
    return row != other.row ? row < other.row : col < other.col;
  }
};

// Size of the map up to the last cell with a touchdown.
cv::Size CellsAround(const std::vector<Touchdown>& touchdowns) {
  cv::Size size;
  for (const Touchdown& touchdown : touchdowns) {
    size = {std::max(size.width, touchdown.col + 1), std::max(size.height, touchdown.row + 1)};
  }
  return size;
}

// Looks up touchdowns by cell.
class TouchdownsByCell {
 public:
  explicit TouchdownsByCell(const std::vector<Touchdown>& touchdowns)
      : touchdowns_(touchdowns), index_(CellsAround(touchdowns), kNone) {
    for (size_t i = 0; i < touchdowns.size(); ++i) {
      index_(touchdowns[i].row, touchdowns[i].col) = static_cast<int>(i);
    }
  }
  bool IsNearAnother(const Touchdown& touchdown) const {
    return index_(touchdown.row, touchdown.col) == kNone;
  }
  // Marks touchdowns nearer to `taken` than the spacing.
  void TakeNear(const Touchdown& taken, double spacing, double cell_size) {
    const auto reach = static_cast<int>(std::min(spacing / cell_size, 1e6)) + 1;
    const cv::Rect around(taken.col - reach, taken.row - reach, 2 * reach + 1, 2 * reach + 1);
    const cv::Rect cells = around & cv::Rect({0, 0}, index_.size());
    for (int row = cells.y; row < cells.y + cells.height; ++row) {
      for (int col = cells.x; col < cells.x + cells.width; ++col) {
        int& index = index_(row, col);
        if (index == kNone) continue;
        const Eigen::Vector3d& place = touchdowns_[static_cast<size_t>(index)].place_in_world;
        const double squared = (taken.place_in_world - place).head<2>().squaredNorm();
        if (squared < spacing * spacing) index = kNone;
      }
    }
  }

 private:
  static constexpr int kNone = -1;
  const std::vector<Touchdown>& touchdowns_;
  cv::Mat1i index_;
};

// Safest first, at a spacing that covers all usable ground.
std::vector<Touchdown> SpreadOut(const std::vector<Touchdown>& wide,
                                 double cell_size,
                                 const ApproachOptions& options) {
  const double area_of_each =
      static_cast<double>(wide.size()) * cell_size * cell_size / options.max_num_candidates;
  const double spacing = std::max(options.candidate_spacing_m, std::sqrt(area_of_each));
  TouchdownsByCell by_cell(wide);
  std::vector<Touchdown> candidates;
  for (const Touchdown& touchdown : wide) {
    if (candidates.size() >= static_cast<size_t>(options.max_num_candidates)) break;
    if (by_cell.IsNearAnother(touchdown)) continue;
    candidates.push_back(touchdown);
    by_cell.TakeNear(touchdown, spacing, cell_size);
  }
  return candidates;
}

// The safest cell of every square block, or all cells if there are few.
std::vector<Touchdown> SafestOfBlocks(const std::vector<Touchdown>& wide,
                                      const ApproachOptions& options) {
  const auto limit = static_cast<size_t>(options.max_num_reserve_candidates);
  if (limit == 0) return {};
  const cv::Size cells = CellsAround(wide);
  for (int side = 1;; ++side) {
    cv::Mat1b has_one(cells.height / side + 1, cells.width / side + 1, uchar{0});
    std::vector<Touchdown> safest;
    for (const Touchdown& touchdown : wide) {
      uchar& is_taken = has_one(touchdown.row / side, touchdown.col / side);
      if (is_taken == 0) safest.push_back(touchdown);
      is_taken = 1;
      if (safest.size() > limit) break;
    }
    if (safest.size() <= limit) return safest;
  }
}

}  // namespace

// The order of arguments keeps NaN: no distance suffices where the deviation is unknown.
double PositionDeviation(const ElevationMap& map, const ApproachOptions& options) {
  return std::max(map.position_sd_m, options.min_map_position_sd_m);
}

void RequireOneGrid(const ElevationMap& map, const HazardLayers& hazards) {
  const cv::Size size(map.grid.num_cols, map.grid.num_rows);
  const bool is_whole = map.elevation.size() == size && map.upper.size() == size &&
                        hazards.slope.size() == size && hazards.roughness.size() == size &&
                        hazards.grass.size() == size && hazards.hazard.size() == size &&
                        hazards.distance.size() == size && map.standard_deviation.size() == size;
  if (map.grid == hazards.grid && is_whole) return;
  throw std::invalid_argument("approach.hazards: must be of the map's grid, " +
                              std::to_string(size.height) + "x" + std::to_string(size.width) +
                              " cells");
}

double RequiredHazardDistance(const ElevationMap& map,
                              const Aircraft& aircraft,
                              const ApproachOptions& options) {
  return aircraft.touchdown_uncertainty_m +
         options.disc_margin_sigma * PositionDeviation(map, options) +
         map.grid.cell_size_m * std::sqrt(0.5);
}

Aircraft WithPositionMargin(Aircraft aircraft,
                            const ElevationMap& map,
                            const ApproachOptions& options) {
  const double margin = options.path_margin_sigma * PositionDeviation(map, options);
  aircraft.path_half_width_m += margin;
  // Without a ground roll the paper's rule applies: the disc alone.
  if (aircraft.ground_roll_m > 0.0) aircraft.ground_roll_m += margin;
  return aircraft;
}

Touchdown TouchdownAt(const ElevationMap& map, const HazardLayers& hazards, const cv::Point& cell) {
  const Eigen::Vector2d center = map.grid.CellCenter(cell.y, cell.x);
  const float distance = hazards.distance(cell);
  return {.row = cell.y,
          .col = cell.x,
          .place_in_world = {center.x(), center.y(), map.elevation(cell)},
          .hazard_distance = std::isnan(distance) ? 0.0 : distance};
}

FootprintContent ReadFootprint(const ElevationMap& map,
                               const HazardLayers& hazards,
                               const Polygon& footprint) {
  FootprintContent content;
  if (footprint.size() < 3) return content;
  const Eigen::Vector2d middle = Centroid(footprint);
  std::vector<Place> places;
  for (const cv::Point& cell : map.grid.CellsIn(footprint)) {
    if (hazards.grass(cell) >= hazards.min_clear_class_posterior) content.has_grass = true;
    if (std::isnan(map.elevation(cell))) continue;
    const Touchdown touchdown = TouchdownAt(map, hazards, cell);
    places.push_back({touchdown.hazard_distance,
                      (touchdown.place_in_world.head<2>() - middle).squaredNorm(),
                      cell.y,
                      cell.x});
  }
  std::sort(places.begin(), places.end());
  content.touchdowns.reserve(places.size());
  for (const Place& place : places) {
    content.touchdowns.push_back(TouchdownAt(map, hazards, {place.col, place.row}));
  }
  return content;
}

TouchdownCandidates SelectCandidates(const std::vector<Touchdown>& touchdowns,
                                     double required_distance,
                                     double cell_size,
                                     const ApproachOptions& options) {
  if (!std::isfinite(required_distance)) return {};
  const auto end_of_wide =
      std::find_if(touchdowns.begin(), touchdowns.end(), [&](const Touchdown& place) {
        return !IsFarEnough(place.hazard_distance, required_distance);
      });
  const std::vector<Touchdown> wide(touchdowns.begin(), end_of_wide);
  return {SpreadOut(wide, cell_size, options), SafestOfBlocks(wide, options)};
}

double LargestInDisc(const cv::Mat1f& layer,
                     const Touchdown& touchdown,
                     double radius,
                     double cell_size) {
  const int half = static_cast<int>(std::floor(radius / cell_size));
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (int row = touchdown.row - half; row <= touchdown.row + half; ++row) {
    for (int col = touchdown.col - half; col <= touchdown.col + half; ++col) {
      if (row < 0 || row >= layer.rows || col < 0 || col >= layer.cols) continue;
      const double distance = cell_size * std::hypot(row - touchdown.row, col - touchdown.col);
      if (distance > radius || std::isnan(layer(row, col))) continue;
      if (!(largest >= layer(row, col))) largest = layer(row, col);
    }
  }
  return largest;
}

}  // namespace freelsd
