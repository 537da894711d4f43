#include "server/handlers/emergency_landing.h"

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

GeoPoint PlaceOf(const nlohmann::json& place) {
  return {place.at("latitude_deg"), place.at("longitude_deg"), place.at("altitude_m")};
}

FinalPlaces FinalOf(const nlohmann::json& approach) {
  FinalPlaces places;
  places.start = PlaceOf(approach.at("start"));
  places.loiter_center = PlaceOf(approach.at("loiter_center"));
  places.loiter_radius_m = approach.at("loiter_radius_m");
  places.is_right_turn = approach.at("loiter_direction") == "right";
  places.heading_deg = approach.at("heading_deg");
  places.distance_m = approach.at("distance_m");
  places.height_m = approach.at("height_m");
  return places;
}

std::string FlightNameOf(const Service& service, const std::string& site_id) {
  const std::optional<SiteRow> row = service.storage.sites.Find(site_id);
  return row ? ParseReplan(row->replan_json).flight.name : "";
}

StoredSite BestOf(const Service& service, const nlohmann::json& answer) {
  const nlohmann::json& best = answer.at("sites").at(0);
  StoredSite site;
  site.id = best.at("site_id");
  site.flight_name = FlightNameOf(service, site.id);
  site.rank = best.at("rank").get<int64_t>();
  site.verdict = best.at("verdict");
  site.is_doubted = best.contains("doubted_at");
  site.is_experiment = best.contains("memory");
  site.altitude_datum = best.at("altitude_datum");
  site.touchdown = PlaceOf(best.at("touchdown"));
  site.score = best.at("score").get<double>();
  if (!best.at("age_s").is_null()) {
    site.last_seen_at = best.at("last_seen_at").get<std::string>();
    site.age_s = best.at("age_s").get<double>();
  }
  site.unseen_ratio = best.at("unseen_ratio").get<double>();
  site.landing_airspeed_mps = best.at("aircraft").at("landing_airspeed_mps").get<double>();
  site.final_places = FinalOf(best.at("approach"));
  for (const nlohmann::json* const from : {&best, &answer}) {
    for (const nlohmann::json& warning : from->at("warnings")) site.warnings.push_back(warning);
  }
  return site;
}

}  // namespace

void AnswerLanding(const Service& service,
                   const nlohmann::json& answer,
                   const std::string& format,
                   const ExportOptions& options,
                   httplib::Response& response) {
  if (answer.at("sites").empty()) {
    throw ApiError("NothingInReach",
                   answer.at("summary").get<std::string>() + "; there is no landing to export");
  }
  const StoredSite best = BestOf(service, answer);
  const std::string text = ExportSites(format, {best}, options);
  const std::string mark = best.verdict == "unverified" ? "-UNVERIFIED." : ".";
  response.set_header("Content-Disposition",
                      "attachment; filename=\"emergency" + mark + format + "\"");
  response.set_content(text,
                       format == "plan" ? "application/vnd.qgroundcontrol.plan+json"
                                        : "text/vnd.qgroundcontrol.waypoints");
}

}  // namespace freelsd
