#include <stdexcept>

#include "api/json_reader.h"

namespace freelsd {
namespace {

// visit(name, field) for every number of an aircraft that has a default.
template <class AircraftType, class Visitor>
void VisitNumbers(AircraftType& aircraft, Visitor&& visit) {
  visit("landing_airspeed_mps", aircraft.landing_airspeed_mps);
  visit("flight_path_angle_deg", aircraft.flight_path_angle_deg);
  visit("max_bank_deg", aircraft.max_bank_deg);
  visit("approach_height_m", aircraft.approach_height_m);
  visit("crosswind_uncertainty_deg", aircraft.crosswind_uncertainty_deg);
  visit("touchdown_uncertainty_m", aircraft.touchdown_uncertainty_m);
  visit("glide_ratio", aircraft.glide_ratio);
  visit("max_slope_deg", aircraft.max_slope_deg);
  visit("max_roughness_m", aircraft.max_roughness_m);
  visit("safety_margin_m", aircraft.safety_margin_m);
  visit("path_half_width_m", aircraft.path_half_width_m);
  visit("min_ground_speed_mps", aircraft.min_ground_speed_mps);
  visit("climb_gradient_deg", aircraft.climb_gradient_deg);
  visit("max_failure_probability", aircraft.max_failure_probability);
  visit("ground_roll_m", aircraft.ground_roll_m);
  visit("min_area_m2", aircraft.min_area_m2);
}

Aircraft BaseProfile(ObjectReader& reader) {
  const nlohmann::json* const profile = reader.Find("profile");
  if (profile == nullptr) return Aircraft{};
  const std::string pointer = reader.PointerTo("profile");
  const std::optional<Aircraft> aircraft = AircraftProfile(ReadString(*profile, pointer));
  if (aircraft) return *aircraft;
  std::string known;
  for (const std::string& name : AircraftProfileNames()) {
    known += (known.empty() ? "" : ", ") + name;
  }
  throw InvalidValue(pointer, "profile: must be one of " + known);
}

}  // namespace

Aircraft ParseAircraft(const nlohmann::json& object, const std::string& pointer) {
  ObjectReader reader(object, pointer);
  Aircraft aircraft = BaseProfile(reader);
  VisitNumbers(aircraft, [&reader](const char* name, double& field) {
    field = reader.Number(name).value_or(field);
  });
  if (const std::optional<double> airspeed = reader.Number("glide_airspeed_mps")) {
    aircraft.glide_airspeed_mps = airspeed;
  }
  reader.RefuseUnknownKeys();
  try {
    aircraft.Check();
  } catch (const std::invalid_argument& error) {
    throw FromCheck(error, pointer, "aircraft.");
  }
  return aircraft;
}

nlohmann::json AircraftJson(const Aircraft& aircraft) {
  nlohmann::json object{{"profile", aircraft.profile}};
  VisitNumbers(aircraft,
               [&object](const char* name, const double& field) { object[name] = field; });
  if (aircraft.glide_airspeed_mps) object["glide_airspeed_mps"] = *aircraft.glide_airspeed_mps;
  return object;
}

}  // namespace freelsd
