#include <cmath>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/stored/stored.h"
#include "engine/glide/glide.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/handlers/paging.h"
#include "server/http/http.h"
#include "server/intake/intake.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

const char* StateName(const Service& service, const FlightSummary& summary) {
  if (summary.flight.has_failed) return "failed";
  if (summary.num_queued_frames > 0 || summary.has_unfinished_job) return "processing";
  return service.intake.IsReceiving(summary.flight.id) ? "receiving" : "idle";
}

// Origin as in api/openapi.yaml: at the estimated ground altitude unless the client gave an origin.
nlohmann::json OriginJson(const FlightRow& flight, const StoredFlight& request) {
  if (request.origin) return GeoPointJson(*request.origin);
  if (flight.rig_json.empty()) return nullptr;
  GeoPoint origin = ParseStoredFlightRig(flight.rig_json).origin;
  nlohmann::json object = GeoPointJson(origin);
  object["altitude_m"] = nullptr;
  if (flight.ground_altitude_m) object["altitude_m"] = *flight.ground_altitude_m;
  return object;
}

nlohmann::json CameraOf(const FlightRow& flight, const StoredFlight& request) {
  if (request.camera) return CameraJson(*request.camera);
  if (flight.rig_json.empty()) return nullptr;
  return CameraJson(ParseStoredFlightRig(flight.rig_json).rig.camera);
}

nlohmann::json FlightJson(const Service& service, const FlightSummary& summary) {
  const FlightRow& flight = summary.flight;
  const StoredFlight request = ParseStoredFlight(flight.request_json);
  return {{"id", flight.id},
          {"name", flight.name},
          {"state", StateName(service, summary)},
          {"frames",
           {{"received", summary.num_frames},
            {"processed", summary.num_frames - summary.num_queued_frames},
            {"rejected", flight.num_rejected_frames}}},
          {"num_regions", summary.num_regions},
          {"num_sites", summary.num_sites},
          {"stages", nlohmann::json::parse(flight.stages_json)},
          {"warnings", AllWarnings(flight.warnings_json)},
          {"camera", CameraOf(flight, request)},
          {"origin", OriginJson(flight, request)},
          {"aircraft", AircraftJson(request.aircraft)},
          {"altitude_datum", AltitudeDatumOf(flight)},
          {"memory", NameOf(request.memory)},
          {"memory_reason", request.memory.reason},
          {"has_retired_images", flight.has_retired_images},
          {"created_at", Rfc3339(flight.created_at_us)}};
}

std::string DatumCost(const GeoPoint& place) {
  const DatumDifference difference =
      DatumDifferenceOf({"unknown", place.latitude_deg, place.longitude_deg, ""},
                        {"amsl", place.latitude_deg, place.longitude_deg, ""});
  return "the datum of the altitudes is unknown: every recall of these sites takes " +
         std::to_string(std::lround(difference.subtracted_m)) +
         " m off the height of its aircraft; to avoid this, give altitude_datum (amsl or "
         "ellipsoid)";
}

// Straight ahead for a kilometre, in the worst of the winds that recall assumes.
std::string WindCost(const Aircraft& aircraft) {
  const Aircraft unpowered = Unpowered(aircraft, std::nullopt);
  const Eigen::Vector3d end(0.0, 1000.0, 0.0);
  const auto arrival_m = [&](const std::optional<Eigen::Vector2d>& wind) {
    const auto glide = GlideTo({Eigen::Vector3d::Zero(), 0.0, wind}, end, 0.0, unpowered, {});
    return glide ? std::optional(glide->arrival_height_m) : std::nullopt;
  };
  const auto calm_m = arrival_m(Eigen::Vector2d::Zero()), worst_m = arrival_m(std::nullopt);
  const std::string cost = calm_m && worst_m
                               ? "takes " + std::to_string(std::lround(*calm_m - *worst_m)) +
                                     " m more off the height for each kilometre of way"
                               : "reaches no site";
  return "the wind is unknown: no site is better than unverified, and a recall without a wind " +
         cost + "; to avoid this, give wind_east_mps and wind_north_mps with the poses";
}

