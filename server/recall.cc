// The rules of emergency recall: what can be reached, and in which order it is told.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string_view>
#include <tuple>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/api.h"
#include "server/emergency.h"
#include "server/stamps.h"
#include "server/terrain_margin.h"

namespace freelsd {
namespace {

constexpr double kMetresPerDegree = 111195.0;  // of latitude, on a sphere
// Sites beyond it are out of any small plane's reach; the box that is searched.
constexpr double kMaxReachM = 100000.0;
// Planning anew may choose another touchdown of the same region, and the final starts elsewhere.
constexpr double kPlanShiftM = 1000.0;
// Boxes are of maps, touchdowns lie somewhere within.
constexpr double kMapHalfSizeM = 500.0;
// More height than this in hand makes no site better than another.
constexpr double kPlentyMarginM = 60.0;
// Margins within one step of it count as equal.
constexpr double kMarginStepM = 15.0;
// A site's score halves in this time: ground changes.
constexpr double kScoreHalfLifeS = 365.0 * 24.0 * 3600.0;
// Scores within one step of it are equally promising.
constexpr double kScoreStep = 0.05;
// Sites that are planned on for one answer, and the time after which no further one is begun.
constexpr size_t kMaxNumPlanned = 40;
constexpr std::chrono::milliseconds kTimeBudget{1500};

struct Candidate {
  RecallRow row;
  double distance_m = 0.0;
  double bearing_deg = 0.0;
  double datum_penalty_m = 0.0;
  double score = 0.0;
  double age_s = 0.0;
  // Never less than the margin that the glide turns out to have.
  double best_margin_m = 0.0;
  // Straight to the site: about what it turns out to have.
  double expected_margin_m = 0.0;
};

struct Reached {
  double margin_m = 0.0;
  bool is_landable = false;
  nlohmann::json answer;
};

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

Eigen::Vector2d WayTo(const RecallRow& row, const GeoPoint& place) {
  const double dlon_deg = std::remainder(row.longitude_deg - place.longitude_deg, 360.0);
  const double middle_deg = 0.5 * (row.latitude_deg + place.latitude_deg);
  return {dlon_deg * kMetresPerDegree * std::cos(RadFromDeg(middle_deg)),
          (row.latitude_deg - place.latitude_deg) * kMetresPerDegree};
}

Aircraft AircraftOf(const EmergencyRequest& request, const Aircraft& site_aircraft) {
  return Unpowered(request.aircraft.value_or(site_aircraft), request.glide_ratio);
}

// Nothing where the stored aircraft is none by today's rules.
std::optional<Aircraft> AircraftOf(const EmergencyRequest& request,
                                   const std::string& aircraft_json) {
  try {
    return AircraftOf(request, ParseAircraft(ParseJson(aircraft_json), "/aircraft"));
  } catch (const ApiError& error) {
    spdlog::error("a stored aircraft cannot be used: {}", error.what());
    return std::nullopt;
  }
}

// No site lies lower, and no aircraft glides farther, than those this is for.
double GreatestReach(const EmergencyRequest& request, const RecallBounds& bounds) {
  const double height_m = std::max(0.0, request.place.altitude_m - bounds.min_altitude_m);
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

GlideStart StartOf(const EmergencyRequest& request, const Eigen::Vector3d& position_in_world) {
  GlideStart start;
  start.position_in_world = position_in_world;
  if (request.heading_deg) start.heading = RadFromDeg(*request.heading_deg);
  start.wind_in_world = request.wind_in_world;
  return start;
}

double StraightMargin(const EmergencyRequest& request,
                      const Candidate& candidate,
                      double within_m,
                      const Aircraft& aircraft) {
  const GlideStart start = StartOf(request, {0.0, 0.0, request.place.altitude_m});
  const auto lost = LeastHeightLost(start, WayTo(candidate.row, request.place), within_m, aircraft);
  if (!lost) return -std::numeric_limits<double>::infinity();
  return request.place.altitude_m - candidate.datum_penalty_m - *lost -
         candidate.row.data.altitude_m - aircraft.approach_height_m;
}

Candidate CandidateOf(const EmergencyRequest& request, RecallRow row, const Aircraft& aircraft) {
  Candidate candidate;
  const Eigen::Vector2d way = WayTo(row, request.place);
  candidate.distance_m = way.norm();
  candidate.bearing_deg = DegFromRad(HeadingOf(way));
  candidate.datum_penalty_m = DatumPenalty(request.altitude_datum, row.data.altitude_datum);
  candidate.age_s = std::max(0.0, static_cast<double>(NowUs() - row.seen_at_us) * 1e-6);
  candidate.score = row.data.score * std::pow(0.5, candidate.age_s / kScoreHalfLifeS);
  candidate.row = std::move(row);
  candidate.best_margin_m = StraightMargin(request, candidate, kPlanShiftM, aircraft);
  candidate.expected_margin_m = StraightMargin(request, candidate, 0.0, aircraft);
  return candidate;
}

int MarginStep(double margin_m) {
  return static_cast<int>(std::floor(std::clamp(margin_m, -1e6, kPlentyMarginM) / kMarginStepM));
}

// Arrival margin, then verdict and score (which has aged), then age.
bool IsBetter(double margin_a,
              bool landable_a,
              const Candidate& a,
              double margin_b,
              bool landable_b,
              const Candidate& b) {
  if (MarginStep(margin_a) != MarginStep(margin_b)) {
    return MarginStep(margin_a) > MarginStep(margin_b);
  }
  if (landable_a != landable_b) return landable_a;
  if (a.score != b.score) return a.score > b.score;
  if (a.age_s != b.age_s) return a.age_s < b.age_s;
  return a.row.site_id < b.row.site_id;
}

// The order in which candidates are looked at: what is promising first, and of what is equally so
// the nearest. What is out of reach comes last, least far out first.
bool IsMorePromising(const Candidate& a, const Candidate& b) {
  const bool is_a_in_reach = a.best_margin_m >= 0.0;
  if (is_a_in_reach != (b.best_margin_m >= 0.0)) return is_a_in_reach;
  if (!is_a_in_reach && a.best_margin_m != b.best_margin_m) {
    return a.best_margin_m > b.best_margin_m;
  }
  const auto rank = [](const Candidate& candidate) {
    return std::tuple(-MarginStep(candidate.expected_margin_m),
                      !candidate.row.data.is_landable,
                      -std::floor(candidate.score / kScoreStep),
                      candidate.distance_m,
                      std::string_view(candidate.row.site_id));
  };
  return rank(a) < rank(b);
}

std::vector<Candidate> Candidates(const Service& service,
                                  const EmergencyRequest& request,
                                  double reach_m) {
  std::vector<Candidate> candidates;
  std::map<std::string, std::optional<Aircraft>> aircraft_by_json;
  std::set<std::string> ids;
  for (RecallRow& row : service.storage.ListRecallable(BoxAround(request.place, reach_m))) {
    if (!ids.insert(row.site_id).second) continue;
    auto aircraft = aircraft_by_json.find(row.data.aircraft_json);
    if (aircraft == aircraft_by_json.end()) {
      aircraft = aircraft_by_json
                     .emplace(row.data.aircraft_json, AircraftOf(request, row.data.aircraft_json))
                     .first;
    }
    if (!aircraft->second) continue;
    candidates.push_back(CandidateOf(request, std::move(row), *aircraft->second));
  }
  std::sort(candidates.begin(), candidates.end(), IsMorePromising);
  return candidates;
}

nlohmann::json PlaceOf(const GeoPoint& place) {
  return {{"latitude_deg", place.latitude_deg},
          {"longitude_deg", place.longitude_deg},
          {"altitude_m", place.altitude_m}};
}

nlohmann::json ApproachOf(const Plan& plan, const FlightContext& context) {
  nlohmann::json approach = PlanProperties(plan, context)["approach"];
  approach["start"] =
      PlaceOf(context.local_frame.GeoFromWorld(plan.approach->approach_start_in_world));
  approach["loiter_center"] =
      PlaceOf(context.local_frame.GeoFromWorld(plan.approach->loiter_center_in_world));
  return approach;
}

nlohmann::json AnswerOf(const Candidate& candidate,
                        const Plan& plan,
                        const Aircraft& aircraft,
                        const Glide& glide,
                        const FlightContext& context) {
  const GeoPoint touchdown = context.local_frame.GeoFromWorld(plan.touchdown_in_world);
  return {{"site_id", candidate.row.site_id},
          {"flight_id", candidate.row.flight_id},
          {"verdict", plan.verdict == Verdict::kLandable ? "landable" : "unverified"},
          {"unseen_ratio", plan.approach->unseen_ratio},
          {"distance_m", candidate.distance_m},
          {"bearing_deg", candidate.bearing_deg},
          {"datum_penalty_m", candidate.datum_penalty_m},
          {"time_s", glide.time_s},
          {"score", candidate.score},
          {"score_when_stored", candidate.row.data.score},
          {"age_s", candidate.age_s},
          {"updated_at", Rfc3339(candidate.row.updated_at_us)},
          {"last_seen_at", Rfc3339(candidate.row.seen_at_us)},
          {"altitude_datum", candidate.row.data.altitude_datum},
          {"aircraft", AircraftJson(aircraft)},
          {"warnings", LimitsWarnings(aircraft)},
          {"touchdown", PlaceOf(touchdown)},
          {"approach", ApproachOf(plan, context)}};
}

// Nothing where the stored map has no approach in this wind, or the wind lets nobody get there.
std::optional<Reached> Reach(const Service& service,
                             const EmergencyRequest& request,
                             const Candidate& candidate) {
  const auto site =
      service.maps.Get(service.storage, candidate.row.site_id, candidate.row.updated_at_us);
  if (!site) return std::nullopt;
  const FlightRequest& flight = site->replan.flight;
  const Aircraft aircraft = AircraftOf(request, flight.aircraft);
  const auto kept_plan = service.maps.PlanFor(site, aircraft, request.wind_in_world);
  const Plan& plan = *kept_plan;
  if (plan.verdict == Verdict::kRejected || !plan.approach) return std::nullopt;
  const FlightContext context{
      site->row.flight_id, flight.altitude_datum, LocalFrame(site->replan.origin)};
  const Eigen::Vector3d& approach_start = plan.approach->approach_start_in_world;
  const Eigen::Vector3d here = context.local_frame.WorldFromGeo(request.place);
  const auto glide = GlideTo(
      StartOf(request, here), approach_start, plan.approach->heading, aircraft, GlideOptions{});
  if (!glide) return std::nullopt;
  Reached reached;
  reached.is_landable = plan.verdict == Verdict::kLandable;
  reached.margin_m = glide->arrival_height_m - approach_start.z() - candidate.datum_penalty_m;
  GeoPoint end = context.local_frame.GeoFromWorld(approach_start);
  end.altitude_m += glide->arrival_height_m - approach_start.z();
  reached.answer = AnswerOf(candidate, plan, aircraft, *glide, context);
  if (const auto terrain = TerrainMargin(service, request, end)) {
    reached.answer["terrain_margin_m"] = *terrain;
    reached.margin_m = std::min(reached.margin_m, *terrain);
  }
  reached.answer["arrival_margin_m"] = reached.margin_m;
  reached.answer["reachable"] = reached.margin_m >= 0.0;
  return reached;
}

std::vector<std::string> WarningsOf(const EmergencyRequest& request,
                                    const std::vector<Candidate>& candidates) {
  std::vector<std::string> warnings;
  const GlideOptions options;
  const bool is_penalised =
      std::any_of(candidates.begin(), candidates.end(), [](const Candidate& candidate) {
        return candidate.datum_penalty_m > 0.0;
      });
  if (is_penalised || request.altitude_datum == "unknown") {
    warnings.push_back("the altitude's datum is unknown or not that of every site: " +
                       std::to_string(std::lround(options.datum_penalty_m)) +
                       " m are taken off the arrival margin where it is (datum_penalty_m)");
  }
  if (!request.wind_in_world) {
    warnings.push_back(
        "no wind is given: the worst direction of a wind of 5.5 m/s is assumed, and "
        "approaches are planned for an unknown wind");
  }
  if (!request.heading_deg) warnings.push_back("no heading is given: the worst turn is assumed");
  warnings.push_back(
      "terrain on the way is known only where stored maps cover it (terrain_margin_m)");
  return warnings;
}

struct Ranked {
  const Candidate* candidate = nullptr;
  Reached reached;
};

struct Search {
  std::vector<Ranked> reachable;
  std::optional<Ranked> nearest_miss;
  size_t num_without_approach = 0;
  bool is_cut_short = false;
};

Search SearchAmong(const Service& service,
                   const EmergencyRequest& request,
                   const std::vector<Candidate>& candidates) {
  const auto begin = std::chrono::steady_clock::now();
  Search search;
  size_t num_planned = 0;
  for (const Candidate& candidate : candidates) {
    if (search.reachable.size() >= request.limit) break;
    // Nothing behind it can be reached either; the first of them may be the nearest miss.
    const bool is_out_of_reach = candidate.best_margin_m < 0.0;
    if (is_out_of_reach && (search.nearest_miss || !search.reachable.empty())) break;
    search.is_cut_short =
        num_planned >= kMaxNumPlanned ||
        (num_planned > 0 && std::chrono::steady_clock::now() - begin > kTimeBudget);
    if (search.is_cut_short) break;
    ++num_planned;
    std::optional<Reached> reached = Reach(service, request, candidate);
    if (!reached) {
      ++search.num_without_approach;
    } else if (reached->margin_m >= 0.0) {
      search.reachable.push_back({&candidate, std::move(*reached)});
    } else if (!search.nearest_miss || reached->margin_m > search.nearest_miss->reached.margin_m) {
      search.nearest_miss = Ranked{&candidate, std::move(*reached)};
    }
  }
  return search;
}

}  // namespace

nlohmann::json RecallSites(const Service& service, const EmergencyRequest& request) {
  double reach_m = GreatestReach(request, service.storage.BoundsOfRecallable());
  std::vector<Candidate> candidates = Candidates(service, request, reach_m);
  Search search = SearchAmong(service, request, candidates);
  // Nothing can be reached: how near the nearest miss is, is looked for ever farther out.
  while (search.reachable.empty() && !search.nearest_miss && !search.is_cut_short &&
         reach_m < kMaxReachM) {
    reach_m = std::min(kMaxReachM, 3.0 * reach_m);
    candidates = Candidates(service, request, reach_m);
    search = SearchAmong(service, request, candidates);
  }
  std::sort(search.reachable.begin(), search.reachable.end(), [](const Ranked& a, const Ranked& b) {
    return IsBetter(a.reached.margin_m,
                    a.reached.is_landable,
                    *a.candidate,
                    b.reached.margin_m,
                    b.reached.is_landable,
                    *b.candidate);
  });
  nlohmann::json answer{{"sites", nlohmann::json::array()}};
  for (Ranked& ranked : search.reachable) {
    ranked.reached.answer["rank"] = answer["sites"].size() + 1;
    answer["sites"].push_back(std::move(ranked.reached.answer));
  }
  if (search.reachable.empty() && search.nearest_miss) {
    answer["nearest_miss"] = search.nearest_miss->reached.answer;
    answer["nearest_miss"]["missing_m"] = -search.nearest_miss->reached.margin_m;
  }
  std::vector<std::string> warnings = WarningsOf(request, candidates);
  if (search.num_without_approach > 0) {
    warnings.push_back(std::to_string(search.num_without_approach) +
                       " nearer stored sites have no approach in this wind");
  }
  if (const int64_t count = service.storage.CountOverruled(BoxAround(request.place, reach_m))) {
    warnings.push_back(std::to_string(count) +
                       " sites hereabouts are left out: a later look at their ground rejects it");
  }
  if (search.is_cut_short) warnings.push_back("not every stored site in reach was looked at");
  answer["warnings"] = warnings;
  return answer;
}

}  // namespace freelsd
