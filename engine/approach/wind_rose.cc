#include <cmath>
#include <stdexcept>
#include <string>

#include "engine/approach/approach.h"

namespace freelsd {
namespace {

constexpr int kMaxNumDirections = 3600;
constexpr size_t kMaxNumSpeeds = 1000;

void Require(bool holds, const std::string& message) {
  if (!holds) throw std::invalid_argument("wind_rose." + message);
}

}  // namespace

void WindRoseOptions::Check() const {
  Require(num_directions >= 1 && num_directions <= kMaxNumDirections,
          "num_directions = " + std::to_string(num_directions) + ": must be in [1, " +
              std::to_string(kMaxNumDirections) + "]");
  Require(!speeds_mps.empty() && speeds_mps.size() <= kMaxNumSpeeds,
          "speeds_mps = " + std::to_string(speeds_mps.size()) + " numbers: must be 1 to " +
              std::to_string(kMaxNumSpeeds));
  double last = -1.0;
  for (const double speed : speeds_mps) {
    Require(std::isfinite(speed) && speed >= 0.0 && speed > last,
            "speeds_mps = " + std::to_string(speed) + ": must be >= 0 and ascending");
    last = speed;
  }
}

Eigen::Vector2d WindRose::WindInWorld(size_t speed, size_t direction) const {
  const double from = 2.0 * kPi * static_cast<double>(direction) / num_directions;
  return -speeds.at(speed) * DirectionOf(from);
}

const Plan& WindRose::At(size_t speed, size_t direction) const {
  return plans.at(speed * static_cast<size_t>(num_directions) + direction);
}

WindRose PlanWindRose(const ApproachPlanner& planner,
                      const WindRoseOptions& options,
                      const std::function<void()>& before_wind) {
  options.Check();
  WindRose rose{options.num_directions, options.speeds_mps, {}};
  const auto num_directions = static_cast<size_t>(options.num_directions);
  for (size_t speed = 0; speed < rose.speeds.size(); ++speed) {
    for (size_t direction = 0; direction < num_directions; ++direction) {
      before_wind();
      // Calm has no direction.
      const bool is_same = direction > 0 && rose.speeds[speed] <= 0.0;
      rose.plans.push_back(
          is_same ? rose.plans.back()
                  : planner.PlanFor(rose.WindInWorld(speed, direction), Explanation::kNone));
    }
  }
  return rose;
}

}  // namespace freelsd
