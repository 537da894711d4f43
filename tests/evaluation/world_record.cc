#include "tests/evaluation/world_record.h"

#include <algorithm>
#include <cmath>

#include "api/plan_json.h"
#include "tests/evaluation/heights/height_totals.h"
#include "tests/evaluation/scores/field_scores.h"
#include "tests/evaluation/scores/flown_site.h"
#include "tests/evaluation/scores/landing_risks.h"
#include "tests/evaluation/scores/obstruction.h"
#include "tests/evaluation/scores/things.h"
#include "tests/evaluation/site_score.h"
#include "tests/evaluation/stage_scores.h"
#include "tests/evaluation/statistics.h"
#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

// A region has to do with a field when it holds this share of its ground.
constexpr double kMinShareOfField = 0.2;

double Rounded(double value) { return std::round(value * 100.0) / 100.0; }
Json Place(const Eigen::Vector2d& place) { return {Rounded(place.x()), Rounded(place.y())}; }

// What a place truly is: a row of the table of decoys.
std::string GroundAt(const TruthMap& truth, const Fields& fields, const Eigen::Vector2d& place) {
  if (place.cwiseAbs().maxCoeff() >= 0.5 * truth.size_m) return "outside";
  const int field = FieldAt(fields, truth, place);
  if (field > 0) {
    return fields.fields[static_cast<size_t>(field - 1)].is_landable ? "true field"
                                                                     : "approach blocked";
  }
  const cv::Point cell = truth.CellAt(place);
  const std::string fault = NameOfFault(truth, cell);
  if (fault == "steep" || fault == "rough") return "too " + fault;
  return fault.empty() ? "too small" : fault;
}

void AddSafety(Json& json, const std::optional<SafetyScore>& score, const Plan& plan) {
  json["is_false_safe"] = false;
  json["is_only_thin"] = false;
  json["is_in_doubt"] = false;
  if (!score) return;
  json["ground_fault"] = score->ground_fault;
  json["final_fault"] = score->final_fault;
  json["loiter_fault"] = score->loiter_fault;
  json["free_distance_m"] = Rounded(score->free_distance);
  json["final_clearance_m"] = Rounded(score->final_clearance);
  json["final_worst_m"] = Place(score->final_worst_place);
  json["loiter_clearance_m"] = Rounded(score->loiter_clearance);
  json["is_only_thin"] = score->IsOnlyThin(plan.verdict);
  json["is_in_doubt"] = score->IsInDoubt(plan.verdict);
  json["is_false_safe"] = score->IsFalseSafe(plan.verdict) && !score->IsOnlyThin(plan.verdict);
}

Json SiteJson(const Site& site,
              const Scenario& scenario,
              const TruthMap& truth,
              const Fields& fields,
              const Eigen::Vector2d& shift) {
  const Plan& plan = site.plan;
  const Eigen::Vector2d touchdown = plan.touchdown_in_world.head<2>();
  Json json{{"region", site.region.id},
            {"verdict", NameOf(plan.verdict)},
            {"reason", plan.reject_reason ? NameOf(*plan.reject_reason) : std::string()},
            {"detail", plan.reject_detail},
            {"touchdown_m", Place(touchdown)},
            {"hazard_distance_m", Rounded(plan.hazard_distance)},
            {"field", FieldAt(fields, truth, touchdown)},
            {"ground", GroundAt(truth, fields, touchdown)}};
  const World& world = scenario.world;
  AddSafety(json, ScorePlan(world, truth, scenario.aircraft, plan, Eigen::Vector2d::Zero()), plan);
  const auto unshifted = ScorePlan(world, truth, scenario.aircraft, plan, shift);
  json["is_false_safe_without_shift"] =
      unshifted && unshifted->IsFalseSafe(plan.verdict) && !unshifted->IsOnlyThin(plan.verdict);
  if (plan.approach) {
    json["unseen_ratio"] = Rounded(plan.approach->unseen_ratio);
    json["heading_deg"] = Rounded(DegFromRad(plan.approach->heading));
    json["approach_distance_m"] = Rounded(plan.approach->approach_distance);
  }
  if (plan.risk) json["failure_probability"] = RoundedNumber(plan.risk->failure_probability);
  if (site.wind) {
    json["wind_error_mps"] = Rounded((site.wind->wind_in_world - world.wind_in_world).norm());
  }
  return json;
}

Json FlownJson(const FlownSite& flown) {
  return {{"num_flown", flown.num_flown},
          {"num_failed", flown.num_failed},
          {"num_failed_thin", flown.num_failed_thin},
          {"causes", flown.causes},
          {"thin_causes", flown.thin_causes},
          {"height_bias_m", Rounded(flown.height_bias)},
          {"absolute",
           {{"num_failed", flown.absolute.num_failed},
            {"num_failed_thin", flown.absolute.num_failed_thin},
            {"num_short", flown.absolute.num_short},
            {"num_long", flown.absolute.num_long}}},
          {"absolute_landing_place_m", RoundedNumber(flown.absolute.landing_place.Mean())}};
}

