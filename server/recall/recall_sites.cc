#include "server/recall/recall_sites.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/http/http.h"
#include "server/recall/descent_path.h"
#include "server/recall/obstacles/obstacles.h"
#include "server/recall/recall_candidates.h"
#include "server/recall/same_place.h"

namespace freelsd {
namespace {

// Limits of one answer: the number of sites to plan on, and the time after which no plan is begun.
constexpr size_t kMaxNumPlanned = 40;
// Candidates that are put in order at a time.
constexpr size_t kNumSorted = kMaxNumPlanned + 1;
constexpr std::chrono::milliseconds kTimeBudget{1500};

struct Reached {
  double margin_m = 0.0;
  bool is_landable = false;
  Landing landing;
  // How the datums of the site and of the terrain below the way were compared.
  std::set<DatumBasis> datum_bases;
  DescentTask task;
  // Nothing if the final is out of reach.
  std::optional<Descent> shortest;
  // Along the shortest path.
  std::optional<TerrainMargin> terrain;
  PathObstacles obstacles;
};

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
                        const DescentTask& task,
                        const GeoPoint& place) {
  const Plan& plan = *task.plan;
  const FlightContext context{
      candidate.row->flight_id, candidate.row->data.altitude_datum, task.local_frame};
  const GeoPoint touchdown = task.local_frame.GeoFromWorld(plan.touchdown_in_world);
  const Eigen::Vector2d way = LocalFrame(place).WorldFromGeo(touchdown).head<2>();
  nlohmann::json answer{{"site_id", candidate.row->site_id},
                        {"flight_id", candidate.row->flight_id},
                        {"verdict", plan.verdict == Verdict::kLandable ? "landable" : "unverified"},
                        {"unseen_ratio", plan.approach->unseen_ratio},
                        {"distance_m", way.norm()},
                        {"bearing_deg", BearingDeg(way)},
                        {"datum_penalty_m", candidate.datum.subtracted_m},
                        {"time_s", task.worst.time_s},
                        {"score", candidate.score},
                        {"score_when_stored", candidate.row->data.score},
                        {"age_s", candidate.age_s},
                        {"updated_at", Rfc3339(candidate.row->updated_at_us)},
                        {"last_seen_at", Rfc3339(candidate.row->seen_at_us)},
                        {"altitude_datum", candidate.row->data.altitude_datum},
                        {"aircraft", AircraftJson(task.aircraft)},
                        {"warnings", LimitsWarnings(task.aircraft)},
                        {"touchdown", PlaceOf(touchdown)},
                        {"approach", ApproachOf(plan, context)}};
  if (plan.approach->ground_speed) answer["ground_speed_mps"] = *plan.approach->ground_speed;
  return answer;
}

// Without the terrain on the way, which can only make it worse. Nothing if the map has no approach
// in this wind, or if the wind is too strong to get there.
std::optional<Reached> ReachIgnoringTerrain(const StoredSites& stored,
                                            const EmergencyRequest& request,
                                            const RecallCandidate& candidate) {
  const Aircraft& aircraft = candidate.gliding->aircraft;
  const auto kept = stored.maps.PlanOf(
      stored.storage, *candidate.row, aircraft, candidate.gliding->key, request.wind_in_world);
  if (!kept) return std::nullopt;
  const auto& plan = kept->plan;
  if (plan->verdict == Verdict::kRejected || !plan->approach) return std::nullopt;
  const Approach& approach = *plan->approach;
  const LocalFrame local_frame(kept->origin);
  GeoPoint place_in_site_datum = request.place;
  place_in_site_datum.altitude_m -= candidate.datum.subtracted_m;
  const GlideStart start = StartOf(request, local_frame.WorldFromGeo(place_in_site_datum));
  const auto glide =
      GlideTo(start, approach.approach_start_in_world, approach.heading, aircraft, {});
  if (!glide) return std::nullopt;
  const double margin_m =
      glide->arrival_height_m - approach.approach_start_in_world.z() - request.arrival_height_m;
  return Reached{.margin_m = margin_m,
                 .is_landable = plan->verdict == Verdict::kLandable,
                 .landing = LandingOf(local_frame.GeoFromWorld(plan->touchdown_in_world),
                                      approach.heading,
                                      request.wind_in_world),
                 .datum_bases = {candidate.datum.basis},
                 .task = {start, plan, aircraft, *glide, local_frame, candidate.datum.subtracted_m},
                 .shortest = std::nullopt,
                 .terrain = std::nullopt,
                 .obstacles = {}};
}

// Terrain and obstacles on the shortest path.
void CheckPath(const StoredSites& stored, const EmergencyRequest& request, Reached& reached) {
  const DescentTask& task = reached.task;
  reached.shortest = PlanDescent(task.start, *task.plan->approach, task.aircraft, {});
  reached.obstacles = ShortestPathObstacles(stored, request, task, reached.shortest);
  if (const auto& obstacle = reached.obstacles.least) {
    reached.margin_m = std::min(reached.margin_m, obstacle->margin_m);
  }
  reached.terrain = ShortestTerrainMargin(stored, request, task, reached.shortest);
  if (!reached.terrain) return;
  reached.margin_m = std::min(reached.margin_m, reached.terrain->margin_m);
  reached.datum_bases.insert(reached.terrain->datum.basis);
}

// A site of the answer, and the datums that it depends on.
struct ToldSite {
  nlohmann::json answer;
  std::set<DatumBasis> datum_bases;
};

// Planning its path takes longer than choosing the site: sites that are not told need none.
ToldSite Tell(const StoredSites& stored,
              const EmergencyRequest& request,
              const RecallCandidate& candidate,
              const Reached& reached) {
  ToldSite told{AnswerOf(candidate, reached.task, request.place), reached.datum_bases};
  told.answer["arrival_margin_m"] = reached.margin_m;
  told.answer["reachable"] = reached.margin_m >= 0.0;
  std::optional<TerrainMargin> terrain = reached.terrain;
  PathObstacles obstacles = reached.obstacles;
  if (reached.shortest) {
    const ToldPath path = PathToTell(stored,
                                     request,
                                     candidate,
                                     reached.task,
                                     {*reached.shortest, reached.terrain, reached.obstacles, 0.0});
    AddPath(path, reached.task.local_frame, told.answer);
    terrain = path.terrain;
    obstacles = path.obstacles;
  }
  AddObstacles(obstacles, told.answer);
  if (!reached.shortest && reached.margin_m >= 0.0) {
    told.answer["warnings"].push_back(
        "no path is given: the margin counts on the longest turns, but no single path was found");
  }
  if (terrain) {
    told.answer["terrain_margin_m"] = terrain->margin_m;
    told.answer["terrain_datum_penalty_m"] = terrain->datum.subtracted_m;
    told.datum_bases.insert(terrain->datum.basis);
  }
  return told;
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

// Airspaces rank a site last. They never hide it.
bool IsInAirspace(const Ranked& ranked) { return !ranked.reached.obstacles.airspaces.empty(); }

bool IsBefore(const Ranked& a, const Ranked& b) {
  if (IsInAirspace(a) != IsInAirspace(b)) return IsInAirspace(b);
  return IsBetter(a.reached.margin_m,
                  a.reached.is_landable,
                  *a.candidate,
                  b.reached.margin_m,
                  b.reached.is_landable,
                  *b.candidate);
}

// Indices of the best `limit` of different places, best first. `ranked` is sorted.
std::vector<size_t> DifferentPlaces(const std::vector<Ranked>& ranked, size_t limit) {
  std::vector<size_t> different;
  for (size_t i = 0; i < ranked.size() && different.size() < limit; ++i) {
    const bool is_known = std::any_of(different.begin(), different.end(), [&](size_t other) {
      return IsSamePlace(ranked[i].reached.landing, ranked[other].reached.landing);
    });
    if (!is_known) different.push_back(i);
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

// The last site of the answer so far; nothing if there is room for more. A candidate that does not
// rank before it cannot change the answer: a smaller limit gives the beginning of what a larger one
// gives.
const Ranked* LastOf(const std::vector<Ranked>& reachable, size_t limit) {
  const std::vector<size_t> answer = DifferentPlaces(reachable, limit);
  return answer.size() < limit ? nullptr : &reachable[answer.back()];
}

bool CanChange(const Ranked* last, const RecallCandidate& candidate) {
  return last == nullptr || IsInAirspace(*last) ||
         !IsSurelyNotBetter(
             candidate, last->reached.margin_m, last->reached.is_landable, *last->candidate);
}

void Add(Ranked ranked, Search& search) {
  std::optional<Ranked>& miss = search.nearest_miss;
  if (ranked.reached.margin_m >= 0.0) {
    const auto place =
        std::upper_bound(search.reachable.begin(), search.reachable.end(), ranked, IsBefore);
    search.reachable.insert(place, std::move(ranked));
  } else if (!miss || ranked.reached.margin_m > miss->reached.margin_m) {
    miss = std::move(ranked);
  }
}

// Plans on the candidate's map, which costs most of the time of an answer.
void Evaluate(const StoredSites& stored,
              const EmergencyRequest& request,
              const RecallCandidate& candidate,
              const Ranked* last,
              Search& search) {
  std::optional<Reached> reached = ReachIgnoringTerrain(stored, request, candidate);
  if (!reached) {
    ++search.num_without_approach;
    return;
  }
  Ranked ranked{&candidate, std::move(*reached)};
  if (last != nullptr && !IsBefore(ranked, *last)) return;
  CheckPath(stored, request, ranked.reached);
  search.datum_bases.merge(std::set(ranked.reached.datum_bases));
  Add(std::move(ranked), search);
}

// Puts `candidates` in order as far as needed. The result points to them.
Search SearchAmong(const StoredSites& stored,
                   const EmergencyRequest& request,
                   std::vector<RecallCandidate>& candidates) {
  const auto begin = std::chrono::steady_clock::now();
  Search search;
  for (const RecallCandidate& candidate : candidates) {
    search.datum_bases.insert(candidate.datum.basis);
  }
  size_t num_planned = 0;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const Ranked* const last = LastOf(search.reachable, request.limit);
    if (i % kNumSorted == 0) {
      const bool is_settled = std::none_of(
          candidates.begin() + static_cast<std::ptrdiff_t>(i),
          candidates.end(),
          [&](const RecallCandidate& candidate) { return CanChange(last, candidate); });
      if (is_settled) break;
      SortNext(candidates, i, kNumSorted);
    }
    const RecallCandidate& candidate = candidates[i];
    if (!CanChange(last, candidate)) continue;
    // All later candidates are out of reach too. The first of them may be the nearest miss.
    const bool is_out_of_reach = candidate.best_margin_m < 0.0;
    if (is_out_of_reach && (search.nearest_miss || !search.reachable.empty())) break;
    search.is_cut_short =
        num_planned >= kMaxNumPlanned ||
        (num_planned > 0 && std::chrono::steady_clock::now() - begin > kTimeBudget);
    if (search.is_cut_short) break;
    ++num_planned;
    Evaluate(stored, request, candidate, last, search);
  }
  return search;
}

}  // namespace

nlohmann::json RecallSites(const StoredSites& stored, const EmergencyRequest& request) {
  double reach_m = GreatestReach(request, stored.storage.sites.BoundsOfRecallable());
  const SiteStore& sites = stored.storage.sites;
  SharedRows<RecallRow> rows = sites.ListRecallable(BoxAround(request.place, reach_m));
  std::vector<RecallCandidate> candidates = Candidates(request, rows);
  Search search = SearchAmong(stored, request, candidates);
  // If nothing is in reach, the box grows until it contains a nearest miss.
  while (search.reachable.empty() && !search.nearest_miss && !search.is_cut_short &&
         reach_m < kMaxReachM) {
    reach_m = std::min(kMaxReachM, 3.0 * reach_m);
    rows = sites.ListRecallable(BoxAround(request.place, reach_m));
    candidates = Candidates(request, rows);
    search = SearchAmong(stored, request, candidates);
  }
  nlohmann::json answer{{"sites", nlohmann::json::array()}};
  const auto tell = [&](const Ranked& ranked) {
    ToldSite told = Tell(stored, request, *ranked.candidate, ranked.reached);
    search.datum_bases.merge(told.datum_bases);
    return std::move(told.answer);
  };
  for (const size_t index : DifferentPlaces(search.reachable, request.limit)) {
    answer["sites"].push_back(tell(search.reachable[index]));
    answer["sites"].back()["rank"] = answer["sites"].size();
  }
  if (search.reachable.empty() && search.nearest_miss) {
    answer["nearest_miss"] = tell(*search.nearest_miss);
    answer["nearest_miss"]["missing_m"] = -search.nearest_miss->reached.margin_m;
  }
  std::vector<std::string> warnings = WarningsOf(request, search.datum_bases);
  if (search.num_without_approach > 0) {
    warnings.push_back(std::to_string(search.num_without_approach) +
                       " nearer stored sites have no approach in this wind that clears terrain "
                       "and obstacles");
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
