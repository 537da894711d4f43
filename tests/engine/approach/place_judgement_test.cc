#include <set>

#include <doctest/doctest.h>

#include "engine/approach/touchdown.h"
#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

using scene::Box;
using scene::Nimble;
using scene::OneWay;
using scene::Scene;

const Eigen::Vector2d kToSouth(0.0, -4.0);  // the final leads north

HazardLimits LimitsOf(const Aircraft& aircraft) {
  return {aircraft.max_slope_deg, aircraft.max_roughness_m};
}

// Fills one layer within a box.
void Fill(Scene& on, cv::Mat1f& layer, const Polygon& box, float value) {
  scene::ForCells(on, box[0], box[2], [&](int row, int col) { layer(row, col) = value; });
}

// A field of 160 m with one thing of each kind that a rule is about, classes by the real rules.
Scene MixedField(const Aircraft& aircraft) {
  Scene field = scene::FlatMeadow(80, 80, 2.0);
  Fill(field, field.hazards.grass, Box({-80, 30}, {-62, 50}), 0.3f);
  Fill(field, field.hazards.grass, Box({-80, -20}, {-70, -10}), std::nanf(""));
  Fill(field, field.hazards.slope, Box({40, 20}, {60, 40}), 0.3f);
  Fill(field, field.hazards.roughness, Box({64, -20}, {80, 0}), 2.0f);
  Fill(field, field.map.standard_deviation, Box({-10, 66}, {10, 80}), 1.5f);
  scene::AddBlock(field, {-30, -30}, {-26, -26}, 9.0);
  scene::AddUnseen(field, {10, -70}, {24, -60});
  field.hazards = WithLimits(field.map, field.hazards, LimitsOf(aircraft), {});
  return field;
}

bool IsOfGround(const PlaceRule& rule) {
  const std::set<std::string> names{
      "seen", "grass", "slope", "roughness", "object", "hazard_distance", "outline", "region"};
  return names.count(rule.name) > 0;
}

bool PassesGround(const PlaceJudgement& judgement) {
  return std::all_of(judgement.rules.begin(), judgement.rules.end(), [](const PlaceRule& rule) {
    return rule.passed || !IsOfGround(rule);
  });
}

const PlaceRule& RuleOf(const PlaceJudgement& judgement, const std::string& name) {
  const auto found = std::find_if(judgement.rules.begin(),
                                  judgement.rules.end(),
                                  [&](const PlaceRule& rule) { return rule.name == name; });
  REQUIRE(found != judgement.rules.end());
  return *found;
}

// Every cell that the planner may choose as a touchdown.
std::set<std::pair<int, int>> CandidatesOf(const Scene& field,
                                           const PlanRequest& request,
                                           const Aircraft& aircraft,
                                           ApproachOptions options) {
  options.max_num_reserve_candidates = 1000000;
  const FootprintContent content = ReadFootprint(field.map, field.hazards, request.footprint);
  const TouchdownCandidates candidates =
      SelectCandidates(content.touchdowns,
                       RequiredHazardDistance(field.map, aircraft, options),
                       field.map.grid.cell_size_m,
                       options);
  std::set<std::pair<int, int>> cells;
  for (const Touchdown& each : candidates.reserve) cells.insert({each.row, each.col});
  return cells;
}

TEST_CASE("why not here: a height that is known is not called unknown") {
  const Aircraft aircraft = Nimble();
  Scene field = MixedField(aircraft);
  Fill(field, field.map.standard_deviation, Box({-10, -10}, {10, 10}), std::nanf(""));
  field.hazards = WithLimits(field.map, field.hazards, LimitsOf(aircraft), {});
  const PlanRequest request = scene::Request(Box({-80, -80}, {80, 80}), kToSouth);
  const ApproachPlanner planner(field.map, field.hazards, request, aircraft, {});
  const PlaceJudgement known = planner.Judge({0, 0}, kToSouth, {});
  REQUIRE(known.height);
  CHECK(RuleOf(known, "seen").sentence.find("No height of the ground") == std::string::npos);
  const PlaceJudgement unseen = planner.Judge({17, -65}, kToSouth, {});
  CHECK_FALSE(unseen.height);
  CHECK(RuleOf(unseen, "seen").sentence.find("No height of the ground") == 0);
}

TEST_CASE("why not here: the ground passes exactly where the planner takes a candidate") {
  const Aircraft aircraft = Nimble();
  const Scene field = MixedField(aircraft);
  const PlanRequest request = scene::Request(Box({-60, -65}, {60, 65}), kToSouth);
  const ApproachPlanner planner(field.map, field.hazards, request, aircraft, OneWay());
  const auto candidates = CandidatesOf(field, request, aircraft, OneWay());
  REQUIRE(candidates.size() > 100);
  std::set<std::string> failed_first;
  int num_landable = 0;
  for (int row = 0; row < field.map.grid.num_rows; ++row) {
    for (int col = 0; col < field.map.grid.num_cols; ++col) {
      CAPTURE(row);
      CAPTURE(col);
      const PlaceJudgement judgement = planner.Judge(field.CellCenter(row, col), kToSouth, {});
      REQUIRE(PassesGround(judgement) == (candidates.count({row, col}) > 0));
      if (const PlaceRule* const first = judgement.FirstFailed()) failed_first.insert(first->name);
      num_landable += judgement.verdict == Verdict::kLandable;
    }
  }
  CHECK(num_landable > 0);
  for (const char* const name : {"seen",
                                 "grass",
                                 "slope",
                                 "roughness",
                                 "hazard_distance",
                                 "outline",
                                 "final",
                                 "circle_seen"}) {
    CAPTURE(name);
    CHECK(failed_first.count(name) == 1);
  }
}

