#include <array>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/import/routes/routes.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/handlers/paging.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

constexpr std::array kNumbers{
    "airspeed_mps", "glide_ratio", "terrain_clearance_m", "arrival_height_m"};
constexpr std::array kTexts{"aircraft", "altitude_datum", "flight"};

// A plan as body leaves no room for the rest of the request, so the query has it.
nlohmann::json ObjectOfPlan(const Call& call, const nlohmann::json& plan) {
  nlohmann::json object{{"plan", plan}};
  for (const char* const name : kNumbers) {
    if (const auto number = call.QueryNumber(name)) object[name] = *number;
  }
  for (const char* const name : kTexts) {
    if (const auto text = call.Query(name)) object[name] = *text;
  }
  const auto add_wind = [&](const char* parameter, const char* key) {
    if (const auto number = call.QueryNumber(parameter)) object["wind"][key] = *number;
  };
  add_wind("wind_east_mps", "east_mps");
  add_wind("wind_north_mps", "north_mps");
  add_wind("wind_sd_mps", "sd_mps");
  return object;
}

struct CompletedRoute {
  RouteRequest request;
  // The flight's wind, if it was taken; else null.
  nlohmann::json wind = nullptr;
};

// Takes what the request does not say from the flight that it names, as emergency recall does.
CompletedRoute Completed(const Service& service, nlohmann::json object) {
  const bool names_flight =
      object.is_object() && object.contains("flight") && object.at("flight").is_string();
  if (!names_flight) return {ParseRouteRequest(object)};
  EmergencyRequest given;
  given.flight_id = object.at("flight").get<std::string>();
  const auto [flight, taken] = CompletedFromFlight(service.storage, given);
  // The altitudes of a plan are above mean sea level.
  if (!object.contains("altitude_datum") && !object.contains("plan")) {
    object["altitude_datum"] = *flight.altitude_datum;
  }
  if (!object.contains("aircraft")) object["aircraft"] = AircraftJson(*flight.aircraft);
  if (object.contains("wind") || object.contains("winds")) return {ParseRouteRequest(object)};
  if (const auto& wind = flight.wind_in_world) {
    object["wind"] = {{"east_mps", wind->x()}, {"north_mps", wind->y()}};
  }
  CompletedRoute completed{ParseRouteRequest(object), taken.value("wind", nlohmann::json())};
  completed.request.wind_sd_mps = flight.wind_sd_mps;
  completed.request.is_wind_old = flight.is_wind_old;
  if (flight.wind_warning) completed.request.warnings.push_back(*flight.wind_warning);
  return completed;
}

CompletedRoute RequestOf(const Service& service, const Call& call) {
  nlohmann::json body = ReadRouteFile(call.body.ReadAll(kLimits.routes.max_bytes));
  if (IsQgcPlan(body)) return Completed(service, ObjectOfPlan(call, body));
  for (const auto& [name, value] : call.request.params) {
    if (name == "f") continue;
    throw ApiError("InvalidQuery",
                   name + ": is part of the body, unless the body is a plan",
                   {{name, "is part of the body, unless the body is a plan"}});
  }
  return Completed(service, std::move(body));
}

}  // namespace

void PostRouteCheck(Service& service, const Call& call, httplib::Response& response) {
  const std::string format = call.Query("f").value_or("json");
  if (format != "json" && format != "geojson") {
    const std::string detail = "f: must be json or geojson";
    throw ApiError("InvalidQuery", detail, {{"f", detail}});
  }
  const auto [request, wind] = RequestOf(service, call);
  const StopIfUnwanted stop_if_unwanted = WantedBy(service, call);
  const LongPlace place(service.long_queues.routes, stop_if_unwanted);
  nlohmann::json answer = CheckRoute({service.storage, service.maps, stop_if_unwanted}, request);
  if (!wind.is_null()) answer["wind"] = wind;
  service.copy.AddTo(answer, NowUs());
  if (format == "geojson") {
    AnswerGeoJson(RouteGeoJson(answer), response);
  } else {
    response.set_content(answer.dump(), "application/json");
  }
}

}  // namespace freelsd
