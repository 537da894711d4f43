#include <cmath>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/api/export/sites/sites.h"

namespace freelsd {
namespace {

// `change` acts on the feature's properties.
template <class Change>
StoredSite Changed(Change&& change) {
  const KnownSite site = MakeSite({});
  nlohmann::json feature = nlohmann::json::parse(site.feature_json);
  change(feature["properties"]);
  return ReadStoredSite(feature.dump(), site.approach_json, "amsl");
}

TEST_CASE("stored site: numbers, wind, final and profile are those of the feature") {
  const KnownSite known = MakeSite({});
  const StoredSite& site = known.stored;
  CHECK(site.id == "f1-r1");
  CHECK(site.verdict == "landable");
  CHECK(site.Name() == "f1-r1");
  CHECK(site.area_m2 == 4000.0);
  CHECK(site.num_observations == 10);
  CHECK(site.wind.value().east_mps == -2.0);
  CHECK(site.approach.value().min_clearance_m == 2.25);
  REQUIRE(site.final_places.has_value());
  CHECK(site.final_places->loiter_radius_m == doctest::Approx(known.loiter_radius_m));
  CHECK(site.final_places->circle.size() > 3);
  REQUIRE(site.profile.size() == 5);
  CHECK(site.profile[0].distance_m == doctest::Approx(108.58));
  CHECK_FALSE(site.profile[1].terrain_m.has_value());
  CHECK(site.profile[1].path_m.has_value());
  REQUIRE(site.go_around.has_value());
  CHECK(site.go_around->no_return_distance_m == 40.0);
  CHECK(site.go_around->unseen_ratio == 0.25);
  CHECK(site.go_around->end.altitude_m - site.go_around->start.altitude_m ==
        doctest::Approx(200.0 * std::tan(RadFromDeg(5.0))).epsilon(1e-3));
}

TEST_CASE("stored site: the strip of the ground roll has its corners once, or none") {
  const KnownSite known = MakeSite({});
  CHECK(known.stored.ground_roll.empty());
  nlohmann::json approach = nlohmann::json::parse(known.approach_json);
  approach["features"].push_back(nlohmann::json::parse(
      R"({"type":"Feature","properties":{"kind":"ground_roll"},"geometry":{"type":"Polygon",)"
      R"("coordinates":[[[8,47,1],[8.1,47,2],[8.1,47.1,3],[8,47.1,4],[8,47,1]]]}})"));
  const StoredSite site = ReadStoredSite(known.feature_json, approach.dump(), "amsl");
  REQUIRE(site.ground_roll.size() == 4);
  CHECK(site.ground_roll[1].longitude_deg == 8.1);
  CHECK(site.ground_roll[2].latitude_deg == 47.1);
  CHECK(site.ground_roll[3].altitude_m == 4.0);
}

TEST_CASE("stored site: an approach without a go-around is read") {
  const KnownSite known = MakeSite({});
  nlohmann::json approach = nlohmann::json::parse(known.approach_json);
  approach["features"].erase(approach["features"].size() - 1);
  const StoredSite site = ReadStoredSite(known.feature_json, approach.dump(), "amsl");
  CHECK(site.final_places.has_value());
  CHECK_FALSE(site.go_around.has_value());
}

TEST_CASE("stored site: what is null or absent is unknown, another verdict is a rejection") {
  const StoredSite site = Changed([](nlohmann::json& properties) {
    properties["wind"] = nullptr;
    properties["slope_deg"] = nullptr;
    properties.erase("score");
    properties.erase("rejections");
    properties["verdict"] = "probably";
  });
  CHECK_FALSE(site.wind.has_value());
  CHECK_FALSE(site.slope_deg.has_value());
  CHECK_FALSE(site.score.has_value());
  CHECK(site.rejections.empty());
  CHECK(site.IsRejected());
  CHECK(site.Name() == "f1-r1 REJECTED");
}

TEST_CASE("stored site: without approach there is no final and no profile") {
  const StoredSite site = ReadStoredSite(MakeSite({}).feature_json, "", "amsl");
  CHECK_FALSE(site.final_places.has_value());
  CHECK(site.profile.empty());
}

TEST_CASE("stored site: damaged text throws") {
  const KnownSite site = MakeSite({});
  CHECK_THROWS(ReadStoredSite("{}", "", "amsl"));
  CHECK_THROWS(ReadStoredSite("{", "", "amsl"));
  CHECK_THROWS(ReadStoredSite(site.feature_json, R"({"features": []})", "amsl"));
}

TEST_CASE("stored site: structs and features rank alike") {
  std::vector<StoredSite> sites;
  std::vector<nlohmann::json> features;
  const Verdict verdicts[] = {Verdict::kRejected, Verdict::kUnverified, Verdict::kLandable};
  for (int i = 0; i < 12; ++i) {
    const KnownSite known = MakeSite({.verdict = verdicts[i % 3], .region_id = 20 - i});
    nlohmann::json feature = nlohmann::json::parse(known.feature_json);
    feature["properties"]["score"] = 0.1 * (i % 4);
    sites.push_back(ReadStoredSite(feature.dump(), known.approach_json, "amsl"));
    features.push_back(std::move(feature));
  }
  const nlohmann::json ranked = RankedSites(features);
  const std::vector<StoredSite> ranked_structs = RankSites(sites);
  for (size_t i = 0; i < sites.size(); ++i) {
    CHECK(ranked["features"][i]["properties"]["id"] == ranked_structs[i].id);
    CHECK(ranked["features"][i]["properties"]["rank"] == ranked_structs[i].rank.value());
  }
  CHECK(ranked_structs.front().verdict == "landable");
  CHECK(ranked_structs.back().IsRejected());
}

}  // namespace
}  // namespace freelsd
