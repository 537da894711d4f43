#include "tests/evaluation/fields/field_records.h"

#include <cmath>

#include "tests/evaluation/statistics.h"

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

// Sums over records.
struct Totals {
  int fields = 0, found = 0, winds_that_fit = 0, winds_found = 0;
  int accepted = 0, right = 0, false_safe = 0, thin = 0, not_judged = 0, in_doubt = 0;
  std::map<std::string, int> causes, fates;

  void Add(const Json& record);
};

void Totals::Add(const Json& record) {
  for (const Json& field : record.at("fields")) {
    if (field.at("winds_that_fit").empty()) continue;
    ++fields;
    found += !field.at("winds_found").empty();
    winds_that_fit += static_cast<int>(field.at("winds_that_fit").size());
    winds_found += static_cast<int>(field.at("winds_found").size());
    if (field.at("fate") != "found") ++fates[field.at("fate").get<std::string>()];
  }
  const Json& counts = record.at("counts");
  accepted += counts.at("accepted").get<int>();
  right += counts.at("right").get<int>();
  false_safe += counts.at("false_safe").get<int>();
  thin += counts.at("thin").get<int>();
  not_judged += counts.at("not_judged").get<int>();
  in_doubt += counts.at("in_doubt").get<int>();
  for (const Json& site : record.at("sites")) {
    for (const auto& [cause, num_plans] : site.at("causes").items()) ++causes[cause];
  }
}

std::string Percent(double ratio) {
  char text[16];
  std::snprintf(text, sizeof(text), "%.0f %%", 100.0 * ratio);
  return text;
}

std::string ListOf(const std::map<std::string, int>& counts) {
  std::string text;
  for (const auto& [name, count] : counts) {
    text += (text.empty() ? "" : ", ") + name + " " + std::to_string(count);
  }
  return text;
}

std::string RowOf(const std::string& flight, const std::string& aircraft, const Totals& totals) {
  const int num_judged = totals.right + totals.false_safe;
  const std::string share =
      totals.winds_that_fit == 0 ? "" : Percent(double(totals.winds_found) / totals.winds_that_fit);
  const std::string bound =
      num_judged == 0 ? "" : Percent(UpperBound95(totals.false_safe, num_judged));
  std::string row = "| " + flight + " | " + aircraft + " |";
  for (const std::string& cell :
       {std::to_string(totals.fields),
        std::to_string(totals.found),
        share,
        std::to_string(totals.accepted),
        std::to_string(totals.right),
        std::to_string(totals.false_safe),
        bound,
        std::to_string(totals.thin),
        std::to_string(totals.not_judged) + " (" + std::to_string(totals.in_doubt) + ")",
        ListOf(totals.causes),
        ListOf(totals.fates)}) {
    row += " " + cell + " |";
  }
  return row + "\n";
}

std::string MainTable(const Json& records) {
  std::string text =
      "| flight | aircraft | fields | found in any wind | found over winds | sites accepted | "
      "right "
      "| false safe | at most (95 %) | of these only thin | not judged (in doubt) | causes | fates "
      "|\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  Totals all;
  for (const Json& record : records) {
    Totals totals;
    totals.Add(record);
    all.Add(record);
    text += RowOf(record.at("flight"), record.at("aircraft"), totals);
  }
  return text + RowOf("all", "", all);
}

std::string InstrumentTable(const Json& records) {
  std::string text =
      "| flight | aircraft | outlines | without a view | objects | pairs of views | differ by m, "
      "median | largest | tall ones, median | at share of height | overlap | position sd m | "
      "tolerance m |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Json& record : records) {
    text += "| " + record.at("flight").get<std::string>() + " | " +
            record.at("aircraft").get<std::string>() + " |";
    for (const char* key : {"outlines",
                            "outlines_without_view",
                            "objects",
                            "pairs_of_views",
                            "views_differ_median_m",
                            "views_differ_largest_m",
                            "tall_views_differ_median_m",
                            "tall_share",
                            "views_overlap_ratio",
                            "position_sd_m",
                            "tolerance_m"}) {
      text += " " + record.at("instrument").at(key).dump() + " |";
    }
    text += "\n";
  }
  return text;
}

// Empty if nothing was blinded.
std::string BlindingTable(const Json& records) {
  std::string text =
      "| flight | aircraft | regions | accepted | right | false safe | not judged | causes |\n"
      "|---|---|---|---|---|---|---|---|\n";
  bool is_any = false;
  for (const Json& record : records) {
    for (const auto& [name, entry] : record.at("on_labels").items()) {
      is_any = true;
      const Json& counts = entry.at("counts");
      text += "| " + record.at("flight").get<std::string>() + " | " +
              record.at("aircraft").get<std::string>() + " | labels, blinded: " + name + " |";
      for (const char* key : {"accepted", "right", "false_safe", "not_judged"}) {
        text += " " + counts.at(key).dump() + " |";
      }
      text += " " + ListOf(entry.at("causes").get<std::map<std::string, int>>()) + " |\n";
    }
  }
  return is_any ? text : "";
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

std::string FieldTables(const Json& records) {
  const std::string blinding = BlindingTable(records);
  return MainTable(records) + "\n" + InstrumentTable(records) +
         (blinding.empty() ? "" : "\n" + blinding);
}

}  // namespace freelsd
