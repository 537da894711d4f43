#include <doctest/doctest.h>

#include "tests/evaluation/look/look_report.h"
#include "tests/evaluation/look/look_world.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

Json OutcomeWorth(double landing_value) {
  return {{"landing_value", landing_value}, {"num_false_safe", 0}, {"num_only_thin", 0}};
}

Json RecordOf(uint64_t seed, double suggested, const std::vector<double>& random) {
  Json record{{"seed", seed}, {"aircraft", "small"}, {"before", OutcomeWorth(1.0)}};
  record["suggested"] = OutcomeWorth(suggested);
  record["suggested"]["expected_gain"] = 2.0;
  record["random"] = Json::array();
  for (const double value : random) record["random"].push_back(OutcomeWorth(value));
  return record;
}

TEST_CASE("look: gains count from the survey alone, and ties count half") {
  const Json gains = LookGains(RecordOf(1, 3.0, {1.0, 2.0, 3.0, 4.0}));
  CHECK(gains["suggested"] == 2.0);
  CHECK(gains["random_mean"] == 1.5);
  CHECK(gains["random_75"] == 2.25);
  CHECK(gains["random_best"] == 3.0);
  CHECK(gains["percentile"] == 62.5);
  CHECK(gains["advantage"] == 0.5);
}

TEST_CASE("look: the interval holds the mean, and legs that gain nothing have no advantage") {
  const Json records{RecordOf(1, 3.0, {1.0, 2.0}), RecordOf(2, 1.0, {1.0, 1.0})};
  const Json totals = LookReport({}, records)["totals"];
  CHECK(totals["advantage"]["mean"] == 0.75);
  CHECK(totals["advantage"]["low"] <= 0.75);
  CHECK(totals["advantage"]["high"] >= 0.75);
  CHECK(totals["advantage"]["low"] >= 0.0);
  CHECK(totals["num_worlds_at_75"] == 2);
}

TEST_CASE("look: legs may be photographed in any order, and random ones stay in the area") {
  LookWorldOptions options;
  options.num_survey_legs = 2;
  options.survey_leg_m = 60.0;
  options.look_leg_m = 60.0;
  const LookWorld world(1000, options);
  // The western leg of 60 m, photographed every 30 m.
  CHECK(world.survey().size() == 3);
  const SyntheticLeg leg = world.RandomLeg(4);
  CHECK((leg.to - leg.from).norm() == doctest::Approx(60.0));
  CHECK(world.area().DistanceTo(leg.from) == 0.0);
  CHECK(world.area().DistanceTo(leg.to) == 0.0);
  const std::vector<Frame> first = world.Photograph(leg);
  world.Photograph(world.RandomLeg(1));
  const std::vector<Frame> again = world.Photograph(leg);
  REQUIRE(first.size() == again.size());
  CHECK(first[0].prior.position_in_world == again[0].prior.position_in_world);
  CHECK(cv::norm(first[0].image, again[0].image, cv::NORM_INF) == 0.0);
  CHECK(first[0].timestamp_us > world.survey().back().timestamp_us);
}

}  // namespace
}  // namespace freelsd
