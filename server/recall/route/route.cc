#include "server/recall/route/route.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/recall/route/fixes.h"

namespace freelsd {
namespace {

// Time for the moments and fixes of one route. Thirty kilometres take less than two seconds.
constexpr std::chrono::seconds kMaxCheckTime{60};

// Colours of lines and points in GeoJSON (simplestyle): covered, not covered, other.
constexpr char kGreen[] = "#1a7f37";
constexpr char kRed[] = "#cf222e";
constexpr char kBlue[] = "#0969da";

// A route's moments, and its end.
class RouteTimes {
 public:
  RouteTimes(const RouteRequest& request, const Insurance& insurance, double period_s)
      : request_(request), insurance_(insurance), period_s_(period_s) {}

  size_t size() const { return insurance_.moments.size(); }
  // The moment's, or the route's end.
  GeoPoint PlaceAt(size_t i) const {
    return i < size() ? insurance_.moments[i].moment.place : request_.route.back();
  }
  double TimeAt(size_t i) const { return static_cast<double>(i) * period_s_; }

 private:
  const RouteRequest& request_;
  const Insurance& insurance_;
  double period_s_;
};

nlohmann::json MomentJson(const InsuredMoment& insured) {
  nlohmann::json json{{"time_s", insured.moment.time_s},
                      {"latitude_deg", insured.moment.place.latitude_deg},
                      {"longitude_deg", insured.moment.place.longitude_deg},
                      {"altitude_m", insured.moment.place.altitude_m},
                      {"heading_deg", insured.moment.heading_deg},
                      {"covered", insured.is_covered},
                      {"covered_weight", insured.covered_weight},
                      {"arrival_margin_m", nullptr}};
  if (insured.best_site) json["best_site"] = *insured.best_site;
  if (insured.arrival_margin_m) json["arrival_margin_m"] = *insured.arrival_margin_m;
  if (insured.failure_probability) json["failure_probability"] = *insured.failure_probability;
  if (!insured.is_covered) json["reason"] = NameOf(insured.reason);
  return json;
}

std::string SentenceOf(const RouteGap& gap) {
  const std::string& site = gap.nearest_miss ? gap.nearest_miss->site_id : std::string();
  const std::string missing =
      gap.nearest_miss ? std::to_string(std::lround(std::ceil(gap.nearest_miss->missing_m))) : "";
  switch (gap.reason) {
    case MissReason::kTooLow:
      return "no site is in reach; where least is missing, " + missing + " m are missing to " +
             site;
    case MissReason::kTerrain:
      return "terrain or an obstacle is on the way to " + site + "; where least is missing, " +
             missing + " m are missing";
    case MissReason::kTooHigh:
      return "the route is too near and too high for " + site +
             ": no clear way there loses the height before the final";
    case MissReason::kNoApproach:
      return "the sites nearby have no approach in this wind, or it is too strong to get there";
    case MissReason::kNoSite:
      return "no site is stored within any glide";
    case MissReason::kNotEvaluated:
      break;
  }
  return "there was no time to evaluate this part";
}

nlohmann::json GapJson(const RouteGap& gap, const RouteTimes& times) {
  nlohmann::json json{{"from_s", times.TimeAt(gap.first)},
                      {"to_s", times.TimeAt(gap.last + 1)},
                      {"from", GeoPointJson(times.PlaceAt(gap.first))},
                      {"to", GeoPointJson(times.PlaceAt(gap.last + 1))},
                      {"reason", NameOf(gap.reason)},
                      {"sentence", SentenceOf(gap)}};
  if (gap.nearest_miss) {
    json["nearest_miss"] = {{"site_id", gap.nearest_miss->site_id},
                            {"missing_m", gap.nearest_miss->missing_m}};
  }
  return json;
}

nlohmann::json PointsJson(const std::vector<GeoPoint>& points) {
  nlohmann::json json = nlohmann::json::array();
  for (const GeoPoint& point : points) json.push_back(GeoPointJson(point));
  return json;
}

// `gaps_s`: of all gaps without the change.
nlohmann::json FixJson(const RouteFix& fix, double gaps_s) {
  nlohmann::json json{
      {"kind", NameOf(fix.kind)}, {"gap", fix.gap}, {"gaps_left_s", fix.gaps_left_s}};
  const std::string left = "closes " + std::to_string(std::lround(gaps_s - fix.gaps_left_s)) +
                           " of " + std::to_string(std::lround(gaps_s)) + " s of gaps";
  const auto metres = [](double length_m) { return std::to_string(std::lround(length_m)) + " m"; };
  switch (fix.kind) {
    case FixKind::kClimb:
      json["climb_m"] = fix.climb_m;
      json["sentence"] = "fly " + metres(fix.climb_m) + " higher there: " + left;
      break;
    case FixKind::kOffset:
      json["offset_m"] = fix.offset_m;
      json["sentence"] = "fly " + metres(std::abs(fix.offset_m)) +
                         (fix.offset_m > 0.0 ? " to the right: " : " to the left: ") + left;
      break;
    case FixKind::kLook:
      json["place"] = GeoPointJson(*fix.place);
      json["sentence"] = "photograph this ground first: a strip there " + left;
      break;
  }
  if (!fix.route.empty()) json["route"] = PointsJson(fix.route);
  return json;
}

// The last covered moment, if the route then stays uncovered to its end.
std::optional<nlohmann::json> PointOfNoReturn(const Insurance& insurance) {
  if (insurance.gaps.empty()) return std::nullopt;
  const RouteGap& gap = insurance.gaps.back();
  if (gap.last + 1 != insurance.moments.size() || gap.first == 0) return std::nullopt;
  return MomentJson(insurance.moments[gap.first - 1]);
}

size_t NumRecalls(const RouteRequest& request, size_t num_moments) {
  return num_moments * std::max<size_t>(1, request.winds.size());
}

void RefuseTooLong(const RouteRequest& request, size_t num_moments) {
  const size_t limit = kLimits.routes.max_num_recalls;
  if (NumRecalls(request, num_moments) <= limit) return;
  const std::string detail = "takes " + std::to_string(num_moments) +
                             " s; seconds times winds must be at most " + std::to_string(limit);
  ApiError error("InvalidValue", "route: " + detail, {{"/route", detail}});
  error.limit = static_cast<double>(limit);
  error.observed = static_cast<double>(NumRecalls(request, num_moments));
  throw error;
}

std::vector<std::string> WarningsOf(const RouteRequest& request, const Insurance& insurance) {
  std::vector<std::string> warnings = request.warnings;
  if (request.winds.empty()) {
    warnings.emplace_back(
        "the wind is unknown: the worst direction of a wind of 5.5 m/s is assumed, and times are "
        "those of calm air");
  }
  if (request.altitude_datum == "unknown" && !request.flight_id) {
    warnings.emplace_back(
        "the datum of the altitudes is unknown: the height of the geoid is subtracted");
  }
  const bool is_cut_short = std::any_of(
      insurance.moments.begin(), insurance.moments.end(), [](const InsuredMoment& insured) {
        return !insured.is_covered && insured.reason == MissReason::kNotEvaluated;
      });
  if (is_cut_short) warnings.emplace_back("not every second was evaluated");
  warnings.emplace_back("terrain on the way to a site is known only where stored maps cover it");
  return warnings;
}

nlohmann::json Coordinates(const nlohmann::json& place) {
  return {place["longitude_deg"], place["latitude_deg"], place["altitude_m"]};
}

nlohmann::json Feature(const std::string& type,
                       const nlohmann::json& coordinates,
                       nlohmann::json properties) {
  return {{"type", "Feature"},
          {"geometry", {{"type", type}, {"coordinates", coordinates}}},
          {"properties", std::move(properties)}};
}

// Each line ends where the next one begins.
void AddLines(const nlohmann::json& answer, nlohmann::json& features) {
  const nlohmann::json& samples = answer["samples"];
  for (size_t first = 0; first < samples.size();) {
    const bool is_covered = samples[first]["covered"];
    nlohmann::json line = nlohmann::json::array();
    size_t next = first;
    while (next < samples.size() && samples[next]["covered"] == is_covered) {
      line.push_back(Coordinates(samples[next++]));
    }
    line.push_back(Coordinates(next < samples.size() ? samples[next] : answer["end"]));
    features.push_back(
        Feature("LineString",
                line,
                {{"kind", is_covered ? "covered" : "gap"},
                 {"from_s", samples[first]["time_s"]},
                 {"to_s", next < samples.size() ? samples[next]["time_s"] : answer["time_s"]},
                 {"stroke", is_covered ? kGreen : kRed},
                 {"stroke-width", 4}}));
    first = next;
  }
}

nlohmann::json FixFeature(const nlohmann::json& fix) {
  nlohmann::json properties = fix;
  properties.erase("route");
  properties.erase("place");
  if (fix.contains("place")) {
    properties["marker-color"] = kBlue;
    return Feature("Point", Coordinates(fix["place"]), properties);
  }
  nlohmann::json line = nlohmann::json::array();
  for (const auto& point : fix["route"]) line.push_back(Coordinates(point));
  properties["stroke"] = kBlue;
  return Feature("LineString", line, properties);
}

}  // namespace

nlohmann::json CheckRoute(const StoredSites& stored, const RouteRequest& request) {
  const RouteJudge judge(stored, request, std::chrono::steady_clock::now() + kMaxCheckTime);
  const std::vector<RouteMoment> moments = judge.MomentsOf(request.route);
  RefuseTooLong(request, moments.size());
  const Insurance insurance = judge.Insure(request.route);
  const RouteTimes times(request, insurance, judge.options().moment_period_s);
  const auto num_moments = static_cast<double>(insurance.moments.size());
  nlohmann::json answer{
      {"covered_ratio", 1.0 - static_cast<double>(insurance.NumUncovered()) / num_moments},
      {"time_s", times.TimeAt(times.size())},
      {"end", GeoPointJson(request.route.back())},
      {"gaps", nlohmann::json::array()},
      {"fixes", nlohmann::json::array()},
      {"samples", nlohmann::json::array()},
      {"wires_known", AreWiresKnown(stored, request.route)},
      {"warnings", WarningsOf(request, insurance)}};
  for (const std::string& notice : stored.storage.Notices()) answer["warnings"].push_back(notice);
  for (const RouteGap& gap : insurance.gaps) answer["gaps"].push_back(GapJson(gap, times));
  if (const auto point = PointOfNoReturn(insurance)) answer["point_of_no_return"] = *point;
  for (const InsuredMoment& insured : insurance.moments) {
    answer["samples"].push_back(MomentJson(insured));
  }
  if (!request.has_fixes) return answer;
  const FoundFixes found = FindFixes(judge, stored, request, insurance);
  const double gaps_s =
      static_cast<double>(insurance.NumUncovered()) * judge.options().moment_period_s;
  for (const RouteFix& fix : found.fixes) answer["fixes"].push_back(FixJson(fix, gaps_s));
  if (!found.is_complete) answer["warnings"].push_back("there was no time to search all fixes");
  return answer;
}

nlohmann::json RouteGeoJson(const nlohmann::json& answer) {
  nlohmann::json features = nlohmann::json::array();
  AddLines(answer, features);
  if (const auto point = answer.find("point_of_no_return"); point != answer.end()) {
    nlohmann::json properties{{"kind", "point_of_no_return"}, {"marker-color", kRed}};
    for (const char* const key :
         {"time_s", "best_site", "arrival_margin_m", "failure_probability"}) {
      if (point->contains(key)) properties[key] = (*point)[key];
    }
    features.push_back(Feature("Point", Coordinates(*point), properties));
  }
  for (const nlohmann::json& fix : answer["fixes"]) features.push_back(FixFeature(fix));
  return {{"type", "FeatureCollection"},
          {"features", features},
          {"covered_ratio", answer["covered_ratio"]},
          {"warnings", answer["warnings"]}};
}

}  // namespace freelsd