// What recall takes off because the flight does not say it.
std::vector<std::string> CostsOf(const FlightRow& flight, const Aircraft& aircraft, bool has_wind) {
  std::vector<std::string> costs;
  if (flight.rig_json.empty()) return costs;
  if (AltitudeDatumOf(flight) == "unknown") {
    costs.push_back(DatumCost(ParseStoredFlightRig(flight.rig_json).origin));
  }
  if (!has_wind) costs.push_back(WindCost(aircraft));
  return costs;
}

void AnswerFlight(const Service& service,
                  const std::string& flight_id,
                  httplib::Response& response) {
  const std::optional<FlightSummary> summary = service.storage.flights.FindSummary(flight_id);
  if (!summary) throw ApiError("NoSuchFlight", "there is no such flight");
  nlohmann::json flight = FlightJson(service, *summary);
  const std::optional<LiveWind> wind = LiveWindOf(service.storage, flight_id, ArrivalNowUs());
  flight["wind"] = wind ? WindJson(*wind) : nlohmann::json();
  const Aircraft aircraft = ParseStoredFlight(summary->flight.request_json).aircraft;
  for (const std::string& cost : CostsOf(summary->flight, aircraft, wind.has_value())) {
    flight["warnings"].push_back(cost);
  }
  flight["options"] = GivenOptionsJson(ParseStoredFlightRequest(summary->flight.request_json));
  response.set_content(flight.dump(), "application/json");
}

// Of a request that changes nothing else.
std::string NameIn(const std::string& body) {
  const FlightRequest request = ParseFlightRequest(body);
  const nlohmann::json object = nlohmann::json::parse(body);
  for (const auto& [key, value] : object.items()) {
    if (key == "name") continue;
    throw ApiError(
        "InvalidValue", key + ": only the name can be changed", {{"/" + key, "cannot be changed"}});
  }
  return request.name;
}

}  // namespace

void PostFlight(Service& service, const Call& call, httplib::Response& response) {
  const FlightRequest request = ParseFlightRequest(call.body.ReadAll(kLimits.json.max_bytes));
  FlightRow flight;
  flight.id = NewId("f");
  flight.name = request.name;
  flight.request_json = request.canonical_json;
  flight.created_at_us = NowUs();
  service.storage.flights.Insert(flight);
  response.status = 201;
  response.set_header("Location", "/v1/flights/" + flight.id);
  AnswerFlight(service, flight.id, response);
}

void GetFlights(Service& service, const Call& call, httplib::Response& response) {
  const FlightPage page =
      service.storage.flights.ListPage(ParseLimit(call), ParseNumberCursor(call));
  std::string flights;
  for (const FlightSummary& summary : page.flights) {
    flights += (flights.empty() ? "" : ",") + FlightJson(service, summary).dump();
  }
  AnswerPage("flights",
             flights,
             page.has_more ? std::optional(page.flights.back().number) : std::nullopt,
             response);
}

void GetFlight(Service& service, const Call& call, httplib::Response& response) {
  AnswerFlight(service, call.Id("flight"), response);
}

void PatchFlight(Service& service, const Call& call, httplib::Response& response) {
  const std::string name = NameIn(call.body.ReadAll(kLimits.json.max_bytes));
  const bool is_there = service.storage.flights.Change(
      call.Id("flight"), [&name](FlightRow& flight) { flight.name = name; });
  if (!is_there) throw ApiError("NoSuchFlight", "there is no such flight");
  AnswerFlight(service, call.Id("flight"), response);
}

void DeleteFlight(Service& service, const Call& call, httplib::Response& response) {
  const bool forget_sites = call.QueryFlag("forget_sites");
  const std::string id = call.Id("flight");
  // What a flight left behind is forgotten also when the flight itself is gone.
  if (!forget_sites) ExistingFlight(service, call);
  const bool was_there = forget_sites ? ForgetFlight(service.storage, service.maps, id)
                                      : service.storage.flights.Delete(id);
  if (!was_there) throw ApiError("NoSuchFlight", "there is no such flight");
  service.alternates.Forget(id);
  if (forget_sites) service.alternates.WakeAll();
  service.intake.wake_worker();
  response.status = 204;
}

}  // namespace freelsd
