#include "tests/evaluation/fields/field_records.h"

#include <cmath>

namespace freelsd {
namespace {

using Json = nlohmann::json;

double Centimetres(double metres) { return std::round(100.0 * metres) / 100.0; }

Json SiteJson(const DistinctSite& site) {
  const JudgedPlan& shown = site.shown;
  return {{"east_m", Centimetres(shown.approach.touchdown_in_world.x())},
          {"north_m", Centimetres(shown.approach.touchdown_in_world.y())},
          {"heading_deg", std::round(DegFromRad(shown.approach.heading))},
          {"finding", NameOf(site.finding)},
          {"is_only_thin", site.is_only_thin},
          {"num_plans", site.num_plans},
          {"causes", site.causes},
          {"shown",
           {{"wind", shown.wind},
            {"region", shown.region_id},
            {"verdict", shown.verdict == Verdict::kLandable ? "landable" : "unverified"},
            {"object", shown.judgement.object_id},
            {"land_ratio", Centimetres(shown.judgement.land_ratio)},
            {"doubt_ratio", Centimetres(shown.judgement.doubt_ratio)},
            {"circle_meets", shown.judgement.circle}}}};
}

Json FieldJson(const FieldResult& result) {
  return {{"id", result.field.id},
          {"area_m2", std::round(result.field.area_m2)},
          {"radius_m", Centimetres(result.field.radius_m)},
          {"winds_that_fit", result.winds_that_fit},
          {"winds_found", result.winds_found},
          {"fate", result.fate},
          {"detail", result.detail}};
}

Json CountsJson(const SiteCounts& counts) {
  return {{"accepted", counts.num_accepted},
          {"right", counts.num_right},
          {"false_safe", counts.num_false_safe},
          {"thin", counts.num_thin},
          {"not_judged", counts.num_not_judged},
          {"in_doubt", counts.num_in_doubt}};
}

Json InstrumentJson(const FieldSurvey& survey) {
  const Disagreement& disagreement = survey.ground.disagreement;
  return {{"outlines", survey.num_outlines},
          {"outlines_without_view", survey.num_outlines_without_view},
          {"objects", survey.ground.objects.size()},
          {"pairs_of_views", disagreement.num_pairs},
          {"views_differ_median_m", Centimetres(disagreement.median_m)},
          {"views_differ_largest_m", Centimetres(disagreement.largest_m)},
          {"tall_views_differ_median_m", Centimetres(survey.ground.tall_disagreement.median_m)},
          {"tall_share", survey.ground.tall_share},
          {"views_overlap_ratio", Centimetres(disagreement.mean_overlap_ratio)},
          {"position_sd_m", Centimetres(survey.run.evaluation.block.position_sd_m)},
          {"tolerance_m", Centimetres(survey.ground.tolerance_m)}};
}

}  // namespace

Json RecordOf(const FieldSurvey& survey) {
  Json record{{"flight", survey.flight},
              {"aircraft", survey.aircraft.profile},
              {"instrument", InstrumentJson(survey)},
              {"counts", CountsJson(CountsOf(survey.sites))},
              {"sites", Json::array()},
              {"fields", Json::array()},
              {"on_labels", Json::object()}};
  for (const DistinctSite& site : survey.sites) record["sites"].push_back(SiteJson(site));
  for (const FieldResult& field : survey.fields) record["fields"].push_back(FieldJson(field));
  for (const auto& [name, sites] : survey.sites_on_labels) {
    Json& entry = record["on_labels"][name];
    std::map<std::string, int> causes;
    for (const DistinctSite& site : sites) {
      for (const auto& [cause, num_plans] : site.causes) ++causes[cause];
    }
    entry = {{"counts", CountsJson(CountsOf(sites))}, {"causes", causes}, {"sites", Json::array()}};
    for (const DistinctSite& site : sites) entry["sites"].push_back(SiteJson(site));
  }
  return record;
}

}  // namespace freelsd
