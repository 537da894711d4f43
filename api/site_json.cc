#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "api/geojson.h"
#include "api/plan_json.h"

namespace freelsd {
namespace {

// Warning for every site, because no map from photographs shows these.
constexpr const char* kWhatIsNotSeen =
    "wires, thin poles, animals, vehicles that moved and ground under trees are not seen";

std::string ReasonOf(const Plan& plan) {
  return plan.reject_reason ? NameOf(*plan.reject_reason) : "no_safe_touchdown";
}

std::string ObstacleSentencePart(const PathObstacle& obstacle) {
  std::ostringstream text;
  text << ", tightest obstacle " << std::round(obstacle.clearance * 10.0) / 10.0 << " m below the "
       << (obstacle.part == PathPart::kFinal ? "final" : "circle") << " and "
       << std::lround(obstacle.distance) << " m from touchdown";
  return text.str();
}

// "180 x 35 m".
std::string StripText(const LandingStrip& strip) {
  return std::to_string(static_cast<int64_t>(strip.Length())) + " x " +
         std::to_string(static_cast<int64_t>(strip.Width())) + " m";
}

std::string ApproachSentencePart(const Approach& approach, const LocalFrame& local_frame) {
  std::ostringstream text;
  text << "final of " << std::lround(approach.approach_distance) << " m on heading "
       << std::lround(ApproachProperties(approach, local_frame)["heading_deg"].get<double>()) % 360
       << " deg from " << std::lround(approach.approach_height) << " m up";
  if (approach.crosswind > 0.0) {
    text << " with " << std::round(approach.crosswind * 10.0) / 10.0
         << " m/s of crosswind on the final";
  }
  text << " after a " << DirectionName(approach.loiter_direction) << " turn of "
       << std::lround(approach.loiter_radius) << " m radius";
  if (approach.obstacle) {
    text << ObstacleSentencePart(*approach.obstacle);
  } else if (approach.strip) {
    text << ", no obstacle below";
  }
  return text.str();
}

// One English sentence.
std::string SummaryOf(const Plan& plan, const LocalFrame& local_frame) {
  std::ostringstream text;
  if (plan.verdict == Verdict::kRejected) {
    text << "Rejected (" << ReasonOf(plan) << ")";
    if (!plan.reject_detail.empty()) text << ": " << plan.reject_detail;
  } else {
    text << (plan.verdict == Verdict::kLandable ? "Landable" : "Unverified") << ": "
         << std::lround(plan.hazard_distance) << " m free around the touchdown";
    if (plan.approach && plan.approach->strip) {
      text << ", usable strip of " << StripText(*plan.approach->strip);
    }
    if (plan.approach) text << ", " << ApproachSentencePart(*plan.approach, local_frame);
    if (plan.approach && plan.approach->unseen_ratio > 0.0) {
      text << "; along " << std::max(1L, std::lround(100.0 * plan.approach->unseen_ratio))
           << " % of the circle some ground is not measured";
    }
  }
  std::string summary = text.str();
  if (summary.back() != '.') summary += '.';
  return summary;
}

std::string TwoDigits(double number) {
  std::ostringstream text;
  text << std::setprecision(2) << number;
  return text.str();
}

// Reason for the site's rank, in one English sentence.
std::string WhyOf(const Plan& plan) {
  if (!plan.risk) return "Ranked last: no way down could be planned.";
  const FailureParts& parts = plan.risk->parts;
  return "Ranked among the " + NameOf(plan.verdict) +
         " sites by the probability that a landing fails, " +
         TwoDigits(plan.risk->failure_probability) + ": alone, the ground would make it " +
         TwoDigits(parts.ground) + ", the final " + TwoDigits(parts.final_path) + ", the circle " +
         TwoDigits(parts.circle) + ".";
}

nlohmann::json RejectionsJson(const Plan& plan, const LocalFrame& local_frame) {
  nlohmann::json rejections = nlohmann::json::array();
  for (const Rejection& rejection : plan.rejections) {
    nlohmann::json object{{"touchdown", PlaceJson(rejection.touchdown_in_world, local_frame)},
                          {"reason", NameOf(rejection.reason)},
                          {"detail", rejection.detail}};
    if (rejection.obstacle_in_world) {
      object["obstacle"] = PlaceJson(*rejection.obstacle_in_world, local_frame);
    }
    rejections.push_back(std::move(object));
  }
  return rejections;
}

// The plan's numbers are meaningless if no terrain was seen.
nlohmann::json SurfaceProperties(const Plan& plan, const LocalFrame& local_frame) {
  if (plan.reject_reason == RejectReason::kNoTerrain || !plan.touchdown_in_world.allFinite()) {
    return {{"hazard_distance_m", nullptr},
            {"slope_deg", nullptr},
            {"roughness_m", nullptr},
            {"elevation_m", nullptr}};
  }
  return {{"hazard_distance_m", Rounded(plan.hazard_distance)},
          {"slope_deg", Rounded(DegFromRad(plan.slope))},
          {"roughness_m", Rounded(plan.roughness)},
          {"elevation_m", Rounded(AltitudeOf(plan.touchdown_in_world, local_frame))}};
}

// Null where no path was planned.
nlohmann::json StripProperties(const Plan& plan) {
  if (!plan.approach || !plan.approach->strip) {
    return {{"usable_length_m", nullptr}, {"usable_width_m", nullptr}};
  }
  return {{"usable_length_m", Rounded(plan.approach->strip->Length())},
          {"usable_width_m", Rounded(plan.approach->strip->Width())}};
}

}  // namespace

std::string NameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kLandable:
      return "landable";
    case Verdict::kUnverified:
      return "unverified";
    case Verdict::kRejected:
      break;
  }
  return "rejected";
}

