#include "server/recall/site_search.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "server/recall/recall_candidates.h"

namespace freelsd {
namespace {

// The number of sites to plan on for one answer.
constexpr size_t kMaxNumPlanned = 40;
// Candidates that are put in order at a time.
constexpr size_t kNumSorted = kMaxNumPlanned + 1;

// An old wind makes nothing landable.
std::shared_ptr<const Plan> PlanIn(const EmergencyRequest& request,
                                   const std::shared_ptr<const Plan>& plan) {
  if (!request.is_wind_old || plan->verdict != Verdict::kLandable) return plan;
  auto unverified = std::make_shared<Plan>(*plan);
  unverified->verdict = Verdict::kUnverified;
  return unverified;
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
  const auto plan = PlanIn(request, kept->plan);
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
                 .margin_in_free_air_m = margin_m,
                 .is_doubted = candidate.row->doubt || !plan->reject_detail.empty(),
                 .is_landable = plan->verdict == Verdict::kLandable && !candidate.row->doubt,
                 .landing = LandingOf(local_frame.GeoFromWorld(plan->touchdown_in_world),
                                      approach.heading,
                                      request.wind_in_world),
                 .datum_bases = {candidate.datum.basis},
                 .task = {start, plan, aircraft, *glide, local_frame, candidate.datum.subtracted_m},
                 .path = {}};
}

// Terrain and obstacles on the shortest path.
void CheckShortest(const StoredSites& stored, const EmergencyRequest& request, Reached& reached) {
  reached.path = ShortestPath(stored, request, reached.task);
  if (const auto& obstacle = reached.path.obstacles.least) {
    reached.margin_m = std::min(reached.margin_m, obstacle->margin_m);
  }
  if (!reached.path.terrain) return;
  reached.margin_m = std::min(reached.margin_m, reached.path.terrain->margin_m);
  reached.datum_bases.insert(reached.path.terrain->datum.basis);
}

// Airspaces rank a site last. They never hide it.
bool IsInAirspace(const Ranked& ranked) { return !ranked.reached.path.obstacles.airspaces.empty(); }

bool IsBefore(const Ranked& a, const Ranked& b) {
  if (IsInAirspace(a) != IsInAirspace(b)) return IsInAirspace(b);
  return IsBetter(a.reached.Rank(), *a.candidate, b.reached.Rank(), *b.candidate);
}

// Planning a longer way costs more than the shortest one: only sites of the answer need it.
void LoseSurplus(const StoredSites& stored, const EmergencyRequest& request, Ranked& ranked) {
  Reached& reached = ranked.reached;
  if (reached.margin_m < 0.0) return;
  reached.path = PathToTell(stored, request, *ranked.candidate, reached.task, reached.path);
  if (reached.path.terrain) reached.datum_bases.insert(reached.path.terrain->datum.basis);
}

// `ranked` is sorted.
std::vector<size_t> DifferentAmong(const std::vector<Ranked>& ranked, size_t limit) {
  std::vector<size_t> different;
  for (size_t i = 0; i < ranked.size() && different.size() < limit; ++i) {
    const bool is_known = std::any_of(different.begin(), different.end(), [&](size_t other) {
      return IsSamePlace(ranked[i].reached.landing, ranked[other].reached.landing);
    });
    if (!is_known) different.push_back(i);
  }
  return different;
}

// The last site of the answer so far; nothing if there is room for more. A candidate that does not
// rank before it cannot change the answer: a smaller limit gives the beginning of what a larger one
// gives.
const Ranked* LastOf(const std::vector<Ranked>& reachable, size_t limit) {
  const std::vector<size_t> answer = DifferentAmong(reachable, limit);
  return answer.size() < limit ? nullptr : &reachable[answer.back()];
}

bool CanChange(const Ranked* last, const RecallCandidate& candidate) {
  return last == nullptr || IsInAirspace(*last) ||
         !IsSurelyNotBetter(candidate, last->reached.Rank(), *last->candidate);
}

// Of two sites that are not reachable. Too much height can be lost by other means, too little is
// missing.
bool MissesLess(const Reached& a, const Reached& b) {
  const bool is_a_high = a.margin_m >= 0.0, is_b_high = b.margin_m >= 0.0;
  if (is_a_high != is_b_high) return is_a_high;
  return is_a_high ? a.path.SurplusM() < b.path.SurplusM() : a.margin_m > b.margin_m;
}

void Add(Ranked ranked, Search& search) {
  std::optional<Ranked>& miss = search.nearest_miss;
  if (ranked.reached.IsReachable()) {
    const auto place =
        std::upper_bound(search.reachable.begin(), search.reachable.end(), ranked, IsBefore);
    search.reachable.insert(place, std::move(ranked));
  } else if (!miss || MissesLess(ranked.reached, miss->reached)) {
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
  const auto is_too_late = [&] { return last != nullptr && !IsBefore(ranked, *last); };
  if (is_too_late()) return;
  CheckShortest(stored, request, ranked.reached);
  search.datum_bases.merge(std::set(ranked.reached.datum_bases));
  if (is_too_late()) return;
  LoseSurplus(stored, request, ranked);
  Add(std::move(ranked), search);
}

// Candidates in a box of this radius, put in order as far as needed.
Search SearchWithin(const StoredSites& stored,
                    const EmergencyRequest& request,
                    double reach_m,
                    std::chrono::milliseconds time_budget,
                    const SharedRows<RecallRow>& own_sites,
                    GlidingFleet& fleet) {
  const auto begin = std::chrono::steady_clock::now();
  Search search;
  search.reach_m = reach_m;
  search.rows = stored.storage.sites.ListRecallable(BoxAround(request.place, reach_m));
  search.rows.insert(search.rows.end(), own_sites.begin(), own_sites.end());
  search.candidates = Candidates(request, search.rows, fleet);
  std::vector<RecallCandidate>& candidates = search.candidates;
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
        (num_planned > 0 && std::chrono::steady_clock::now() - begin > time_budget);
    if (search.is_cut_short) break;
    stored.stop_if_unwanted();
    ++num_planned;
    Evaluate(stored, request, candidate, last, search);
  }
  return search;
}

std::string Metres(double length_m) { return std::to_string(std::lround(length_m)) + " m"; }

}  // namespace

