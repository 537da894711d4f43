// Finds the stored sites that an aircraft without power reaches. Recall tells them; the insurance
// of a route counts them. Private to recall.
#pragma once

#include <chrono>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/recall/descent_path.h"
#include "server/recall/recall_candidates.h"
#include "server/recall/recall_sites.h"
#include "server/recall/same_place.h"

namespace freelsd {

// A site that was evaluated.
struct Reached {
  // Arrival margin, metres: negative if out of reach.
  double margin_m = 0.0;
  // The same if terrain and obstacles on the way are ignored.
  double margin_in_free_air_m = 0.0;
  // By another map: the site, or this plan of it.
  bool is_doubted = false;
  bool is_landable = false;
  Landing landing;
  // How the datums of the site and of the terrain below the way were compared.
  std::set<DatumBasis> datum_bases;
  DescentTask task;
  // The way there. If height is missing, the shortest one.
  ToldPath path;

  // Neither is height missing, nor is more left at the start of the final than the final can lose.
  bool IsReachable() const;
  PlannedRank Rank() const { return {is_doubted, margin_m, is_landable}; }
};

// Why no site is in reach, the least excuse first.
enum class MissReason {
  kTooLow,      // the nearest miss is too far for this height
  kTerrain,     // it would be in reach without the terrain or an obstacle on the way
  kTooHigh,     // no clear way there loses the surplus height before the final
  kNoApproach,  // the sites nearby have no approach in this wind, or it is too strong to get there
  kNoSite,      // no site is stored within any glide
  kNotEvaluated,  // there was no time to tell
};
const char* NameOf(MissReason reason);
// Of a site that is not reachable.
MissReason ReasonOf(const Reached& miss);
// "18 m of height are missing"
std::string SentenceOf(const Reached& miss);

struct Ranked {
  const RecallCandidate* candidate = nullptr;
  Reached reached;
};

struct Search {
  SharedRows<RecallRow> rows;
  // Point into `rows`.
  std::vector<RecallCandidate> candidates;
  // The candidates lie in a box of this radius.
  double reach_m = 0.0;
  // How the datums were compared: for all candidates, and for the terrain below the ways that were
  // evaluated.
  std::set<DatumBasis> datum_bases;
  // Best first. They point into `candidates`.
  std::vector<Ranked> reachable;
  // If nothing is reachable: of those that were evaluated, the site with the least surplus height;
  // if height is missing everywhere, the site with the greatest margin.
  std::optional<Ranked> nearest_miss;
  size_t num_without_approach = 0;
  bool is_cut_short = false;
};

// Evaluates as many sites as the best `request.limit` different places need. No plan is begun after
// `time_budget`; it is then cut short. If nothing is in reach, the search grows until it contains a
// nearest miss.
Search SearchSites(const StoredSites& stored,
                   const EmergencyRequest& request,
                   std::chrono::milliseconds time_budget,
                   GlidingFleet& fleet);

// Of a search without a site in reach.
MissReason ReasonOf(const Search& search);

// Indices in search.reachable of the best `limit` of different places, best first.
std::vector<size_t> DifferentPlaces(const Search& search, size_t limit);

}  // namespace freelsd
