// What a wind of some age is worth, in every answer about now.
#include <doctest/doctest.h>

#include "server/intake/arrival_clock.h"
#include "server/recall/live_pose/live_pose.h"
#include "tests/server/recall/emergency_query.h"

namespace freelsd {
namespace {

LiveWind WindOf(std::optional<double> age_s, double speed_mps = 2.0) {
  LiveWind wind;
  wind.wind_in_world = {0.0, -speed_mps};
  wind.age_s = age_s;
  return wind;
}

TEST_CASE("wind of now: it grows less certain with its age, as winds were measured to") {
  CHECK(WindOfNowOf(WindOf(0.0)).sd_mps == 0.0);
  // The eBee of decision 0045 measured 0.16, 0.32, 0.48 and 0.63 m/s.
  CHECK(WindOfNowOf(WindOf(10.0)).sd_mps == doctest::Approx(0.18).epsilon(0.02));
  CHECK(WindOfNowOf(WindOf(60.0)).sd_mps == doctest::Approx(0.33).epsilon(0.02));
  CHECK(WindOfNowOf(WindOf(300.0)).sd_mps == doctest::Approx(0.56).epsilon(0.02));
  CHECK(WindOfNowOf(WindOf(600.0)).sd_mps == doctest::Approx(0.71).epsilon(0.02));
  // Gusts grow with the wind, and what it was measured with stays.
  CHECK(WindOfNowOf(WindOf(60.0, 8.7)).sd_mps == doctest::Approx(0.99).epsilon(0.02));
  LiveWind drift = WindOf(60.0);
  drift.sd_mps = 0.44;
  CHECK(WindOfNowOf(drift).sd_mps == doctest::Approx(0.55).epsilon(0.02));
}

TEST_CASE("wind of now: after 10 minutes it is an interval, after 3 hours it is unknown") {
  const WindOfNow young = WindOfNowOf(WindOf(599.0));
  CHECK_FALSE(young.is_old);
  CHECK_FALSE(young.warning);
  CHECK(young.holds_for_s == doctest::Approx(1.0));
  const WindOfNow old = WindOfNowOf(WindOf(601.0));
  CHECK(old.is_old);
  CHECK(old.wind_in_world->y() == -2.0);
  CHECK(2.0 * old.sd_mps == doctest::Approx(3.0));
  CHECK(old.warning->find("10 minutes ago") != std::string::npos);
  // Two of its own deviations where they are larger.
  CHECK(2.0 * WindOfNowOf(WindOf(10000.0, 8.7)).sd_mps > 10.0);
  for (const auto age_s :
       {std::optional(10801.0), std::optional(2.0 * 365.0 * 86400.0), std::optional<double>()}) {
    const WindOfNow none = WindOfNowOf(WindOf(age_s));
    CHECK_FALSE(none.wind_in_world);
    CHECK_FALSE(none.is_old);
    CHECK(none.warning->find("unknown") != std::string::npos);
  }
}

// A flight over the meadow whose position is of now and whose wind is so old.
struct WindyFlight {
  const MeadowServer& meadow;
  std::string id;