bool Reached::IsReachable() const {
  return margin_m >= 0.0 && path.SurplusM() <= GlideOptions{}.max_surplus_m;
}

const char* NameOf(MissReason reason) {
  switch (reason) {
    case MissReason::kTooLow:
      return "too_low";
    case MissReason::kTerrain:
      return "terrain";
    case MissReason::kTooHigh:
      return "too_high";
    case MissReason::kNoApproach:
      return "no_approach";
    case MissReason::kNoSite:
      return "no_site";
    case MissReason::kNotEvaluated:
      break;
  }
  return "not_evaluated";
}

MissReason ReasonOf(const Reached& miss) {
  if (miss.margin_m >= 0.0) return MissReason::kTooHigh;
  return miss.margin_in_free_air_m >= 0.0 ? MissReason::kTerrain : MissReason::kTooLow;
}

MissReason ReasonOf(const Search& search) {
  if (search.nearest_miss) return ReasonOf(search.nearest_miss->reached);
  if (search.is_cut_short || search.reach_m == 0.0) return MissReason::kNotEvaluated;
  return search.num_without_approach > 0 ? MissReason::kNoApproach : MissReason::kNoSite;
}

std::string SentenceOf(const Reached& miss) {
  if (ReasonOf(miss) == MissReason::kTooHigh) {
    return "the aircraft arrives " + Metres(miss.path.SurplusM()) +
           " too high for the final, and no clear way that loses this height was found";
  }
  const bool is_terrain = ReasonOf(miss) == MissReason::kTerrain;
  return Metres(std::ceil(-miss.margin_m)) + " of height are missing" +
         (is_terrain ? " above terrain or an obstacle on the way" : "");
}

Search SearchSites(const StoredSites& stored,
                   const EmergencyRequest& request,
                   std::chrono::milliseconds time_budget,
                   GlidingFleet& fleet) {
  const SharedRows<RecallRow> own_sites = OwnSites(stored.storage, request);
  const RecallBounds bounds = WithSites(stored.storage.sites.BoundsOfRecallable(), own_sites);
  double reach_m = GreatestReach(request, bounds, fleet);
  Search search = SearchWithin(stored, request, reach_m, time_budget, own_sites, fleet);
  while (search.reachable.empty() && !search.nearest_miss && !search.is_cut_short &&
         reach_m < kMaxReachM) {
    reach_m = std::min(kMaxReachM, 3.0 * reach_m);
    search = SearchWithin(stored, request, reach_m, time_budget, own_sites, fleet);
  }
  return search;
}

std::vector<size_t> DifferentPlaces(const Search& search, size_t limit) {
  return DifferentAmong(search.reachable, limit);
}

}  // namespace freelsd
