// Flights whose memory is "none".
#include <doctest/doctest.h>

#include "server/recall/recall.h"
#include "server/recall/terrain_margin.h"
#include "tests/server/recall/flown_ground.h"

namespace freelsd {
namespace {

constexpr int64_t kFirst = 1600000000000000;
constexpr int64_t kLater = kFirst + 86400000000;
// Away from the meadow that the server holds anyway.
constexpr int kPlace = 1;

Flown Kept() { return {.flight_id = "kept", .seen_at_us = kFirst, .place = kPlace}; }

Flown Experiment(Ground ground) {
  Flown flown{.flight_id = "tried", .seen_at_us = kLater, .ground = ground, .place = kPlace};
  flown.is_experiment = true;
  return flown;
}

struct Field : FlownServer {
  using FlownServer::FlownServer;

  nlohmann::json Recall(const std::string& more) const {
    return GetJson(*client,
                   "/v1/emergency?latitude_deg=47.04&longitude_deg=8&altitude_m=1500&heading_deg=0"
                   "&wind_east_mps=0&wind_north_mps=-4&limit=50" +
                       more);
  }
  bool IsRecalled(const std::string& id, const std::string& more = "") const {
    const nlohmann::json answer = Recall(more);
    for (const nlohmann::json& site : answer["sites"]) {
      if (site["site_id"] == id) return true;
    }
    return false;
  }
};

TEST_CASE("experiments: their sites are recalled and exported for their own flight alone, marked") {
  const Field field({Experiment(Ground::kFree)});
  CHECK_FALSE(field.IsRecalled("tried-r1"));
  const auto exported = field.client->Get("/v1/emergency/export");
  CHECK(exported->body.find("tried-r1") == std::string::npos);
  CHECK(field.IsRecalled("tried-r1", "&flight=tried"));
  for (const nlohmann::json& site : field.Recall("&flight=tried")["sites"]) {
    if (site["site_id"] != "tried-r1") continue;
    CHECK(site["memory"] == "none");
    CHECK(site["warnings"].dump().find("experiment") != std::string::npos);
  }
  // By its own name, it says so too.
  CHECK(field.Site("tried-r1")["memory"] == "none");
  const auto plan = field.client->Get("/v1/sites/tried-r1?f=kml");
  CHECK(plan->body.find("EXPERIMENT") != std::string::npos);
  const nlohmann::json flight = GetJson(*field.client, "/v1/flights/tried");
  CHECK(flight["memory"] == "none");
}

TEST_CASE("experiments: the ground of an experiment counts on the ways of its own flight alone") {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  MapCache maps({size_t{1} << 24, size_t{1} << 22});
  Store(storage, maps, Kept());
  Flown wall = Experiment(Ground::kTreeOnFinal);
  wall.tree_m = 300.0;
  Store(storage, maps, wall);
  // Over the tree, 50 m above the ground.
  const LocalFrame frame(TouchdownOf(kPlace));
  const std::vector<GeoPoint> path{frame.GeoFromWorld({0.0, -60.0, 50.0}),
                                   frame.GeoFromWorld({0.0, 0.0, 50.0})};
  const auto margin_m = [&](const std::optional<std::string>& flight_id) {
    EmergencyRequest request;
    request.place = path.front();
    request.flight_id = flight_id;
    return TerrainMarginOf({storage, maps}, request, path)->margin_m;
  };
  CHECK(margin_m("tried") < -200.0);
  CHECK(margin_m(std::nullopt) > -60.0);
  CHECK(margin_m("kept") > -60.0);
}

}  // namespace
}  // namespace freelsd
