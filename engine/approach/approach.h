// Input: elevation map, hazard layers, wind, aircraft. Output: touchdown point, approach path and
// verdict. Paper: Sec. III-H, Eq. 1.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/hazard/hazard.h"
#include "engine/risk/risk.h"

namespace freelsd {

struct ApproachOptions {
  // --- What counts as safe ---
  // Lower bound for the standard deviation of the map's position. The least distance between the
  // edge of the touchdown disc and a hazard is disc_margin_sigma times this deviation. Paper: no
  // margin. Differs: even a margin of one deviation is too small (decision 0018).
  double min_map_position_sd_m = 1.0;
  double disc_margin_sigma = 2.0;
  // Margin for a shift of the map, in deviations of the map's position. It widens the ground roll
  // and the corridors on both sides, and it lengthens the ground roll.
  double path_margin_sigma = 3.0;
  // Height added to the cells under the path that have no clear class, because the map misses
  // leafless trees. A cell has no clear class if its posterior of grass is unknown or too low. If
  // photographs were compared, nothing is added: the comparison finds these trees and marks their
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
  // Error of the measured wind speed to allow for, in deviations of the measured wind. The length
  // of the final is computed for a wind that is weaker by this error. The circle and the least
  // ground speed are computed for a wind that is stronger by it. Paper: Eq. 1 allows only for an
  // error of the wind's direction. Differs: the speed is uncertain too.
  double wind_sigma = 1.0;
  // Bare ground gets no height allowance. Ground is bare if all cells within this radius are seen
  // and no rougher than max_bare_roughness_m. Below branches they are rougher.
  double bare_ground_radius_m = 2.0;
  double max_bare_roughness_m = 0.5;
  // --- Search ---
  // Largest number of touchdown candidates per region.
  int max_num_candidates = 60;
  // Largest number of reserve candidates, which are more densely spaced. They are tried if all
  // other candidates are rejected. A coarse search may miss the only possible final of a small
  // field.
  int max_num_reserve_candidates = 500;
  // Least distance between touchdown candidates; greater in a large region, to cover all of it.
  double candidate_spacing_m = 4.0;
  // Heights of the start of the final, in units of the aircraft's approach height, ascending. A
  // greater height is tried if all lower heights fail and an obstacle blocks a circle at one of
  // them. The length of the final is proportional to the height. Paper: only 1.
  std::vector<double> start_height_ratios{1.0, 1.5, 2.0, 3.0};
  // Largest crosswind, as a share of the landing airspeed. Headings with crosswind are tried if no
  // final into the wind is accepted. Paper: 0, only into the wind.
  double max_crosswind_ratio = 0.15;
  // Step between headings where several are tried: with crosswind, in calm, and in unknown wind.
  double heading_step_deg = 10.0;
  // If the wind is weaker than this, all headings are tried. Final and circle are still computed
  // for the actual wind.
  double calm_wind_mps = 0.5;
  // Step along final and circle. On the final, the step is at most half a cell.
  double path_step_m = 0.5;
  // Largest number of rejections stored with the site.
  int max_num_rejections = 20;

  RiskOptions risk = {};

