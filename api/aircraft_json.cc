#include <algorithm>
#include <iterator>
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

// Landing is planned on grass. What the network earned on polygons of places left out (model card):
// how often its likeliest kind was right.
struct UnmeasuredSurface {
  const char* name;
  const char* right_of_polygons;
};
constexpr UnmeasuredSurface kUnmeasuredSurfaces[] = {
    {"stubble", "0.12"}, {"soil", "0.12"}, {"sand", "0.00"}, {"snow", "no place with snow"}};

// Takes `landing_surfaces` where it asks for grass alone.
void CheckLandingSurfaces(ObjectReader& reader) {
  const nlohmann::json* const surfaces = reader.Find("landing_surfaces");
  if (surfaces == nullptr) return;
  const std::string pointer = reader.PointerTo("landing_surfaces");
  if (!surfaces->is_array() || surfaces->empty()) {
    throw InvalidValue(pointer, "landing_surfaces: must be a list of surfaces, as [\"grass\"]");
  }
  for (size_t i = 0; i < surfaces->size(); ++i) {
    const std::string place = pointer + "/" + std::to_string(i);
    const std::string name = ReadString((*surfaces)[i], place);
    if (name == "grass") continue;
    const auto* const unmeasured =
        std::find_if(std::begin(kUnmeasuredSurfaces),
                     std::end(kUnmeasuredSurfaces),
                     [&name](const UnmeasuredSurface& surface) { return name == surface.name; });
    if (unmeasured == std::end(kUnmeasuredSurfaces)) {
      throw InvalidValue(place, "landing_surfaces: must be of grass, stubble, soil, sand, snow");
    }
    const std::string detail = "landing_surfaces: " + name +
                               " is not told well enough to land on: right in " +
                               unmeasured->right_of_polygons +
                               " of the labelled ground of places left out, 0.97 is needed";
    throw ApiError("SurfaceNotMeasured", detail, {{place, detail}});
  }
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
  CheckLandingSurfaces(reader);
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
