#include "tests/evaluation/site_score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/evaluation/scores/obstruction.h"

namespace freelsd {
namespace {

const std::string kDoubt = CoverName(Cover::kDoubt);

struct PathTruth {
  double clearance = std::numeric_limits<double>::infinity();
  Eigen::Vector2d worst_place = Eigen::Vector2d::Zero();
};

// The highest thing across a corridor, by the finest grid there is.
PathTruth LookAcross(const World& world,
                     ThinThings thin,
                     const Eigen::Vector2d& place,
                     const Eigen::Vector2d& across,
                     double half_width,
                     double path_height) {
  PathTruth path;
  for (double t = -half_width; t <= half_width + 1e-9; t += StepOf(world)) {
    const Eigen::Vector2d point = place + t * across;
    const double clearance = path_height - TopOf(world, point, thin);
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
                     ThinThings thin,
                     const Aircraft& aircraft,
                     const Eigen::Vector2d& touchdown,
                     const Eigen::Vector2d& start,
                     double height_of_start) {
  const double length = (start - touchdown).norm();
  const Eigen::Vector2d outward = (start - touchdown) / std::max(length, 1e-9);
  const Eigen::Vector2d across(-outward.y(), outward.x());
  const double floor = world.GroundHeight(touchdown.x(), touchdown.y());
  PathTruth path;
  for (double s = aircraft.touchdown_uncertainty_m; s <= length; s += StepOf(world)) {
    path = Lower(path,
                 LookAcross(world,
                            thin,
                            touchdown + s * outward,
                            across,
                            aircraft.path_half_width_m,
                            floor + height_of_start * s / length));
  }
  return path;
}

PathTruth AlongCircle(const World& world,
                      ThinThings thin,
                      const Aircraft& aircraft,
                      const Eigen::Vector2d& center,
                      double radius,
                      double height_in_world) {
  PathTruth path;
  for (double angle = 0.0; angle < 2.0 * kPi; angle += StepOf(world) / radius) {
    const Eigen::Vector2d outward(std::cos(angle), std::sin(angle));
    path = Lower(path,
                 LookAcross(world,
                            thin,
                            center + radius * outward,
                            outward,
                            aircraft.path_half_width_m,
                            height_in_world));
  }
  return path;
}

// The highest is named.
struct WorstFault {
  std::string name;
  double top = -std::numeric_limits<double>::infinity();

  void Add(const std::string& other, double other_top) {
    if (!name.empty() && other_top <= top) return;
    name = other;
    top = other_top;
  }
};

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
  if (touchdown.cwiseAbs().maxCoeff() > half - reach) return "outside";
  WorstFault solid, thin, doubt;
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
      if (fault == kDoubt) {
        doubt.Add(fault, top);
      } else {
        (IsThinFault(truth, {col, row}) ? thin : solid).Add(fault, top);
      }
    }
  }
  for (const WorstFault* fault : {&solid, &thin}) {
    if (!fault->name.empty()) return fault->name;
  }
  return doubt.name;
}

}  // namespace

bool SafetyScore::IsFalseSafe(Verdict verdict) const {
  if (verdict == Verdict::kRejected) return false;
  if ((!ground_fault.empty() && ground_fault != kDoubt) || !final_fault.empty()) return true;
  return verdict == Verdict::kLandable && !loiter_fault.empty();
}

bool SafetyScore::IsInDoubt(Verdict verdict) const {
  return verdict != Verdict::kRejected && ground_fault == kDoubt && !IsFalseSafe(verdict);
}

bool SafetyScore::IsOnlyThin(Verdict verdict) const {
  const auto is_harmless = [](const std::string& fault) {
    return fault.empty() || fault == kDoubt || IsThinName(fault);
  };
  return IsFalseSafe(verdict) && is_harmless(ground_fault) && is_harmless(final_fault) &&
         (verdict != Verdict::kLandable || is_harmless(loiter_fault));
}

std::optional<SafetyScore> ScorePlan(const World& world,
                                     const TruthMap& truth,
                                     const Aircraft& aircraft,
                                     const Plan& plan,
                                     const Eigen::Vector2d& shift) {
  if (!plan.approach && plan.verdict != Verdict::kRejected) {
    throw std::invalid_argument("an accepted site without an approach");
  }
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
  const auto judge = [&](const auto& look, double& clearance, std::string& fault) {
    const PathTruth all = look(ThinThings::kCount), solid = look(ThinThings::kIgnore);
    clearance = all.clearance;
    const bool is_thin = solid.clearance >= 0.0;
    const PathTruth& named = is_thin ? all : solid;
    if (named.clearance < 0.0) {
      fault =
          NameOfThing(world, named.worst_place, is_thin ? ThinThings::kCount : ThinThings::kIgnore);
    }
    return named.worst_place;
  };
  score.final_worst_place = judge(
      [&](ThinThings thin) { return AlongFinal(world, thin, aircraft, touchdown, start, height); },
      score.final_clearance,
      score.final_fault);
  judge(
      [&](ThinThings thin) {
        return AlongCircle(world,
                           thin,
                           aircraft,
                           approach.loiter_center_in_world.head<2>() - shift,
                           approach.loiter_radius,
                           world.GroundHeight(touchdown.x(), touchdown.y()) + height);
      },
      score.loiter_clearance,
      score.loiter_fault);
  return score;
}

}  // namespace freelsd
