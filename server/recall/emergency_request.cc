#include "server/recall/emergency_request.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {
namespace {

constexpr double kMaxAltitudeM = 20000.0;
constexpr double kMinAltitudeM = -1000.0;
constexpr double kMaxWindMps = 100.0;
constexpr double kMaxWindSdMps = 20.0;
constexpr double kMaxSafetyHeightM = 1000.0;
constexpr double kMaxTouchdownUncertaintyM = 500.0;

[[noreturn]] void Refuse(const std::string& key, const std::string& detail) {
  throw ApiError("InvalidValue", key + ": " + detail, {{"/" + key, detail}});
}

// JSON null counts as absent.
std::optional<double> TakeNumber(nlohmann::json& object,
                                 const std::string& key,
                                 double min,
                                 double max) {
  const auto found = object.find(key);
  if (found == object.end()) return std::nullopt;
  const nlohmann::json value = *found;
  object.erase(found);
  if (value.is_null()) return std::nullopt;
  if (!value.is_number() || !std::isfinite(value.get<double>())) Refuse(key, "must be a number");
  const double number = value.get<double>();
  if (number < min || number > max) {
    Refuse(key,
           "must be in [" + nlohmann::json(min).dump() + ", " + nlohmann::json(max).dump() + "]");
  }
  return number;
}

double TakeNeeded(nlohmann::json& object, const std::string& key, double min, double max) {
  const std::optional<double> number = TakeNumber(object, key, min, max);
  if (!number) Refuse(key, "is missing");
  return *number;
}

std::optional<Eigen::Vector2d> TakeWind(nlohmann::json& object) {
  const auto east = TakeNumber(object, "wind_east_mps", -kMaxWindMps, kMaxWindMps);
  const auto north = TakeNumber(object, "wind_north_mps", -kMaxWindMps, kMaxWindMps);
  if (east.has_value() != north.has_value()) {
    Refuse(east ? "wind_north_mps" : "wind_east_mps", "is missing");
  }
  if (!east) return std::nullopt;
  return Eigen::Vector2d(*east, *north);
}

// JSON null counts as absent.
std::optional<std::string> TakeText(nlohmann::json& object, const std::string& key) {
  const auto found = object.find(key);
  if (found == object.end()) return std::nullopt;
  const nlohmann::json value = *found;
  object.erase(found);
  if (value.is_null()) return std::nullopt;
  if (!value.is_string()) Refuse(key, "must be a text");
  return value.get<std::string>();
}

std::optional<std::string> TakeDatum(nlohmann::json& object) {
  std::optional<std::string> datum = TakeText(object, "altitude_datum");
  if (datum && *datum != "amsl" && *datum != "ellipsoid" && *datum != "unknown") {
    Refuse("altitude_datum", "must be amsl, ellipsoid or unknown");
  }
  return datum;
}

// The name of a profile, or an object whose fields override a profile.
std::optional<Aircraft> TakeAircraft(nlohmann::json& object) {
  const auto found = object.find("aircraft");
  if (found == object.end()) return std::nullopt;
  const nlohmann::json value = *found;
  object.erase(found);
  if (value.is_null()) return std::nullopt;
  if (value.is_string()) return ParseAircraft({{"profile", value}}, "/aircraft");
  return ParseAircraft(value, "/aircraft");
}

}  // namespace

AltitudeReference ReferenceOf(const EmergencyRequest& request) {
  return {request.altitude_datum ? std::string_view(*request.altitude_datum) : "unknown",
          request.place.latitude_deg,
          request.place.longitude_deg,
          request.flight_id ? std::string_view(*request.flight_id) : std::string_view()};
}

EmergencyRequest InWind(EmergencyRequest request, const WindOfNow& wind) {
  request.wind_in_world = wind.wind_in_world;
  request.wind_sd_mps = wind.sd_mps;
  request.is_wind_old = wind.is_old;
  request.wind_warning = wind.warning;
  return request;
}

EmergencyRequest ParseEmergencyRequest(const nlohmann::json& given) {
  if (!given.is_object()) throw ApiError("InvalidValue", "must be an object", {{"", "object"}});
  nlohmann::json object = given;
  EmergencyRequest request;
  request.place.latitude_deg = TakeNeeded(object, "latitude_deg", -90.0, 90.0);
  request.place.longitude_deg = TakeNeeded(object, "longitude_deg", -180.0, 180.0);
  request.place.altitude_m = TakeNeeded(object, "altitude_m", kMinAltitudeM, kMaxAltitudeM);
  request.wind_in_world = TakeWind(object);
  request.wind_sd_mps = TakeNumber(object, "wind_sd_mps", 0.0, kMaxWindSdMps).value_or(0.0);
  if (request.wind_sd_mps > 0.0 && !request.wind_in_world) {
    Refuse("wind_sd_mps", "needs a wind, whose deviation it is");
  }
  request.heading_deg = TakeNumber(object, "heading_deg", -36000.0, 36000.0);
  request.glide_ratio = TakeNumber(object, "glide_ratio", 1.0, 100.0);
  request.touchdown_uncertainty_m =
      TakeNumber(object, "touchdown_uncertainty_m", 0.0, kMaxTouchdownUncertaintyM).value_or(0.0);
  request.terrain_clearance_m = TakeNumber(object, "terrain_clearance_m", 0.0, kMaxSafetyHeightM)
                                    .value_or(request.terrain_clearance_m);
  request.arrival_height_m = TakeNumber(object, "arrival_height_m", 0.0, kMaxSafetyHeightM)
                                 .value_or(request.arrival_height_m);
  request.altitude_datum = TakeDatum(object);
  request.flight_id = TakeText(object, "flight");
  request.aircraft = TakeAircraft(object);
  const double limit =
      TakeNumber(object, "limit", 1.0, kLimits.answer.max_num_emergency_sites).value_or(5.0);
  if (limit != std::floor(limit)) Refuse("limit", "must be a whole number");
  request.limit = static_cast<size_t>(limit);
  if (!object.empty()) {
    throw ApiError("UnknownKey", "unknown key", {{"/" + object.begin().key(), "is unknown"}});
  }
  return request;
}

}  // namespace freelsd
