#include "server/recall/recall_sites.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/http/http.h"
#include "server/recall/descent_path.h"
#include "server/recall/recall_candidates.h"
#include "server/recall/same_place.h"
#include "server/recall/terrain_margin.h"

namespace freelsd {
namespace {

// Limits of one answer: the number of sites to plan on, and the time after which no plan is begun.
constexpr size_t kMaxNumPlanned = 40;
// One more candidate is ranked than is planned for. It shows whether there are more.
constexpr size_t kNumRanked = kMaxNumPlanned + 1;
constexpr std::chrono::milliseconds kTimeBudget{1500};

// NOLINTNEXTLINE(bugprone-exception-escape): an empty json throws nothing.
struct Reached {
  double margin_m = 0.0;
  bool is_landable = false;
  Landing landing;
  // How the datums of the site and of the terrain below the way were compared.
  std::set<DatumBasis> datum_bases;
  nlohmann::json answer;
};

// Removes duplicates: a box that crosses the antimeridian is read in two parts.
SharedRows<RecallRow> RowsWithin(const StoredSites& stored,
                                 const EmergencyRequest& request,
                                 double reach_m) {
  const BoundingBox box = BoxAround(request.place, reach_m);
  SharedRows<RecallRow> rows = stored.storage.sites.ListRecallable(box);
  if (box.west_deg > box.east_deg) {
    std::set<std::string> ids;
    std::erase_if(rows, [&ids](const auto& row) { return !ids.insert(row->site_id).second; });
  }
  return rows;
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

// In [0, 360).
double BearingDeg(const Eigen::Vector2d& way) {
  const double bearing_deg = DegFromRad(HeadingOf(way));
  return bearing_deg < 0.0 ? bearing_deg + 360.0 : bearing_deg;
}

nlohmann::json AnswerOf(const RecallCandidate& candidate,
                        const Plan& plan,
                        const Aircraft& aircraft,
                        const Glide& glide,
                        const FlightContext& context,
                        const GeoPoint& place) {
  const GeoPoint touchdown = context.local_frame.GeoFromWorld(plan.touchdown_in_world);
  const Eigen::Vector2d way = LocalFrame(place).WorldFromGeo(touchdown).head<2>();
  nlohmann::json answer{{"site_id", candidate.row->site_id},
                        {"flight_id", candidate.row->flight_id},
                        {"verdict", plan.verdict == Verdict::kLandable ? "landable" : "unverified"},
                        {"unseen_ratio", plan.approach->unseen_ratio},
                        {"distance_m", way.norm()},
                        {"bearing_deg", BearingDeg(way)},
                        {"datum_penalty_m", candidate.datum.subtracted_m},
                        {"time_s", glide.time_s},
                        {"score", candidate.score},
                        {"score_when_stored", candidate.row->data.score},
                        {"age_s", candidate.age_s},
                        {"updated_at", Rfc3339(candidate.row->updated_at_us)},
                        {"last_seen_at", Rfc3339(candidate.row->seen_at_us)},
                        {"altitude_datum", candidate.row->data.altitude_datum},
                        {"aircraft", AircraftJson(aircraft)},
                        {"warnings", LimitsWarnings(aircraft)},
                        {"touchdown", PlaceOf(touchdown)},
                        {"approach", ApproachOf(plan, context)}};
  if (plan.approach->ground_speed) answer["ground_speed_mps"] = *plan.approach->ground_speed;
  return answer;
}

// Nothing if the map has no approach in this wind, or if the wind is too strong to get there.
std::optional<Reached> Reach(const StoredSites& stored,
                             const EmergencyRequest& request,
                             const RecallCandidate& candidate) {
  const auto site =
      stored.maps.Get(stored.storage, candidate.row->site_id, candidate.row->updated_at_us);
  if (!site) return std::nullopt;
  const FlightRequest& flight = site->replan.flight;
  const Aircraft aircraft = AircraftOf(request, flight.aircraft);
  const auto kept_plan = stored.maps.PlanFor(site, aircraft, request.wind_in_world);
  const Plan& plan = *kept_plan;
  if (plan.verdict == Verdict::kRejected || !plan.approach) return std::nullopt;
  const FlightContext context{site->row.flight_id,
                              flight.altitude_datum.value_or("unknown"),
                              LocalFrame(site->replan.origin)};
  const Eigen::Vector3d& approach_start = plan.approach->approach_start_in_world;
  GeoPoint place_in_site_datum = request.place;
  place_in_site_datum.altitude_m -= candidate.datum.subtracted_m;
  const Eigen::Vector3d here = context.local_frame.WorldFromGeo(place_in_site_datum);
  const GlideStart start = StartOf(request, here);
  const GlideOptions options;
  const auto glide = GlideTo(start, approach_start, plan.approach->heading, aircraft, options);
  if (!glide) return std::nullopt;
  const auto descent = PlanDescent(start, *plan.approach, aircraft, options);
  Reached reached;
  reached.is_landable = plan.verdict == Verdict::kLandable;
  reached.landing = LandingOf(context.local_frame.GeoFromWorld(plan.touchdown_in_world),
                              plan.approach->heading,
                              request.wind_in_world);
  reached.margin_m = glide->arrival_height_m - approach_start.z() - request.arrival_height_m;
  reached.answer = AnswerOf(candidate, plan, aircraft, *glide, context, request.place);
  reached.datum_bases = {candidate.datum.basis};
  std::vector<GeoPoint> unchecked{
      place_in_site_datum,
      context.local_frame.GeoFromWorld(
          {approach_start.x(), approach_start.y(), glide->arrival_height_m})};
  if (descent) {
    unchecked = UncheckedPath(*descent, *glide, context.local_frame);
    AddDescent(*descent, context.local_frame, reached.answer);
  }
  for (GeoPoint& point : unchecked) point.altitude_m += candidate.datum.subtracted_m;
  if (const auto terrain = TerrainMarginOf(stored, request, unchecked)) {
    reached.answer["terrain_margin_m"] = terrain->margin_m;
    reached.answer["terrain_datum_penalty_m"] = terrain->datum.subtracted_m;
    reached.margin_m = std::min(reached.margin_m, terrain->margin_m);
    reached.datum_bases.insert(terrain->datum.basis);
  }
  reached.answer["arrival_margin_m"] = reached.margin_m;
  reached.answer["reachable"] = reached.margin_m >= 0.0;
  return reached;
}

std::vector<std::string> DatumWarnings(const EmergencyRequest& request,
                                       const std::set<DatumBasis>& bases) {
  std::vector<std::string> warnings;
  const bool is_unknown = request.altitude_datum.value_or("unknown") == "unknown";
  if (bases.contains(DatumBasis::kUnknown) || (is_unknown && !request.flight_id)) {
    warnings.emplace_back(
        "the datum of the altitude, or of stored sites or maps, is unknown: the height of the "
        "geoid "
        "is subtracted there (datum_penalty_m, terrain_datum_penalty_m)");
  }
  if (bases.contains(DatumBasis::kNoGeoid)) {
    warnings.push_back(
        "the height of the geoid is unknown, because PROJ has no grid egm96_15.gtx: " +
        std::to_string(std::lround(GlideOptions{}.datum_penalty_m)) +
        " m are subtracted where datums differ or are unknown");
  }
  return warnings;
}

std::vector<std::string> WarningsOf(const EmergencyRequest& request,
                                    const std::set<DatumBasis>& bases) {
  std::vector<std::string> warnings = DatumWarnings(request, bases);
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
  const RecallCandidate* candidate = nullptr;
  Reached reached;
};

bool IsBefore(const Ranked& a, const Ranked& b) {
  return IsBetter(a.reached.margin_m,
                  a.reached.is_landable,
                  *a.candidate,
                  b.reached.margin_m,
                  b.reached.is_landable,
                  *b.candidate);
}

// The best `limit` of different places, best first. `ranked` is sorted.
std::vector<const Ranked*> DifferentPlaces(const std::vector<Ranked>& ranked, size_t limit) {
  std::vector<const Ranked*> different;
  for (const Ranked& each : ranked) {
    if (different.size() >= limit) break;
    const bool is_known = std::any_of(different.begin(), different.end(), [&](const Ranked* other) {
      return IsSamePlace(each.reached.landing, other->reached.landing);
    });
    if (!is_known) different.push_back(&each);
  }
  return different;
}

struct Search {
  // How the datums were compared: for all candidates, and for the terrain below the ways that were
  // evaluated.
  std::set<DatumBasis> datum_bases;
  // Best first.
  std::vector<Ranked> reachable;
  std::optional<Ranked> nearest_miss;
  size_t num_without_approach = 0;
  bool is_cut_short = false;
};

// True if no candidate from `next` on can change the answer. An answer with a smaller limit is
// therefore always the beginning of an answer with a larger limit.
bool IsSettled(const std::vector<Ranked>& reachable,
               size_t limit,
               const std::vector<RecallCandidate>& candidates,
               size_t next) {
  const std::vector<const Ranked*> answer = DifferentPlaces(reachable, limit);
  if (answer.size() < limit) return false;
  const Ranked& last = *answer.back();
  return std::all_of(
      candidates.begin() + static_cast<std::ptrdiff_t>(next),
      candidates.end(),
      [&last](const RecallCandidate& candidate) {
        return IsSurelyNotBetter(
            candidate, last.reached.margin_m, last.reached.is_landable, *last.candidate);
      });
}

Search SearchAmong(const StoredSites& stored,
                   const EmergencyRequest& request,
                   const std::vector<RecallCandidate>& candidates) {
  const auto begin = std::chrono::steady_clock::now();
  Search search;
  for (const RecallCandidate& candidate : candidates) {
    search.datum_bases.insert(candidate.datum.basis);
  }
  size_t num_planned = 0;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const RecallCandidate& candidate = candidates[i];
    if (IsSettled(search.reachable, request.limit, candidates, i)) break;
    // All later candidates are out of reach too. The first of them may be the nearest miss.
    const bool is_out_of_reach = candidate.best_margin_m < 0.0;
    if (is_out_of_reach && (search.nearest_miss || !search.reachable.empty())) break;
    search.is_cut_short =
        num_planned >= kMaxNumPlanned ||
        (num_planned > 0 && std::chrono::steady_clock::now() - begin > kTimeBudget);
    if (search.is_cut_short) break;
    ++num_planned;
    std::optional<Reached> reached = Reach(stored, request, candidate);
    if (reached) search.datum_bases.merge(reached->datum_bases);
    if (!reached) {
      ++search.num_without_approach;
    } else if (reached->margin_m >= 0.0) {
      Ranked ranked{&candidate, std::move(*reached)};
      const auto place =
          std::upper_bound(search.reachable.begin(), search.reachable.end(), ranked, IsBefore);
      search.reachable.insert(place, std::move(ranked));
    } else if (!search.nearest_miss || reached->margin_m > search.nearest_miss->reached.margin_m) {
      search.nearest_miss = Ranked{&candidate, std::move(*reached)};
    }
  }
  return search;
}

}  // namespace

nlohmann::json RecallSites(const StoredSites& stored, const EmergencyRequest& request) {
  double reach_m = GreatestReach(request, stored.storage.sites.BoundsOfRecallable());
  SharedRows<RecallRow> rows = RowsWithin(stored, request, reach_m);
  std::vector<RecallCandidate> candidates = Candidates(request, rows, kNumRanked);
  Search search = SearchAmong(stored, request, candidates);
  // If nothing is in reach, the box grows until it contains a nearest miss.
  while (search.reachable.empty() && !search.nearest_miss && !search.is_cut_short &&
         reach_m < kMaxReachM) {
    reach_m = std::min(kMaxReachM, 3.0 * reach_m);
    rows = RowsWithin(stored, request, reach_m);
    candidates = Candidates(request, rows, kNumRanked);
    search = SearchAmong(stored, request, candidates);
  }
  nlohmann::json answer{{"sites", nlohmann::json::array()}};
  for (const Ranked* ranked : DifferentPlaces(search.reachable, request.limit)) {
    answer["sites"].push_back(ranked->reached.answer);
    answer["sites"].back()["rank"] = answer["sites"].size();
  }
  if (search.reachable.empty() && search.nearest_miss) {
    answer["nearest_miss"] = search.nearest_miss->reached.answer;
    answer["nearest_miss"]["missing_m"] = -search.nearest_miss->reached.margin_m;
  }
  std::vector<std::string> warnings = WarningsOf(request, search.datum_bases);
  if (search.num_without_approach > 0) {
    warnings.push_back(std::to_string(search.num_without_approach) +
                       " nearer stored sites have no approach in this wind");
  }
  if (const int64_t count =
          stored.storage.sites.CountOverruled(BoxAround(request.place, reach_m))) {
    warnings.push_back(std::to_string(count) +
                       " sites nearby are left out: their stored approach fails on a later map");
  }
  if (search.is_cut_short) warnings.push_back("not every stored site in reach was evaluated");
  answer["warnings"] = warnings;
  return answer;
}

}  // namespace freelsd