TEST_CASE("why not here: the verdict is the planner's for a region of this one cell") {
  const Aircraft aircraft = Nimble();
  const Scene field = MixedField(aircraft);
  const PlanRequest request = scene::Request(Box({-80, -80}, {80, 80}), kToSouth);
  const ApproachPlanner planner(field.map, field.hazards, request, aircraft, {});
  const std::vector<std::optional<Eigen::Vector2d>> winds{
      kToSouth, Eigen::Vector2d(0.0, 0.2), Eigen::Vector2d(30.0, 0.0), std::nullopt};
  for (size_t i = 0; i < winds.size(); ++i) {
    for (int cell = 0; cell < 80 * 80; cell += 61) {
      const Eigen::Vector2d place = field.CellCenter(cell / 80, cell % 80);
      CAPTURE(i);
      CAPTURE(place.transpose());
      const Eigen::Vector2d corner(0.9, 0.9);
      const Plan plan = PlanApproach(field.map,
                                     field.hazards,
                                     scene::Request(Box(place - corner, place + corner), winds[i]),
                                     aircraft,
                                     {});
      const PlaceJudgement judgement = planner.Judge(place, winds[i], {});
      REQUIRE(judgement.verdict == plan.verdict);
      const bool is_landable = judgement.FirstFailed() == nullptr;
      REQUIRE(is_landable == (plan.verdict == Verdict::kLandable));
    }
  }
}

TEST_CASE("why not here: numbers of the rules are the planner's, with margins") {
  const Aircraft aircraft = Nimble();
  const Scene field = MixedField(aircraft);
  const PlanRequest request = scene::Request(Box({-80, -80}, {80, 80}), kToSouth);
  const ApproachPlanner planner(field.map, field.hazards, request, aircraft, OneWay());
  const auto at = [&](double east, double north) {
    return planner.Judge({east, north}, kToSouth, {});
  };
  const PlaceJudgement grazing = at(35.0, 31.0);  // 6 m from the steep ground
  CHECK(grazing.FirstFailed()->name == "hazard_distance");
  CHECK(grazing.FirstFailed()->value == doctest::Approx(6.0));
  CHECK(grazing.FirstFailed()->limit ==
        doctest::Approx(RequiredHazardDistance(field.map, aircraft, {})));
  CHECK(RuleOf(at(50.0, 30.0), "slope").value == doctest::Approx(DegFromRad(0.3)));
  CHECK(RuleOf(at(50.0, 30.0), "slope").limit == doctest::Approx(aircraft.max_slope_deg));
  CHECK(at(-70.0, 40.0).FirstFailed()->name == "grass");
  CHECK(at(-28.0, -28.0).FirstFailed()->name == "object");
  CHECK(*RuleOf(at(-28.0, -28.0), "object").value == doctest::Approx(9.0));
  // The final to a place north of the block meets it.
  const PlaceJudgement behind = at(-28.0, 5.0);
  CHECK(behind.FirstFailed()->name == "final");
  CHECK(behind.verdict == Verdict::kRejected);
  CHECK(*behind.FirstFailed()->value < *behind.FirstFailed()->limit);
}

TEST_CASE("why not here: without a height no path is tried, and off the map nothing is seen") {
  const Aircraft aircraft = Nimble();
  const Scene field = MixedField(aircraft);
  const PlanRequest request = scene::Request(Box({-80, -80}, {80, 80}), kToSouth);
  const ApproachPlanner planner(field.map, field.hazards, request, aircraft, {});
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(17.0, -65.0),
                                       Eigen::Vector2d(81.0, 0.0),
                                       Eigen::Vector2d(-1e9, 1e9),
                                       Eigen::Vector2d(std::nan(""), 0.0)}) {
    const PlaceJudgement judgement = planner.Judge(place, kToSouth, {});
    CHECK(judgement.verdict == Verdict::kRejected);
    CHECK(judgement.FirstFailed()->name == "seen");
    CHECK_FALSE(judgement.height);
    for (const PlaceRule& rule : judgement.rules) CHECK(rule.name != "final");
  }
}

TEST_CASE(
    "why not here: unknown wind is at most unverified, wind that stops the aircraft is told") {
  const Scene meadow = scene::FlatMeadow(200, 200, 2.0);
  const PlanRequest request = scene::Request(Box({-20, -20}, {20, 20}), std::nullopt);
  const ApproachPlanner planner(meadow.map, meadow.hazards, request, Nimble(), {});
  CHECK(planner.Judge({0, 0}, Eigen::Vector2d(3, 0), {}).FirstFailed() == nullptr);
  const PlaceJudgement unknown = planner.Judge({0, 0}, std::nullopt, {});
  CHECK(unknown.verdict == Verdict::kUnverified);
  CHECK(unknown.FirstFailed()->name == "wind_known");
  const PlaceJudgement storm = planner.Judge({0, 0}, Eigen::Vector2d(30, 0), {});
  CHECK(storm.verdict == Verdict::kRejected);
  CHECK(storm.FirstFailed()->name == "wind");
  CHECK(*storm.FirstFailed()->value < *storm.FirstFailed()->limit);
}

TEST_CASE(
    "why not here: a region that is refused as a whole is told, with the rules of the place") {
  const Scene meadow = scene::FlatMeadow(200, 200, 2.0);
  PlanRequest request = scene::Request(Box({-20, -20}, {20, 20}), kToSouth);
  request.area_m2 = 10.0;
  const ApproachPlanner planner(meadow.map, meadow.hazards, request, Nimble(), {});
  const PlaceJudgement judgement = planner.Judge({0, 0}, kToSouth, {});
  CHECK(judgement.verdict == Verdict::kRejected);
  CHECK(judgement.FirstFailed()->name == "region");
  CHECK(RuleOf(judgement, "final").passed);
}

}  // namespace
}  // namespace freelsd
