// Input: elevation map, hazard layers, wind, aircraft. Output: touchdown point, approach path and
// verdict. Paper: Sec. III-H, Eq. 1.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/hazard/hazard.h"

namespace freelsd {

struct ApproachOptions {
  // --- What counts as safe ---
  // The map's position is never taken to be better known than this (a standard deviation), and a
  // touchdown keeps disc_margin_sigma deviations of it away from hazard too. Differs: spec has one,
  // and a rough spot lay in such a disc on a map that was 2.4 m aside.
  double min_map_position_sd_m = 1.0;
  double disc_margin_sigma = 2.0;
  // Ground roll and corridor of the paths are wider on either side, and the roll longer, by this
  // many standard deviations of the map's position: what stands beside them may stand in them.
  double path_margin_sigma = 3.0;
  // Cells of a tree or of no clear class under the path get this height on top: leafless trees are
  // seen through. Such a cell's posterior of grass is unknown or below min_clear_class_posterior.
  // Only where no photographs were compared: those tell what is seen through, and its height is
  // unknown then.
  double unclear_height_allowance_m = 2.0;
  double min_clear_class_posterior = 0.5;
  // A cell whose height is less certain than this counts as unseen under the path too; what stands
  // in it still blocks.
  double max_height_sd_m = 1.0;
  // The whole map may lean: what lies at a distance from touchdown may stand higher against it by
  // the distance times this many standard deviations of the map's tilt.
  double tilt_sigma = 2.0;
  // Where no wind is known, the final must also be clear with this wind from behind. Paper: 5.5 m/s
  // in the last experiment.
  double unknown_wind_mps = 5.5;
  // Ground is bare, and gets no such height, where all cells within that distance are seen and no
  // rougher than this: below a tree's branches they are not.
  double bare_ground_radius_m = 2.0;
  double max_bare_roughness_m = 0.5;
  // --- Search ---
  // Touchdown candidates tried per region, best first, at least this far apart; farther where that
  // many would not reach over all of the region's free ground.
  int max_num_candidates = 60;
  // Where none of those is good: this many more, at equal distances. A field with room for a single
  // final has no place for two candidates beside each other.
  int max_num_reserve_candidates = 500;
  double candidate_spacing_m = 4.0;
  // Where every circle at the aircraft's approach height is blocked, higher starts are tried: their
  // heights in units of it, ascending. The final grows in proportion. Paper: 1 alone.
  std::vector<double> start_height_ratios{1.0, 1.5, 2.0, 3.0};
  // Where no final into the wind is good, others are tried with no more wind from the side than
  // this share of the landing airspeed. Paper: 0, into the wind alone.
  double max_crosswind_ratio = 0.15;
  // Headings tried where the wind is unknown or calm, or partly from the side.
  double heading_step_deg = 10.0;
  // Below this the heading is free.
  double calm_wind_mps = 0.5;
  // Step along path and circle; never coarser than half a cell on the final.
  double path_step_m = 0.5;
  // Rejections kept with the site.
  int max_num_rejections = 20;
  // Final score: weights of distance to hazard, clearance, area, slope, roughness, evidence.
  std::vector<double> score_weights{0.25, 0.2, 0.15, 0.15, 0.1, 0.15};

