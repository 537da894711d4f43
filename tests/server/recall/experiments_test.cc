// Flights whose memory is "none", and flights with a looser aircraft than every profile.
#include <doctest/doctest.h>

#include "server/recall/recall.h"
#include "server/recall/terrain_margin.h"
#include "tests/server/meadow.h"
#include "tests/server/recall/flown_ground.h"

namespace freelsd {
namespace {

constexpr int64_t kFirst = 1600000000000000;
constexpr int64_t kLater = kFirst + 86400000000;
// Away from the meadow that the server holds anyway.
constexpr int kPlace = 1;

Flown Kept(const std::string& flight_id = "kept") {
  return {.flight_id = flight_id, .seen_at_us = kFirst, .place = kPlace};
}

Flown Experiment(Ground ground) {
  Flown flown{.flight_id = "tried", .seen_at_us = kLater, .ground = ground, .place = kPlace};
  flown.is_experiment = true;
  return flown;
}

struct Field : MeadowServer {
  explicit Field(const std::vector<Flown>& flights)
      : MeadowServer([&flights](Storage& storage) {
          MapCache maps({size_t{1} << 24, size_t{1} << 22});
          for (const Flown& flown : flights) {
            storage.flights.Insert(FlightOf(flown));
            Store(storage, maps, flown);
          }
        }) {}

  nlohmann::json Site(const std::string& id) const {
    return GetJson(*client, "/v1/sites/" + id)["properties"];
  }
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
  int Delete(const std::string& flight, const std::string& query = "") const {
    return client->Delete("/v1/flights/" + flight + query)->status;
  }
};

TEST_CASE("experiments: a flight without memory supersedes, doubts and confirms nothing") {
  for (const Ground ground : {Ground::kTreeOnFinal, Ground::kHazardInDisc, Ground::kFree}) {
    Flown tried = Experiment(ground);
    tried.is_accepted = false;
    const Field field({Kept(), tried});
    const nlohmann::json site = field.Site("kept-r1");
    CAPTURE(site.dump());
    CHECK_FALSE(site.contains("superseded_by"));
    CHECK_FALSE(site.contains("doubted_by"));
    CHECK(site["last_seen_at"] == "2020-09-13T12:26:40Z");
    CHECK(field.IsRecalled("kept-r1"));
    CHECK(field.Recall("")["sites"][0]["verdict"] == "landable");
  }
}

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

TEST_CASE("experiments: later flights judge their sites like any other") {
  Flown tried = Experiment(Ground::kFree);
  tried.seen_at_us = kFirst - 1;
  Flown later = Kept("later");
  later.ground = Ground::kTreeOnFinal;
  for (const auto& flights : {std::vector<Flown>{tried, later}, std::vector<Flown>{later, tried}}) {
    const Field field(flights);
    CHECK(field.Site("tried-r1")["superseded_by"] == "later-r1");
    CHECK_FALSE(field.IsRecalled("tried-r1", "&flight=tried"));
  }
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

TEST_CASE("experiments: an aircraft with looser limits than every profile judges no other site") {
  Flown loose = Kept("loose");
  loose.seen_at_us = kLater;
  loose.ground = Ground::kTreeOnFinal;
  loose.is_loose = true;
  CHECK_FALSE(Field({Kept(), loose}).Site("kept-r1").contains("superseded_by"));
  loose.is_loose = false;
  CHECK(Field({Kept(), loose}).Site("kept-r1").contains("superseded_by"));
}

TEST_CASE("experiments: what a deleted flight superseded comes back when it is forgotten later") {
  Flown blocked = Kept("later");
  blocked.seen_at_us = kLater;
  blocked.ground = Ground::kTreeOnFinal;
  blocked.is_accepted = false;
  const Field field({Kept(), blocked});
  CHECK(field.Delete("later") == 204);
  CHECK(field.Site("kept-r1")["superseded_by"] == "later-r1");
  CHECK(field.Delete("later") == 404);
  CHECK(field.Delete("later", "?forget_sites=true") == 204);
  CHECK_FALSE(field.Site("kept-r1").contains("superseded_by"));
  CHECK(field.IsRecalled("kept-r1"));
  // Nothing is left of it.
  CHECK(field.Delete("later", "?forget_sites=true") == 404);
  CHECK(field.Delete("nobody", "?forget_sites=true") == 404);
}

TEST_CASE("experiments: a third flight that refutes the site too keeps it superseded") {
  Flown second = Kept("second"), third = Kept("third");
  second.seen_at_us = kLater + 1;
  second.ground = Ground::kTreeOnFinal;
  third.seen_at_us = kLater;
  third.ground = Ground::kTreeOnCircle;
  const Field field({Kept(), second, third});
  CHECK(field.Site("kept-r1")["superseded_by"] == "second-r1");
  CHECK(field.Delete("second") == 204);
  CHECK(field.Delete("second", "?forget_sites=true") == 204);
  CHECK(field.Site("kept-r1")["superseded_by"] == "third-r1");
  CHECK(field.Site("kept-r1")["superseded_reason"] == "loiter_blocked");
}

}  // namespace
}  // namespace freelsd
