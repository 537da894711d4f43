#include "server/recall/recall_candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <tuple>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/api.h"
#include "server/http/http.h"
#include "server/recall/geoid/geoid.h"
#include "server/recall/obstacles/obstacles.h"
#include "server/recall/plan_check.h"

namespace freelsd {
namespace {

// A new plan may move the touchdown within the region, and the final starts away from it.
constexpr double kPlanShiftM = 1000.0;
// Boxes enclose maps; the touchdown may lie anywhere on a map.
constexpr double kMapHalfSizeM = 500.0;
// Margins above this value count as equal.
constexpr double kPlentyMarginM = 60.0;
// Margins are compared in steps of this size.
constexpr double kMarginStepM = 15.0;

Eigen::Vector2d WayTo(const RecallRow& row, const GeoPoint& place) {
  const double dlon_deg = std::remainder(row.longitude_deg - place.longitude_deg, 360.0);
  const double middle_deg = 0.5 * (row.latitude_deg + place.latitude_deg);
  return {dlon_deg * kMetresPerDegree * std::cos(RadFromDeg(middle_deg)),
          (row.latitude_deg - place.latitude_deg) * kMetresPerDegree};
}

double StraightMargin(const EmergencyRequest& request,
                      const RecallCandidate& candidate,
                      double within_m) {
  const GlidingAircraft& gliding = *candidate.gliding;
  const GlideStart start = StartOf(request, {0.0, 0.0, request.place.altitude_m});
  const auto lost = LeastHeightLost(start, candidate.way_m, within_m, gliding.glide);
  if (!lost) return -std::numeric_limits<double>::infinity();
  return request.place.altitude_m - candidate.datum.subtracted_m - *lost -
         candidate.row->data.altitude_m - gliding.aircraft.approach_height_m -
         request.arrival_height_m;
}

std::shared_ptr<const GlidingAircraft> GlidingOf(const EmergencyRequest& request,
                                                 const std::string& aircraft_json) {
  const std::optional<Aircraft> aircraft = AircraftOf(request, aircraft_json);
  if (!aircraft) return nullptr;
  return std::make_shared<const GlidingAircraft>(
      GlidingAircraft{*aircraft, AircraftJson(*aircraft).dump(), StraightGlideOf(*aircraft)});
}

RecallCandidate CandidateOf(const EmergencyRequest& request,
                            const RecallRow& row,
                            const std::shared_ptr<const GlidingAircraft>& gliding,
                            int64_t now_us) {
  RecallCandidate candidate;
  candidate.row = &row;
  candidate.gliding = gliding;
  candidate.way_m = WayTo(row, request.place);
  candidate.distance_m = candidate.way_m.norm();
  candidate.datum = DatumDifferenceOf(
      ReferenceOf(request),
      {row.data.altitude_datum, row.latitude_deg, row.longitude_deg, row.flight_id});
  candidate.age_s = GroundAgeS(row.seen_at_us, now_us);
  candidate.score = row.data.score * ScoreLeft(candidate.age_s);
  candidate.best_margin_m = StraightMargin(request, candidate, kPlanShiftM);
  candidate.expected_margin_m = StraightMargin(request, candidate, 0.0);
  return candidate;
}

double SortAgeS(const RecallCandidate& candidate) {
  return candidate.age_s.value_or(std::numeric_limits<double>::infinity());
}
bool IsDoubted(const RecallCandidate& candidate) { return candidate.row->doubt != nullptr; }

int MarginStep(double margin_m) {
  return static_cast<int>(std::floor(std::clamp(margin_m, -1e6, kPlentyMarginM) / kMarginStepM));
}

// The order in which candidates are evaluated: that of the answer (IsBetter), as far as it is known
// without a plan. Candidates out of reach come last, the smallest shortfall first.
bool IsMorePromising(const RecallCandidate& a, const RecallCandidate& b) {
  const bool is_a_in_reach = a.best_margin_m >= 0.0;
  if (is_a_in_reach != (b.best_margin_m >= 0.0)) return is_a_in_reach;
  if (is_a_in_reach && IsDoubted(a) != IsDoubted(b)) return IsDoubted(b);
  if (!is_a_in_reach && a.best_margin_m != b.best_margin_m) {
    return a.best_margin_m > b.best_margin_m;
  }
  const auto rank = [](const RecallCandidate& candidate) {
    return std::tuple(-MarginStep(candidate.expected_margin_m),
                      !candidate.row->data.is_landable,
                      -candidate.score,
                      SortAgeS(candidate),
                      -candidate.row->data.score,
                      candidate.distance_m,
                      std::string_view(candidate.row->site_id));
  };
  return rank(a) < rank(b);
}

// Distance over ground per height, straight against the wind.
double LeastGlide(const EmergencyRequest& request, const Aircraft& aircraft) {
  const StraightGlide glide = StraightGlideOf(aircraft);
  const double wind =
      request.wind_in_world ? request.wind_in_world->norm() : GlideOptions{}.unknown_wind_mps;
  return (glide.airspeed_mps - wind) / glide.sink_rate_mps;
}

Aircraft AsRequested(const EmergencyRequest& request, const Aircraft& given) {
  Aircraft aircraft = Unpowered(given, request.glide_ratio);
  aircraft.touchdown_uncertainty_m =
      std::max(aircraft.touchdown_uncertainty_m, request.touchdown_uncertainty_m);
  return aircraft;
}

RecallRow RecalledRowOf(const SiteRow& site, const StoredPlan& plan) {
  RecallRow row;
  row.site_id = site.id;
  row.flight_id = site.flight_id;
  row.map_id = site.map_id;
  row.latitude_deg = site.latitude_deg;
  row.longitude_deg = site.longitude_deg;
  row.updated_at_us = site.updated_at_us;
  row.seen_at_us = site.LastSeenUs();
  row.seen_until_us = site.seen_until_us;
  row.data = {plan.site.verdict == "landable",
              plan.site.touchdown.altitude_m,
              plan.site.altitude_datum,
              plan.site.score.value_or(0.0),
              AircraftJson(plan.replan.flight.aircraft).dump()};
  if (site.IsDoubted()) row.doubt = std::make_shared<const Standing>(site);
  return row;
}

}  // namespace

std::optional<Aircraft> AircraftOf(const EmergencyRequest& request,
                                   const std::string& aircraft_json) {
  try {
    const Aircraft stored = ParseAircraft(ParseJson(aircraft_json), "/aircraft");
    return AsRequested(request, request.aircraft.value_or(stored));
  } catch (const ApiError& error) {
    spdlog::error("a stored aircraft cannot be used: {}", error.what());
    return std::nullopt;
  }
}

std::optional<double> GroundAgeS(int64_t seen_at_us, int64_t now_us) {
  if (seen_at_us == 0) return std::nullopt;
  return std::max(0.0, static_cast<double>(now_us - seen_at_us) * 1e-6);
}

nlohmann::json GroundAgeJson(int64_t seen_at_us, int64_t now_us) {
  const std::optional<double> age_s = GroundAgeS(seen_at_us, now_us);
  if (!age_s) return {{"last_seen_at", nullptr}, {"age_s", nullptr}};
  return {{"last_seen_at", Rfc3339(seen_at_us)}, {"age_s", *age_s}};
}

double ScoreLeft(const std::optional<double>& age_s) {
  return age_s ? std::exp2(-*age_s / kScoreHalfLifeS) : 0.0;
}

BoundingBox BoxAround(const GeoPoint& place, double reach_m) {
  const double dlat_deg = reach_m / kMetresPerDegree;
  const double south = std::max(-90.0, place.latitude_deg - dlat_deg);
  const double north = std::min(90.0, place.latitude_deg + dlat_deg);
  const double widest = std::max(std::abs(south), std::abs(north));
  const double shrink = std::cos(RadFromDeg(std::min(widest, 89.9)));
  const double dlon_deg = dlat_deg / shrink;
  if (dlon_deg >= 180.0 || widest >= 89.9) return {-180.0, south, 180.0, north};
  const auto wrapped = [](double longitude) { return std::remainder(longitude, 360.0); };
  return {wrapped(place.longitude_deg - dlon_deg),
          south,
          wrapped(place.longitude_deg + dlon_deg),
          north};
}

GlideStart StartOf(const EmergencyRequest& request, const Eigen::Vector3d& position_in_world) {
  GlideStart start;
  start.position_in_world = position_in_world;
  if (request.heading_deg) start.heading = RadFromDeg(*request.heading_deg);
  start.wind_in_world = request.wind_in_world;
  start.wind_sd_mps = request.wind_sd_mps;
  if (request.is_wind_old) start.wind_turn = RadFromDeg(kOldWindTurnDeg);
  return start;
}

std::shared_ptr<const GlidingAircraft> GlidingFleet::Of(const EmergencyRequest& request,
                                                        const std::string& aircraft_json) {
  const std::lock_guard lock(mutex_);
  auto found = gliding_.find(aircraft_json);
  if (found == gliding_.end()) {
    found = gliding_.emplace(aircraft_json, GlidingOf(request, aircraft_json)).first;
  }
  return found->second;
}

double GreatestReach(const EmergencyRequest& request,
                     const RecallBounds& bounds,
                     GlidingFleet& fleet) {
  // If the site has another datum, the altitude may be higher by this value.
  const double height_m =
      std::max(0.0, request.place.altitude_m + kMaxGeoidHeightM - bounds.min_altitude_m);
  const double wind_mps = request.wind_in_world ? request.wind_in_world->norm() : 0.0;
  double reach_m = 0.0;
  for (const std::string& aircraft_json : bounds.aircraft_jsons) {
    const auto gliding = fleet.Of(request, aircraft_json);
    if (!gliding) return kMaxReachM;
    const Aircraft& aircraft = gliding->aircraft;
    const double speed_mps = aircraft.glide_airspeed_mps.value_or(aircraft.landing_airspeed_mps);
    const double aloft_s = height_m * std::hypot(aircraft.glide_ratio, 1.0) / speed_mps;
    reach_m = std::max(reach_m, height_m * aircraft.glide_ratio + wind_mps * aloft_s);
  }
  return std::min(kMaxReachM, reach_m + kPlanShiftM + kMapHalfSizeM);
}

bool IsBetter(const PlannedRank& rank_a,
              const RecallCandidate& a,
              const PlannedRank& rank_b,
              const RecallCandidate& b) {
  if (rank_a.is_doubted != rank_b.is_doubted) return rank_b.is_doubted;
  if (MarginStep(rank_a.margin_m) != MarginStep(rank_b.margin_m)) {
    return MarginStep(rank_a.margin_m) > MarginStep(rank_b.margin_m);
  }
  if (rank_a.is_landable != rank_b.is_landable) return rank_a.is_landable;
  if (a.score != b.score) return a.score > b.score;
  if (a.age_s != b.age_s) return SortAgeS(a) < SortAgeS(b);
  if (a.row->data.score != b.row->data.score) return a.row->data.score > b.row->data.score;
  if (a.distance_m != b.distance_m) return a.distance_m < b.distance_m;
  return a.row->site_id < b.row->site_id;
}

bool IsSurelyNotBetter(const RecallCandidate& candidate,
                       const PlannedRank& rank_of_reached,
                       const RecallCandidate& reached) {
  const PlannedRank best{IsDoubted(candidate), candidate.best_margin_m, true};
  return IsBetter(rank_of_reached, reached, best, candidate);
}

std::vector<RecallCandidate> Candidates(const EmergencyRequest& request,
                                        const SharedRows<RecallRow>& rows,
                                        GlidingFleet& fleet) {
  std::vector<RecallCandidate> candidates;
  candidates.reserve(rows.size());
  const int64_t now_us = NowUs();
  for (const auto& row : rows) {
    const auto gliding = fleet.Of(request, row->data.aircraft_json);
    if (gliding) candidates.push_back(CandidateOf(request, *row, gliding, now_us));
  }
  return candidates;
}

void SortNext(std::vector<RecallCandidate>& candidates, size_t begin, size_t num) {
  const auto at = [&](size_t i) {
    return candidates.begin() + static_cast<std::ptrdiff_t>(std::min(candidates.size(), i));
  };
  std::partial_sort(at(begin), at(begin + num), candidates.end(), IsMorePromising);
}

Aircraft LeastGlidingAircraft(const EmergencyRequest& request, const RecallBounds& bounds) {
  if (request.aircraft) return AsRequested(request, *request.aircraft);
  std::optional<Aircraft> least;
  for (const std::string& json : bounds.aircraft_jsons) {
    const std::optional<Aircraft> aircraft = AircraftOf(request, json);
    if (!aircraft) continue;
    if (!least || LeastGlide(request, *aircraft) < LeastGlide(request, *least)) least = aircraft;
  }
  return least.value_or(AsRequested(request, Aircraft{}));
}

SiteRow AsRemembered(SiteRow site, const FlightMemory& memory) {
  if (memory.is_kept) return site;
  site.recall.reset();
  nlohmann::json feature = nlohmann::json::parse(site.feature_json);
  nlohmann::json& properties = feature["properties"];
  properties["memory"] = NameOf(memory);
  properties["warnings"].push_back(kExperimentWarning);
  properties["summary"] = properties.value("summary", "") + " " + kExperimentWarning;
  site.feature_json = feature.dump();
  return site;
}

bool IsOwnExperiment(const EmergencyRequest& request, const RecallRow& site) {
  return request.is_of_experiment && request.flight_id == site.flight_id;
}

SharedRows<RecallRow> OwnSites(const Storage& storage, const EmergencyRequest& request) {
  SharedRows<RecallRow> rows;
  if (!request.is_of_experiment) return rows;
  for (const SiteRow& site : storage.sites.List(request.flight_id, std::nullopt)) {
    if (site.superseded_by) continue;
    const std::optional<StoredPlan> plan = ReadStoredPlan(site);
    if (plan) rows.push_back(std::make_shared<const RecallRow>(RecalledRowOf(site, *plan)));
  }
  return rows;
}

RecallBounds WithSites(RecallBounds bounds, const SharedRows<RecallRow>& sites) {
  std::vector<std::string>& aircraft = bounds.aircraft_jsons;
  for (const auto& site : sites) {
    const bool is_first = aircraft.empty();
    const double altitude_m = site->data.altitude_m;
    bounds.min_altitude_m = is_first ? altitude_m : std::min(bounds.min_altitude_m, altitude_m);
    const std::string& json = site->data.aircraft_json;
    if (std::find(aircraft.begin(), aircraft.end(), json) == aircraft.end()) {
      aircraft.push_back(json);
    }
  }
  return bounds;
}

}  // namespace freelsd
