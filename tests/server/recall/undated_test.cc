// Photographs without a usable date, and flights whose order is contested.
#include <algorithm>

#include <doctest/doctest.h>

#include "tests/server/recall/flown_ground.h"

namespace freelsd {
namespace {

constexpr int64_t kFirst = 1600000000000000;  // 2020-09-13T12:26:40Z
constexpr int64_t kHourUs = int64_t{3600} * 1000000;
constexpr char kFirstText[] = "2020-09-13T12:26:40Z";
// Away from the meadow that the server holds anyway.
constexpr int kPlace = 1;

Flown Dated(Ground ground = Ground::kFree) {
  return {.flight_id = "first", .seen_at_us = kFirst, .ground = ground, .place = kPlace};
}

Flown Undated(Ground ground, const std::optional<int64_t>& arrived_at_us = std::nullopt) {
  Flown flown{.flight_id = "undated", .seen_at_us = 0, .ground = ground, .place = kPlace};
  flown.seen_until_us = arrived_at_us;
  return flown;
}

// Noon of some time zone, on the day of the dated flight.
Flown Local(Ground ground) {
  Flown flown = Undated(ground, kFirst + 12 * kHourUs);
  flown.flight_id = "local";
  flown.seen_at_us = kFirst - 14 * kHourUs;
  return flown;
}

struct Field : FlownServer {
  using FlownServer::FlownServer;

  nlohmann::json RecalledAt(const std::string& latitude_deg) const {
    return GetJson(*client,
                   "/v1/emergency?limit=50&heading_deg=0&wind_east_mps=0&wind_north_mps=-4&"
                   "longitude_deg=8&altitude_m=1500&latitude_deg=" +
                       latitude_deg)["sites"];
  }
  // Without the meadow's.
  std::string OrderOfRecalled(const std::string& latitude_deg = "47.04") const {
    std::string ids;
    const nlohmann::json sites = RecalledAt(latitude_deg);
    for (const nlohmann::json& site : sites) {
      if (site["flight_id"] != "f") ids += site["site_id"].get<std::string>() + " ";
    }
    return ids;
  }
};

TEST_CASE("photographs without a usable date refresh nothing, and their own age is unknown") {
  const Field field({Dated(), Undated(Ground::kFree)});
  CHECK(field.Site("first-r1")["last_seen_at"] == kFirstText);
  CHECK(field.Site("first-r1")["verdict"] == "landable");
  const nlohmann::json undated = field.Site("undated-r1");
  CHECK(undated["verdict"] == "landable");
  CHECK(undated["age_s"].is_null());
  CHECK(undated["last_seen_at"].is_null());
  // Of two sites at one place, the better one is recalled.
  CHECK(field.OrderOfRecalled() == "first-r1 ");
  const auto file = [&field](const std::string& query) {
    return field.client->Get("/v1/sites/undated-r1?home_altitude_m=300&f=" + query)->body;
  };
  for (const char* const format : {"cup", "kml", "rally"}) {
    CHECK(file(format).find("Ground photographed at an unknown time.") != std::string::npos);
    CHECK(file(format).find("before this file") == std::string::npos);
  }
  CHECK(nlohmann::json::parse(file("plan"))["freelsd"]["age_s"].is_null());
  const nlohmann::json to_look_at = GetJson(*field.client, "/v1/sites?order=new_look");
  for (const nlohmann::json& feature : to_look_at["features"]) {
    if (feature["properties"]["id"] != "undated-r1") continue;
    CHECK(feature["properties"]["new_look"]["age_s"].is_null());
  }
}

TEST_CASE("photographs without a usable date rank behind any dated ones") {
  Flown old = Dated();
  old.flight_id = "old";
  old.seen_at_us = 1262304000000000;
  old.place = kPlace + 1;
  // Both are equally far away.
  const Field field({old, Undated(Ground::kFree)});
  CHECK(field.OrderOfRecalled("47.06") == "old-r1 undated-r1 ");
  const nlohmann::json recalled = field.RecalledAt("47.06");
  const auto found = std::find_if(recalled.begin(), recalled.end(), [](const auto& site) {
    return site["site_id"] == "undated-r1";
  });
  REQUIRE(found != recalled.end());
  CHECK((*found)["age_s"].is_null());
  CHECK((*found)["last_seen_at"].is_null());
  CHECK((*found)["score"] == 0.0);
}

TEST_CASE("a building on an undated map counts: neither map replaces the other, the worse holds") {
  for (const Flown& other : {Undated(Ground::kTreeOnFinal), Local(Ground::kTreeOnFinal)}) {
    const std::string id = IdOf(other);
    CAPTURE(id);
    for (const bool is_dated_first : {true, false}) {
      const Field field(is_dated_first ? std::vector{Dated(), other} : std::vector{other, Dated()});
      const nlohmann::json site = field.Site("first-r1");
      CHECK(site["verdict"] == "rejected");
      CHECK(site["reject_reason"] == "approach_blocked");
      CHECK_FALSE(site.contains("superseded_by"));
      CHECK(site["last_seen_at"] == kFirstText);
      const std::string summary = site["summary"];
      CHECK(summary.find("on the map of " + id + ", which may be later or earlier, ") !=
            std::string::npos);
      CHECK(field.OrderOfRecalled().find("first-r1") == std::string::npos);
      CHECK(GetJson(*field.client, "/v1/sites").dump().find("first-r1") != std::string::npos);
      CHECK(field.client->Get("/v1/sites/first-r1?f=cup")->status == 409);
      // A plan that the dated map rejects is rejected for the other flight as well.
      const Field mirrored({Dated(Ground::kTreeOnFinal), [&] {
                              Flown free = other;
                              free.ground = Ground::kFree;
                              return free;
                            }()});
      CHECK(mirrored.Site(id)["verdict"] == "rejected");
      CHECK(mirrored.OrderOfRecalled().find(id) == std::string::npos);
      // Once the other flight is forgotten, nothing speaks against the site.
      const std::string path = "/v1/flights/" + other.flight_id + "?forget_sites=true";
      CHECK(field.client->Delete(path)->status == 204);
      CHECK(field.Site("first-r1")["verdict"] == "landable");
    }
  }
}

}  // namespace
}  // namespace freelsd