  void Check() const;
};

enum class Verdict { kLandable, kUnverified, kRejected };

// api/openapi.yaml explains each reason.
enum class RejectReason {
  kNoSafeTouchdown,
  kApproachBlocked,
  kApproachUnseen,
  kLoiterBlocked,
  kRiskTooHigh,
  kWindTooStrong,
  kTooSmall,
  kTooFewObservations,
  kNotGrass,
  kNoTerrain,
};

enum class LoiterDirection { kLeft, kRight };  // direction of the turn

// Eq. 1: length of the final over ground, into the wind. Zero or negative if the wind is too
// strong. `wind_margin`, m/s: the true wind may be weaker than wind_speed by this value.
double ApproachDistance(const Aircraft& aircraft, double wind_speed, double wind_margin = 0.0);
// Eq. 1 with a tail wind. Used only if the wind is unknown: no final is planned with a known tail
// wind.
double DownwindApproachDistance(const Aircraft& aircraft, double wind_speed);
double LoiterRadius(const Aircraft& aircraft, double wind_speed);

// Least distance of a touchdown from hazard: the radius of the touchdown disc, the margin for the
// map's position, and half the diagonal of a cell (decision 0019). NaN: no distance suffices,
// because the deviation of the map's position is unknown.
double RequiredHazardDistance(const ElevationMap& map,
                              const Aircraft& aircraft,
                              const ApproachOptions& options);

// Path and terrain below it, from the start of the final to touchdown.
struct ApproachProfile {
  // Distance to touchdown, descending.
  std::vector<double> distance;
  std::vector<double> path_height;     // world z
  std::vector<double> terrain_height;  // highest in the corridor; NaN where unseen
};

// Free ground around a touchdown: a rectangle along the landing heading, in metres from touchdown.
// All cells that reach into the rectangle are kFree. Two steps give its size:
// 1. Length: the planner's corridor is extended ahead and behind while all its cells are kFree. The
//    half-width of the corridor is path_half_width_m plus the margin for the map's position.
// 2. Width: the rectangle is widened to each side, at its full length, while all its cells are
//    kFree.
// All 0 if the ground at the touchdown is not free.
struct LandingStrip {
  double ahead = 0.0;
  double behind = 0.0;
  double left = 0.0;
  double right = 0.0;

