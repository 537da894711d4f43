// What a later map shows of a plan's ground, and what it only fails to recognise.
#include "server/recall/other_maps/positive_evidence.h"

#include <cmath>

#include <doctest/doctest.h>

#include "tests/server/meadow.h"

namespace freelsd {
namespace {

constexpr float kToldSdM = 0.1f;

struct Landed {
  SiteMap ground = Meadow();
  StoredPlan plan;
  // The touchdown's cell.
  cv::Point touchdown;
};

// To the north, on the meadow.
Landed LandedOnMeadow() {
  Landed landed;
  landed.ground.map.standard_deviation.setTo(kToldSdM);
  Replan replan = ParseReplan(MeadowSite("amsl").replan_json);
  replan.request.wind_in_world = Eigen::Vector2d(0.0, -4.0);
  const StoredMapPlanner planner(replan, replan.flight.aircraft, landed.ground);
  const Plan plan = planner.planner.PlanFor(replan.request.wind_in_world);
  REQUIRE(plan.approach);
  landed.touchdown = *landed.ground.map.grid.CellAt(plan.touchdown_in_world.head<2>());
  landed.plan = AsStoredPlan(plan, std::move(replan));
  return landed;
}

MapRasters CopyOf(const SiteMap& from) {
  MapRasters copy{from, {}};
  for (cv::Mat1f* const layer : {&copy.site_map.map.elevation,
                                 &copy.site_map.map.upper,
                                 &copy.site_map.map.standard_deviation,
                                 &copy.site_map.layers.grass}) {
    *layer = layer->clone();
  }
  return copy;
}

std::optional<PlanCheck> Broken(const Landed& landed, const MapRasters& later) {
  const GeoPoint& origin = landed.plan.replan.origin;
  return BrokenByEvidence(landed.plan, {origin, {landed.ground, {}}}, {origin, later}, {});
}

// A square about a place of the meadow, metres from the touchdown to the east and to the south.
cv::Rect SquareAt(const Landed& landed, int east, int south, int side) {
  return {landed.touchdown.x + east - side / 2, landed.touchdown.y + south - side / 2, side, side};
}

void Raise(MapRasters& later, const cv::Rect& where, float height_m) {
  later.site_map.map.elevation(where) += height_m;
  later.site_map.map.upper(where) += height_m;
}

void AddNoise(MapRasters& later, double sd_m) {
  cv::theRNG().state = 5;
  cv::Mat1f noise(later.site_map.map.elevation.size());
  cv::randn(noise, 0.0, sd_m);
  later.site_map.map.elevation += noise;
  later.site_map.map.upper += noise;
}

TEST_CASE("evidence: snow, another datum, noise and a lost class show no change") {
  const Landed landed = LandedOnMeadow();
  MapRasters later = CopyOf(landed.ground);
  later.site_map.layers.grass.setTo(0.0f);
  CHECK_FALSE(Broken(landed, later));
  Raise(later, {0, 0, 600, 600}, 48.0f);
  CHECK_FALSE(Broken(landed, later));
  AddNoise(later, 2.0 * kToldSdM);
  CHECK_FALSE(Broken(landed, later));
  // Rough ground, by a texture that no height shows.
  later.site_map.layers.roughness = cv::Mat1f(600, 600, 2.0f);
  CHECK_FALSE(Broken(landed, later));
}

TEST_CASE("evidence: what stands or is dug breaks the plan") {
  const Landed landed = LandedOnMeadow();
  for (const float height_m : {1.5f, -1.5f}) {
    CAPTURE(height_m);
    MapRasters later = CopyOf(landed.ground);
    AddNoise(later, kToldSdM);
    Raise(later, SquareAt(landed, 3, 0, 5), height_m);
    later.site_map.layers.grass(SquareAt(landed, 3, 0, 5)).setTo(0.0f);
    const auto broken = Broken(landed, later);
    REQUIRE(broken);
    CHECK(broken->verdict == PlanVerdict::kFails);
    CHECK(broken->reason == RejectReason::kNoSafeTouchdown);
    // The same within three deviations that are told.
    later.site_map.map.standard_deviation.setTo(0.5f);
    CHECK_FALSE(Broken(landed, later));
  }
  MapRasters later = CopyOf(landed.ground);
  // Farther out, the circle would be blocked too.
  Raise(later, SquareAt(landed, 0, 25, 10), 12.0f);
  later.site_map.layers.grass(SquareAt(landed, 0, 25, 10)).setTo(0.0f);
  REQUIRE(Broken(landed, later));
  CHECK(Broken(landed, later)->reason == RejectReason::kApproachBlocked);
  // Beside the way it breaks nothing.
  MapRasters beside = CopyOf(landed.ground);
  Raise(beside, SquareAt(landed, 200, 200, 20), 12.0f);
  beside.site_map.layers.grass.setTo(0.0f);
  CHECK_FALSE(Broken(landed, beside));
}

TEST_CASE("evidence: a cell alone, and what allowances add, are no change") {
  const Landed landed = LandedOnMeadow();
  MapRasters later = CopyOf(landed.ground);
  later.site_map.layers.grass.setTo(0.0f);
  Raise(later, SquareAt(landed, 3, 0, 1), 3.0f);
  CHECK_FALSE(Broken(landed, later));
  // A narrow cover: only its upper height is raised.
  later.site_map.map.is_compared = true;
  later.site_map.map.upper(SquareAt(landed, 0, 20, 6)) += 4.0f;
  CHECK_FALSE(Broken(landed, later));
  later.site_map.map.upper(SquareAt(landed, 0, 20, 6)) += 8.0f;
  CHECK(Broken(landed, later));
}

TEST_CASE("evidence: a hedge that the later map shows a little aside has not moved") {
  Landed landed = LandedOnMeadow();
  const cv::Rect hedge(landed.touchdown.x - 100, landed.touchdown.y + 24, 200, 3);
  landed.ground.map.upper(hedge) += 2.0f;
  landed.ground.map.elevation(hedge) += 2.0f;
  landed.ground.map.position_sd_m = 1.5;
  MapRasters later = CopyOf(Meadow());
  later.site_map.map.standard_deviation.setTo(kToldSdM);
  later.site_map.layers.grass.setTo(0.0f);
  Raise(later, hedge + cv::Point(0, -4), 2.0f);
  CHECK_FALSE(Broken(landed, later));
}

TEST_CASE(
    "evidence: what stands in the way where the own map saw nothing blocks it by its height") {
  Landed landed = LandedOnMeadow();
  // The own map ends 30 m before the touchdown.
  const cv::Rect unseen(0, landed.touchdown.y + 30, 600, 570 - landed.touchdown.y);
  for (cv::Mat1f* const layer : {&landed.ground.map.elevation, &landed.ground.map.upper}) {
    (*layer)(unseen).setTo(std::nanf(""));
  }
  MapRasters later = CopyOf(Meadow());
  later.site_map.layers.grass.setTo(0.0f);
  CHECK_FALSE(Broken(landed, later));
  Raise(later, SquareAt(landed, 0, 50, 10), 12.0f);
  REQUIRE(Broken(landed, later));
  CHECK(Broken(landed, later)->reason == RejectReason::kApproachBlocked);
}

// The views recognised grass nearly everywhere, or had never seen the like.
MapRasters WithCue(const Landed& landed, const char* name, const cv::Rect& where, int8_t views) {
  MapRasters later = CopyOf(landed.ground);
  later.cues = {{"views", cv::Mat_<int8_t>(600, 600, views)},
                {name, cv::Mat_<int8_t>::zeros(600, 600)}};
  later.cues[1].steps(where).setTo(CueSteps::kVeto);
  later.site_map.layers.grass(where).setTo(0.0f);
  return later;
}

TEST_CASE("evidence: cues of things count where the views know the ground, other cues never") {
  const Landed landed = LandedOnMeadow();
  const cv::Rect where = SquareAt(landed, 3, 0, 2);
  for (const char* const thing : {"small_object", "fence"}) {
    CHECK(Broken(landed, WithCue(landed, thing, where, CueSteps::kMost)));
    for (const int8_t unsure : {CueSteps::kUnknown, int8_t{0}}) {
      CHECK_FALSE(Broken(landed, WithCue(landed, thing, where, unsure)));
    }
  }
  CHECK_FALSE(Broken(landed, WithCue(landed, "look_alike", where, CueSteps::kMost)));
}

}  // namespace
}  // namespace freelsd
