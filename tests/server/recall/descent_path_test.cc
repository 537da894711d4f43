// The path that recall tells: the whole way, in three dimensions, checked where it really leads.
#include <cmath>

#include <doctest/doctest.h>

#include "engine/geometry/geometry.h"
#include "tests/server/recall/emergency_query.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

constexpr double kMaxPlaceErrorM = 0.1;

GeoPoint PlaceOf(const nlohmann::json& coordinates) {
  return {coordinates[1], coordinates[0], coordinates[2]};
}

double Apart(const GeoPoint& a, const GeoPoint& b) { return LocalFrame(a).WorldFromGeo(b).norm(); }

TEST_CASE("emergency: the path leads from the aircraft to the touchdown of the same answer") {
  const MeadowServer meadow(StoreAmslMeadow);
  for (const char* wind : {kCalmNorth,
                           "&wind_east_mps=3&wind_north_mps=2&heading_deg=200&altitude_datum=amsl",
                           "&altitude_datum=amsl"}) {
    const nlohmann::json answer = GetJson(*meadow.client, Query(700.0, wind));
    INFO(answer.dump());
    REQUIRE(answer["sites"].size() == 1);
    const nlohmann::json& site = answer["sites"][0];
    const nlohmann::json& path = site["path"]["coordinates"];
    CHECK(site["path"]["type"] == "LineString");
    REQUIRE(path.size() > 2);
    CHECK(site["times_s"].size() == path.size());
    CHECK(Apart(PlaceOf(path.front()), {46.9955, 8.0, 700.0}) < kMaxPlaceErrorM);
    const nlohmann::json& touchdown = site["touchdown"];
    CHECK(Apart(PlaceOf(path.back()),
                {touchdown["latitude_deg"], touchdown["longitude_deg"], touchdown["altitude_m"]}) <
          kMaxPlaceErrorM);
    const nlohmann::json& start = site["approach"]["start"];
    const GeoPoint before = PlaceOf(path[path.size() - 2]);
    CHECK(Apart(before, {start["latitude_deg"], start["longitude_deg"], before.altitude_m}) <
          kMaxPlaceErrorM);
    CHECK(before.altitude_m >= start["altitude_m"].get<double>() - kMaxPlaceErrorM);
    for (size_t i = 1; i < path.size(); ++i) {
      CHECK(site["times_s"][i].get<double>() >= site["times_s"][i - 1].get<double>());
      CHECK(path[i][2].get<double>() <= path[i - 1][2].get<double>());
    }
  }
}

// Told height above the planned start of the final.
double SurplusM(const nlohmann::json& site) {
  const nlohmann::json& path = site["path"]["coordinates"];
  return path[path.size() - 2][2].get<double>() -
         site["approach"]["start"]["altitude_m"].get<double>();
}

TEST_CASE("emergency: the told path loses the surplus height before the final") {
  constexpr double kMaxSurplusM = 2.0;
  const MeadowServer meadow(StoreAmslMeadow);
  int num_told = 0;
  for (int altitude_m = 560; altitude_m <= 700; altitude_m += 7) {
    for (const char* wind : {kCalmNorth,
                             "&wind_east_mps=3&wind_north_mps=2&heading_deg=200&altitude_datum="
                             "amsl"}) {
      const nlohmann::json answer = GetJson(*meadow.client, Query(altitude_m, wind));
      if (answer["sites"].empty()) continue;
      const nlohmann::json& site = answer["sites"][0];
      INFO(site.dump());
      CHECK(SurplusM(site) <= kMaxSurplusM);
      CHECK(site["surplus_height_m"].get<double>() ==
            doctest::Approx(SurplusM(site)).epsilon(0.01).scale(1.0));
      CHECK(site["terrain_margin_m"].get<double>() >= 0.0);
      ++num_told;
    }
  }
  CHECK(num_told > 20);
}

