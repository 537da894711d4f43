#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/export/layers/layers.h"
#include "api/stored/stored.h"
#include "server/handlers/evidence/evidence.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/handlers/paging.h"
#include "server/handlers/site_rose.h"
#include "server/recall/other_maps/other_maps.h"

namespace freelsd {
namespace {

// False for parameters of the wind and of a place; all other parameters here belong to the
// aircraft.
bool IsOfAircraft(const std::string& parameter) {
  constexpr std::string_view kOthers[] = {
      "directions", "speeds_mps", "latitude_deg", "longitude_deg", "aircraft", "profile"};
  return !parameter.starts_with("wind") &&
         std::find(std::begin(kOthers), std::end(kOthers), parameter) == std::end(kOthers);
}

// The query's fields override the named profile, or the site's aircraft if no profile is named.
Aircraft AircraftOf(const Call& call, const Aircraft& site_aircraft) {
  nlohmann::json object = AircraftJson(site_aircraft);
  for (const char* const name : {"aircraft", "profile"}) {
    if (const auto profile = call.Query(name)) object = {{"profile", *profile}};
  }
  for (const auto& [name, value] : call.request.params) {
    if (IsOfAircraft(name)) object[name] = *call.QueryNumber(name);
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

// Larger than any real wind; the same limit as for a frame's meta.
constexpr double kMaxWindMps = 100.0;

std::optional<double> WindComponent(const Call& call, const std::string& name) {
  const std::optional<double> speed_mps = call.QueryNumber(name);
  if (!speed_mps || std::abs(*speed_mps) <= kMaxWindMps) return speed_mps;
  throw ApiError("InvalidValue", name + ": must be in [-100, 100]", {{name, "out of range"}});
}

// The query's wind, which may be "unknown", else the wind with which the site was planned.
std::optional<Eigen::Vector2d> WindOf(const Call& call, const PlanRequest& request) {
  if (const auto wind = call.Query("wind")) {
    if (*wind == "unknown" && !call.Query("wind_east_mps") && !call.Query("wind_north_mps")) {
      return std::nullopt;
    }
    const std::string detail = "wind: must be unknown, without wind_east_mps and wind_north_mps";
    throw ApiError("InvalidQuery", detail, {{"wind", detail}});
  }
  const auto east_mps = WindComponent(call, "wind_east_mps");
  const auto north_mps = WindComponent(call, "wind_north_mps");
  if (east_mps.has_value() != north_mps.has_value()) {
    const std::string missing = east_mps ? "wind_north_mps" : "wind_east_mps";
    throw ApiError("InvalidQuery", missing + ": is missing", {{missing, "is missing"}});
  }
  if (!east_mps) return request.wind_in_world;
  return Eigen::Vector2d(*east_mps, *north_mps);
}

std::shared_ptr<const KeptSite> SiteWithMap(const Service& service, const SiteRow& site) {
  auto kept = service.maps.Get(service.storage, site.id, site.updated_at_us);
  if (!kept) throw ApiError("NoApproach", "the site has no map to plan on");
  return kept;
}

FlightContext ContextOf(const KeptSite& kept) {
  const Replan& replan = kept.replan;
  const std::string datum = replan.flight.altitude_datum.value_or("unknown");
  return {kept.row.flight_id, datum, LocalFrame(replan.origin)};
}

nlohmann::json PlanJson(const Service& service,
                        const Plan& plan,
                        const Aircraft& aircraft,
                        const FlightContext& context) {
  nlohmann::json answer = ApproachJson(plan, context);
  answer["wires_known"] = AreWiresKnown(
      {service.storage, service.maps}, {context.local_frame.GeoFromWorld(plan.touchdown_in_world)});
  answer["plan"] = PlanProperties(plan, context);
  answer["plan"]["aircraft"] = AircraftJson(aircraft);
  answer["plan"]["warnings"] = LimitsWarnings(aircraft);
  return answer;
}

nlohmann::json PlanAnew(const Service& service, const SiteRow& site, const Call& call) {
  const auto stored = SiteWithMap(service, site);
  const Replan& replan = stored->replan;
  const Aircraft aircraft = AircraftOf(call, replan.flight.aircraft);
  const auto wind = WindOf(call, replan.request);
  const auto kept = service.maps.Covering(service.storage, stored, aircraft, wind);
  const auto plan = service.maps.PlanFor(service.storage, kept, aircraft, wind);
  if (!plan->approach) {
    throw ApiError("NoApproach", "no approach for this wind: " + plan->reject_detail);
  }
  return PlanJson(service, *plan, aircraft, ContextOf(*kept));
}

[[noreturn]] void Refuse(const std::string& parameter, const std::string& detail) {
  throw ApiError("InvalidValue", parameter + ": " + detail, {{parameter, detail}});
}

double NeededDegrees(const Call& call, const std::string& name, double most) {
  const std::optional<double> degrees = call.QueryNumber(name);
  if (!degrees) throw ApiError("InvalidQuery", name + ": is missing", {{name, "is missing"}});
  if (std::abs(*degrees) > most) {
    const std::string bound = std::to_string(std::lround(most));
    Refuse(name, "must be in [-" + bound + ", " + bound + "]");
  }
  return *degrees;
}

GeoPoint PlaceOf(const Call& call) {
  return {
      NeededDegrees(call, "latitude_deg", 90.0), NeededDegrees(call, "longitude_deg", 180.0), 0.0};
}

// A place on a flight's map, with the aircraft and the wind of the query.
struct PlaceOnMap {
  std::shared_ptr<const FlightMap> map;
  std::shared_ptr<const KeptSite> site;
  Aircraft aircraft;
  std::optional<Eigen::Vector2d> wind_in_world;
};

PlaceOnMap PlaceOnFlightMap(const Service& service, const Call& call) {
  const GeoPoint place = PlaceOf(call);
  const StoredSites stored{service.storage, service.maps};
  PlaceOnMap on;
  on.map = MapAt(stored, call.Id("flight"), place);
  if (!on.map) {
    ExistingFlight(service, call);
    throw ApiError("NoMap", "no map of the flight shows this place");
  }
  const MapHead& head = on.map->head;
  PlanRequest usual;
  if (head.wind) usual.wind_in_world = head.wind->wind_in_world;
  on.aircraft = AircraftOf(call, ParseStoredFlightRequest(head.flight_json).aircraft);
  on.wind_in_world = WindOf(call, usual);
  on.site = SiteAt(stored, *on.map, place, on.aircraft, on.wind_in_world);
  return on;
}

std::optional<std::string> EvidenceDigestOf(const SiteRow& site) {
  if (site.feature_json.empty()) return std::nullopt;
  const nlohmann::json properties = nlohmann::json::parse(site.feature_json).at("properties");
  const auto digest = properties.find("evidence_digest");
  return digest == properties.end() ? std::nullopt : std::optional(digest->get<std::string>());
}

// What a flight's map knows about the place.
void AddEvidence(Service& service,
                 const KeptSite& site,
                 const PlaceJudgement& judgement,
                 const Eigen::Vector2d& place_in_world,
                 nlohmann::json& answer) {
  const auto map = service.maps.flight_maps().Find(service.storage, site.row.map_id);
  if (!map) return;
  answer["options"] = OptionsOfMapJson(map->head);
  answer["versions"] = VersionsOfMapJson(*map);
  if (!judgement.height) return;
  answer["evidence"].update(CellEvidenceJson(service, {*map, place_in_world, *judgement.height}));
}

// The answer for a place, judged on a site's map.
void AnswerJudgement(Service& service,
                     const KeptSite& site,
                     const PlaceJudgement& judgement,
                     const Aircraft& aircraft,
                     const Eigen::Vector2d& place_in_world,
                     httplib::Response& response) {
  nlohmann::json answer = PlaceJudgementJson(judgement, place_in_world, ContextOf(site));
  answer["nearest_limit"] = NearestLimitJson(judgement, aircraft);
  if (const auto digest = EvidenceDigestOf(site.row)) answer["evidence_digest"] = *digest;
  AddEvidence(service, site, judgement, place_in_world, answer);
  answer["wires_known"] = AreWiresKnown(
      {service.storage, service.maps},
      {LocalFrame(site.replan.origin).GeoFromWorld({place_in_world.x(), place_in_world.y(), 0.0})});
  answer["warnings"] = LimitsWarnings(aircraft);
  response.set_content(answer.dump(), "application/json");
}

Eigen::Vector2d InWorldOf(const KeptSite& site, GeoPoint place) {
  place.altitude_m = site.replan.origin.altitude_m;
  return LocalFrame(site.replan.origin).WorldFromGeo(place).head<2>();
}

std::vector<double> SpeedsOf(const std::string& text) {
  std::vector<double> speeds_mps;
  for (const double speed_mps : ParseQueryNumbers(text, "speeds_mps")) {
    if (speed_mps < 0.0 || speed_mps > kMaxWindMps) Refuse("speeds_mps", "must be in [0, 100]");
    if (!speeds_mps.empty() && speed_mps <= speeds_mps.back()) {
      Refuse("speeds_mps", "must be ascending");
    }
    speeds_mps.push_back(speed_mps);
  }
  return speeds_mps;
}

WindRoseOptions RoseOf(const Call& call) {
  WindRoseOptions rose;
  constexpr auto kMax = static_cast<int64_t>(kLimits.answer.max_num_rose_winds);
  const int64_t num_directions = call.QueryInteger("directions").value_or(rose.num_directions);
  if (num_directions < 1 || num_directions > kMax) {
    Refuse("directions", "must be a whole number, 1 to " + std::to_string(kMax));
  }
  rose.num_directions = static_cast<int>(num_directions);
  if (const auto speeds_mps = call.Query("speeds_mps")) rose.speeds_mps = SpeedsOf(*speeds_mps);
  const size_t num_winds = static_cast<size_t>(rose.num_directions) * rose.speeds_mps.size();
  if (num_winds <= kLimits.answer.max_num_rose_winds) return rose;
  ApiError error("InvalidValue",
                 "directions times speeds_mps: at most " +
                     std::to_string(kLimits.answer.max_num_rose_winds) + " winds are allowed",
                 {{"directions", "too many winds"}, {"speeds_mps", "too many winds"}});
  error.limit = kLimits.answer.max_num_rose_winds;
  error.observed = static_cast<double>(num_winds);
  throw error;
}

// As another map leaves it: a plan that one rejects is refused, one that is doubted is unverified.
nlohmann::json StoredApproach(const Service& service, const SiteRow& site) {
  const std::optional<SiteRow> stored = service.storage.sites.Find(site.id);
  if (stored && stored->IsContested()) {
    throw ApiError("SiteRejected",
                   "another map rejects the stored approach: " + stored->superseded_detail);
  }
  nlohmann::json approach = nlohmann::json::parse(site.approach_json);
  approach["wires_known"] = AreWiresKnown({service.storage, service.maps},
                                          {{site.latitude_deg, site.longitude_deg, 0.0}});
  if (!site.IsDoubted()) return approach;
  const auto lower = [](nlohmann::json& object) {
    if (object.value("verdict", "") == "landable") object["verdict"] = "unverified";
  };
  lower(approach);
  for (nlohmann::json& feature : approach["features"]) lower(feature["properties"]);
  return approach;
}

}  // namespace

void GetApproach(Service& service, const Call& call, httplib::Response& response) {
  const SiteRow site = ExistingSite(service, call);
  if (call.request.params.empty()) {
    if (site.approach_json.empty()) {
      const nlohmann::json feature = nlohmann::json::parse(site.feature_json);
      const std::string summary = feature.at("properties").value("summary", "none was found");
      throw ApiError("NoApproach", "the site has no approach: " + summary);
    }
    if (const auto obstruction = ObstructionOf({service.storage, service.maps}, site)) {
      throw ApiError("SiteRejected",
                     "an obstacle blocks the stored approach: " + obstruction->detail +
                         "; with a wind it is planned anew");
    }
    AnswerGeoJson(StoredApproach(service, site), response);
    return;
  }
  const LongPlace place(service.long_queues.plans, WantedBy(service, call));
  AnswerGeoJson(PlanAnew(service, site, call), response);
}

void GetWhy(Service& service, const Call& call, httplib::Response& response) {
  const SiteRow site = ExistingSite(service, call);
  const GeoPoint place = PlaceOf(call);
  const LongPlace turn(service.long_queues.plans, WantedBy(service, call));
  const auto stored = SiteWithMap(service, site);
  const Replan& replan = stored->replan;
  const Aircraft aircraft = AircraftOf(call, replan.flight.aircraft);
  const auto wind = WindOf(call, replan.request);
  const auto kept = service.maps.Covering(service.storage, stored, aircraft, wind);
  const Eigen::Vector2d place_in_world = InWorldOf(*kept, place);
  PlaceJudgement judgement =
      service.maps.PlannerFor(kept, aircraft)
          ->planner.Judge(place_in_world, wind, replan.flight.options.hazard);
  CheckAround({service.storage, service.maps}, *kept, aircraft, wind, judgement);
  AnswerJudgement(service, *kept, judgement, aircraft, place_in_world, response);
}

void GetFlightWhy(Service& service, const Call& call, httplib::Response& response) {
  const LongPlace turn(service.long_queues.plans, WantedBy(service, call));
  const PlaceOnMap on = PlaceOnFlightMap(service, call);
  const Eigen::Vector2d place_in_world = InWorldOf(*on.site, PlaceOf(call));
  const StoredMapPlanner on_map(on.site->replan, on.aircraft, on.site->obstructed_map);
  PlaceJudgement judgement =
      on_map.planner.Judge(place_in_world, on.wind_in_world, on.site->replan.flight.options.hazard);
  CheckAround({service.storage, service.maps}, *on.site, on.aircraft, on.wind_in_world, judgement);
  AnswerJudgement(service, *on.site, judgement, on.aircraft, place_in_world, response);
}

void GetFlightLanding(Service& service, const Call& call, httplib::Response& response) {
  const LongPlace turn(service.long_queues.plans, WantedBy(service, call));
  const PlaceOnMap on = PlaceOnFlightMap(service, call);
  const StoredMapPlanner on_map(on.site->replan, on.aircraft, on.site->obstructed_map);
  const Plan plan = CheckedAround(on_map.planner.PlanFor(on.wind_in_world),
                                  {service.storage, service.maps},
                                  *on.site,
                                  on.aircraft,
                                  on.wind_in_world);
  if (plan.verdict == Verdict::kRejected || !plan.approach) {
    throw ApiError("NoApproach",
                   "no landing within " + std::to_string(std::lround(kLandingRadiusM)) +
                       " m: " + plan.reject_detail);
  }
  AnswerGeoJson(PlanJson(service, plan, on.aircraft, ContextOf(*on.site)), response);
}

SiteRose PlanSiteRose(Service& service,
                      const std::shared_ptr<const KeptSite>& stored,
                      const Aircraft& aircraft,
                      const WindRoseOptions& options,
                      const StopIfUnwanted& stop_if_unwanted) {
  // The circle is largest in the strongest wind, the final longest in the weakest.
  auto kept = stored;
  for (const double speed_mps : {options.speeds_mps.front(), options.speeds_mps.back()}) {
    kept = service.maps.Covering(service.storage, kept, aircraft, Eigen::Vector2d(speed_mps, 0.0));
  }
  const auto on_map = service.maps.PlannerFor(kept, aircraft);
  WindRose rose = PlanWindRose(on_map->planner, options, stop_if_unwanted);
  const size_t num_directions = static_cast<size_t>(rose.num_directions);
  const bool has_later_maps = HasLaterMaps(*kept);
  for (size_t i = 0; i < rose.plans.size(); ++i) {
    stop_if_unwanted();
    const Eigen::Vector2d wind = rose.WindInWorld(i / num_directions, i % num_directions);
    // A rose has no profiles.
    if (has_later_maps && rose.plans[i].verdict != Verdict::kRejected) {
      rose.plans[i] = on_map->planner.PlanFor(wind);
    }
    rose.plans[i] = CheckedAround(
        std::move(rose.plans[i]), {service.storage, service.maps}, *kept, aircraft, wind);
  }
  return {std::move(kept), std::move(rose)};
}

void GetWindRose(Service& service, const Call& call, httplib::Response& response) {
  const SiteRow site = ExistingSite(service, call);
  const WindRoseOptions options = RoseOf(call);
  const StopIfUnwanted stop_if_unwanted = WantedBy(service, call);
  const LongPlace place(service.long_queues.plans, stop_if_unwanted);
  const auto stored = SiteWithMap(service, site);
  const Aircraft aircraft = AircraftOf(call, stored->replan.flight.aircraft);
  const SiteRose planned = PlanSiteRose(service, stored, aircraft, options, stop_if_unwanted);
  nlohmann::json answer = WindRoseJson(planned.rose, ContextOf(*planned.site));
  answer["aircraft"] = AircraftJson(aircraft);
  answer["wires_known"] = AreWiresKnown({service.storage, service.maps},
                                        {{site.latitude_deg, site.longitude_deg, 0.0}});
  answer["warnings"] = LimitsWarnings(aircraft);
  response.set_content(answer.dump(), "application/json");
}

}  // namespace freelsd
