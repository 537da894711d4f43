#include "engine/approach/candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freelsd {
namespace {

// Cells from which grass is more likely than not.
constexpr float kMinGrassProbability = 0.5f;

// Calls visit(row, col) for every cell of the grid whose centre lies in the footprint.
template <typename Visit>
void ForEachCell(const Grid& grid, const Polygon& footprint, Visit visit) {
  for (int row = 0; row < grid.num_rows; ++row) {
    for (int col = 0; col < grid.num_cols; ++col) {
      if (Contains(footprint, grid.CellCenter(row, col))) visit(row, col);
    }
  }
}

Candidate CandidateAt(const ElevationMap& map, const HazardLayers& hazards, int row, int col) {
  Candidate candidate;
  candidate.cell = {col, row};
  candidate.touchdown_in_world.head<2>() = map.grid.CellCenter(row, col);
  candidate.touchdown_in_world.z() = map.elevation(row, col);
  candidate.hazard_distance = hazards.distance(row, col);
  return candidate;
}

bool IsBetter(const Candidate& a, const Candidate& b) {
  if (a.hazard_distance != b.hazard_distance) return a.hazard_distance > b.hazard_distance;
  return a.cell.y < b.cell.y || (a.cell.y == b.cell.y && a.cell.x < b.cell.x);
}

}  // namespace

double NeededHazardDistance(const Grid& grid,
                            const Aircraft& aircraft,
                            const ApproachOptions& options) {
  return aircraft.touchdown_uncertainty_m + options.map_position_sd_m +
         std::sqrt(0.5) * grid.cell_size_m;
}

std::vector<Candidate> TouchdownCandidates(const ElevationMap& map,
                                           const HazardLayers& hazards,
                                           const PlanRequest& request,
                                           const Aircraft& aircraft,
                                           const ApproachOptions& options) {
  const double needed = NeededHazardDistance(map.grid, aircraft, options);
  std::vector<Candidate> cells;
  ForEachCell(map.grid, request.footprint, [&](int row, int col) {
    if (hazards.hazard(row, col) == kFree && hazards.distance(row, col) >= needed) {
      cells.push_back(CandidateAt(map, hazards, row, col));
    }
  });
  std::sort(cells.begin(), cells.end(), IsBetter);
  std::vector<Candidate> candidates;
  for (const Candidate& cell : cells) {
    if (static_cast<int>(candidates.size()) >= options.max_num_candidates) break;
    const bool is_apart =
        std::all_of(candidates.begin(), candidates.end(), [&](const Candidate& other) {
          return (cell.touchdown_in_world - other.touchdown_in_world).head<2>().norm() >=
                 options.candidate_spacing_m;
        });
    if (is_apart) candidates.push_back(cell);
  }
  return candidates;
}

std::optional<Candidate> LeastBadCell(const ElevationMap& map,
                                      const HazardLayers& hazards,
                                      const PlanRequest& request) {
  std::optional<Candidate> best;
  ForEachCell(map.grid, request.footprint, [&](int row, int col) {
    if (std::isnan(map.elevation(row, col))) return;
    const Candidate cell = CandidateAt(map, hazards, row, col);
    if (!best || IsBetter(cell, *best)) best = cell;
  });
  return best;
}

bool HasGrass(const HazardLayers& hazards, const PlanRequest& request) {
  bool has_grass = false;
  ForEachCell(hazards.grid, request.footprint, [&](int row, int col) {
    has_grass |= hazards.grass(row, col) >= kMinGrassProbability;
  });
  return has_grass;
}

Ground GroundAround(const HazardLayers& hazards,
                    const Eigen::Vector2d& touchdown_in_world,
                    double radius) {
  Ground ground{std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  for (int row = 0; row < hazards.grid.num_rows; ++row) {
    for (int col = 0; col < hazards.grid.num_cols; ++col) {
      const Eigen::Vector2d center = hazards.grid.CellCenter(row, col);
      if ((center - touchdown_in_world).norm() > radius) continue;
      // fmax ignores NaN as long as one value is known.
      ground.slope = std::fmax(ground.slope, hazards.slope(row, col));
      ground.roughness = std::fmax(ground.roughness, hazards.roughness(row, col));
    }
  }
  return ground;
}

}  // namespace freelsd
