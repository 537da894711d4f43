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
  // Lower bound for the standard deviation of the map's position. The edge of the touchdown disc
  // stays disc_margin_sigma such deviations away from hazard. Paper: no margin. Differs: even a
  // margin of one deviation is too small (decision 0018).
  double min_map_position_sd_m = 1.0;
  double disc_margin_sigma = 2.0;
  // Margin for a shift of the map, in deviations of the map's position. It widens the ground roll
  // and the corridors on both sides, and it lengthens the ground roll.
  double path_margin_sigma = 3.0;
  // Height added to the cells under the path that have no clear class, because the map misses
  // leafless trees. A cell has no clear class if its posterior of grass is unknown or too low.
  // Nothing is added if photographs were compared: the comparison finds such trees and marks their
  // height as unknown.
  double unclear_height_allowance_m = 2.0;
  // A cell under the path counts as unseen if its height deviation is larger. Such a cell still
  // blocks the path if it is too high.
  double max_height_sd_m = 1.0;
  // The whole map may be tilted. This is the assumed tilt, in deviations of the map's tilt. The
  // needed clearance increases with the distance from touchdown, by distance * tan(assumed tilt).
  double tilt_sigma = 2.0;
  // If the wind is unknown, the path must be clear in calm and also with a tail wind of this speed.
  // Paper: 5.5 m/s in the last experiment.
  double unknown_wind_mps = 5.5;
  // Spread of the measured wind to allow for, in its deviations: that much less wind counts in the
  // length of the final, that much more in circle and ground speed. Paper: Eq. 1 allows for the
  // wind's direction alone. Differs: its speed is uncertain too.
  double wind_sigma = 1.0;
  // Bare ground gets no allowance. All cells within this radius must be seen and no rougher than
  // the limit: below branches they are rougher.
  double bare_ground_radius_m = 2.0;
  double max_bare_roughness_m = 0.5;
  // --- Search ---
  // Largest number of touchdown candidates per region.
  int max_num_candidates = 60;
  // Largest number of reserve candidates, which are more densely spaced. They are tried if all
  // other candidates are rejected. A field may have room for only one final, which a coarse search
  // misses.
  int max_num_reserve_candidates = 500;
  // Least distance between touchdown candidates. It is increased in a large region, so that the
  // candidates cover all free ground.
  double candidate_spacing_m = 4.0;
  // Heights of the start of the final, in units of the aircraft's approach height, ascending. The
  // next height is tried if all lower heights fail and one of their circles is blocked. The length
  // of the final is proportional to the height. Paper: only 1.
  std::vector<double> start_height_ratios{1.0, 1.5, 2.0, 3.0};
  // Largest crosswind, as a share of the landing airspeed. Headings with crosswind are tried if
  // every final into the wind fails. Paper: 0, only into the wind.
  double max_crosswind_ratio = 0.15;
  // Step between headings where several are tried: with crosswind, in calm, and in unknown wind.
  double heading_step_deg = 10.0;
  // Below this wind speed every heading is tried. The wind still counts in final and circle.
  double calm_wind_mps = 0.5;
  // Step along the final and the circle. On the final, the step is at most half a cell.
  double path_step_m = 0.5;
  // Largest number of rejections stored with the site.
  int max_num_rejections = 20;
  // Weights of the score's terms: distance to hazard, clearance, area, slope, roughness, evidence.
  std::vector<double> score_weights{0.25, 0.2, 0.15, 0.15, 0.1, 0.15};

  void Check() const;
};

enum class Verdict { kLandable, kUnverified, kRejected };

// As in api/openapi.yaml.
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

enum class LoiterDirection { kLeft, kRight };  // direction of the turn

// Eq. 1: length of the final over ground, into the wind. Zero or negative where the wind is too
// strong. `wind_margin`, m/s: how much weaker the wind may be than estimated.
double ApproachDistance(const Aircraft& aircraft, double wind_speed, double wind_margin = 0.0);
// Eq. 1 with a tail wind, for wind that is unknown. No final is planned downwind.
double DownwindApproachDistance(const Aircraft& aircraft, double wind_speed);
double LoiterRadius(const Aircraft& aircraft, double wind_speed);

