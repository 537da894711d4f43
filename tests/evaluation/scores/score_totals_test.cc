#include "tests/evaluation/scores/score_totals.h"

#include <doctest/doctest.h>

namespace freelsd {
namespace {

using Json = nlohmann::json;

Json SiteWith(int num_failed, int num_failed_thin) {
  return {{"flown",
           {{"num_flown", 200},
            {"num_failed", num_failed},
            {"num_failed_thin", num_failed_thin},
            {"causes", {{"final: tree", num_failed}}},
            {"thin_causes", Json::object()},
            {"height_bias_m", 3.0},
            {"absolute",
             {{"num_failed", 10}, {"num_failed_thin", 0}, {"num_short", 0}, {"num_long", 100}}}}}};
}

Json WorldOf(const std::vector<Json>& sites) { return {{"sites", sites}}; }

TEST_CASE("score totals: failures are averaged over sites, with an interval over worlds") {
  Json records = Json::array();
  for (int i = 0; i < 20; ++i) {
    records.push_back(WorldOf({SiteWith(i == 0 ? 100 : 0, 0), SiteWith(0, 20)}));
  }
  const Json totals = FlownTotals(records);
  CHECK(totals.at("num_sites") == 40);
  CHECK(totals.at("failure_ratio") == doctest::Approx(0.5 / 40));
  CHECK(totals.at("failure_ratio_low_95") == 0.0);
  // The world with failures is drawn at most three or four times.
  CHECK(totals.at("failure_ratio_high_95").get<double>() > 0.5 / 40);
  CHECK(totals.at("failure_ratio_high_95").get<double>() <= 4 * 0.5 / 40);
  CHECK(totals.at("num_sites_above_5_percent") == 1);
  CHECK(totals.at("num_sites_above_5_percent_thin") == 20);
  CHECK(totals.at("absolute_long_ratio") == 0.5);
  CHECK(totals.at("causes").at("final: tree") == 100);
  CHECK(FlownTotals(records) == totals);
}

TEST_CASE("score totals: worlds without sites and records of older programs are left out") {
  CHECK(FlownTotals(Json::array()).at("failure_ratio").is_null());
  Json older = Json::array({Json::object()});
  older[0]["sites"] = Json::array({{{"verdict", "landable"}}});
  older[0]["fields"] = Json::array({{{"is_landable", true}}});
  older[0]["maps"] = Json::object();
  CHECK(FlownTotals(older).at("num_sites") == 0);
  CHECK(FoundTotals(older).at("fields_accepted_on_truth") == 0);
  CHECK(FoundTotals(older).at("found_of_accepted_ratio").is_null());
  CHECK(ThingTotals(older).empty());
  CHECK(DetiltedTotals(older).at("tilt_rms_deg").is_null());
}

Json FieldWith(bool is_accepted, bool is_found, int num_touchdowns) {
  return {{"is_accepted_on_truth", is_accepted},
          {"is_landable", true},
          {"is_seen", true},
          {"is_found", is_found},
          {"num_touchdowns", num_touchdowns},
          {"photographed_ratio", is_accepted ? 1.0 : 0.6},
          {"reason_on_truth", is_accepted ? "" : "approach_unseen"},
          {"lost_reason", is_found ? "" : "final"},
          {"fault_on_truth", ""},
          {"is_only_thin_on_truth", false}};
}

TEST_CASE("score totals: found is a share of what the planner accepts without error") {
  Json faulty = FieldWith(true, true, 150);
  faulty["fault_on_truth"] = "final: tree";
  const Json records = Json::array({{{"fields",
                                      {FieldWith(true, true, 59),
                                       FieldWith(true, false, 60),
                                       FieldWith(false, false, 149),
                                       faulty}}}});
  const Json totals = FoundTotals(records);
  CHECK(totals.at("fields_accepted_on_truth") == 3);
  CHECK(totals.at("found_of_accepted_ratio") == doctest::Approx(0.6667).epsilon(0.001));
  CHECK(totals.at("reasons_of_lost_fields") == Json{{"final", 1}});
  CHECK(totals.at("reasons_on_truth") == Json{{"approach_unseen", 1}});
  CHECK(totals.at("num_false_safe_on_truth") == 1);
  CHECK(totals.at("by_room").at("0-59").at("num_found") == 1);
  CHECK(totals.at("by_room").at("60-149").at("num_fields") == 2);
  CHECK(totals.at("by_room").at(">=150").at("num_found") == 1);
  CHECK(totals.at("by_photographed_ratio").at("50-90 %").at("num_fields") == 1);
  CHECK(totals.at("by_photographed_ratio").at("all").at("num_accepted_truth") == 3);
}

}  // namespace
}  // namespace freelsd