  void Check() const;
};

enum class Verdict { kLandable, kUnverified, kRejected };

// Closed list of the HTTP contract.
enum class RejectReason {
  kNoSafeTouchdown,
  kApproachBlocked,
  kApproachUnseen,
  kLoiterBlocked,
  kWindTooStrong,
  kTooSmall,
  kTooFewObservations,
  kNotGrass,
  kNoTerrain,
};

enum class LoiterDirection { kLeft, kRight };  // as flown

// Eq. 1: length of the final over ground, flown into the wind; zero or negative where the wind is
// too strong.
double ApproachDistance(const Aircraft& aircraft, double wind_speed);
// The same with all of the wind from behind, which nobody plans but who does not know it may get.
double DownwindApproachDistance(const Aircraft& aircraft, double wind_speed);
double LoiterRadius(const Aircraft& aircraft, double wind_speed);

// What a touchdown keeps from hazard: its disc, the map's own deviation and half a cell's diagonal
// (spec 3.6). NaN where the deviation is unknown: nothing keeps that.
double RequiredHazardDistance(const ElevationMap& map,
                              const Aircraft& aircraft,
                              const ApproachOptions& options);

// Path height against the map's upper surface, from the start of the final to touchdown.
struct ApproachProfile {
  // Distance to touchdown, descending.
  std::vector<double> distance;
  std::vector<double> path_height;     // world z
  std::vector<double> terrain_height;  // highest in the corridor; NaN where unseen
};

struct Approach {
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d approach_start_in_world = Eigen::Vector3d::Zero();
  // Direction of travel on final, radians clockwise from north.
  double heading = 0.0;
  double approach_distance = 0.0;
  double approach_height = 0.0;
  // Of the wind planned for, from the side of the final; 0 where no wind is known.
  double crosswind = 0.0;
  double loiter_radius = 0.0;
  Eigen::Vector3d loiter_center_in_world = Eigen::Vector3d::Zero();
  LoiterDirection loiter_direction = LoiterDirection::kLeft;
  // Over the final outside the touchdown disc and the seen part of the circle; NaN if all unseen.
  double min_clearance = 0.0;
  // Unseen share of the chosen circle.
  double unseen_ratio = 0.0;
  ApproachProfile profile;
};

// The circle as flown from the start of the final, closed: num_points + 1 points, first = last.
std::vector<Eigen::Vector3d> LoiterPolyline(const Approach& approach, int num_points);

struct Rejection {
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  RejectReason reason = RejectReason::kNoSafeTouchdown;
  // One sentence with numbers.
  std::string detail;
  std::optional<Eigen::Vector3d> obstacle_in_world;
};

struct ScoreTerm {
  std::string name;
  double value = 0.0;  // 0..1
  double weight = 0.0;
};

// What the planner answers for one region: always a place with numbers, even when rejected (the
// least bad one, and the rule it breaks), unless nothing was seen at all.
struct Plan {
  Verdict verdict = Verdict::kRejected;
  std::optional<RejectReason> reject_reason;
  std::string reject_detail;
  // World; for a rejected site the least bad place, or the region's centre at its ground_height.
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  double hazard_distance = 0.0;
  // Largest within the touchdown disc; NaN if unseen. Slope in radians.
  double slope = 0.0;
  double roughness = 0.0;
  std::optional<Approach> approach;
  std::vector<Rejection> rejections;
  double score = 0.0;
  std::vector<ScoreTerm> score_terms;
};

// What of the region enters the plan.
struct PlanRequest {
  Polygon footprint;  // where the touchdown may lie, world
  double area_m2 = 0.0;
  double grade = 0.0;
  int num_observations = 0;
  int min_num_observations = 2;
  std::optional<Eigen::Vector2d> wind_in_world;
  // World z of the region by coarse depth: only the answer where the map saw nothing of it.
  double ground_height = 0.0;
};

// Touchdown candidates are tried best first (distance to hazard) and the first landable one wins;
// else the first unverified one of the few, then of the reserve. The search looks at a limited
// number of places, so it may miss a good place, but never accepts a bad one. Ways down in order: a
// final into the wind, one across it, and where circles are blocked both from higher up. Throws
// std::invalid_argument when map and hazards are not of one grid.
Plan PlanApproach(const ElevationMap& map,
                  const HazardLayers& hazards,
                  const PlanRequest& request,
                  const Aircraft& aircraft,
                  const ApproachOptions& options);

// Whether a plan tells what was refused, and what lies below its final.
enum class Explanation { kFull, kNone };

// The same for one wind after another: what does not hang on the wind is done once. Map and hazards
// must live as long. May be asked by several threads at a time.
class ApproachPlanner {
 public:
  // The request's own wind has no meaning here. Throws as PlanApproach does.
  ApproachPlanner(const ElevationMap& map,
                  const HazardLayers& hazards,
                  const PlanRequest& request,
                  const Aircraft& aircraft,
                  const ApproachOptions& options);
  ~ApproachPlanner();
  ApproachPlanner(ApproachPlanner&&) noexcept;
  ApproachPlanner& operator=(ApproachPlanner&&) noexcept;

  // Without explanation rejections and profile are empty; nothing else is another, and it takes
  // less time.
  Plan PlanFor(const std::optional<Eigen::Vector2d>& wind_in_world,
               Explanation explanation = Explanation::kFull) const;

 private:
  std::unique_ptr<const struct ApproachGround> ground_;
};

// Which winds a rose is made of.
struct WindRoseOptions {
  // Evenly spaced from north: 36 are 10 degrees apart.
  int num_directions = 36;
  // Ascending.
  std::vector<double> speeds_mps{2.5, 5.0, 7.5, 10.0};

  void Check() const;
};

// What a place is good for in each of many winds.
struct WindRose {
  // The wind comes from 360 deg * i / num_directions, clockwise from north.
  int num_directions = 0;
  std::vector<double> speeds;
  // Speed by speed, in it direction by direction.
  std::vector<Plan> plans;

  // Where that air moves to.
  Eigen::Vector2d WindInWorld(size_t speed, size_t direction) const;
  const Plan& At(size_t speed, size_t direction) const;
};

// Each plan is the planner's for that wind, without explanation. Throws std::invalid_argument on
// bad options.
WindRose PlanWindRose(const ApproachPlanner& planner, const WindRoseOptions& options);

}  // namespace freelsd