std::string NameOf(RejectReason reason) {
  switch (reason) {
    case RejectReason::kNoSafeTouchdown:
      return "no_safe_touchdown";
    case RejectReason::kApproachBlocked:
      return "approach_blocked";
    case RejectReason::kApproachUnseen:
      return "approach_unseen";
    case RejectReason::kLoiterBlocked:
      return "loiter_blocked";
    case RejectReason::kRiskTooHigh:
      return "risk_too_high";
    case RejectReason::kWindTooStrong:
      return "wind_too_strong";
    case RejectReason::kTooSmall:
      return "too_small";
    case RejectReason::kTooFewObservations:
      return "too_few_observations";
    case RejectReason::kNotGrass:
      return "not_grass";
    case RejectReason::kNoTerrain:
      break;
  }
  return "no_terrain";
}

// Null without a path.
nlohmann::json RiskProperties(const Plan& plan) {
  if (!plan.risk) return {{"failure_probability", nullptr}, {"failure_parts", nullptr}};
  const FailureParts& parts = plan.risk->parts;
  return {{"failure_probability", Rounded(plan.risk->failure_probability)},
          {"failure_parts",
           {{"ground", Rounded(parts.ground)},
            {"final", Rounded(parts.final_path)},
            {"circle", Rounded(parts.circle)},
            {"position", Rounded(parts.position)},
            {"wind", Rounded(parts.wind)}}}};
}

nlohmann::json PlanProperties(const Plan& plan, const FlightContext& context) {
  nlohmann::json properties = SurfaceProperties(plan, context.local_frame);
  properties.update(StripProperties(plan));
  properties["verdict"] = NameOf(plan.verdict);
  if (plan.verdict == Verdict::kRejected) properties["reject_reason"] = ReasonOf(plan);
  if (!plan.reject_detail.empty()) properties["reject_detail"] = plan.reject_detail;
  properties["score"] = Rounded(std::clamp(plan.score, 0.0, 1.0));
  properties.update(RiskProperties(plan));
  properties["why"] = WhyOf(plan);
  properties["summary"] = SummaryOf(plan, context.local_frame);
  properties["rejections"] = RejectionsJson(plan, context.local_frame);
  properties["approach"] = nullptr;
  properties["unseen_ratio"] = nullptr;
  if (plan.approach) {
    properties["approach"] = ApproachProperties(*plan.approach, context.local_frame);
    properties["unseen_ratio"] = Rounded(plan.approach->unseen_ratio);
  }
  return properties;
}