// Least distance of a touchdown from hazard. It is the sum of the disc's radius, the margin for the
// map's position, and half the diagonal of a cell (decision 0019). NaN if the deviation of the
// map's position is unknown: then no distance suffices.
double RequiredHazardDistance(const ElevationMap& map,
                              const Aircraft& aircraft,
                              const ApproachOptions& options);

// Heights of the path and of the terrain below it, from the start of the final to touchdown.
struct ApproachProfile {
  // Distance to touchdown, descending.
  std::vector<double> distance;
  std::vector<double> path_height;     // world z
  std::vector<double> terrain_height;  // highest in the corridor; NaN where unseen
};

// Free ground around a touchdown: a rectangle along the landing heading, in metres from touchdown.
// It is as long as the planner's corridor (path_half_width_m and the margin of the map's position
// on both sides) meets only cells that are kFree, ahead and behind. It is then as wide as this
// whole length stays free. No cell that is not kFree reaches into it. All 0: the touchdown's own
// ground is not free.
struct LandingStrip {
  double ahead = 0.0;
  double behind = 0.0;
  double left = 0.0;
  double right = 0.0;

  double Length() const { return ahead + behind; }
  double Width() const { return left + right; }
};

enum class PathPart { kFinal, kCircle };

// What a path passes over with the least spare clearance, of all that is higher above touchdown
// than the safety margin, or than max_roughness_m in cells that are not kFree. The ground on which
// the aircraft lands is no obstacle: the end of every final is low above it.
struct PathObstacle {
  PathPart part = PathPart::kFinal;
  // Its top, with the allowance of its cell.
  Eigen::Vector3d place_in_world = Eigen::Vector3d::Zero();
  // Distance to touchdown; on the final, measured along it.
  double distance = 0.0;
  double clearance = 0.0;
  // Clearance that the planner needs there.
  double wanted = 0.0;
};

// A straight climb with power along the landing heading that breaks the approach off. It clears all
// seen ground ahead by the safety margin and the allowance for the map's tilt. Unseen ground does
// not block it.
struct GoAround {
  // Point of no return: the last place on the final from which the climb clears. Distance to
  // touchdown. The path there is at least safety_margin_m above touchdown, and outside the disc.
  double no_return_distance = 0.0;
  // The climb begins on the final. It ends where it is as high as the start of the final and no
  // seen ground lies ahead.
  Eigen::Vector3d start_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d end_in_world = Eigen::Vector3d::Zero();
  // Angle over ground, radians. Tail wind makes it less than climb_gradient_deg.
  double climb_angle = 0.0;
  // Share of the climb below which ground is unseen or lies off the map.
  double unseen_ratio = 0.0;
};

struct Approach {
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d approach_start_in_world = Eigen::Vector3d::Zero();
  // Direction of travel on final, radians clockwise from north.
  double heading = 0.0;
  double approach_distance = 0.0;
  double approach_height = 0.0;
  // Crosswind of the planned wind; 0 where the wind is unknown or calm.
  double crosswind = 0.0;
  // Ground speed on final in the planned wind, m/s. Empty if the wind is unknown.
  std::optional<double> ground_speed;
  double loiter_radius = 0.0;
  Eigen::Vector3d loiter_center_in_world = Eigen::Vector3d::Zero();
  LoiterDirection loiter_direction = LoiterDirection::kLeft;
  // Least clearance along the seen parts of the final and of the circle. The touchdown disc is left
  // out. NaN if neither has a seen part.
  double min_clearance = 0.0;
  // Unseen share of the chosen circle.
  double unseen_ratio = 0.0;
  // Corners of the ground roll that must be free, with its margins; empty where none is needed.
  std::vector<Eigen::Vector3d> ground_roll_in_world;
  // The next four are left empty without explanation.
  std::optional<LandingStrip> strip;
  // Over all scenarios of the wind. Empty: there is none.
  std::optional<PathObstacle> obstacle;
  // It clears in all scenarios of the wind. Empty: no climb clears, or the plan is rejected.
  std::optional<GoAround> go_around;
  ApproachProfile profile;
};

