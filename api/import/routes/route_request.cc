#include <cmath>

#include "api/import/routes/qgc_plan.h"
#include "api/import/routes/routes.h"
#include "api/json_reader.h"

namespace freelsd {
namespace {

constexpr NumberRange kWindRange{-100.0, 100.0};
constexpr NumberRange kWindSdRange{0.0, 20.0};
constexpr NumberRange kWeightRange{0.0, 1e6};
constexpr NumberRange kAirspeedRange{1.0, 200.0};
constexpr NumberRange kSafetyHeightRange{0.0, 1000.0};
constexpr NumberRange kGlideRatioRange{1.0, 100.0};

Eigen::Vector2d ReadComponents(ObjectReader& reader) {
  const double east_mps = reader.RequiredNumber("east_mps", kWindRange);
  return {east_mps, reader.RequiredNumber("north_mps", kWindRange)};
}

// The mean, and two points on each axis, which have together the mean and the covariance of a
// normal distribution (Julier and Uhlmann 1997, with n + kappa = 3).
std::vector<WeightedWind> Spread(const Eigen::Vector2d& mean, double sd_mps) {
  if (sd_mps == 0.0) return {{mean, 1.0}};
  const double step_mps = std::sqrt(3.0) * sd_mps;
  std::vector<WeightedWind> winds{{mean, 1.0 / 3.0}};
  for (const Eigen::Vector2d& axis : {Eigen::Vector2d(1.0, 0.0), Eigen::Vector2d(0.0, 1.0)}) {
    winds.push_back({mean + step_mps * axis, 1.0 / 6.0});
    winds.push_back({mean - step_mps * axis, 1.0 / 6.0});
  }
  return winds;
}

std::vector<WeightedWind> ReadOneWind(const nlohmann::json& value) {
  ObjectReader reader(value, "/wind");
  const Eigen::Vector2d mean = ReadComponents(reader);
  const double sd_mps = reader.Number("sd_mps", kWindSdRange).value_or(0.0);
  reader.RefuseUnknownKeys();
  return Spread(mean, sd_mps);
}

// Winds of weight 0 cannot blow.
std::vector<WeightedWind> ReadWinds(const nlohmann::json& value) {
  if (!value.is_array() || value.empty() || value.size() > kLimits.routes.max_num_winds) {
    throw InvalidValue(
        "/winds",
        "must be an array of 1 to " + std::to_string(kLimits.routes.max_num_winds) + " winds");
  }
  std::vector<WeightedWind> winds;
  double sum = 0.0;
  for (size_t i = 0; i < value.size(); ++i) {
    ObjectReader reader(value[i], "/winds/" + std::to_string(i));
    const Eigen::Vector2d wind = ReadComponents(reader);
    const double weight = reader.Number("weight", kWeightRange).value_or(1.0);
    reader.RefuseUnknownKeys();
    if (weight > 0.0) winds.push_back({wind, weight});
    sum += weight;
  }
  if (winds.empty()) throw InvalidValue("/winds", "all weights are 0");
  for (WeightedWind& wind : winds) wind.weight /= sum;
  return winds;
}

std::vector<GeoPoint> ReadRoute(const nlohmann::json& value) {
  if (!value.is_array() || value.size() < 2) {
    throw InvalidValue("/route", "must be an array of at least two points");
  }
  std::vector<GeoPoint> route;
  for (size_t i = 0; i < value.size(); ++i) {
    route.push_back(ReadGeoPoint(value[i], "/route/" + std::to_string(i)));
  }
  return route;
}

// Sets the points, and what a plan says besides.
void ReadPoints(ObjectReader& reader, RouteRequest& request, std::optional<double>& airspeed_mps) {
  const nlohmann::json* const route = reader.Find("route");
  const nlohmann::json* const plan = reader.Find("plan");
  if ((route == nullptr) == (plan == nullptr)) {
    throw InvalidValue("/route", route == nullptr ? "is missing" : "is given besides a plan");
  }
  if (route != nullptr) {
    request.route = ReadRoute(*route);
  } else {
    PlannedRoute planned = ReadQgcPlan(*plan, "/plan");
    request.route = std::move(planned.points);
    request.warnings = std::move(planned.warnings);
    request.altitude_datum = "amsl";
    if (!airspeed_mps) airspeed_mps = planned.cruise_airspeed_mps;
  }
  if (request.route.size() <= kLimits.routes.max_num_points) return;
  throw InvalidValue(
      route != nullptr ? "/route" : "/plan",
      "must have at most " + std::to_string(kLimits.routes.max_num_points) + " points");
}

std::string ReadRouteDatum(const nlohmann::json& value) {
  std::string datum = ReadString(value, "/altitude_datum");
  if (datum == "amsl" || datum == "ellipsoid" || datum == "unknown") return datum;
  throw InvalidValue("/altitude_datum", "must be amsl, ellipsoid or unknown");
}

// The name of a profile, or an object whose fields override a profile.
Aircraft ReadAircraft(const nlohmann::json& value) {
  if (value.is_string()) return ParseAircraft({{"profile", value}}, "/aircraft");
  return ParseAircraft(value, "/aircraft");
}

void ReadWindsOf(ObjectReader& reader, RouteRequest& request) {
  const nlohmann::json* const wind = reader.Find("wind");
  const nlohmann::json* const winds = reader.Find("winds");
  if (wind != nullptr && winds != nullptr) {
    throw InvalidValue("/winds", "is given besides a wind");
  }
  if (wind != nullptr) request.winds = ReadOneWind(*wind);
  if (winds != nullptr) request.winds = ReadWinds(*winds);
}

}  // namespace

RouteRequest ParseRouteRequest(const nlohmann::json& object) {
  ObjectReader reader(object, "");
  RouteRequest request;
  std::optional<double> airspeed_mps = reader.Number("airspeed_mps", kAirspeedRange);
  ReadPoints(reader, request, airspeed_mps);
  ReadWindsOf(reader, request);
  if (const auto* const datum = reader.Find("altitude_datum")) {
    request.altitude_datum = ReadRouteDatum(*datum);
  }
  if (const auto* const flight = reader.Find("flight")) {
    request.flight_id = ReadString(*flight, "/flight");
  }
  if (const auto* const aircraft = reader.Find("aircraft")) {
    request.aircraft = ReadAircraft(*aircraft);
  }
  request.glide_ratio = reader.Number("glide_ratio", kGlideRatioRange);
  request.terrain_clearance_m = reader.Number("terrain_clearance_m", kSafetyHeightRange);
  request.arrival_height_m = reader.Number("arrival_height_m", kSafetyHeightRange);
  if (const auto* const fixes = reader.Find("with_fixes")) {
    request.has_fixes = ReadBoolean(*fixes, "/with_fixes");
  }
  reader.RefuseUnknownKeys();
  if (!airspeed_mps) {
    throw InvalidValue("/airspeed_mps",
                       reader.Find("plan") == nullptr
                           ? "is missing"
                           : "airspeed_mps is missing: the plan has no cruise speed, so the query "
                             "must have it");
  }
  request.airspeed_mps = *airspeed_mps;
  return request;
}

bool IsQgcPlan(const nlohmann::json& object) {
  return object.is_object() && object.value("fileType", nlohmann::json()) == "Plan" &&
         object.contains("mission");
}

}  // namespace freelsd
