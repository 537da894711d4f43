#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "engine/approach/approach.h"
#include "engine/approach/approach_ground.h"
#include "engine/approach/attempt_verdict.h"
#include "engine/approach/path_rules.h"

namespace freelsd {
namespace {

std::optional<double> IfKnown(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::string Fixed(double value, int num_decimals) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(num_decimals);
  text << value;
  return text.str();
}

// "0.42 m", or "unknown".
std::string Known(double value, int num_decimals, const std::string& unit) {
  return std::isfinite(value) ? Fixed(value, num_decimals) + unit : "unknown";
}

// Name of a cell's rule, and the words and the format of its numbers.
struct Wording {
  const char* name;
  const char* unit;
  const char* subject;
  const char* suffix;
  int num_decimals;
};

Wording WordingOf(CellCondition condition) {
  switch (condition) {
    case CellCondition::kSeen:
      return {"seen", "m", "The standard deviation of the ground's height", " m", 2};
    case CellCondition::kGrass:
      return {"grass", "ratio", "The probability of grass", "", 2};
    case CellCondition::kNotSteep:
      return {"slope", "deg", "The slope", " deg", 1};
    case CellCondition::kNotRough:
      return {"roughness", "m", "The roughness", " m", 2};
    case CellCondition::kNoObject:
      break;
  }
  return {"object", "m", "What stands on the ground", " m", 2};
}

std::string CellSentence(const CellRule& rule,
                         const Wording& wording,
                         double value,
                         double limit,
                         bool is_height_known) {
  const bool is_unexplained =
      rule.condition == CellCondition::kSeen && !rule.passed && value <= limit;
  if (is_unexplained) return "Too little ground around the place was seen to know its slope.";
  if (rule.condition == CellCondition::kSeen && !std::isfinite(value)) {
    return is_height_known ? "How exact the height of the ground is here is not known. Ground that "
                             "was not measured is never safe."
                           : "No height of the ground is known here. Unseen ground is never safe.";
  }
  const bool is_least = rule.condition == CellCondition::kGrass;
  return std::string(wording.subject) + " is " +
         Known(value, wording.num_decimals, wording.suffix) + "; at " +
         (is_least ? "least " : "most ") + Known(limit, wording.num_decimals, wording.suffix) +
         (is_least ? " is needed." : " is allowed.");
}

PlaceRule RuleOf(const CellRule& rule, bool is_height_known) {
  const Wording wording = WordingOf(rule.condition);
  const bool is_angle = rule.condition == CellCondition::kNotSteep;
  const double value = is_angle ? DegFromRad(rule.value) : rule.value;
  const double limit = is_angle ? DegFromRad(rule.limit) : rule.limit;
  return {.name = wording.name,
          .passed = rule.passed,
          .value = IfKnown(value),
          .limit = IfKnown(limit),
          .unit = wording.unit,
          .sentence = CellSentence(rule, wording, value, limit, is_height_known)};
}

PlaceRule DistanceRule(const Touchdown& touchdown, double required) {
  return {.name = "hazard_distance",
          .passed = IsFarEnough(touchdown.hazard_distance, required),
          .value = touchdown.hazard_distance,
          .limit = IfKnown(required),
          .unit = "m",
          .sentence = "The nearest hazard or unseen ground is " +
                      Fixed(touchdown.hazard_distance, 1) + " m away; " + Known(required, 1, " m") +
                      " are needed for the disc of touchdown and the uncertainty of the map."};
}

PlaceRule OutlineRule(const ApproachGround& ground, const cv::Point& cell) {
  const std::vector<cv::Point> cells = ground.request.footprint.size() < 3
                                           ? std::vector<cv::Point>{}
                                           : ground.map.grid.CellsIn(ground.request.footprint);
  const bool is_inside = std::find(cells.begin(), cells.end(), cell) != cells.end();
  return {.name = "outline",
          .passed = is_inside,
          .sentence = is_inside ? "The place lies in the outline of the region."
                                : "The place lies outside the region: touchdowns of this site are "
                                  "searched in its outline only."};
}

PlaceRule RegionRule(const ApproachGround& ground) {
  const std::optional<Refusal>& refusal = ground.refusal_of_region;
  return {.name = "region",
          .passed = !refusal,
          .sentence = refusal ? Sentence(refusal->detail)
                              : "The region is large enough and was seen as grass."};
}

PlaceRule WindRule(const WindCase& wind, const Aircraft& aircraft) {
  PlaceRule rule{.name = "wind", .passed = !wind.is_too_strong, .unit = "m/s"};
  rule.limit = aircraft.min_ground_speed_mps;
  if (const auto refusal = RefuseWind(wind, aircraft)) {
    rule.value = IfKnown(wind.ground_speed);
    rule.sentence = Sentence(refusal->detail);
    return rule;
  }
  const std::optional<double> speed = wind.headings.front().scenarios.front().ground_speed;
  rule.value = speed;
  rule.sentence = speed ? "The ground speed on final is " + Fixed(*speed, 1) + " m/s; at least " +
                              Fixed(*rule.limit, 1) + " m/s is needed."
                        : "No wind is known that is too strong.";
  return rule;
}

// The ground, as if this were the only place to touch down.
ApproachGround AtPlace(const ApproachGround& ground, const Touchdown& touchdown) {
  const double half = 0.5 * ground.map.grid.cell_size_m;
  const Eigen::Vector2d place = touchdown.place_in_world.head<2>();
  ApproachGround here = ground;
  here.request.footprint = {place + Eigen::Vector2d(-half, -half),
                            place + Eigen::Vector2d(half, -half),
                            place + Eigen::Vector2d(half, half),
                            place + Eigen::Vector2d(-half, half)};
  here.safest = touchdown;
  here.refusal.reset();
  here.candidates = {{touchdown}, {}};
  return here;
}

PlaceJudgement UnseenPlace() {
  PlaceJudgement judgement;
  judgement.rules = {
      {.name = "seen",
       .passed = false,
       .sentence = "The map does not cover this place. Unseen ground is never safe."}};
  return judgement;
}

// The rules of the ground, without a path.
PlaceJudgement JudgeGround(const ApproachGround& ground,
                           const cv::Point& cell,
                           const HazardOptions& options) {
  const HazardLimits limits{ground.aircraft.max_slope_deg, ground.aircraft.max_roughness_m};
  PlaceJudgement judgement;
  judgement.height = IfKnown(ground.map.elevation(cell));
  for (const CellRule& rule : CellRulesAt(ground.map, ground.hazards, cell, limits, options)) {
    judgement.rules.push_back(RuleOf(rule, judgement.height.has_value()));
  }
  judgement.rules.push_back(
      DistanceRule(TouchdownAt(ground.map, ground.hazards, cell), ground.required_hazard_distance));
  judgement.rules.push_back(OutlineRule(ground, cell));
  judgement.rules.push_back(RegionRule(ground));
  judgement.height_sd = IfKnown(ground.map.standard_deviation(cell));
  judgement.grass_probability = IfKnown(ground.hazards.grass(cell));
  return judgement;
}

}  // namespace

const PlaceRule* PlaceJudgement::FirstFailed() const {
  const auto failed =
      std::find_if(rules.begin(), rules.end(), [](const PlaceRule& rule) { return !rule.passed; });
  return failed == rules.end() ? nullptr : &*failed;
}

PlaceJudgement ApproachPlanner::Judge(const Eigen::Vector2d& place_in_world,
                                      const std::optional<Eigen::Vector2d>& wind_in_world,
                                      const HazardOptions& options) const {
  const auto cell = ground_->map.grid.CellAt(place_in_world);
  if (!cell) return UnseenPlace();
  PlaceJudgement judgement = JudgeGround(*ground_, *cell, options);
  const bool is_ground_good = judgement.FirstFailed() == nullptr;
  judgement.rules.push_back(WindRule(
      MakeWindCase(wind_in_world, ground_->aircraft, ground_->options), ground_->aircraft));
  if (!judgement.height) return judgement;
  const Touchdown touchdown = TouchdownAt(ground_->map, ground_->hazards, *cell);
  Plan plan = AtPlace(*ground_, touchdown).PlanWind(wind_in_world, Explanation::kFull);
  judgement.rules.insert(judgement.rules.end(), plan.path_rules.begin(), plan.path_rules.end());
  if (is_ground_good) judgement.verdict = plan.verdict;
  judgement.plan = std::move(plan);
  return judgement;
}

}  // namespace freelsd
