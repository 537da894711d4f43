#include "server/routes.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/api.h"
#include "server/handlers/handlers.h"
#include "server/http/http.h"

namespace freelsd {
namespace {

using Handler = void (*)(Service&, const Call&, httplib::Response&);

enum class Listeners { kMain, kBoth };

struct Route {
  const char* method;
  const char* path;
  Handler handler;
  // Supported query parameters, separated by spaces.
  const char* parameters = "";
  Listeners listeners = Listeners::kMain;
  const char* more_parameters = "";
};

// The scope that a token needs. Some POST need only read, because they
// change nothing.
Scope ScopeOf(const Route& route) {
  const std::string_view path = route.path;
  if (path == "/healthz") return Scope::kNone;
  const std::string_view method = route.method;
  const bool changes_nothing = method == "GET" || path == "/v1/emergency" || path == "/v1/reach" ||
                               path == "/v1/routes/check";
  if (changes_nothing) return Scope::kRead;
  if (method == "POST" && path.starts_with("/v1/links")) return Scope::kCommand;
  // Whoever may add obstacles could hide every site, and who may tell changes could invent some.
  if (method == "DELETE" || path.starts_with("/v1/obstacles") || path.starts_with("/v1/changes") ||
      path.starts_with("/v1/maps") || path.starts_with("/v1/notices")) {
    return Scope::kAdmin;
  }
  return Scope::kIngest;
}

constexpr char kAircraft[] =
    "aircraft profile landing_airspeed_mps flight_path_angle_deg "
    "max_bank_deg "
    "approach_height_m crosswind_uncertainty_deg touchdown_uncertainty_m glide_ratio "
    "glide_airspeed_mps max_slope_deg max_roughness_m safety_margin_m path_half_width_m "
    "min_ground_speed_mps climb_gradient_deg ground_roll_m max_failure_probability min_area_m2";

constexpr char kEmergency[] =
    "latitude_deg longitude_deg altitude_m altitude_datum wind_east_mps wind_north_mps "
    "wind_sd_mps heading_deg "
    "glide_ratio touchdown_uncertainty_m terrain_clearance_m arrival_height_m aircraft limit "
    "flight "
    "f home_altitude_m "
    "firmware";

constexpr char kReach[] =
    "latitude_deg longitude_deg altitude_m altitude_datum wind_east_mps wind_north_mps "
    "wind_sd_mps heading_deg "
    "glide_ratio touchdown_uncertainty_m terrain_clearance_m arrival_height_m aircraft limit "
    "flight";

constexpr Route kRoutes[] = {
    {"POST", "/v1/flights", PostFlight},
    {"GET", "/v1/flights", GetFlights, "limit cursor"},
    {"GET", "/v1/flights/{flight}", GetFlightAs, "f"},
    {"PATCH", "/v1/flights/{flight}", PatchFlight},
    {"DELETE", "/v1/flights/{flight}", DeleteFlight, "forget_sites"},
    {"GET", "/v1/flights/{flight}/track", GetTrack},
    {"PUT", "/v1/flights/{flight}/frames/{frame}", PutFrame},
    {"POST", "/v1/flights/{flight}/frames", PostFrame},
    {"GET", "/v1/flights/{flight}/frames", GetFrames},
    {"GET", "/v1/flights/{flight}/frames/{frame}/patch.png", GetFramePatch, "x_px y_px side_px"},
    {"POST", "/v1/flights/{flight}/batch", PostBatch, "dry_run extra_poses angles"},
    {"POST", "/v1/flights/{flight}/finish", PostFinish},
    {"POST", "/v1/flights/{flight}/replay", PostReplay},
    {"POST", "/v1/flights/{flight}/telemetry", PostTelemetry},
    {"POST", "/v1/flights/{flight}/stream", PostStream},
    {"GET", "/v1/flights/{flight}/alternates", GetAlternates, "limit"},
    {"GET", "/v1/events", GetEvents, "flight"},
    {"GET", "/v1/jobs", GetJobs, "limit cursor"},
    {"GET", "/v1/jobs/{job}", GetJob},
    {"DELETE", "/v1/jobs/{job}", DeleteJob},
    {"GET", "/v1/flights/{flight}/regions", GetRegions},
    {"GET", "/v1/flights/{flight}/regions/{region}/history", GetRegionHistory},
    {"GET", "/v1/flights/{flight}/sites", GetFlightSitesAs, "f home_altitude_m firmware include"},
    {"GET", "/v1/sites", GetSites, "bbox limit cursor include order"},
    {"GET", "/v1/sites/{site}", GetSiteAs, "f home_altitude_m firmware include"},
    {"DELETE", "/v1/sites/{site}", DeleteSite},
    {"GET",
     "/v1/sites/{site}/approach",
     GetApproach,
     "wind wind_east_mps wind_north_mps",
     Listeners::kMain,
     kAircraft},
    {"GET",
     "/v1/sites/{site}/why",
     GetWhy,
     "latitude_deg longitude_deg wind wind_east_mps wind_north_mps",
     Listeners::kMain,
     kAircraft},
    {"GET",
     "/v1/sites/{site}/wind-rose",
     GetWindRose,
     "directions speeds_mps",
     Listeners::kMain,
     kAircraft},
    {"GET", "/v1/sites/{site}/layers", GetLayers},
    {"GET", "/v1/sites/{site}/layers/{layer}.png", GetLayerPicture},
    {"GET", "/v1/sites/{site}/layers/{layer}.pgw", GetLayerWorldFile},
    {"GET", "/v1/sites/{site}/layers/{layer}.tif", GetLayerGeoTiff},
    {"GET", "/v1/sites/{site}/layers/{layer}/legend.png", GetLayerLegend},
    {"GET", "/v1/flights/{flight}/map", GetFlightMap},
    {"GET", "/v1/flights/{flight}/map/{layer}/{z}/{x}/{y}.png", GetMapTilePng},
    {"GET", "/v1/flights/{flight}/map/{layer}/{z}/{x}/{y}.jpg", GetMapTileJpeg},
    {"GET", "/v1/flights/{flight}/map/{layer}/legend.png", GetMapLegend},
    {"GET", "/v1/flights/{flight}/map/{layer}.tif", GetMapGeoTiff},
    {"GET", "/v1/flights/{flight}/map/{layer}.kmz", GetMapKmz},
    {"GET",
     "/v1/flights/{flight}/why",
     GetFlightWhy,
     "latitude_deg longitude_deg wind wind_east_mps wind_north_mps",
     Listeners::kMain,
     kAircraft},
    {"GET",
     "/v1/flights/{flight}/landing",
     GetFlightLanding,
     "latitude_deg longitude_deg wind wind_east_mps wind_north_mps",
     Listeners::kMain,
     kAircraft},
    {"GET", "/v1/flights/{flight}/next-look", GetNextLook, "legs f home_altitude_m firmware"},
    {"PUT", "/v1/obstacles/{obstacle}", PutObstacle},
    {"GET", "/v1/obstacles/{obstacle}", GetObstacle},
    {"DELETE", "/v1/obstacles/{obstacle}", DeleteObstacle},
    {"POST", "/v1/obstacles", PostObstacles},
    {"GET", "/v1/obstacles", GetObstacles, "bbox"},
    {"GET", "/v1/changes", GetChanges, "since bbox subjects limit wait_s"},
    {"POST", "/v1/changes", PostChanges},
    {"GET", "/v1/maps/{flight}/{number}", GetStoredMap},
    {"PUT", "/v1/maps/{flight}/{number}", PutStoredMap},
    {"GET", "/v1/notices", GetNotices},
    {"POST", "/v1/notices/{notice}/acknowledge", PostAcknowledgement},
    {"GET", "/v1/links", GetLinks},
    {"GET", "/v1/links/{link}", GetLink},
    {"PUT", "/v1/links/{link}", PutLink},
    {"POST", "/v1/links/{link}/mission", PostLinkMission},
    {"POST", "/v1/links/{link}/engine-failure", PostEngineFailure},
    {"POST", "/v1/links/{link}/release", PostRelease},
    {"GET", "/v1/emergency", GetEmergency, kEmergency, Listeners::kBoth},
    {"POST", "/v1/emergency", PostEmergency, kEmergency, Listeners::kBoth},
    {"GET",
     "/v1/emergency/export",
     GetEmergencyExport,
     "bbox f home_altitude_m firmware",
     Listeners::kBoth},
    {"GET", "/v1/reach", GetReach, kReach},
    {"POST", "/v1/reach", PostReach, kReach},
    {"POST",
     "/v1/routes/check",
     PostRouteCheck,
     "f airspeed_mps wind_east_mps wind_north_mps wind_sd_mps aircraft altitude_datum flight "
     "glide_ratio terrain_clearance_m arrival_height_m"},
    {"GET", "/v1/base-map", GetBaseMap},
    {"GET", "/v1/base-map/{z}/{x}/{y}", GetBaseMapTile},
    {"GET", "/healthz", GetHealth, "", Listeners::kBoth},
    {"GET", "/readyz", GetReadiness},
    {"GET", "/metrics", GetMetrics},
    {"GET", "/v1/info", GetInfo},
    {"GET", "/openapi.json", GetOpenApi},
};

// Longer strings from a client are cut in the log.
constexpr size_t kMaxLoggedBytes = 256;

std::vector<std::string_view> Segments(std::string_view path) {
  std::vector<std::string_view> segments;
  while (!path.empty()) {
    path.remove_prefix(1);
    const size_t end = std::min(path.find('/'), path.size());
    segments.push_back(path.substr(0, end));
    path.remove_prefix(end);
  }
  return segments;
}

// The pattern "{layer}.png" matches "slope.png" with layer = slope.
bool MatchSegment(std::string_view pattern,
                  std::string_view segment,
                  std::map<std::string, std::string>& ids) {
  if (!pattern.starts_with("{")) return pattern == segment;
  const size_t close = pattern.find('}');
  const std::string_view suffix = pattern.substr(close + 1);
  if (segment.size() <= suffix.size() || !segment.ends_with(suffix)) return false;
  ids[std::string(pattern.substr(1, close - 1))] =
      std::string(segment.substr(0, segment.size() - suffix.size()));
  return true;
}

// The ids in the path; nothing if the path does not match.
std::optional<std::map<std::string, std::string>> Match(const char* pattern,
                                                        const std::string& path) {
  const std::vector<std::string_view> wanted = Segments(pattern);
  const std::vector<std::string_view> given = Segments(path);
  if (wanted.size() != given.size()) return std::nullopt;
  std::map<std::string, std::string> ids;
  for (size_t i = 0; i < wanted.size(); ++i) {
    if (!MatchSegment(wanted[i], given[i], ids)) return std::nullopt;
  }
  return ids;
}

bool IsMethod(const Route& route, const std::string& method) {
  return method == route.method || (method == "HEAD" && std::string_view(route.method) == "GET");
}

void RefuseUnknownParameters(const Route& route, const httplib::Request& request) {
  std::istringstream words(route.parameters + std::string(" ") + route.more_parameters);
  const std::vector<std::string> known{std::istream_iterator<std::string>(words), {}};
  for (const auto& [name, value] : request.params) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw ApiError("UnknownParameter", "unknown query parameter", {{name, "is unknown"}});
  }
}

// The page loads nothing from elsewhere, except the pictures of a base map that the operator chose.
std::string PagePolicy(const BaseMap& base_map) {
  const std::string& origin = base_map.outside_origin();
  return "default-src 'self'; img-src 'self' data: blob:" + (origin.empty() ? "" : " " + origin) +
         "; style-src 'self' 'unsafe-inline'; frame-ancestors 'none'";
}

bool ServePage(const Service& service,
               const httplib::Request& request,
               httplib::Response& response) {
  const auto file = service.page.find(request.path);
  if (file == service.page.end() || (request.method != "GET" && request.method != "HEAD")) {
    return false;
  }
  response.set_content(file->second.content, file->second.content_type);
  response.set_header("Cache-Control", "no-cache");
  response.set_header("Content-Security-Policy", PagePolicy(service.base_map));
  return true;
}

[[noreturn]] void RefuseMethod(const std::string& allow, httplib::Response& response) {
  response.set_header("Allow", allow);
  throw ApiError("MethodNotAllowed", "this path supports only " + allow);
}

void Dispatch(Service& service,
              Listener listener,
              const httplib::Request& request,
              BodyReader& body,
              httplib::Response& response) {
  std::string allow;
  for (const Route& route : kRoutes) {
    if (listener == Listener::kEmergency && route.listeners != Listeners::kBoth) continue;
    std::optional<std::map<std::string, std::string>> ids = Match(route.path, request.path);
    if (!ids) continue;
    if (IsMethod(route, request.method)) {
      service.tokens.Require(ScopeOf(route), request.get_header_value("Authorization"));
      RefuseUnknownParameters(route, request);
      route.handler(service, {request, body, std::move(*ids)}, response);
      return;
    }
    allow += (allow.empty() ? "" : ", ") + std::string(route.method);
    if (std::string_view(route.method) == "GET") allow += ", HEAD";
  }
  if (!allow.empty()) RefuseMethod(allow, response);
  if (listener == Listener::kEmergency) {
    throw ApiError("NotFound", "this listener serves only /v1/emergency, its export and /healthz");
  }
  if (ServePage(service, request, response)) return;
  if (service.page.contains(request.path)) RefuseMethod("GET, HEAD", response);
  throw ApiError("NotFound", "there is nothing at this path");
}

void RefuseOtherSites(const Service& service, const httplib::Request& request) {
  const bool is_page = request.method == "GET" && service.page.contains(request.path);
  CheckFetchSite({request.get_header_value("Sec-Fetch-Site"),
                  request.get_header_value("Sec-Fetch-Mode"),
                  request.get_header_value("Sec-Fetch-Dest")},
                 is_page);
}

// Turns every failure into an answer. Details that are not meant for clients go to the log only.
void DispatchSafely(Service& service,
                    Listener listener,
                    const httplib::Request& request,
                    BodyReader& body,
                    httplib::Response& response) {
  try {
    RefuseOtherSites(service, request);
    Dispatch(service, listener, request, body, response);
  } catch (const ApiError& error) {
    AnswerProblem(error, response);
  } catch (const StorageError& error) {
    spdlog::error("storage: {}", error.what());
    if (error.fault == StorageFault::kDamaged) service.storage.MarkDamaged(error.what());
    AnswerProblem(error.fault == StorageFault::kFull
                      ? ApiError("StorageFull", "the disk is full")
                      : ApiError("Unavailable", "storage failed; try again later"),
                  response);
  } catch (const std::exception& error) {
    spdlog::error("request failed: {}", error.what());
    AnswerProblem(ApiError("InternalError", "the server failed"), response);
  }
}

// The pattern that the request matches. A metric's label is the pattern, so that clients cannot
// create labels.
std::string RouteOf(const Service& service, const httplib::Request& request) {
  for (const Route& route : kRoutes) {
    if (Match(route.path, request.path)) return route.path;
  }
  return service.page.contains(request.path) ? "page" : "unknown";
}

std::string Loggable(const std::string& text) {
  return nlohmann::json(text.substr(0, kMaxLoggedBytes))
      .dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace

void Serve(Service& service,
           Listener listener,
           const httplib::Request& request,
           BodyReader& body,
           httplib::Response& response) {
  const auto begin = std::chrono::steady_clock::now();
  response.set_header("X-Content-Type-Options", "nosniff");
  DispatchSafely(service, listener, request, body, response);
  if (!response.has_header("Cache-Control")) response.set_header("Cache-Control", "no-store");
  if (response.status == -1) response.status = 200;
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - begin;
  service.metrics.CountRequest(
      request.method, RouteOf(service, request), response.status, elapsed.count() * 1e-3);
  spdlog::info("{} {} {} {:.1f} ms",
               request.method,
               Loggable(request.path),
               response.status,
               elapsed.count());
}

}  // namespace freelsd
