#include "tests/evaluation/fields/field_survey.h"

#include <algorithm>
#include <array>

#include "tests/evaluation/fields/ground_projection.h"

namespace freelsd {
namespace {

PipelineOptions OptionsFor(PipelineOptions options, const Aircraft& aircraft) {
  options.regions.min_area_m2 = aircraft.min_area_m2;
  return options;
}

// `share`: of a thing's height, where its outline lies. The outline of a pole is its top.
double RaiseOf(const Outline& outline, double share) {
  if (outline.height_m <= kMaxLowHeightM) return 0.0;
  return (outline.kind == OutlineKind::kPole ? 1.0 : share) * outline.height_m;
}

std::vector<GroundOutline> Projected(const std::vector<Outline>& outlines,
                                     const GroundProjection& projection,
                                     double share) {
  std::vector<GroundOutline> on_ground;
  for (const Outline& outline : outlines) {
    const double raise = RaiseOf(outline, share);
    if (const auto polygon = projection.OnGround(outline, raise)) {
      on_ground.push_back(
          {outline.id, outline.kind, outline.height_m, outline.photograph, *polygon, raise});
    }
  }
  return on_ground;
}

int NumViewsOf(const LabelledGround& ground) {
  size_t count = 0;
  for (const LabelledObject& object : ground.objects) count += object.views.size();
  return static_cast<int>(count);
}

class Judge {
 public:
  Judge(const LabelledGround& ground, const Aircraft& aircraft)
      : ground_(ground), aircraft_(aircraft) {}

  void Add(const std::string& wind, int region_id, const Plan& plan) {
    if (plan.verdict == Verdict::kRejected || !plan.approach) return;
    plans_.push_back({wind,
                      region_id,
                      plan.verdict,
                      *plan.approach,
                      JudgeApproach(ground_, aircraft_, *plan.approach)});
  }
  const std::vector<JudgedPlan>& plans() const { return plans_; }
  std::vector<DistinctSite> Sites() const {
    return DistinctSites(plans_, 2.0 * aircraft_.touchdown_uncertainty_m);
  }