std::string AgeText(double age_s) {
  constexpr double kMinuteS = 60.0, kHourS = 3600.0, kDayS = 86400.0;
  const auto whole = [age_s](double unit_s) {
    return std::to_string(static_cast<int64_t>(age_s / unit_s));
  };
  if (age_s >= 2.0 * kDayS) return whole(kDayS) + " days";
  if (age_s >= 2.0 * kHourS) return whole(kHourS) + " hours";
  return whole(kMinuteS) + " minutes";
}

std::vector<std::string> LimitsWarnings(const Aircraft& aircraft) {
  const std::vector<std::string> looser = LimitsLooserThanProfiles(aircraft);
  if (looser.empty()) return {};
  std::string text = "the aircraft's limits are looser than every known profile's: ";
  for (const std::string& each : looser) text += (&each == &looser.front() ? "" : ", ") + each;
  return {text};
}

nlohmann::json SiteFeature(const std::string& site_id,
                           const Site& site,
                           const Aircraft& aircraft,
                           const std::string& updated_at,
                           const FlightContext& context) {
  const Region& region = site.region;
  nlohmann::json properties = PlanProperties(site.plan, context);
  properties["id"] = site_id;
  properties["flight_id"] = context.flight_id;
  properties["region_id"] =
      region.id == kNoRegion ? nlohmann::json(nullptr) : nlohmann::json(region.id);
  properties["grade"] = NumberOrNull(region.grade);
  properties["num_observations"] = region.num_observations;
  properties["num_grass_observations"] = region.num_grass_observations;
  properties["area_m2"] = Rounded(region.area_m2);
  properties["wind"] = WindJson(site.wind);
  if (site.wind) properties["wind_spread_mps"] = Rounded(site.wind->spread_mps);
  properties["altitude_datum"] = context.altitude_datum;
  properties["aircraft"] = AircraftJson(aircraft);
  properties["footprint"] = PolygonGeometry(region.corners_in_world, context.local_frame);
  properties["warnings"] = nlohmann::json::array({kWhatIsNotSeen});
  if (!site.wind) properties["warnings"].push_back("the wind is unknown: all headings were tried");
  for (const std::string& warning : LimitsWarnings(aircraft)) {
    properties["warnings"].push_back(warning);
  }
  properties["updated_at"] = updated_at;
  nlohmann::json feature =
      Feature(PointGeometry(site.plan.touchdown_in_world, context.local_frame), properties);
  feature["id"] = site_id;
  return feature;
}

RankKey RankKeyOf(const std::string& verdict, double score, const std::string& id) {
  return {verdict == "landable" ? 0 : verdict == "unverified" ? 1 : 3, -score, id};
}

RankKey RankKeyOf(const nlohmann::json& site_feature) {
  const nlohmann::json& properties = site_feature.at("properties");
  const auto score = properties.find("score");
  const bool has_score = score != properties.end() && score->is_number();
  const std::string verdict = properties.value("verdict", "rejected");
  RankKey key = RankKeyOf(
      verdict, has_score ? score->get<double>() : 0.0, properties.value("id", std::string()));
  if (verdict == "unverified" && properties.contains("doubted_by"))
    std::get<int>(key) = kDoubtedRank;
  return key;
}

nlohmann::json RankedSites(std::vector<nlohmann::json> features) {
  std::stable_sort(features.begin(), features.end(), [](const auto& a, const auto& b) {
    return RankKeyOf(a) < RankKeyOf(b);
  });
  int rank = 0;
  for (nlohmann::json& feature : features) feature["properties"]["rank"] = ++rank;
  return FeatureCollection(features);
}

}  // namespace freelsd