  WindyFlight(const MeadowServer& server, double age_s) : meadow(server) {
    const auto made = meadow.client->Post(
        "/v1/flights",
        R"({"name":"x","altitude_datum":"amsl","aircraft":{"profile":"small"}})",
        "application/json");
    id = nlohmann::json::parse(made->body)["id"];
    const int64_t now_us = ArrivalNowUs();
    const nlohmann::json position{
        {"timestamp_us", now_us},
        {"position", {{"latitude_deg", 46.9955}, {"longitude_deg", 8.0}, {"altitude_m", 620.0}}}};
    const nlohmann::json wind{{"timestamp_us", now_us - static_cast<int64_t>(age_s * 1e6)},
                              {"wind", {{"east_mps", 0.0}, {"north_mps", -2.0}}}};
    const auto sent = meadow.client->Post("/v1/flights/" + id + "/telemetry",
                                          position.dump() + "\n" + wind.dump() + "\n",
                                          "application/x-ndjson");
    REQUIRE(nlohmann::json::parse(sent->body)["accepted"] == 2);
  }
  nlohmann::json Emergency(const std::string& more = "") {
    return GetJson(*meadow.client, Query(620.0, "&heading_deg=0&flight=" + id + more));
  }
  nlohmann::json Alternates() {
    return GetJson(*meadow.client, "/v1/flights/" + id + "/alternates");
  }
  nlohmann::json Reach() {
    return GetJson(*meadow.client,
                   "/v1/reach?latitude_deg=46.9955&longitude_deg=8.0&altitude_m=620&heading_deg=0"
                   "&flight=" +
                       id);
  }
  nlohmann::json Route() {
    nlohmann::json route = nlohmann::json::array();
    for (const double latitude_deg : {46.9955, 46.9965}) {
      route.push_back(
          {{"latitude_deg", latitude_deg}, {"longitude_deg", 8.0}, {"altitude_m", 620.0}});
    }
    const nlohmann::json body{
        {"route", route}, {"airspeed_mps", 10.0}, {"flight", id}, {"with_fixes", false}};
    const auto answer = meadow.client->Post("/v1/routes/check", body.dump(), "application/json");
    REQUIRE(answer);
    REQUIRE(answer->status == 200);
    return nlohmann::json::parse(answer->body);
  }
};

bool Warns(const nlohmann::json& answer, const std::string& text) {
  return answer["warnings"].dump().find(text) != std::string::npos;
}

nlohmann::json SiteOf(const nlohmann::json& reach) {
  for (const nlohmann::json& feature : reach["features"]) {
    if (feature["properties"]["kind"] == "site") return feature["properties"];
  }
  return nullptr;
}

struct Expected {
  double age_s;
  const char* counts_as;
  const char* verdict;
  const char* warning;
};

TEST_CASE("a wind of any age is not the wind of now: in emergency, alternates, reach and routes") {
  const Expected all[] = {{1.0, "known", "landable", nullptr},
                          {500.0, "known", "landable", nullptr},
                          {1500.0, "old", "unverified", "the wind was measured 25 minutes ago"},
                          {21600.0, "unknown", "unverified", "measured 6 hours ago"},
                          {63072000.0, "unknown", "unverified", "measured 730 days ago"}};
  const MeadowServer meadow(StoreAmslMeadow);
  for (const Expected& expected : all) {
    INFO(expected.age_s);
    WindyFlight flight(meadow, expected.age_s);
    const nlohmann::json emergency = flight.Emergency(), alternates = flight.Alternates(),
                         reach = flight.Reach(), route = flight.Route();
    for (const nlohmann::json& wind :
         {emergency["taken_from_flight"]["wind"],
          alternates["wind"],
          reach["taken_from_flight"]["wind"],
          route["wind"],
          GetJson(*flight.meadow.client, "/v1/flights/" + flight.id)["wind"]}) {
      INFO(wind.dump());
      CHECK(wind["age_s"].get<double>() ==
            doctest::Approx(expected.age_s).epsilon(0.02).scale(500));
      CHECK(wind["counts_as"] == expected.counts_as);
    }
    for (const nlohmann::json& site :
         {emergency["sites"].at(0), alternates["sites"].at(0), SiteOf(reach)}) {
      CHECK(site["verdict"] == expected.verdict);
    }
    for (const nlohmann::json& answer : {emergency, alternates, reach, route}) {
      INFO(answer["warnings"].dump());
      CHECK(Warns(answer, "ago") == (expected.warning != nullptr));
      if (expected.warning != nullptr) CHECK(Warns(answer, expected.warning));
      CHECK(Warns(answer, "the wind is unknown") == (std::string(expected.counts_as) == "unknown"));
    }
    // An old wind still chooses the heading.
    if (std::string(expected.counts_as) != "unknown") {
      CHECK(std::abs(std::remainder(emergency["sites"][0]["approach"]["heading_deg"].get<double>(),
                                    360.0)) < 31.0);
    }
    // A wind in the query has age 0.
    const nlohmann::json given = flight.Emergency("&wind_east_mps=0&wind_north_mps=-2");
    CHECK(given["sites"][0]["verdict"] == "landable");
    CHECK_FALSE(Warns(given, "ago"));
  }
}

TEST_CASE("a wind of any age is not the wind of now: age only ever costs margin") {
  const MeadowServer meadow(StoreAmslMeadow);
  double before_m = 1e9;
  for (const double age_s : {0.0, 60.0, 599.0, 601.0, 10000.0}) {
    INFO(age_s);
    const double margin_m = WindyFlight(meadow, age_s).Emergency()["sites"][0]["arrival_margin_m"];
    CHECK(margin_m <= before_m + 0.05);
    before_m = margin_m;
  }
}

}  // namespace
}  // namespace freelsd
