// Finds the stored sites that an aircraft without power reaches. Recall tells them; the insurance
// of a route counts them. Private to recall.
#pragma once

#include <chrono>
#include <optional>
#include <set>
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
  // If nothing is reachable: the site with the greatest margin of those that were evaluated.
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

// Indices in search.reachable of the best `limit` of different places, best first.
std::vector<size_t> DifferentPlaces(const Search& search, size_t limit);

}  // namespace freelsd
