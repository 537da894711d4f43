#include "tests/evaluation/site_score.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freelsd {
namespace {

constexpr double kStepM = 0.25;

struct PathTruth {
  double clearance = std::numeric_limits<double>::infinity();
  Eigen::Vector2d worst_place = Eigen::Vector2d::Zero();
};

// The highest thing across a corridor, by the finest grid there is.
PathTruth LookAcross(const World& world,
                     const Eigen::Vector2d& place,
                     const Eigen::Vector2d& across,
                     double half_width,
                     double path_height) {
  PathTruth path;
  for (double t = -half_width; t <= half_width + 1e-9; t += kStepM) {
    const Eigen::Vector2d point = place + t * across;
    const double clearance = path_height - world.TopHeight(point.x(), point.y());
    if (clearance >= path.clearance) continue;
    path.clearance = clearance;
    path.worst_place = point;
  }
  return path;
}

PathTruth Lower(const PathTruth& a, const PathTruth& b) {
  return b.clearance < a.clearance ? b : a;
}

PathTruth AlongFinal(const World& world,
                     const Aircraft& aircraft,
                     const Eigen::Vector2d& touchdown,
                     const Eigen::Vector2d& start,
                     double height_of_start) {
  const double length = (start - touchdown).norm();
  const Eigen::Vector2d outward = (start - touchdown) / std::max(length, 1e-9);
  const Eigen::Vector2d across(-outward.y(), outward.x());
  const double floor = world.GroundHeight(touchdown.x(), touchdown.y());
  PathTruth path;
  for (double s = aircraft.touchdown_uncertainty_m; s <= length; s += kStepM) {
    path = Lower(path,
                 LookAcross(world,
                            touchdown + s * outward,
                            across,
                            aircraft.path_half_width_m,
                            floor + height_of_start * s / length));
  }
  return path;
}

PathTruth AlongCircle(const World& world,
                      const Aircraft& aircraft,
                      const Eigen::Vector2d& center,
                      double radius,
                      double height_in_world) {
  PathTruth path;
  for (double angle = 0.0; angle < 2.0 * kPi; angle += kStepM / radius) {
    const Eigen::Vector2d outward(std::cos(angle), std::sin(angle));
    path = Lower(path,
                 LookAcross(world,
                            center + radius * outward,
                            outward,
                            aircraft.path_half_width_m,
                            height_in_world));
  }
  return path;
}

std::string NameOfObstacle(const World& world, const PathTruth& path) {
  if (path.clearance >= 0.0) return "";
  if (world.IsWireAt(path.worst_place.x(), path.worst_place.y())) return "wire";
  const Cover cover = world.CoverAt(path.worst_place.x(), path.worst_place.y());
  return cover == Cover::kMeadow ? "ground" : CoverName(cover);
}

std::string NameOfFault(const TruthMap& truth, const cv::Point& cell) {
  switch (static_cast<GroundFault>(truth.fault(cell))) {
    case GroundFault::kNone:
      return "";
    case GroundFault::kOutside:
      return "outside";
    case GroundFault::kCover:
      return CoverName(static_cast<Cover>(truth.cover(cell)));
    case GroundFault::kSteep:
      return "steep";
    case GroundFault::kRough:
      return "rough";
  }
  return "";
}

// The worst cell is named: things that stand before covers, covers before steepness.
std::string Worse(const std::string& a, const std::string& b, double top_a, double top_b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return top_b > top_a ? b : a;
}

// Cells whose centre lies in the touchdown disc or on the strip.
std::string GroundFaultOf(const World& world,
                          const TruthMap& truth,
                          const Aircraft& aircraft,
                          const Eigen::Vector2d& touchdown,
                          const Eigen::Vector2d& forward) {
  const Eigen::Vector2d across(-forward.y(), forward.x());
  const double radius = aircraft.touchdown_uncertainty_m;
  const double reach = std::max(radius, aircraft.ground_roll_m) + aircraft.path_half_width_m;
  const cv::Point low = truth.CellAt(touchdown - Eigen::Vector2d::Constant(reach));
  const cv::Point high = truth.CellAt(touchdown + Eigen::Vector2d::Constant(reach));
  const double half = 0.5 * world.size_m;
  std::string worst = touchdown.cwiseAbs().maxCoeff() > half - reach ? "outside" : "";
  double worst_top = -std::numeric_limits<double>::infinity();
  for (int row = low.y; row <= high.y; ++row) {
    for (int col = low.x; col <= high.x; ++col) {
      const Eigen::Vector2d place = truth.CellCenter(row, col);
      const Eigen::Vector2d offset = place - touchdown;
      const double along = offset.dot(forward);
      const bool is_on_strip = along >= 0.0 && along <= aircraft.ground_roll_m &&
                               std::abs(offset.dot(across)) <= aircraft.path_half_width_m;
      if (offset.norm() > radius && !is_on_strip) continue;
      const std::string fault = NameOfFault(truth, {col, row});
      if (fault.empty()) continue;
      const double top = truth.top(row, col) - world.GroundHeight(place.x(), place.y());
      worst = Worse(worst, fault, worst_top, top);
      worst_top = std::max(worst_top, top);
    }
  }
  return worst;
}

}  // namespace

bool SafetyScore::IsFalseSafe(Verdict verdict) const {
  if (verdict == Verdict::kRejected) return false;
  if (!ground_fault.empty() || !final_fault.empty()) return true;
  return verdict == Verdict::kLandable && !loiter_fault.empty();
}

std::optional<SafetyScore> ScorePlan(const World& world,
                                     const TruthMap& truth,
                                     const Aircraft& aircraft,
                                     const Plan& plan,
                                     const Eigen::Vector2d& shift) {
  if (!plan.approach) return std::nullopt;
  const Approach& approach = *plan.approach;
  const Eigen::Vector2d touchdown = approach.touchdown_in_world.head<2>() - shift;
  const Eigen::Vector2d start = approach.approach_start_in_world.head<2>() - shift;
  const double height = approach.approach_start_in_world.z() - approach.touchdown_in_world.z();
  SafetyScore score;
  // The roll goes on in the direction of the final.
  const Eigen::Vector2d forward = (touchdown - start).normalized();
  score.ground_fault = GroundFaultOf(world, truth, aircraft, touchdown, forward);
  score.free_distance = truth.free_distance(truth.CellAt(touchdown));
  const PathTruth final_path = AlongFinal(world, aircraft, touchdown, start, height);
  score.final_clearance = final_path.clearance;
  score.final_fault = NameOfObstacle(world, final_path);
  const PathTruth circle = AlongCircle(world,
                                       aircraft,
                                       approach.loiter_center_in_world.head<2>() - shift,
                                       approach.loiter_radius,
                                       world.GroundHeight(touchdown.x(), touchdown.y()) + height);
  score.loiter_clearance = circle.clearance;
  score.loiter_fault = NameOfObstacle(world, circle);
  return score;
}

}  // namespace freelsd
