// Input: stored sites of a world, and its truth. Output: what happens to an aircraft that flies the
// paths that emergency recall tells.
#pragma once

#include <optional>
#include <random>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/recall/recall_sites.h"
#include "tests/evaluation/flown/mosaic.h"

namespace freelsd {

// What the aircraft meets first.
enum class Obstacle {
  kNone,
  kOnMap,     // on the way to the final, where a stored map shows the ground
  kOffMap,    // on the way to the final, elsewhere
  kInCircle,  // in the circles at the start of the final
  kOnFinal    // outside the disc in which the aircraft may touch down
};

// One path of an answer, flown by a point mass in the wind that the answer assumes.
struct FlownPath {
  std::string site_id;
  std::optional<double> terrain_margin_m;
  // As told, above the planned start of the final.
  double surplus_height_m = 0.0;
  // Flown less told, where the path first reaches the start of the final; and the largest error
  // that is allowed there: 5 m and 5 % of the height lost.
  double height_error_m = 0.0;
  double max_height_error_m = 0.0;
  Obstacle obstacle = Obstacle::kNone;
  // Place in world, and what it is made of.
  Eigen::Vector3d met_in_world = Eigen::Vector3d::Zero();
  Cover cover = Cover::kMeadow;
  bool is_wire = false;
  // Least height above the truth on the way to the final, where a stored map shows the ground.
  std::optional<double> least_height_m;
};

// An aircraft above the world: near its middle, at most 250 m up. Now and then its heading, or the
// wind, is unknown.
EmergencyRequest RandomRequest(const World& world, std::mt19937& random);

// Worlds with their stored sites.
class RecalledWorld {
 public:
  RecalledWorld(const StoredSites& stored, const Mosaic& mosaic);

  struct Recalled {
    // Of the sites that are told as reachable.
    std::vector<FlownPath> paths;
    nlohmann::json answer;
  };
  Recalled Recall(const EmergencyRequest& request) const;
  // `site`: of an answer to the request, with a path.
  FlownPath Fly(const EmergencyRequest& request, const nlohmann::json& site) const;

 private:
  bool IsOnMap(const GeoPoint& place) const;

  StoredSites stored_;
  const Mosaic& mosaic_;
  std::vector<std::shared_ptr<const KeptTerrain>> terrains_;
};

}  // namespace freelsd