// Points of the loiter circle in the order of flight, beginning at the start of the final. The
// polyline is closed: it has num_points + 1 points, and the last equals the first. A num_points
// below 4 counts as 4.
std::vector<Eigen::Vector3d> LoiterPolyline(const Approach& approach, int num_points);

struct Rejection {
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  RejectReason reason = RejectReason::kNoSafeTouchdown;
  // One sentence with numbers.
  std::string detail;
  std::optional<Eigen::Vector3d> obstacle_in_world;
};

// One rule of the planner for one place.
struct PlaceRule {
  // seen, grass, slope, roughness, object, hazard_distance, outline, region, wind, ground_roll,
  // final, final_seen, circle, circle_seen, wind_known; in this order.
  std::string name;
  bool passed = false;
  // Measured value and the limit that it is compared with, if known and if they are numbers.
  std::optional<double> value = std::nullopt;
  std::optional<double> limit = std::nullopt;
  // "m", "deg", "m/s" or "ratio"; empty where there is no number.
  std::string unit = {};
  // For people, with numbers.
  std::string sentence = {};
};

// What the planner says about a touchdown at one place.
struct PlaceJudgement {
  // As PlanFor, if this were the region's only place. kRejected where a rule of the ground fails.
  Verdict verdict = Verdict::kRejected;
  // Rules that could not be tried are left out: without a height there is no path.
  std::vector<PlaceRule> rules;
  // What the map holds there: world z of the ground, its deviation, posterior of grass.
  std::optional<double> height, height_sd, grass_probability;

  // The first rule that fails; null if all pass.
  const PlaceRule* FirstFailed() const;
};

struct ScoreTerm {
  std::string name;
  double value = 0.0;  // 0..1
  double weight = 0.0;
};

// The plan for one region. The plan of a rejected region describes the least bad place and the rule
// that this place breaks.
struct Plan {
  Verdict verdict = Verdict::kRejected;
  std::optional<RejectReason> reject_reason;
  std::string reject_detail;
  // If rejected, the least bad place. If no ground of the region was seen, the footprint's centroid
  // at ground_height.
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  double hazard_distance = 0.0;
  // Largest within the touchdown disc; NaN if unseen. Slope in radians.
  double slope = 0.0;
  double roughness = 0.0;
  std::optional<Approach> approach;
  std::vector<Rejection> rejections;
  // Rules of the path to the touchdown; empty without a path, or without explanation.
  std::vector<PlaceRule> path_rules;
  double score = 0.0;
  std::vector<ScoreTerm> score_terms;
};

// Data of a region that its plan depends on.
struct PlanRequest {
  Polygon footprint;  // where the touchdown may lie, world
  double area_m2 = 0.0;
  double grade = 0.0;
  int num_observations = 0;
  int min_num_observations = 2;
  std::optional<Eigen::Vector2d> wind_in_world;
  // Deviation of the wind per axis (WindEstimate), m/s; 0 for a wind that was not measured.
  double wind_spread_mps = 0.0;
  // World z of the region by coarse depth. Reported only if the map has no height there.
  double ground_height = 0.0;
};

// Plans the approach to one region. Several searches follow one another:
// 1. headings into the wind;
// 2. headings with crosswind;
// 3. both again from each greater start height.
// The first search that accepts a place ends the planning. Each search tries the candidates
// farthest from hazard first:
// - The first landable candidate is accepted.
// - If none is landable, the first unverified candidate is accepted.
// - If all candidates are rejected, the reserve is tried. Its first place that is landable or
//   unverified is accepted.
// The searches are not exhaustive: they may miss a good place, but they never accept a bad one.
// Throws std::invalid_argument when map and hazards have different grids.
Plan PlanApproach(const ElevationMap& map,
                  const HazardLayers& hazards,
                  const PlanRequest& request,
                  const Aircraft& aircraft,
                  const ApproachOptions& options);

