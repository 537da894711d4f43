// Approaches over a flat field with known outlines.
#include "tests/evaluation/fields/site_judge.h"

#include <doctest/doctest.h>

#include "tests/evaluation/fields/distinct_sites.h"
#include "tests/evaluation/fields/labelled_fields.h"
#include "tests/evaluation/scores/blinding.h"

namespace freelsd {
namespace {

constexpr double kPositionSdM = 1.0;

Polygon Rectangle(double west, double south, double east, double north) {
  return {{west, south}, {east, south}, {east, north}, {west, north}};
}

GroundOutline Labelled(const std::string& id, OutlineKind kind, double height, Polygon outline) {
  return {id, kind, height, "photograph", std::move(outline)};
}

ElevationMap FlatMap() {
  ElevationMap map;
  map.grid = GridAround({-150.0, -150.0}, {150.0, 150.0}, 1.0);
  map.elevation = cv::Mat1f(map.grid.num_rows, map.grid.num_cols, 50.0f);
  map.upper = map.elevation.clone();
  return map;
}

// A meadow of 80 m by 80 m around the origin, and more.
LabelledGround GroundWith(std::vector<GroundOutline> more) {
  more.push_back(Labelled("meadow", OutlineKind::kLand, 0.0, Rectangle(-40, -40, 40, 40)));
  return MakeLabelledGround(more, FlatMap(), kPositionSdM);
}

// Northward to a touchdown on the map's height, down 8 degrees from 10 m.
Approach NorthTo(const Eigen::Vector2d& touchdown) {
  constexpr double kLengthM = 71.0, kHeightM = 10.0;
  Approach approach;
  approach.touchdown_in_world = {touchdown.x(), touchdown.y(), 50.0};
  approach.approach_start_in_world = {touchdown.x(), touchdown.y() - kLengthM, 50.0 + kHeightM};
  approach.heading = 0.0;
  approach.loiter_radius = 20.0;
  approach.loiter_center_in_world = {touchdown.x() + 20.0, touchdown.y() - kLengthM, 60.0};
  return approach;
}

SiteJudgement JudgeAt(const LabelledGround& ground, const Eigen::Vector2d& touchdown) {
  return JudgeApproach(ground, *AircraftProfile("small"), NorthTo(touchdown));
}

TEST_CASE("site judge: a site in the middle of land is right") {
  const SiteJudgement judgement = JudgeAt(GroundWith({}), {0.0, 0.0});
  CHECK(judgement.finding == Finding::kRight);
  CHECK(judgement.cause.empty());
}

TEST_CASE("site judge: ground in doubt and ground without an outline are not judged") {
  const LabelledGround ground =
      GroundWith({Labelled("rough", OutlineKind::kDoubt, 0.0, Rectangle(40, -40, 80, 40))});
  CHECK(JudgeAt(ground, {40.0, 0.0}).finding == Finding::kNotJudged);
  CHECK(JudgeAt(ground, {-38.0, 0.0}).finding == Finding::kNotJudged);
  CHECK(JudgeAt(ground, {500.0, 0.0}).finding == Finding::kNotJudged);
}

TEST_CASE("site judge: refused ground under the disc or the roll is false safe") {
  const LabelledGround ground =
      GroundWith({Labelled("bog", OutlineKind::kRefuse, 0.0, Rectangle(-5, 10, 5, 20))});
  const SiteJudgement disc = JudgeAt(ground, {0.0, 5.0});
  CHECK(disc.finding == Finding::kFalseSafe);
  CHECK(disc.cause == "disc: refuse");
  CHECK(disc.object_id == "bog");
  // The disc of 8 m ends before it, the roll of 15 m does not.
  CHECK(JudgeAt(ground, {0.0, 1.0}).cause == "roll: refuse");
  // Within the tolerance of 1 m at the end of the roll.
  CHECK(JudgeAt(ground, {0.0, -4.5}).finding == Finding::kRight);
  CHECK(JudgeAt(ground, {0.0, 30.0}).finding == Finding::kNotJudged);
}

TEST_CASE("site judge: a wall below the final is false safe where it reaches up to the path") {
  // At 20 m from touchdown, with the tolerance, the path is 2.96 m high.
  const auto with_wall = [](double height_m, OutlineKind kind) {
    return GroundWith({Labelled("line", kind, height_m, {{-30.0, -20.0}, {30.0, -20.0}})});
  };
  CHECK(JudgeAt(with_wall(2.5, OutlineKind::kWall), {0.0, 0.0}).finding == Finding::kRight);
  const SiteJudgement wall = JudgeAt(with_wall(3.5, OutlineKind::kWall), {0.0, 0.0});
  CHECK(wall.finding == Finding::kFalseSafe);
  CHECK(wall.cause == "final: wall");
  CHECK(!wall.is_only_thin);
  CHECK(JudgeAt(with_wall(3.5, OutlineKind::kFence), {0.0, 0.0}).is_only_thin);
  // Under the disc its height does not matter.
  CHECK(JudgeAt(with_wall(0.0, OutlineKind::kWall), {0.0, -18.0}).cause == "disc: wall");
  // Beside the corridor.
  const LabelledGround beside =
      GroundWith({Labelled("tree", OutlineKind::kTree, 9.0, Rectangle(12, -30, 18, -20))});
  CHECK(JudgeAt(beside, {0.0, 0.0}).finding == Finding::kRight);
}

TEST_CASE("site judge: land is where all views of it agree") {
  const LabelledGround ground =
      MakeLabelledGround({Labelled("f", OutlineKind::kLand, 0.0, Rectangle(-40, -40, 40, 40)),
                          Labelled("f", OutlineKind::kLand, 0.0, Rectangle(-38, -40, 42, 40))},
                         FlatMap(),
                         kPositionSdM);
  REQUIRE(ground.disagreement.num_pairs == 1);
  CHECK(ground.disagreement.median_m > 0.5);
  CHECK(ground.disagreement.median_m < 2.0);
  CHECK(ground.tolerance_m > kPositionSdM);
  const std::vector<LabelledField> fields = FieldsOf(ground);
  REQUIRE(fields.size() == 1);
  CHECK(std::abs(fields[0].area_m2 - 78.0 * 80.0) < 60.0);
  CHECK(!Contains(fields[0], ground.grid, {-39.0, 0.0}));
  CHECK(Contains(fields[0], ground.grid, {39.0, 0.0}));
}

TEST_CASE("labelled fields: an aircraft fits along a narrow field and not across it") {
  const LabelledGround ground = MakeLabelledGround(
      {Labelled("lane", OutlineKind::kLand, 0.0, Rectangle(-9, -40, 9, 40))}, FlatMap(), 1.0);
  const LabelledField field = FieldsOf(ground).at(0);
  const Aircraft small = *AircraftProfile("small");
  CHECK(Fits(field, ground.grid, small, {0.0, -3.0}));
  CHECK(!Fits(field, ground.grid, small, {-3.0, 0.0}));
  CHECK(Fits(field, ground.grid, small, {0.0, 0.0}));
  const LabelledGround with_tree =
      MakeLabelledGround({Labelled("lane", OutlineKind::kLand, 0.0, Rectangle(-9, -20, 9, 20)),
                          Labelled("tree", OutlineKind::kTree, 5.0, Rectangle(-2, -2, 2, 2))},
                         FlatMap(),
                         1.0);
  CHECK(!Fits(FieldsOf(with_tree).at(0), with_tree.grid, small, {0.0, -3.0}));
}

TEST_CASE("distinct sites: a place counts once in all winds, and is as bad as its worst wind") {
  const auto plan = [](double east, Finding finding, const std::string& wind) {
    JudgedPlan judged;
    judged.wind = wind;
    judged.approach = NorthTo({east, 0.0});
    judged.judgement.finding = finding;
    if (finding == Finding::kFalseSafe) judged.judgement.cause = "final: wall";
    return judged;
  };
  const std::vector<DistinctSite> sites =
      DistinctSites({plan(0.0, Finding::kRight, "calm"),
                     plan(15.0, Finding::kFalseSafe, "3 m/s from 090"),
                     plan(17.0, Finding::kRight, "calm"),
                     plan(18.0, Finding::kNotJudged, "6 m/s from 000")},
                    16.0);
  REQUIRE(sites.size() == 2);
  CHECK(sites[0].finding == Finding::kFalseSafe);
  CHECK(sites[0].num_plans == 2);
  CHECK(sites[0].shown.wind == "3 m/s from 090");
  CHECK(sites[0].causes.at("final: wall") == 1);
  CHECK(sites[1].finding == Finding::kNotJudged);
  CHECK(sites[1].num_plans == 2);
}

TEST_CASE("blinding: hazards are free, kinds are swapped, heights are doubled, unseen stays") {
  AssessedMap map{FlatMap(), {}};
  map.map.elevation(0, 0) = map.map.upper(0, 0) = 53.0f;
  map.layers.grid = map.map.grid;
  map.layers.hazard = cv::Mat1b(map.map.elevation.size(), kFree);
  map.layers.hazard(5, 5) = kHazard;
  map.layers.hazard(6, 6) = kUnseen;
  map.layers.grass = cv::Mat1f(map.map.elevation.size(), 1.0f);
  const auto blinded = [&](Blinding blinding) { return Blinded(map.map, map.layers, blinding); };
  const AssessedMap free = blinded(Blinding::kHazards);
  CHECK(free.layers.hazard(5, 5) == kFree);
  CHECK(free.layers.hazard(6, 6) == kUnseen);
  CHECK(free.layers.distance(6, 5) == 1.0f);
  const AssessedMap swapped = blinded(Blinding::kKinds);
  CHECK(swapped.layers.hazard(5, 5) == kFree);
  CHECK(swapped.layers.hazard(9, 9) == kHazard);
  CHECK(blinded(Blinding::kHeights).map.upper(0, 0) == 56.0f);
  CHECK(blinded(Blinding::kFlat).map.upper(0, 0) == 50.0f);
  CHECK(blinded(Blinding::kShift).map.grid.CellCenter(0, 0).x() ==
        map.map.grid.CellCenter(0, 0).x() + 5.0);
  CHECK(map.layers.hazard(5, 5) == kHazard);
}

}  // namespace
}  // namespace freelsd