 private:
  const LabelledGround& ground_;
  const Aircraft& aircraft_;
  std::vector<JudgedPlan> plans_;
};

// All labelled ground as regions that the frontend might have made, none of them too small.
std::vector<Candidate> LabelledRegions(const LabelledGround& ground, double min_area_m2) {
  constexpr int kNumObservations = 1000;
  std::vector<Candidate> regions;
  for (const LabelledObject& object : ground.objects) {
    if (!IsGround(object.kind)) continue;
    Region region;
    region.id = static_cast<int>(regions.size()) + 1;
    region.num_observations = region.num_grass_observations = kNumObservations;
    region.grade = 1.0;
    for (const Eigen::Vector2d& corner : object.views.front().outline) {
      region.corners_in_world.emplace_back(corner.x(), corner.y(), ground.bare_heights.At(corner));
    }
    region.area_m2 = std::max(min_area_m2, Area(region.Footprint()));
    regions.push_back({region, std::nullopt});
  }
  return regions;
}

std::vector<DistinctSite> SitesOnLabels(const FieldSurvey& survey,
                                        const AssessedMap& map,
                                        const PipelineOptions& options) {
  const std::vector<Candidate> regions =
      LabelledRegions(survey.ground, survey.aircraft.min_area_m2);
  const std::vector<NamedWind> winds = SurveyWinds();
  const PlanBasis basis{
      map.map, map.layers, survey.run.evaluation.num_views, regions, 1, survey.aircraft, options};
  Judge judge(survey.ground, survey.aircraft);
  const std::vector<std::vector<Plan>> plans = PlansInWinds(basis, winds);
  for (size_t i = 0; i < winds.size(); ++i) {
    for (size_t j = 0; j < plans[i].size(); ++j) {
      judge.Add(winds[i].name, regions[j].region.id, plans[i][j]);
    }
  }
  return judge.Sites();
}

// What the frontend made of a place that breaks no rule.
std::string FateOfRegion(const EngineRun& run, const Eigen::Vector2d& place) {
  bool is_any = false;
  for (const Region& region : run.regions) {
    if (!Contains(region.Footprint(), place)) continue;
    if (region.grade > 0.0) return "touchdown elsewhere";
    is_any = true;
  }
  return is_any ? "region without a grade" : "no region";
}

// The rule that most cells within a distance break: "grass".
std::string CommonHazard(const FieldSurvey& survey,
                         const HazardOptions& options,
                         const Eigen::Vector2d& place,
                         double distance) {
  // In the order of CellCondition.
  constexpr std::array<const char*, 5> kNames{"seen", "grass", "slope", "roughness", "object"};
  const ElevationMap& map = survey.run.evaluation.map;
  const HazardLayers& layers = survey.run.evaluation.hazards;
  std::array<int, 5> counts{};
  for (int row = 0; row < map.grid.num_rows; ++row) {
    for (int col = 0; col < map.grid.num_cols; ++col) {
      if ((map.grid.CellCenter(row, col) - place).norm() > distance) continue;
      const CellRules rules =
          CellRulesAt(map,
                      layers,
                      {col, row},
                      {survey.aircraft.max_slope_deg, survey.aircraft.max_roughness_m},
                      options);
      const auto failed = std::find_if(
          rules.begin(), rules.end(), [](const CellRule& rule) { return !rule.passed; });
      if (failed != rules.end()) ++counts[static_cast<size_t>(failed->condition)];
    }
  }
  return kNames[static_cast<size_t>(std::max_element(counts.begin(), counts.end()) -
                                    counts.begin())];
}

void FillFate(const FieldSurvey& survey, const PipelineOptions& options, FieldResult* result) {
  if (!result->winds_found.empty()) {
    result->fate = "found";
    return;
  }
  const Evaluation& evaluation = survey.run.evaluation;
  const auto object = std::find_if(survey.ground.objects.begin(),
                                   survey.ground.objects.end(),
                                   [&](const auto& o) { return o.id == result->field.id; });
  if (evaluation.map.grid.num_rows == 0) {
    result->fate = "no map";
    return;
  }
  PlanRequest request;
  request.footprint = object->views.front().outline;
  request.area_m2 = result->field.area_m2;
  request.grade = 1.0;
  request.num_observations = request.min_num_observations = 1;
  const ApproachPlanner planner(
      evaluation.map, evaluation.hazards, request, survey.aircraft, options.approach);
  const Eigen::Vector2d calm = Eigen::Vector2d::Zero();
  const PlaceJudgement judgement = planner.Judge(result->field.middle, calm, options.hazard);
  const PlaceRule* failed = judgement.FirstFailed();
  if (judgement.verdict == Verdict::kRejected && failed != nullptr) {
    result->fate = failed->name;
    result->detail = failed->sentence;
    if (failed->name == "hazard_distance" && failed->limit) {
      result->fate +=
          ": " + CommonHazard(survey, options.hazard, result->field.middle, *failed->limit);
    }
  } else {
    result->fate = FateOfRegion(survey.run, result->field.middle);
  }
}

std::vector<FieldResult> ResultsOf(const FieldSurvey& survey,
                                   const std::vector<JudgedPlan>& plans,
                                   const PipelineOptions& options) {
  std::vector<FieldResult> results;
  const Grid& grid = survey.ground.grid;
  for (const LabelledField& field : FieldsOf(survey.ground)) {
    FieldResult result;
    result.field = field;
    for (const NamedWind& wind : SurveyWinds()) {
      if (!Fits(field, grid, survey.aircraft, wind.wind_in_world)) continue;
      result.winds_that_fit.push_back(wind.name);
      if (std::any_of(plans.begin(), plans.end(), [&](const JudgedPlan& plan) {
            return plan.wind == wind.name &&
                   Contains(field, grid, plan.approach.touchdown_in_world.head<2>());
          })) {
        result.winds_found.push_back(wind.name);
      }
    }
    FillFate(survey, options, &result);
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace

// Twice: things stand on the bare ground, which is known once their outlines are. Crowns were
// outlined at one share of their height on one flight and at another on the next: the share at
// which the views of tall things agree best is taken.
LabelledGround LabelledGroundOf(const std::vector<Outline>& outlines,
                                const Evaluation& evaluation) {
  const ElevationMap& map = evaluation.map;
  const double position_sd_m = evaluation.block.position_sd_m;
  const GroundProjection on_map(evaluation.block, {map.grid, map.elevation});
  LabelledGround best = MakeLabelledGround(Projected(outlines, on_map, 0.0), map, position_sd_m);
  const GroundProjection on_bare(evaluation.block, best.bare_heights);
  std::optional<double> least;
  for (const double share : {0.0, 0.5, 1.0}) {
    LabelledGround ground =
        MakeLabelledGround(Projected(outlines, on_bare, share), map, position_sd_m);
    ground.tall_share = share;
    if (least && ground.tall_disagreement.median_m >= *least) continue;
    least = ground.tall_disagreement.median_m;
    best = std::move(ground);
  }
  return best;
}

SiteCounts CountsOf(const std::vector<DistinctSite>& sites) {
  SiteCounts counts;
  for (const DistinctSite& site : sites) {
    ++counts.num_accepted;
    counts.num_right += site.finding == Finding::kRight;
    counts.num_false_safe += site.finding == Finding::kFalseSafe;
    counts.num_thin += site.is_only_thin;
    counts.num_not_judged += site.finding == Finding::kNotJudged;
    counts.num_in_doubt +=
        site.finding == Finding::kNotJudged && site.shown.judgement.doubt_ratio > 0.0;
  }
  return counts;
}

FieldSurvey SurveyFields(const FieldSurveyInput& input, const GroundModel& ground_model) {
  const PipelineOptions options = OptionsFor(input.options, input.aircraft);
  EngineRun run = RunEngine({input.frames.rig, input.frames.frames, input.aircraft},
                            options,
                            ground_model,
                            [](double, const std::string&) { return true; });
  LabelledGround ground = LabelledGroundOf(input.outlines, run.evaluation);
  const auto num_outlines = static_cast<int>(input.outlines.size());
  const int num_views = NumViewsOf(ground);
  FieldSurvey survey{input.flight,
                     input.aircraft,
                     std::move(run),
                     std::move(ground),
                     num_outlines,
                     num_outlines - num_views,
                     {},
                     {},
                     {}};
  const Evaluation& evaluation = survey.run.evaluation;
  const std::vector<Candidate> regions = GradedRegions(survey.run.snapshot);
  const PlanBasis basis{evaluation.map,
                        evaluation.hazards,
                        evaluation.num_views,
                        regions,
                        survey.run.snapshot.min_num_observations,
                        survey.aircraft,
                        options};
  if (evaluation.map.grid.num_rows > 0) {
    RequireSameSites(SitesInWind(basis, std::nullopt), evaluation.sites);
  }
  Judge judge(survey.ground, survey.aircraft);
  for (const NamedWind& wind : SurveyWinds()) {
    for (const Site& site : SitesInWind(basis, wind.wind_in_world)) {
      judge.Add(wind.name, site.region.id, site.plan);
    }
  }
  survey.sites = judge.Sites();
  survey.fields = ResultsOf(survey, judge.plans(), options);
  if (input.blindings.empty()) return survey;
  const AssessedMap map{evaluation.map, evaluation.hazards};
  survey.sites_on_labels["none"] = SitesOnLabels(survey, map, options);
  for (const Blinding blinding : input.blindings) {
    survey.sites_on_labels[NameOf(blinding)] =
        SitesOnLabels(survey, Blinded(map.map, map.layers, blinding), options);
  }
  return survey;
}

}  // namespace freelsd
