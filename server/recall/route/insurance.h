// Judges the moments of a route. Private to recall.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "api/import/routes/routes.h"
#include "engine/route/route.h"
#include "server/recall/recall_candidates.h"
#include "server/recall/recall_sites.h"
#include "server/recall/site_search.h"

namespace freelsd {

struct MissedSite {
  std::string site_id;
  // Height that is missing; 0 if the aircraft is too high.
  double missing_m = 0.0;
};

struct InsuredMoment {
  RouteMoment moment;
  // Sum of the weights of the winds in which a site is in reach.
  double covered_weight = 0.0;
  bool is_covered = false;
  // Of the winds: the site that is the best one for the greatest weight.
  std::optional<std::string> best_site;
  // The least over the winds; that of the nearest miss where none is in reach. Nothing if no site
  // could be evaluated.
  std::optional<double> arrival_margin_m;
  // That the forced landing at the best site of each wind fails, averaged over the winds. Only if
  // covered, and if each of these plans has a risk.
  std::optional<double> failure_probability;
  // If not covered.
  MissReason reason = MissReason::kNotEvaluated;
  std::optional<MissedSite> nearest_miss;
};

// Moments [first, last] without a site.
struct RouteGap {
  size_t first = 0;
  size_t last = 0;
  // That of most of its moments.
  MissReason reason = MissReason::kNotEvaluated;
  // Of all moments, the one that misses least.
  std::optional<MissedSite> nearest_miss;
};

struct Insurance {
  std::vector<InsuredMoment> moments;
  std::vector<RouteGap> gaps;

  size_t NumUncovered() const;
};

// Judges moments of routes for one request. Thread-safe.
class RouteJudge {
 public:
  // Both arguments must outlive it. After `deadline`, moments are not evaluated.
  RouteJudge(const StoredSites& stored,
             const RouteRequest& request,
             std::chrono::steady_clock::time_point deadline);

  // Throws ApiError if the route cannot be flown or is too long.
  std::vector<RouteMoment> MomentsOf(const std::vector<GeoPoint>& route) const;
  InsuredMoment Judge(const RouteMoment& moment) const;
  // Moments that are equal in `known`, to the last bit, are taken from there.
  Insurance Insure(const std::vector<GeoPoint>& route, const Insurance& known = {}) const;

  // A recall at this moment, in one of the winds; nothing: the wind is unknown.
  EmergencyRequest RequestAt(const RouteMoment& moment,
                             const std::optional<Eigen::Vector2d>& wind_in_world) const;
  // True after the deadline: moments judged now may not have been evaluated.
  bool IsLate() const { return std::chrono::steady_clock::now() > deadline_; }
  const RouteOptions& options() const { return options_; }

 private:
  const StoredSites& stored_;
  const RouteRequest& request_;
  std::chrono::steady_clock::time_point deadline_;
  RouteOptions options_;
  mutable GlidingFleet fleet_;
};

}  // namespace freelsd