  double Length() const { return ahead + behind; }
  double Width() const { return left + right; }
};

enum class PathPart { kFinal, kCircle };

// The obstacle below a path with the least spare clearance (clearance minus wanted). An obstacle is
// a cell whose top is higher above the touchdown than a limit. The limit is max_roughness_m in a
// cell that is not kFree, else the safety margin. Lower cells do not count, because every final
// ends low above the ground.
struct PathObstacle {
  PathPart part = PathPart::kFinal;
  // Centre of the cell. z is the top of the obstacle, including the height allowance.
  Eigen::Vector3d place_in_world = Eigen::Vector3d::Zero();
  // Distance from the path above the obstacle to touchdown. On the final: along the final.
  double distance = 0.0;
  double clearance = 0.0;
  // Clearance that the planner needs there.
  double wanted = 0.0;
};

// A go-around: a straight climb with power along the landing heading. It clears all seen ground
// ahead by the safety margin, plus an amount for the tilt of the map. Unseen ground does not block
// the climb.
struct GoAround {
  // Distance from the point of no return to touchdown. This point is the last one on the final from
  // which the climb is clear. It lies outside the touchdown disc, and the path there is at least
  // safety_margin_m above the touchdown.
  double no_return_distance = 0.0;
  // The climb begins at the point of no return. It ends at the height of the start of the final,
  // beyond all seen ground ahead.
  Eigen::Vector3d start_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d end_in_world = Eigen::Vector3d::Zero();
  // Climb angle over ground, radians. It is less than climb_gradient_deg in a tail wind.
  double climb_angle = 0.0;
  // Share of the climb with unseen ground below it. Ground outside the map counts as unseen.
  double unseen_ratio = 0.0;
};

struct Approach {
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d approach_start_in_world = Eigen::Vector3d::Zero();
  // Direction of travel on final, radians clockwise from north.
  double heading = 0.0;
  double approach_distance = 0.0;
  double approach_height = 0.0;
  // Crosswind on final in the planned wind, m/s. 0 if the wind is unknown or calm.
  double crosswind = 0.0;
  // Ground speed on final in the planned wind, m/s. Empty if the wind is unknown.
  std::optional<double> ground_speed;
  double loiter_radius = 0.0;
  Eigen::Vector3d loiter_center_in_world = Eigen::Vector3d::Zero();
  LoiterDirection loiter_direction = LoiterDirection::kLeft;
  // Least clearance along the seen parts of the final and of the circle. The touchdown disc is left
  // out. NaN if no part was seen.
  double min_clearance = 0.0;
  // Unseen share of the chosen circle.
  double unseen_ratio = 0.0;
  // Corners of the strip that must be free for the ground roll. Empty without a ground roll.
  std::vector<Eigen::Vector3d> ground_roll_in_world;
  // Explanation::kNone leaves strip, obstacle, go_around and profile empty.
  std::optional<LandingStrip> strip;
  // The tightest obstacle in all scenarios of the wind. Empty if there is no obstacle.
  std::optional<PathObstacle> obstacle;
  // A climb that is clear in all scenarios of the wind. Empty if there is none, or if the plan is
  // rejected.
  std::optional<GoAround> go_around;
  ApproachProfile profile;
};

// Points of the loiter circle in the order of flight, beginning at the start of the final. The
// polyline is closed: it has num_points + 1 points, and the last point equals the first. If
// num_points is below 4, 4 is used.
std::vector<Eigen::Vector3d> LoiterPolyline(const Approach& approach, int num_points);

struct Rejection {
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  RejectReason reason = RejectReason::kNoSafeTouchdown;
  // One sentence with numbers, for people.
  std::string detail;
  std::optional<Eigen::Vector3d> obstacle_in_world;
};

// Result of one rule of the planner at one place.
struct PlaceRule {
  // seen, grass, slope, roughness, object, hazard_distance, outline, region, wind, ground_roll,
  // final, final_seen, circle, circle_seen, wind_known, risk; in this order. Recall adds
  // surroundings.
  std::string name;
  bool passed = false;
  // Measured value and its limit. Empty if unknown, or if the rule compares no numbers.
  std::optional<double> value = std::nullopt;
  std::optional<double> limit = std::nullopt;
  // "m", "deg", "m/s" or "ratio"; empty if the rule compares no numbers.
  std::string unit = {};
  // One sentence with numbers, for people.
  std::string sentence = {};
};

// The plan for one region. If rejected, it describes the least bad place and the rule it breaks.
struct Plan {
  Verdict verdict = Verdict::kRejected;
  std::optional<RejectReason> reject_reason;
  std::string reject_detail;
  // If rejected: the least bad place, or the footprint's centroid at ground_height if unseen.
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  double hazard_distance = 0.0;
  // Largest slope (radians) and largest roughness within the touchdown disc; NaN if unseen.
  double slope = 0.0;
  double roughness = 0.0;
  std::optional<Approach> approach;
  std::vector<Rejection> rejections;
  // Rules of the path to the touchdown. Empty if there is no path, and with Explanation::kNone.
  std::vector<PlaceRule> path_rules;
  // In the planned wind, else in calm. Empty where path_rules is.
  std::optional<LandingRisk> risk;
  // 1 - risk->failure_probability; a fifth of that if rejected. 0 without a risk.
  double score = 0.0;
};

// The planner's judgement of a touchdown at one place.
struct PlaceJudgement {
  // Verdict of PlanFor for this place alone. kRejected if a rule of the ground fails.
  Verdict verdict = Verdict::kRejected;
  // Rules that cannot be checked are left out: without a ground height there is no path or plan.
  std::vector<PlaceRule> rules;
  std::optional<Plan> plan;
  // Values of the map there: world z of the ground, deviation of this height, posterior of grass.
  std::optional<double> height, height_sd, grass_probability;