// Share of a field's ground within a region.
double ShareIn(const Region& region, const Field& field, const TruthMap& truth, const Fields& all) {
  const Polygon footprint = region.Footprint();
  if (footprint.size() < 3) return 0.0;
  int num_inside = 0, num_cells = 0;
  constexpr int kStep = 3;
  for (int row = 0; row < all.label.rows; row += kStep) {
    for (int col = 0; col < all.label.cols; col += kStep) {
      if (all.label(row, col) != field.id) continue;
      ++num_cells;
      num_inside += Contains(footprint, truth.CellCenter(row, col));
    }
  }
  return num_cells == 0 ? 0.0 : static_cast<double>(num_inside) / num_cells;
}

// Which stage lost a field, or why the site on it was refused.
std::string FateOf(const Field& field,
                   const EngineRun& run,
                   const TruthMap& truth,
                   const Fields& all) {
  const auto concerns = [&](const Region& region) {
    return Contains(region.Footprint(), field.touchdown) ||
           ShareIn(region, field, truth, all) >= kMinShareOfField;
  };
  std::string fate = "no region";
  for (const Region& region : run.regions) {
    if (concerns(region)) fate = "region without a grade";
  }
  for (const Site& site : run.evaluation.sites) {
    if (!concerns(site.region)) continue;
    if (FieldAt(all, truth, site.plan.touchdown_in_world.head<2>()) == field.id) {
      if (site.plan.verdict != Verdict::kRejected) return "found";
      return NameOf(*site.plan.reject_reason);
    }
    fate = site.plan.verdict == Verdict::kRejected ? NameOf(*site.plan.reject_reason)
                                                   : std::string("touchdown elsewhere");
  }
  return fate;
}

// A region that covers several fields has its site in another one: the planner's own reason tells
// more.
std::string FateAfterAsking(const std::string& fate, const FieldScore& score) {
  if (score.is_found) return "found";
  return fate == "touchdown elsewhere" ? score.lost_reason : fate;
}

Json FieldJson(const Field& field, const FieldScore& score, const std::string& fate) {
  return {{"id", field.id},
          {"area_m2", field.area_m2},
          {"is_landable", field.is_landable},
          {"is_seen", field.num_seen_touchdowns > 0},
          {"num_touchdowns", field.num_touchdowns},
          {"touchdown_m", Place(field.touchdown)},
          {"free_radius_m", Rounded(field.free_radius)},
          {"has_loiter", field.has_loiter},
          {"is_found", score.is_found},
          {"fate", FateAfterAsking(fate, score)},
          {"is_accepted_on_truth", score.is_accepted_on_truth},
          {"reason_on_truth", score.reason_on_truth},
          {"best_touchdown_m", Place(score.touchdown)},
          {"fault_on_truth", score.fault_on_truth},
          {"is_only_thin_on_truth", score.is_only_thin_on_truth},
          {"photographed_ratio", score.photographed_ratio},
          {"lost_reason", score.lost_reason}};
}

// What the frontend knew in the end, with its history over the frames: the paper's plots.
Json RegionJson(const Region& region) {
  Json json{{"id", region.id},
            {"grade", region.grade},
            {"area_m2", std::round(region.area_m2)},
            {"num_observations", region.num_observations},
            {"num_grass_observations", region.num_grass_observations},
            {"is_fixed", region.is_fixed},
            {"corners_m", Json::array()},
            {"history", Json::array()}};
  for (const Eigen::Vector2d& corner : region.Footprint())
    json["corners_m"].push_back(Place(corner));
  for (const RegionHistory& state : region.history) {
    json["history"].push_back({state.frame_id,
                               state.num_observations,
                               state.num_grass_observations,
                               Rounded(state.grade),
                               std::round(state.area_m2)});
  }
  return json;
}

Json PosesJson(const PoseScore& score) {
  return {{"num_views", score.num_views},
          {"num_connected", score.num_connected},
          {"horizontal_before_m", ToJson(score.horizontal_before)},
          {"horizontal_after_m", ToJson(score.horizontal_after)},
          {"horizontal_within_m", ToJson(score.horizontal_within)},
          {"vertical_before_m", ToJson(score.vertical_before)},
          {"vertical_after_m", ToJson(score.vertical_after)},
          {"attitude_before_deg", ToJson(score.attitude_before)},
          {"attitude_after_deg", ToJson(score.attitude_after)},
          {"rms_before_px", score.rms_before_px},
          {"rms_after_px", score.rms_after_px},
          {"shift_m", {score.shift.x(), score.shift.y(), score.shift.z()}}};
}

