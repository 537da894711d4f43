#include "engine/approach/refusal.h"

#include <sstream>

namespace freelsd {
namespace {

std::string Rounded(double value, int num_decimals) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(num_decimals);
  text << value;
  return text.str();
}

std::optional<Refusal> RefuseTouchdown(const FootprintContent& content, double required_distance) {
  const double largest = content.touchdowns.front().hazard_distance;
  if (IsFarEnough(largest, required_distance)) return std::nullopt;
  return Refusal{RejectReason::kNoSafeTouchdown,
                 "the place farthest from hazard is " + Rounded(largest, 1) + " m from it, " +
                     Rounded(required_distance, 1) + " m are needed"};
}

}  // namespace

std::optional<Refusal> RefuseRegion(const PlanRequest& request,
                                    const FootprintContent& content,
                                    const Aircraft& aircraft) {
  if (!(request.area_m2 >= aircraft.min_area_m2)) {
    return Refusal{RejectReason::kTooSmall,
                   "the region has " + Rounded(request.area_m2, 0) + " m2, " +
                       Rounded(aircraft.min_area_m2, 0) + " m2 are needed"};
  }
  if (request.num_observations < request.min_num_observations) {
    return Refusal{RejectReason::kTooFewObservations,
                   "the region was seen in " + std::to_string(request.num_observations) +
                       " images, " + std::to_string(request.min_num_observations) + " are needed"};
  }
  if (!(request.grade > 0.0)) {
    return Refusal{RejectReason::kNotGrass, "the region was never seen as grass"};
  }
  if (content.touchdowns.empty()) {
    return Refusal{RejectReason::kNoTerrain, "no ground within the region could be reconstructed"};
  }
  if (!content.has_grass) {
    return Refusal{RejectReason::kNotGrass, "no ground within the region is grass on the map"};
  }
  return std::nullopt;
}

std::optional<Refusal> RefuseGround(const PlanRequest& request,
                                    const FootprintContent& content,
                                    double required_distance,
                                    const Aircraft& aircraft) {
  const std::optional<Refusal> refusal = RefuseRegion(request, content, aircraft);
  return refusal ? refusal : RefuseTouchdown(content, required_distance);
}

std::optional<Refusal> RefuseWind(const WindCase& wind, const Aircraft& aircraft) {
  if (!wind.is_too_strong) return std::nullopt;
  const double ground_speed = wind.ground_speed;
  return Refusal{RejectReason::kWindTooStrong,
                 "against " + Rounded(wind.wind_speed, 1) +
                     " m/s of wind the ground speed on final is " + Rounded(ground_speed, 1) +
                     " m/s, " + Rounded(aircraft.min_ground_speed_mps, 1) + " m/s are needed"};
}

}  // namespace freelsd
