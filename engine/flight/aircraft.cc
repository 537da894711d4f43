#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "engine/check/check.h"
#include "engine/flight/flight.h"

namespace freelsd {
namespace {

// A final or circle of many kilometres is an error of units, and no map holds it.
void RequirePath(const Aircraft& aircraft) {
  constexpr double kMaxFinalM = 10000.0;
  constexpr double kMaxRadiusM = 10000.0;
  constexpr double kGravity = 9.81;
  const double final_m =
      aircraft.approach_height_m / std::tan(RadFromDeg(aircraft.flight_path_angle_deg));
  const double radius_m = aircraft.landing_airspeed_mps * aircraft.landing_airspeed_mps /
                          (kGravity * std::tan(RadFromDeg(aircraft.max_bank_deg)));
  std::ostringstream message;
  if (final_m > kMaxFinalM) {
    message << "aircraft.flight_path_angle_deg = " << aircraft.flight_path_angle_deg
            << ": makes a final of " << final_m << " m from approach_height_m, at most "
            << kMaxFinalM << " m";
  } else if (radius_m > kMaxRadiusM) {
    message << "aircraft.max_bank_deg = " << aircraft.max_bank_deg << ": makes a circle of "
            << radius_m << " m radius at landing_airspeed_mps, at most " << kMaxRadiusM << " m";
  } else {
    return;
  }
  throw std::invalid_argument(message.str());
}

// As people call it, and its unit.
struct Limit {
  const char* name;
  const char* unit;
};

}  // namespace

void Aircraft::Check() const {
  const FieldCheck check("aircraft");
  check.Inside("landing_airspeed_mps", landing_airspeed_mps, 1.0, 100.0);
  check.Inside("flight_path_angle_deg", flight_path_angle_deg, 0.5, 45.0);
  check.Inside("max_bank_deg", max_bank_deg, 1.0, 80.0);
  check.Inside("approach_height_m", approach_height_m, 1.0, 500.0);
  check.Inside("crosswind_uncertainty_deg", crosswind_uncertainty_deg, 0.0, 89.0);
  check.Inside("touchdown_uncertainty_m", touchdown_uncertainty_m, 0.0, 500.0);
  check.Inside("glide_ratio", glide_ratio, 1.0, 100.0);
  check.Inside("glide_airspeed_mps", glide_airspeed_mps.value_or(landing_airspeed_mps), 1.0, 100.0);
  check.Inside("max_slope_deg", max_slope_deg, 0.1, 60.0);
  check.Inside("max_roughness_m", max_roughness_m, 0.01, 20.0);
  check.Inside("safety_margin_m", safety_margin_m, 0.0, 100.0);
  check.Inside("path_half_width_m", path_half_width_m, 0.0, 100.0);
  check.Inside("min_ground_speed_mps", min_ground_speed_mps, 0.0, 50.0);
  check.Inside("climb_gradient_deg", climb_gradient_deg, 0.5, 45.0);
  check.Inside("ground_roll_m", ground_roll_m, 0.0, 2000.0);
  check.Inside("max_failure_probability", max_failure_probability, 1e-6, 1.0);
  check.Inside("min_area_m2", min_area_m2, 1.0, 1e7);
  RequirePath(*this);
}

std::vector<std::string> LimitsLooserThanProfiles(const Aircraft& aircraft) {
  std::vector<Aircraft> known;
  for (const std::string& name : AircraftProfileNames()) known.push_back(*AircraftProfile(name));
  std::vector<std::string> looser;
  const auto compare = [&](const Limit& limit, double Aircraft::*value, bool is_larger_looser) {
    const auto [least, most] = std::minmax_element(
        known.begin(), known.end(), [value](const Aircraft& a, const Aircraft& b) {
          return a.*value < b.*value;
        });
    const double bound = is_larger_looser ? (*most).*value : (*least).*value;
    const bool is_looser = is_larger_looser ? aircraft.*value > bound : aircraft.*value < bound;
    if (!is_looser) return;
    std::ostringstream text;
    text << limit.name << " " << aircraft.*value << limit.unit
         << " (profiles: " << (is_larger_looser ? "at most " : "at least ") << bound << limit.unit
         << ")";
    looser.push_back(text.str());
  };
  compare({"change of the wind direction", " deg"}, &Aircraft::crosswind_uncertainty_deg, false);
  compare({"uncertainty of the touchdown", " m"}, &Aircraft::touchdown_uncertainty_m, false);
  compare({"slope", " deg"}, &Aircraft::max_slope_deg, true);
  compare({"roughness", " m"}, &Aircraft::max_roughness_m, true);
  compare({"clearance above obstacles", " m"}, &Aircraft::safety_margin_m, false);
  compare({"half width of the path", " m"}, &Aircraft::path_half_width_m, false);
  compare({"ground speed on final", " m/s"}, &Aircraft::min_ground_speed_mps, false);
  compare({"ground roll", " m"}, &Aircraft::ground_roll_m, false);
  compare({"probability of a failed landing", ""}, &Aircraft::max_failure_probability, true);
  return looser;
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