  // The first rule that fails; null if all pass.
  const PlaceRule* FirstFailed() const;
};

// The data of a region that are needed to plan for it.
struct PlanRequest {
  Polygon footprint;  // the touchdown lies in it; world
  double area_m2 = 0.0;
  double grade = 0.0;
  int num_observations = 0;
  int min_num_observations = 2;
  std::optional<Eigen::Vector2d> wind_in_world;
  // Deviation of the wind per axis (WindEstimate). 0 for a wind that was not measured.
  double wind_spread_mps = 0.0;
  // World z of the region, from coarse depth. Used as the touchdown's height if the map shows no
  // ground.
  double ground_height = 0.0;
};

// Within this distance of a touchdown, rounded up to 100 m, a plan reads the map: below finals and
// circles from the lowest start height, and at least `least`. wind_spread_mps: as in PlanRequest.
double PlanReach(const Aircraft& aircraft,
                 const std::optional<Eigen::Vector2d>& wind_in_world,
                 double wind_spread_mps,
                 double least,
                 const ApproachOptions& options);

// Plans the approach to one region. It tries several searches in this order:
// 1. headings into the wind;
// 2. headings with crosswind;
// 3. both again from each greater start height, if an obstacle blocked a circle.
// Planning ends with the first search that accepts a place. Each search tries the candidates that
// are farthest from hazard first:
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

// Whether a plan includes what people need: rejections, rules, risk, score, strip, tightest
// obstacle, go-around, profile. The other parts are identical.
enum class Explanation { kFull, kNone };

// Result of checking an approach on another map than the one on which it was planned.
struct ApproachCheck {
  // The first rule that seen ground breaks. Order of the rules: disc, ground roll, final, circle.
  // Unseen ground breaks no rule.
  std::optional<Rejection> rejection;
  // True if disc, ground roll and final are wholly seen.
  bool is_covered = false;
};

// Checks an unchanged approach on another map. The approach must be given in the frame of that map.
// `wind_in_world` is the wind for which the approach was planned. Absolute heights are not
// compared, because the altitudes of two flights differ by metres, or by tens of metres if their
// datums differ. Instead, the approach is shifted vertically until its touchdown lies on the ground
// of this map. If the map shows no ground in the touchdown disc, the shift is computed from the
// ground below the final and the stored profile. Throws like PlanApproach.
ApproachCheck CheckApproach(const Approach& approach,
                            const ElevationMap& map,
                            const HazardLayers& hazards,
                            const Aircraft& aircraft,
                            const std::optional<Eigen::Vector2d>& wind_in_world,
                            const ApproachOptions& options);
// Corners of a box, in world. CheckApproach reads only cells in this box.
Polygon CheckedGround(const Approach& approach,
                      const ElevationMap& map,
                      const Aircraft& aircraft,
                      const std::optional<Eigen::Vector2d>& wind_in_world,
                      const ApproachOptions& options);

// Plans for many winds at little cost each. Thread-safe. Map and hazards must outlive the planner.
class ApproachPlanner {
 public:
  // The planner ignores request.wind_in_world, with one exception: a plan for exactly this wind
  // allows for request.wind_spread_mps. Throws like PlanApproach.
  ApproachPlanner(const ElevationMap& map,
                  const HazardLayers& hazards,
                  const PlanRequest& request,
                  const Aircraft& aircraft,
                  const ApproachOptions& options);
  ~ApproachPlanner();
  ApproachPlanner(ApproachPlanner&&) noexcept;
  ApproachPlanner& operator=(ApproachPlanner&&) noexcept;

  Plan PlanFor(const std::optional<Eigen::Vector2d>& wind_in_world,
               Explanation explanation = Explanation::kFull) const;

  // Applies the rules of PlanFor to the cell at a place, for this wind. A place outside the map
  // counts as unseen. `options` must be those that the hazard layers were computed with.
  PlaceJudgement Judge(const Eigen::Vector2d& place_in_world,
                       const std::optional<Eigen::Vector2d>& wind_in_world,
                       const HazardOptions& options) const;

 private:
  std::unique_ptr<const struct ApproachGround> ground_;
};

// The winds of a wind rose: every combination of a speed and a direction.
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

  // Velocity of the air, m/s; points to where the air moves.
  Eigen::Vector2d WindInWorld(size_t speed, size_t direction) const;
  const Plan& At(size_t speed, size_t direction) const;
};

// Each plan equals planner.PlanFor(wind, Explanation::kNone) for its wind. Throws
// std::invalid_argument if the options are invalid.
// Calls `before_wind` before each of them; to give up, it throws.
WindRose PlanWindRose(
    const ApproachPlanner& planner,
    const WindRoseOptions& options,
    const std::function<void()>& before_wind = [] {});

}  // namespace freelsd
