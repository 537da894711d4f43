#include "api/geojson.h"
#include "api/plan_json.h"

namespace freelsd {
namespace {

nlohmann::json NumberJson(const std::optional<double>& number) {
  return number ? Rounded(*number) : nlohmann::json(nullptr);
}

nlohmann::json RuleJson(const PlaceRule& rule) {
  return {{"rule", rule.name},
          {"passed", rule.passed},
          {"value", NumberJson(rule.value)},
          {"limit", NumberJson(rule.limit)},
          {"unit", rule.unit},
          {"sentence", rule.sentence}};
}

nlohmann::json EvidenceJson(const PlaceJudgement& judgement,
                            const Eigen::Vector2d& place_in_world,
                            const FlightContext& context) {
  nlohmann::json evidence{{"frames", nullptr},
                          {"height_m", nullptr},
                          {"height_sd_m", NumberJson(judgement.height_sd)},
                          {"grass_probability", NumberJson(judgement.grass_probability)},
                          {"risk", nullptr},
                          {"cues", nullptr}};
  if (judgement.plan && judgement.plan->risk) {
    evidence["risk"] = Rounded(judgement.plan->risk->failure_probability);
  }
  if (judgement.height) {
    const Eigen::Vector3d ground(place_in_world.x(), place_in_world.y(), *judgement.height);
    evidence["height_m"] = Rounded(AltitudeOf(ground, context.local_frame));
  }
  return evidence;
}

}  // namespace

nlohmann::json PlaceJudgementJson(const PlaceJudgement& judgement,
                                  const Eigen::Vector2d& place_in_world,
                                  const FlightContext& context) {
  nlohmann::json rules = nlohmann::json::array();
  for (const PlaceRule& rule : judgement.rules) rules.push_back(RuleJson(rule));
  const PlaceRule* const first_failed = judgement.FirstFailed();
  return {{"verdict", NameOf(judgement.verdict)},
          {"rules", rules},
          {"first_failed", first_failed ? nlohmann::json(first_failed->name) : nullptr},
          {"evidence", EvidenceJson(judgement, place_in_world, context)},
          {"altitude_datum", context.altitude_datum}};
}

}  // namespace freelsd
