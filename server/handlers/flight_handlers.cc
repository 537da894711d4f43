#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/stored/stored.h"
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

void AnswerFlight(const Service& service,
                  const std::string& flight_id,
                  httplib::Response& response) {
  const std::optional<FlightSummary> summary = service.storage.flights.FindSummary(flight_id);
  if (!summary) throw ApiError("NoSuchFlight", "there is no such flight");
  nlohmann::json flight = FlightJson(service, *summary);
  const std::optional<LiveWind> wind = LiveWindOf(service.storage, flight_id, ArrivalNowUs());
  flight["wind"] = wind ? WindJson(*wind) : nlohmann::json();
  flight["options"] = GivenOptionsJson(ParseStoredFlightRequest(summary->flight.request_json));
  response.set_content(flight.dump(), "application/json");
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

void DeleteFlight(Service& service, const Call& call, httplib::Response& response) {
  const bool forget_sites = call.QueryFlag("forget_sites");
  const std::string id = call.Id("flight");
  // What a flight left behind is forgotten also when the flight itself is gone. With organisations,
  // it may be what another one shares.
  if (!forget_sites || !service.config.organisations.empty()) ExistingFlight(service, call);
  const bool has_left = forget_sites && ForgetFlight(service.storage, service.maps, id);
  if (!has_left) ExistingFlight(service, call);
  service.storage.flights.Delete(id, false);
  // Those that a worker stored meanwhile; without its flight it stores no more.
  if (forget_sites) ForgetFlight(service.storage, service.maps, id);
  service.alternates.Forget(id);
  if (forget_sites) service.alternates.WakeAll();
  service.intake.wake_worker();
  response.status = 204;
}

}  // namespace freelsd
