// Reports of parts that are put together, and the winds that all of them are planned in.
#include "tests/evaluation/fields/field_campaign.h"

#include <set>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/evaluation/fields/wind_plans.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

Json ReportWith(const std::string& flight, const std::string& blinding) {
  return {{"settings", {{"blindings", {blinding}}}},
          {"surveys", {{{"flight", flight}, {"aircraft", "small"}}}}};
}

TEST_CASE("field campaign: reports are merged by flight, and never twice or of other settings") {
  const Json merged = MergeFieldReports({ReportWith("b", "shift"), ReportWith("a", "shift")});
  REQUIRE(merged.at("surveys").size() == 2);
  CHECK(merged.at("surveys").at(0).at("flight") == "a");
  CHECK_THROWS_WITH(MergeFieldReports({ReportWith("a", "shift"), ReportWith("a", "shift")}),
                    "a with small is in two reports");
  CHECK_THROWS_AS(MergeFieldReports({ReportWith("a", "shift"), ReportWith("b", "kinds")}),
                  std::runtime_error);
  FieldCampaignOptions options;
  options.resumes = true;
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
}

TEST_CASE("field campaign: 17 winds, named by where they come from") {
  const std::vector<NamedWind> winds = SurveyWinds();
  REQUIRE(winds.size() == 17);
  CHECK(winds[0].wind_in_world.norm() == 0.0);
  std::set<std::string> names;
  for (const NamedWind& wind : winds) names.insert(wind.name);
  CHECK(names.size() == 17);
  CHECK(winds[3].name == "3 m/s from 090");
  CHECK((winds[3].wind_in_world - Eigen::Vector2d(-3.0, 0.0)).norm() < 1e-9);
}

}  // namespace
}  // namespace freelsd