// Whether a plan includes its rejections, its rules, its strip, its tightest obstacle, its
// go-around and the profile below its final.
enum class Explanation { kFull, kNone };

// What a map says of an approach that was planned on another map.
struct ApproachCheck {
  // The first rule that seen ground breaks: disc, ground roll, final, circle. Unseen ground breaks
  // none.
  std::optional<Rejection> rejection;
  // Disc, ground roll and final are wholly seen.
  bool is_covered = false;
};

// Checks an approach again, as it stands, on another map: same touchdown, heading and sizes, in the
// frame of that map. `wind_in_world` is the wind that it was planned for. Only differences of
// height count: the approach is set on the ground of its touchdown on this map, because altitudes
// of two flights differ by metres, and by tens of metres where their datums differ. If the map
// shows no ground in the disc, the ground below the stored profile of the final takes its place.
// Throws as PlanApproach does.
ApproachCheck CheckApproach(const Approach& approach,
                            const ElevationMap& map,
                            const HazardLayers& hazards,
                            const Aircraft& aircraft,
                            const std::optional<Eigen::Vector2d>& wind_in_world,
                            const ApproachOptions& options);
// Corners of a box, in world, around everything that CheckApproach reads.
Polygon CheckedGround(const Approach& approach,
                      const ElevationMap& map,
                      const Aircraft& aircraft,
                      const std::optional<Eigen::Vector2d>& wind_in_world,
                      const ApproachOptions& options);

// Plans for many winds. Work that does not depend on wind is done once. Map and hazards must
// outlive the planner. Thread-safe.
class ApproachPlanner {
 public:
  // Of the request's own wind, only its spread counts, and only in a plan for that very wind.
  // Throws as PlanApproach does.
  ApproachPlanner(const ElevationMap& map,
                  const HazardLayers& hazards,
                  const PlanRequest& request,
                  const Aircraft& aircraft,
                  const ApproachOptions& options);
  ~ApproachPlanner();
  ApproachPlanner(ApproachPlanner&&) noexcept;
  ApproachPlanner& operator=(ApproachPlanner&&) noexcept;

  // Without explanation planning is faster. Everything else is identical.
  Plan PlanFor(const std::optional<Eigen::Vector2d>& wind_in_world,
               Explanation explanation = Explanation::kFull) const;

  // Judges the cell at a place by the rules that PlanFor uses, over the ways of this wind. Off the
  // map nothing is seen. `options` are those of the hazard layers.
  PlaceJudgement Judge(const Eigen::Vector2d& place_in_world,
                       const std::optional<Eigen::Vector2d>& wind_in_world,
                       const HazardOptions& options) const;

 private:
  std::unique_ptr<const struct ApproachGround> ground_;
};

// The winds of a wind rose: each speed from each direction.
struct WindRoseOptions {
  // The directions are evenly spaced, and the first is north. 36 directions are 10 degrees apart.
  int num_directions = 36;
  // Ascending.
  std::vector<double> speeds_mps{2.5, 5.0, 7.5, 10.0};

  void Check() const;
};

// Plans for one place in many winds.
struct WindRose {
  // The wind comes from 360 deg * i / num_directions, clockwise from north.
  int num_directions = 0;
  std::vector<double> speeds;
  // Ordered by speed, then by direction.
  std::vector<Plan> plans;

  // Velocity of the air; points to where the air moves.
  Eigen::Vector2d WindInWorld(size_t speed, size_t direction) const;
  const Plan& At(size_t speed, size_t direction) const;
};

// Each plan equals planner.PlanFor(wind, Explanation::kNone) for its wind. Throws
// std::invalid_argument on bad options.
WindRose PlanWindRose(const ApproachPlanner& planner, const WindRoseOptions& options);

}  // namespace freelsd
