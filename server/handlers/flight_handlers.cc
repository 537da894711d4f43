#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/stored/stored.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/http/http.h"
#include "server/intake/intake.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

const char* StateName(const Service& service, const FlightRow& flight, const FrameCounts& counts) {
  if (flight.has_failed) return "failed";
  if (counts.processed + counts.rejected < counts.received) return "processing";
  for (const JobRow& job : service.storage.jobs.ListUnfinished()) {
    if (job.flight_id == flight.id) return "processing";
  }
  return service.intake.IsReceiving(flight.id) ? "receiving" : "idle";
}

// Origin as in api/openapi.yaml: at the estimated ground altitude unless the client gave an origin.
nlohmann::json OriginJson(const FlightRow& flight, const FlightRequest& request) {
  if (request.origin) return GeoPointJson(*request.origin);
  if (flight.rig_json.empty()) return nullptr;
  GeoPoint origin = ParseStoredFlightRig(flight.rig_json).origin;
  nlohmann::json object = GeoPointJson(origin);
  object["altitude_m"] = nullptr;
  if (flight.ground_altitude_m) object["altitude_m"] = *flight.ground_altitude_m;
  return object;
}

nlohmann::json CameraOf(const FlightRow& flight, const FlightRequest& request) {
  if (request.camera) return CameraJson(*request.camera);
  if (flight.rig_json.empty()) return nullptr;
  return CameraJson(ParseStoredFlightRig(flight.rig_json).rig.camera);
}

nlohmann::json FlightJson(const Service& service, const FlightRow& flight) {
  const FlightRequest request = ParseFlightRequest(flight.request_json);
  const FrameCounts counts = service.storage.frames.Count(flight.id);
  return {{"id", flight.id},
          {"name", flight.name},
          {"state", StateName(service, flight, counts)},
          {"frames",
           {{"received", counts.received},
            {"processed", counts.processed + counts.rejected},
            {"rejected", flight.num_rejected_frames}}},
          {"num_regions", service.storage.flights.CountRegions(flight.id)},
          {"num_sites", service.storage.sites.Count(flight.id)},
          {"stages", nlohmann::json::parse(flight.stages_json)},
          {"warnings", AllWarnings(flight.warnings_json)},
          {"camera", CameraOf(flight, request)},
          {"origin", OriginJson(flight, request)},
          {"aircraft", AircraftJson(request.aircraft)},
          {"altitude_datum", AltitudeDatumOf(flight)},
          {"has_retired_images", flight.has_retired_images},
          {"created_at", Rfc3339(flight.created_at_us)}};
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
  response.set_content(FlightJson(service, flight).dump(), "application/json");
}

void GetFlights(Service& service, const Call&, httplib::Response& response) {
  nlohmann::json flights = nlohmann::json::array();
  for (const FlightRow& flight : service.storage.flights.List()) {
    flights.push_back(FlightJson(service, flight));
  }
  response.set_content(nlohmann::json{{"flights", flights}}.dump(), "application/json");
}

void GetFlight(Service& service, const Call& call, httplib::Response& response) {
  response.set_content(FlightJson(service, ExistingFlight(service, call)).dump(),
                       "application/json");
}

void DeleteFlight(Service& service, const Call& call, httplib::Response& response) {
  const bool forget_sites = call.QueryFlag("forget_sites");
  const FlightRow flight = ExistingFlight(service, call);
  {
    const std::lock_guard lock(service.sites_mutex);
    if (forget_sites) {
      for (const SiteRow& site : service.storage.sites.List(flight.id, std::nullopt)) {
        ForgetSite(service.storage, service.maps, site.id);
      }
    }
    service.storage.flights.Delete(flight.id, forget_sites);
  }
  service.alternates.Forget(flight.id);
  if (forget_sites) service.alternates.WakeAll();
  service.intake.wake_worker();
  response.status = 204;
}

}  // namespace freelsd