Json MapsJson(const MapScore& score) {
  return {{"elevation_error_m", ToJson(score.elevation_error)},
          {"elevation_error_unbiased_m", ToJson(score.elevation_error_unbiased)},
          {"elevation_median_error_m", score.elevation_median_error},
          {"elevation_error_detilted_m", ToJson(score.detilted.residual)},
          {"tilt_deg", score.detilted.plane.TiltDeg()},
          {"local_noise_m", score.detilted.local_noise.ToJson()},
          {"slope_error_deg", ToJson(score.slope_error)},
          {"roughness_error_m", ToJson(score.roughness_error)},
          {"hazard_of_kind", score.hazard_of_kind},
          {"grass_by_views", ToJson(score.grass_by_views)},
          {"num_faulty", score.num_faulty},
          {"num_faulty_not_free", score.num_faulty_not_free},
          {"num_called_hazard", score.num_called_hazard},
          {"num_called_hazard_rightly", score.num_called_hazard_rightly}};
}

Json FrontendJson(const FrontendScore& score) {
  return {{"pixels_of_cover", score.pixels_of_cover},
          {"coarse_height_error_m", ToJson(score.coarse_height_error)},
          {"num_regions", score.num_regions},
          {"num_graded", score.num_graded},
          {"num_duplicates", score.num_duplicates},
          {"track_length", ToJson(score.track_length)}};
}

Json HeadOf(uint64_t seed, const Scenario& scenario, const EngineRun& run) {
  return {{"seed", seed},
          {"aircraft", scenario.aircraft.profile},
          {"spacing_m", scenario.frame_spacing_m},
          {"wind_mps", Rounded(scenario.world.wind_in_world.norm())},
          {"num_frames", scenario.frames.size()},
          {"num_processed", run.num_processed},
          {"frontend_s", run.frontend_seconds},
          {"total_s", run.total_seconds},
          {"stage_s", run.StageSeconds()},
          {"warnings", run.evaluation.warnings}};
}

// The whole block's horizontal shift, which the positions of the autopilot decide, is taken off:
// beside what stands it would count as an error of heights.
Json HeightsOf(const EngineRun& run, const Scenario& scenario, const TruthMap& truth) {
  const Eigen::Vector2d shift = ScorePoses(run, scenario).shift.head<2>();
  ElevationMap map = run.evaluation.map;
  HazardLayers layers = run.evaluation.hazards;
  map.grid.north_west_in_world -= shift;
  layers.grid.north_west_in_world -= shift;
  return HeightRecord(ScoreHeights(map, layers, scenario, truth));
}

}  // namespace

Json HeightsRecord(uint64_t seed,
                   const Scenario& scenario,
                   const EngineRun& run,
                   const TruthMap& truth) {
  Json record = HeadOf(seed, scenario, run);
  record["poses"] = PosesJson(ScorePoses(run, scenario));
  record["maps"] = MapsJson(ScoreMap(run, scenario, truth));
  record["heights"] = HeightsOf(run, scenario, truth);
  return record;
}

Json WorldRecord(uint64_t seed,
                 const Scenario& scenario,
                 const EngineRun& run,
                 const TruthMap& truth,
                 const Fields& fields,
                 const PipelineOptions& options) {
  const PoseScore poses = ScorePoses(run, scenario);
  const MapScore maps = ScoreMap(run, scenario, truth);
  const MapOffset offset = OffsetOfMap(
      scenario.world, truth, run.evaluation.map, maps.detilted.plane, poses.shift.head<2>());
  const ThingScores things =
      ScoreThings(scenario, run.evaluation.map, run.evaluation.hazards, offset);
  Json record = HeadOf(seed, scenario, run);
  record.update({{"poses", PosesJson(poses)},
                 {"maps", MapsJson(maps)},
                 {"heights", HeightsOf(run, scenario, truth)},
                 {"frontend", FrontendJson(ScoreFrontend(run, scenario))},
                 {"things", things.counts},
                 {"missed_things", Json::array()},
                 {"map_shift_m", Place(offset.shift)},
                 {"sites", Json::array()},
                 {"fields", Json::array()},
                 {"regions", Json::array()}});
  for (const auto& [name, middle] : things.missed) {
    record["missed_things"].push_back({name, Place(middle)});
  }
  for (const Site& site : run.evaluation.sites) {
    Json json = SiteJson(site, scenario, truth, fields, poses.shift.head<2>());
    if (site.plan.verdict != Verdict::kRejected && !json.at("is_in_doubt").get<bool>()) {
      const uint64_t series = MixSeed(seed, record["sites"].size());
      json["flown"] = FlownJson(FlySite(scenario.world, truth, scenario.aircraft, site, series));
    }
    record["sites"].push_back(std::move(json));
  }
  record["landing_risks"] = LandingRisksJson(run, scenario, truth, options.approach, seed);
  for (const Region& region : run.regions) record["regions"].push_back(RegionJson(region));
  const std::vector<FieldScore> scores = ScoreFields(scenario, run, truth, fields, options);
  for (size_t i = 0; i < scores.size(); ++i) {
    const Field& field = fields.fields[i];
    record["fields"].push_back(FieldJson(field, scores[i], FateOf(field, run, truth, fields)));
  }
  return record;
}

}  // namespace freelsd
