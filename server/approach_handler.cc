#include <cmath>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/export/export.h"
#include "server/handlers.h"
#include "server/site_lookup.h"

namespace freelsd {
namespace {

constexpr char kGeoJson[] = "application/geo+json";

// The site's aircraft with the query's fields in place of its own, or of the named profile's.
Aircraft AircraftOf(const Call& call, const Aircraft& site_aircraft) {
  nlohmann::json object = AircraftJson(site_aircraft);
  for (const char* const name : {"aircraft", "profile"}) {
    if (const auto profile = call.Query(name)) object = {{"profile", *profile}};
  }
  for (const auto& [name, value] : call.request.params) {
    if (name == "aircraft" || name == "profile" || name.starts_with("wind_")) continue;
    object[name] = *call.QueryNumber(name);
  }
  try {
    return ParseAircraft(object, "");
  } catch (const ApiError& error) {
    std::vector<FieldError> errors = error.errors();
    for (FieldError& each : errors) {
      if (each.pointer.starts_with("/")) each.pointer.erase(0, 1);
    }
    throw ApiError(error.code(), error.what(), errors);
  }
}

// Beyond any wind, as in a frame's meta.
constexpr double kMaxWindMps = 100.0;

std::optional<double> WindComponent(const Call& call, const std::string& name) {
  const std::optional<double> speed_mps = call.QueryNumber(name);
  if (!speed_mps || std::abs(*speed_mps) <= kMaxWindMps) return speed_mps;
  throw ApiError("InvalidValue", name + ": must be in [-100, 100]", {{name, "out of range"}});
}

// The query's wind, else the one the site was planned with.
std::optional<Eigen::Vector2d> WindOf(const Call& call, const PlanRequest& request) {
  const auto east_mps = WindComponent(call, "wind_east_mps");
  const auto north_mps = WindComponent(call, "wind_north_mps");
  if (east_mps.has_value() != north_mps.has_value()) {
    const std::string missing = east_mps ? "wind_north_mps" : "wind_east_mps";
    throw ApiError("InvalidQuery", missing + ": is missing", {{missing, "is missing"}});
  }
  if (!east_mps) return request.wind_in_world;
  return Eigen::Vector2d(*east_mps, *north_mps);
}

nlohmann::json PlanAnew(const Service& service, const SiteRow& site, const Call& call) {
  const auto kept = service.maps.Get(service.storage, site.id, site.updated_at_us);
  if (!kept) throw ApiError("NoApproach", "the site has no map to plan on");
  const Replan& replan = kept->replan;
  const Aircraft aircraft = AircraftOf(call, replan.flight.aircraft);
  const auto kept_plan = service.maps.PlanFor(kept, aircraft, WindOf(call, replan.request));
  const Plan& plan = *kept_plan;
  const FlightContext context{
      site.flight_id, replan.flight.altitude_datum, LocalFrame(replan.origin)};
  if (!plan.approach)
    throw ApiError("NoApproach", "no approach for this wind: " + plan.reject_detail);
  nlohmann::json answer = ApproachJson(plan, context);
  answer["plan"] = PlanProperties(plan, context);
  answer["plan"]["aircraft"] = AircraftJson(aircraft);
  answer["plan"]["warnings"] = LimitsWarnings(aircraft);
  return answer;
}

}  // namespace

void GetApproach(Service& service, const Call& call, httplib::Response& response) {
  const SiteRow site = ExistingSite(service, call);
  if (call.request.params.empty()) {
    if (site.approach_json.empty()) throw ApiError("NoApproach", "the site has no approach");
    response.set_content(site.approach_json, kGeoJson);
    return;
  }
  response.set_content(PlanAnew(service, site, call).dump(), kGeoJson);
}

}  // namespace freelsd
