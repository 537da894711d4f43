#include <cmath>
#include <sstream>
#include <stdexcept>

#include "engine/flight/flight.h"

namespace freelsd {
namespace {

struct Bound {
  const char* field;
  double value;
  double min;
  double max;
};

void RequireInside(const Bound& bound) {
  if (std::isfinite(bound.value) && bound.value >= bound.min && bound.value <= bound.max) return;
  std::ostringstream message;
  message << "aircraft." << bound.field << " = " << bound.value << ": must be in [" << bound.min
          << ", " << bound.max << "]";
  throw std::invalid_argument(message.str());
}

}  // namespace

void Aircraft::Check() const {
  const Bound bounds[] = {
      {"landing_airspeed_mps", landing_airspeed_mps, 1.0, 100.0},
      {"flight_path_angle_deg", flight_path_angle_deg, 0.5, 45.0},
      {"max_bank_deg", max_bank_deg, 1.0, 80.0},
      {"approach_height_m", approach_height_m, 1.0, 500.0},
      {"crosswind_uncertainty_deg", crosswind_uncertainty_deg, 0.0, 89.0},
      {"touchdown_uncertainty_m", touchdown_uncertainty_m, 0.0, 500.0},
      {"glide_ratio", glide_ratio, 1.0, 100.0},
      {"glide_airspeed_mps", glide_airspeed_mps.value_or(landing_airspeed_mps), 1.0, 100.0},
      {"max_slope_deg", max_slope_deg, 0.1, 60.0},
      {"max_roughness_m", max_roughness_m, 0.01, 20.0},
      {"safety_margin_m", safety_margin_m, 0.0, 100.0},
      {"path_half_width_m", path_half_width_m, 0.0, 100.0},
      {"ground_roll_m", ground_roll_m, 0.0, 2000.0},
      {"min_area_m2", min_area_m2, 1.0, 1e7},
  };
  for (const Bound& bound : bounds) RequireInside(bound);
}

std::optional<Aircraft> AircraftProfile(std::string_view name) {
  Aircraft aircraft;
  aircraft.profile = name;
  if (name == "techpod") return aircraft;
  if (name == "atlantiksolar") {
    aircraft.landing_airspeed_mps = 9.0;
    return aircraft;
  }
  if (name == "small") {
    aircraft.landing_airspeed_mps = 10.0;
    aircraft.flight_path_angle_deg = 8.0;
    aircraft.max_bank_deg = 30.0;
    aircraft.approach_height_m = 10.0;
    aircraft.touchdown_uncertainty_m = 8.0;
    aircraft.glide_ratio = 7.0;
    aircraft.ground_roll_m = 15.0;
    return aircraft;
  }
  return std::nullopt;
}

std::vector<std::string> AircraftProfileNames() { return {"techpod", "atlantiksolar", "small"}; }

}  // namespace freelsd
