// Input: a mosaic of worlds with stored sites, a random route. Output: what the insurance of the
// route tells, and what happens where the engine stops on it.
#pragma once

#include <map>
#include <random>
#include <string>
#include <vector>

#include "api/import/routes/routes.h"
#include "tests/evaluation/flown/flown_recall.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

// Sums over the moments of one route at which the engine stopped.
struct FlownRoute {
  int num_moments = 0;
  // Seconds of the whole route.
  int num_seconds = 0;
  int num_covered_seconds = 0;
  // Moments whose sample is not what recall answers there.
  int num_different = 0;
  int num_covered = 0;
  double told_risk = 0.0;
  // Shares of flights that fail, summed over the covered moments; those that fences, poles and
  // wires alone cause apart.
  double num_failed = 0.0;
  double num_failed_thin = 0.0;
  // Paths that met something before the final, by Obstacle.
  std::map<Obstacle, int> met;
  std::vector<std::string> remarks;
  // Gaps, fixes by kind, and fixes whose route leaves other gaps than told when it is checked.
  int num_gaps = 0;
  std::map<std::string, int> fixes;
  int num_wrong_fixes = 0;
  double check_s = 0.0;
};

// Two to five points over the mosaic, 40 to 160 m above its first world's origin; every second
// route has a wind with a spread.
RouteRequest RandomRoute(const Mosaic& mosaic, std::mt19937& random);

// Stops the engine at `num_stops` moments of routes over one mosaic.
class RouteFlyer {
 public:
  // Both must outlive it.
  RouteFlyer(const StoredSites& stored, const Mosaic& mosaic);

  FlownRoute Fly(const RouteRequest& request, int num_stops, uint64_t seed);

 private:
  void Stop(const RouteRequest& request,
            const nlohmann::json& sample,
            const std::vector<Eigen::Vector2d>& winds,
            FlownRoute& flown);
  void Land(const EmergencyRequest& request, const nlohmann::json& site, FlownRoute& flown);
  const TruthMap& TruthOf(const World& world, const Aircraft& aircraft);
  int CountWrongFixes(const RouteRequest& request, const nlohmann::json& answer) const;

  const StoredSites stored_;
  const Mosaic& mosaic_;
  RecalledWorld recalled_;
  std::map<const World*, TruthMap> truths_;
};

}  // namespace freelsd
