#include "server/recall/recall_candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>
#include <tuple>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/api.h"
#include "server/http/http.h"
#include "server/recall/geoid.h"

namespace freelsd {
namespace {

constexpr double kMetresPerDegree = 111195.0;  // of latitude, on a sphere
// A new plan may move the touchdown within the region, and the final starts away from it.
constexpr double kPlanShiftM = 1000.0;
// Boxes enclose maps; the touchdown may lie anywhere on a map.
constexpr double kMapHalfSizeM = 500.0;
// Margins above this value count as equal.
constexpr double kPlentyMarginM = 60.0;
// Margins are compared in steps of this size.
constexpr double kMarginStepM = 15.0;
// A site's score halves in this time, because ground changes.
constexpr double kScoreHalfLifeS = 365.0 * 24.0 * 3600.0;
// Scores are compared in steps of this size.
constexpr double kScoreStep = 0.05;

Eigen::Vector2d WayTo(const RecallRow& row, const GeoPoint& place) {
  const double dlon_deg = std::remainder(row.longitude_deg - place.longitude_deg, 360.0);
  const double middle_deg = 0.5 * (row.latitude_deg + place.latitude_deg);
  return {dlon_deg * kMetresPerDegree * std::cos(RadFromDeg(middle_deg)),
          (row.latitude_deg - place.latitude_deg) * kMetresPerDegree};
}

// Nothing if the stored aircraft is invalid by current rules.
std::optional<Aircraft> AircraftOf(const EmergencyRequest& request,
                                   const std::string& aircraft_json) {
  try {
    return AircraftOf(request, ParseAircraft(ParseJson(aircraft_json), "/aircraft"));
  } catch (const ApiError& error) {
    spdlog::error("a stored aircraft cannot be used: {}", error.what());
    return std::nullopt;
  }
}

// Values that all sites of one aircraft share.
struct Glider {
  StraightGlide glide;
  double approach_height_m = 0.0;
};

double StraightMargin(const EmergencyRequest& request,
                      const RecallCandidate& candidate,
                      double within_m,
                      const Glider& glider) {
  const GlideStart start = StartOf(request, {0.0, 0.0, request.place.altitude_m});
  const auto lost = LeastHeightLost(start, candidate.way_m, within_m, glider.glide);
  if (!lost) return -std::numeric_limits<double>::infinity();
  return request.place.altitude_m - candidate.datum.subtracted_m - *lost -
         candidate.row->data.altitude_m - glider.approach_height_m - request.arrival_height_m;
}

std::optional<Glider> GliderOf(const EmergencyRequest& request, const std::string& aircraft_json) {
  const std::optional<Aircraft> aircraft = AircraftOf(request, aircraft_json);
  if (!aircraft) return std::nullopt;
  return Glider{StraightGlideOf(*aircraft), aircraft->approach_height_m};
}

RecallCandidate CandidateOf(const EmergencyRequest& request,
                            const RecallRow& row,
                            const Glider& glider,
                            int64_t now_us) {
  RecallCandidate candidate;
  candidate.row = &row;
  candidate.way_m = WayTo(row, request.place);
  candidate.distance_m = candidate.way_m.norm();
  candidate.datum = DatumDifferenceOf(
      ReferenceOf(request),
      {row.data.altitude_datum, row.latitude_deg, row.longitude_deg, row.flight_id});
  candidate.age_s = std::max(0.0, static_cast<double>(now_us - row.seen_at_us) * 1e-6);
  candidate.score = row.data.score * std::exp2(-candidate.age_s / kScoreHalfLifeS);
  candidate.best_margin_m = StraightMargin(request, candidate, kPlanShiftM, glider);
  candidate.expected_margin_m = StraightMargin(request, candidate, 0.0, glider);
  return candidate;
}

int MarginStep(double margin_m) {
  return static_cast<int>(std::floor(std::clamp(margin_m, -1e6, kPlentyMarginM) / kMarginStepM));
}

// The order in which candidates are evaluated: the most promising first, and the nearest first
// among equals. Candidates out of reach come last, the smallest shortfall first.
bool IsMorePromising(const RecallCandidate& a, const RecallCandidate& b) {
  const bool is_a_in_reach = a.best_margin_m >= 0.0;
  if (is_a_in_reach != (b.best_margin_m >= 0.0)) return is_a_in_reach;
  if (!is_a_in_reach && a.best_margin_m != b.best_margin_m) {
    return a.best_margin_m > b.best_margin_m;
  }
  const auto rank = [](const RecallCandidate& candidate) {
    return std::tuple(-MarginStep(candidate.expected_margin_m),
                      !candidate.row->data.is_landable,
                      -std::floor(candidate.score / kScoreStep),
                      candidate.distance_m,
                      std::string_view(candidate.row->site_id));
  };
  return rank(a) < rank(b);
}

}  // namespace

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

Aircraft AircraftOf(const EmergencyRequest& request, const Aircraft& site_aircraft) {
  return Unpowered(request.aircraft.value_or(site_aircraft), request.glide_ratio);
}

GlideStart StartOf(const EmergencyRequest& request, const Eigen::Vector3d& position_in_world) {
  GlideStart start;
  start.position_in_world = position_in_world;
  if (request.heading_deg) start.heading = RadFromDeg(*request.heading_deg);
  start.wind_in_world = request.wind_in_world;
  return start;
}

double GreatestReach(const EmergencyRequest& request, const RecallBounds& bounds) {
  // If the site has another datum, the altitude may be higher by this value.
  const double height_m =
      std::max(0.0, request.place.altitude_m + kMaxGeoidHeightM - bounds.min_altitude_m);
  const double wind_mps = request.wind_in_world ? request.wind_in_world->norm() : 0.0;
  double reach_m = 0.0;
  for (const std::string& aircraft_json : bounds.aircraft_jsons) {
    const std::optional<Aircraft> aircraft = AircraftOf(request, aircraft_json);
    if (!aircraft) return kMaxReachM;
    const double speed_mps = aircraft->glide_airspeed_mps.value_or(aircraft->landing_airspeed_mps);
    const double aloft_s = height_m * std::hypot(aircraft->glide_ratio, 1.0) / speed_mps;
    reach_m = std::max(reach_m, height_m * aircraft->glide_ratio + wind_mps * aloft_s);
  }
  return std::min(kMaxReachM, reach_m + kPlanShiftM + kMapHalfSizeM);
}

bool IsBetter(double margin_a,
              bool landable_a,
              const RecallCandidate& a,
              double margin_b,
              bool landable_b,
              const RecallCandidate& b) {
  if (MarginStep(margin_a) != MarginStep(margin_b)) {
    return MarginStep(margin_a) > MarginStep(margin_b);
  }
  if (landable_a != landable_b) return landable_a;
  if (a.score != b.score) return a.score > b.score;
  if (a.age_s != b.age_s) return a.age_s < b.age_s;
  return a.row->site_id < b.row->site_id;
}

bool IsSurelyNotBetter(const RecallCandidate& candidate,
                       double margin_of_reached,
                       bool is_reached_landable,
                       const RecallCandidate& reached) {
  return IsBetter(
      margin_of_reached, is_reached_landable, reached, candidate.best_margin_m, true, candidate);
}

std::vector<RecallCandidate> Candidates(const EmergencyRequest& request,
                                        const SharedRows<RecallRow>& rows,
                                        size_t num_first) {
  std::vector<RecallCandidate> candidates;
  candidates.reserve(rows.size());
  std::map<std::string_view, std::optional<Glider>> glider_by_json;
  const int64_t now_us = NowUs();
  for (const auto& row : rows) {
    const std::string& aircraft_json = row->data.aircraft_json;
    auto glider = glider_by_json.find(aircraft_json);
    if (glider == glider_by_json.end()) {
      glider = glider_by_json.emplace(aircraft_json, GliderOf(request, aircraft_json)).first;
    }
    if (!glider->second) continue;
    candidates.push_back(CandidateOf(request, *row, *glider->second, now_us));
  }
  num_first = std::min(candidates.size(), num_first);
  std::partial_sort(candidates.begin(),
                    candidates.begin() + static_cast<std::ptrdiff_t>(num_first),
                    candidates.end(),
                    IsMorePromising);
  return candidates;
}

}  // namespace freelsd