// A request from over the start of the final of `site`, in its direction and `above_m` higher.
// There a whole turn loses more height than a few metres, and nothing shorter leads back.
std::string OverStart(const nlohmann::json& site, double above_m, const std::string& more = "") {
  const nlohmann::json& start = site["approach"]["start"];
  const auto text = [](const nlohmann::json& number) { return number.dump(); };
  return "/v1/emergency?altitude_datum=amsl&wind_east_mps=0&wind_north_mps=0&latitude_deg=" +
         text(start["latitude_deg"]) + "&longitude_deg=" + text(start["longitude_deg"]) +
         "&heading_deg=" + text(site["approach"]["heading_deg"]) +
         "&altitude_m=" + text(start["altitude_m"].get<double>() + above_m) + more;
}

TEST_CASE("emergency: a way that cannot lose its surplus height is not reachable") {
  constexpr double kHighM = 9.0;
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json site = GetJson(*meadow.client, Query(600.0, kCalmNorth))["sites"][0];
  const nlohmann::json answer = GetJson(*meadow.client, OverStart(site, kHighM));
  INFO(answer.dump());
  CHECK(answer["sites"].empty());
  const nlohmann::json& miss = answer["nearest_miss"];
  CHECK(miss["reachable"] == false);
  CHECK(miss["reason"] == "too_high");
  CHECK(miss["arrival_margin_m"].get<double>() > 0.0);
  CHECK_FALSE(miss.contains("missing_m"));
  CHECK(miss["surplus_height_m"].get<double>() == doctest::Approx(kHighM).epsilon(0.1));
  CHECK(miss["sentence"].get<std::string>().find("9 m too high") != std::string::npos);
  CHECK(answer["summary"].get<std::string>().find(miss["sentence"]) != std::string::npos);
  CheckProblem(meadow.client->Get(OverStart(site, kHighM, "&f=plan")), 409, "NothingInReach");
  std::string reach = OverStart(site, kHighM);
  reach.replace(0, std::string("/v1/emergency").size(), "/v1/reach");
  const nlohmann::json point = GetJson(*meadow.client, reach)["features"].back()["properties"];
  CHECK(point["kind"] == "site");
  CHECK(point["reachable"] == false);
  CHECK(point["reason"] == "too_high");
  // At the height of the final it is in reach.
  CHECK(GetJson(*meadow.client, OverStart(site, 1.0))["sites"].size() == 1);
}

TEST_CASE("emergency: what is reachable stands before a way that cannot lose its height") {
  const MeadowServer meadow([](Storage& storage) {
    StoreAmslMeadow(storage);
    SiteRow other = MeadowSite("amsl", 60.0);
    other.id = std::string("f-r2");
    PutOnMap(storage, other, Meadow());
  });
  const nlohmann::json reached = GetJson(*meadow.client, Query(600.0, kCalmNorth));
  for (const nlohmann::json& site : reached["sites"]) {
    for (const double above_m : {4.0, 9.0, 14.0, 60.0}) {
      const nlohmann::json answer = GetJson(*meadow.client, OverStart(site, above_m));
      INFO(answer.dump());
      for (const auto& told : answer["sites"]) {
        CHECK(told["reachable"] == true);
        CHECK(SurplusM(told) <= 2.05);
      }
    }
  }
}

