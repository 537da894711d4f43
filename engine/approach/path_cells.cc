#include "engine/approach/path_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freelsd {
namespace {

bool IsSame(const CellOffset& a, const CellOffset& b) { return a.row == b.row && a.col == b.col; }

// Cell of a place given relative to the centre of the touchdown's cell, world.
CellOffset OffsetOf(const Eigen::Vector2d& from_touchdown, double cell_size) {
  return {FloorOf(0.5 - from_touchdown.y() / cell_size),
          FloorOf(0.5 + from_touchdown.x() / cell_size)};
}

std::vector<CellOffset> RollCells(double heading,
                                  const ClearanceSurface& surface,
                                  const Aircraft& aircraft) {
  std::vector<CellOffset> cells;
  for (const RollSample& sample : RollSamples(heading, surface, aircraft)) {
    cells.push_back(OffsetOf(sample.from_touchdown, surface.cell_size));
  }
  const auto key = [](const CellOffset& cell) { return std::pair(cell.row, cell.col); };
  std::sort(
      cells.begin(), cells.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  cells.erase(std::unique(cells.begin(), cells.end(), IsSame), cells.end());
  return cells;
}

void AddFinal(const Approach& approach,
              const std::vector<double>& steps,
              const ClearanceSurface& surface,
              const Aircraft& aircraft,
              PathCells& cells) {
  const Eigen::Vector2d forward = DirectionOf(approach.heading);
  const double slope = approach.approach_height / approach.approach_distance;
  std::vector<FinalCell>& path = cells.final_path;
  cells.num_final_steps = static_cast<int>(steps.size());
  for (const double distance : steps) {
    const CellOffset offset = OffsetOf(-distance * forward, surface.cell_size);
    const double height = slope * distance;
    const double free_height = height - WantedClearance(distance, height, surface, aircraft);
    if (path.empty() || !IsSame(path.back().offset, offset)) {
      path.push_back({offset, height, free_height});
    }
    path.back().free_height = std::min(path.back().free_height, free_height);
  }
}

void AddCircle(const Approach& approach,
               const ClearanceSurface& surface,
               const Aircraft& aircraft,
               PathCells& cells) {
  const auto direction = static_cast<size_t>(approach.loiter_direction);
  const int num_steps = NumCircleSteps(approach.loiter_radius, surface);
  const Eigen::Vector2d center = approach.loiter_center_in_world.head<2>();
  const Eigen::Matrix2d rotation = Eigen::Rotation2Dd(2.0 * kPi / num_steps).toRotationMatrix();
  Eigen::Vector2d arm = approach.approach_start_in_world.head<2>() - center;
  std::vector<CircleCell>& circle = cells.circles[direction];
  for (int i = 0; i < num_steps; ++i, arm = rotation * arm) {
    const Eigen::Vector2d place = center + arm;
    const CellOffset offset = OffsetOf(place, surface.cell_size);
    if (circle.empty() || !IsSame(circle.back().offset, offset)) circle.push_back({offset});
    ++circle.back().num_steps;
    circle.back().wanted =
        std::max(circle.back().wanted, aircraft.safety_margin_m + surface.lean * place.norm());
  }
  cells.num_circle_steps[direction] = num_steps;
}

PathCells CellsOf(double heading,
                  const WindScenario& scenario,
                  const ClearanceSurface& surface,
                  const Aircraft& aircraft,
                  const ApproachOptions& options) {
  PathCells cells;
  for (const LoiterDirection direction : {LoiterDirection::kLeft, LoiterDirection::kRight}) {
    const Approach approach = MakeApproach(
        Eigen::Vector3d::Zero(), heading, scenario, direction, aircraft.approach_height_m);
    AddCircle(approach, surface, aircraft, cells);
    if (direction == LoiterDirection::kRight) continue;
    const std::vector<double> steps = FinalSteps(surface, scenario, aircraft, options);
    AddFinal(approach, steps, surface, aircraft, cells);
  }
  return cells;
}

}  // namespace

std::vector<HeadingCells> MakeHeadingCells(const WindCase& wind,
                                           const ClearanceSurface& surface,
                                           const Aircraft& aircraft,
                                           const ApproachOptions& options) {
  std::vector<HeadingCells> headings;
  for (const HeadingCase& flown : wind.headings) {
    HeadingCells cells{RollCells(flown.heading, surface, aircraft), {}};
    for (const WindScenario& scenario : flown.scenarios) {
      cells.scenarios.push_back(CellsOf(flown.heading, scenario, surface, aircraft, options));
    }
    headings.push_back(std::move(cells));
  }
  return headings;
}

bool CellsBelow::IsRollFree(const std::vector<CellOffset>& ground_roll) const {
  return std::all_of(ground_roll.begin(), ground_roll.end(), [this](const CellOffset& offset) {
    const int row = row_ + offset.row, col = col_ + offset.col;
    return surface_.IsInside(row, col) && surface_.hazard(row, col) == kFree;
  });
}

std::optional<PathCheck> CellsBelow::GlanceAlongFinal(const PathCells& cells) const {
  PathCheck check;
  check.num_steps = cells.num_final_steps;
  for (const FinalCell& cell : cells.final_path) {
    const int row = row_ + cell.offset.row, col = col_ + cell.offset.col;
    if (!surface_.IsInside(row, col) || surface_.corridor_is_unseen(row, col)) return std::nullopt;
    const double top = surface_.corridor_height(row, col) - height_;
    if (!(top <= cell.free_height)) return std::nullopt;  // Nor where it is no number.
    check.min_clearance = std::min(check.min_clearance, cell.path_height - top);
  }
  return check;
}

PathCheck CellsBelow::CheckCircle(const PathCells& cells,
                                  LoiterDirection direction,
                                  double approach_height) const {
  PathCheck check;
  check.num_steps = cells.num_circle_steps[static_cast<size_t>(direction)];
  const double height = height_ + approach_height;
  Obstacle nearest;
  double worst_deficit = -std::numeric_limits<double>::infinity();
  for (const CircleCell& cell : cells.circles[static_cast<size_t>(direction)]) {
    const int row = row_ + cell.offset.row, col = col_ + cell.offset.col;
    if (!surface_.IsInside(row, col)) {
      check.num_unseen_steps += cell.num_steps;
      continue;
    }
    check.num_unseen_steps += surface_.corridor_is_unseen(row, col) * cell.num_steps;
    const float top = surface_.corridor_height(row, col);
    if (top == kNoHeight) continue;
    const double clearance = height - top;
    if (cell.wanted - clearance <= worst_deficit) continue;
    worst_deficit = cell.wanted - clearance;
    nearest.clearance = clearance;
    nearest.wanted = cell.wanted;
    if (worst_deficit > 0.0) break;
  }
  return std::isinf(worst_deficit) ? check : WithObstacle(check, nearest);
}

}  // namespace freelsd