TEST_CASE("emergency: the sentences of an answer name no JSON key and say one thing") {
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json site = GetJson(*meadow.client, Query(600.0, kCalmNorth))["sites"][0];
  const std::string calm = kCalmNorth;
  for (const std::string& query : {Query(600.0, calm),
                                   Query(430.0, calm),
                                   Query(2000.0),
                                   Query(3000.0, "&wind_east_mps=30&wind_north_mps=0"),
                                   Query(900.0, calm + "&terrain_clearance_m=600"),
                                   OverStart(site, 9.0)}) {
    const nlohmann::json answer = GetJson(*meadow.client, query);
    const bool is_missed = answer.contains("nearest_miss");
    std::string text = answer["summary"].get<std::string>() + answer["warnings"].dump();
    if (is_missed) text += answer["nearest_miss"]["warnings"].dump();
    for (const auto& told : answer["sites"]) text += told["warnings"].dump();
    INFO(text);
    CHECK(text.find('_') == std::string::npos);
    const auto says = [&](const char* words) { return text.find(words) != std::string::npos; };
    CHECK(says("no site in reach") == answer["sites"].empty());
    CHECK(says("height are missing") ==
          (is_missed && answer["nearest_miss"]["arrival_margin_m"].get<double>() < 0.0));
    CHECK_FALSE((says("height are missing") && says("too high")));
    CHECK_FALSE((says("no usable site is stored") && says("stored site") && says("nearby has")));
    CHECK_FALSE((says("surplus height") && is_missed));
  }
}

TEST_CASE("emergency: terrain is checked along the turn, not along the straight line") {
  const MeadowServer meadow([](Storage& storage) {
    StoreAmslMeadow(storage);
    SiteMap ridge = Meadow();
    // From 5 m south of the aircraft on, higher than the aircraft.
    ridge.map.upper(cv::Rect(0, 205, 600, 395)) = 300.0f;
    SiteRow row = MeadowSite("amsl", -600.0);
    row.id = std::string("f-r9");
    row.recall.reset();
    PutOnMap(storage, row, ridge);
  });
  const nlohmann::json north = GetJson(*meadow.client, Query(600.0, kCalmNorth));
  INFO(north.dump());
  CHECK(north["sites"].size() == 1);
  const nlohmann::json south = GetJson(
      *meadow.client,
      Query(600.0, "&wind_east_mps=0&wind_north_mps=0&heading_deg=180&altitude_datum=amsl"));
  INFO(south.dump());
  CHECK(south["sites"].empty());
  CHECK(south["nearest_miss"]["terrain_margin_m"].get<double>() < -100.0);
}

TEST_CASE("emergency: safety heights are kept above the terrain and on arrival") {
  const MeadowServer meadow(StoreAmslMeadow);
  const auto site = [&](const std::string& more) {
    const nlohmann::json answer = GetJson(*meadow.client, Query(900.0, kCalmNorth + more));
    return answer["sites"].empty() ? answer["nearest_miss"] : answer["sites"][0];
  };
  const nlohmann::json plain = site("");
  const nlohmann::json higher = site("&terrain_clearance_m=60");
  CHECK(higher["terrain_margin_m"].get<double>() ==
        doctest::Approx(plain["terrain_margin_m"].get<double>() - 50.0));
  const nlohmann::json arrival = site("&arrival_height_m=600");
  CHECK(arrival["reachable"] == false);
  CheckProblem(meadow.client->Get(Query(900.0, "&terrain_clearance_m=-1")), 422, "InvalidValue");
}

TEST_CASE("emergency: a touchdown is planned for at least the uncertainty that is asked for") {
  const MeadowServer meadow(StoreAmslMeadow);
  const auto site = [&](const std::string& more) {
    return GetJson(*meadow.client, Query(900.0, kCalmNorth + more));
  };
  const auto uncertainty_m = [&](const std::string& more) {
    const nlohmann::json sites = site(more).at("sites");
    REQUIRE(sites.size() == 1);
    return sites[0]["aircraft"]["touchdown_uncertainty_m"].get<double>();
  };
  CHECK(uncertainty_m("") == 8.0);
  CHECK(uncertainty_m("&touchdown_uncertainty_m=5") == 8.0);
  CHECK(uncertainty_m("&touchdown_uncertainty_m=14") == 14.0);
  // The meadow's free ground ends before.
  CHECK(site("&touchdown_uncertainty_m=400").at("sites").empty());
  CheckProblem(
      meadow.client->Get(Query(900.0, "&touchdown_uncertainty_m=-1")), 422, "InvalidValue");
}

}  // namespace
}  // namespace freelsd
