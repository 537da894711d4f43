// The same ground flown over twice, from upload to recall.
#include <set>

#include <doctest/doctest.h>

#include "tests/server/sample_flight.h"

namespace freelsd {
namespace {

// Flights that the recalled sites are of.
std::set<std::string> RecalledFlights(httplib::Client& client, const std::string& flight) {
  const nlohmann::json sites =
      GetJson(client, "/v1/flights/" + flight + "/sites?include=superseded");
  REQUIRE_FALSE(sites["features"].empty());
  const nlohmann::json& place = sites["features"][0]["geometry"]["coordinates"];
  const std::string path = "/v1/emergency?latitude_deg=" + place[1].dump() +
                           "&longitude_deg=" + place[0].dump() +
                           "&altitude_m=1500&altitude_datum=amsl&heading_deg=0&limit=50"
                           "&wind_east_mps=0&wind_north_mps=0";
  // The number of sites that are planned for depends on the machine, because recall has a time
  // limit.
  std::set<std::string> flights;
  const nlohmann::json answer = GetJson(client, path);
  for (const nlohmann::json& site : answer["sites"]) flights.insert(site["flight_id"]);
  return flights;
}

std::string FlyOver(httplib::Client& client) {
  std::string flight = PostSampleFlight(client, 0, kNumSampleFrames);
  REQUIRE(AwaitJob(client, Finish(client, flight))["state"] == "done");
  return flight;
}

TEST_CASE(
    "supersede: the same ground flown again forgets nothing, and each flight can be forgotten") {
  FreshServer fresh([](Config& config) { config.model = RealModel(); });
  const std::string first = FlyOver(fresh.client);
  const std::set<std::string> before = RecalledFlights(fresh.client, first);
  REQUIRE(before.contains(first));
  const std::string second = FlyOver(fresh.client);
  for (const std::string& flight : {first, second}) {
    const nlohmann::json sites =
        GetJson(fresh.client, "/v1/flights/" + flight + "/sites?include=superseded");
    CHECK_FALSE(sites["features"].empty());
    for (const nlohmann::json& site : sites["features"]) {
      CHECK_FALSE(site["properties"].contains("superseded_by"));
    }
  }
  // One place is recalled once, whichever flight found it.
  CHECK_FALSE(RecalledFlights(fresh.client, second).empty());
  CHECK(fresh.client.Delete("/v1/flights/" + second + "?forget_sites=true")->status == 204);
  const std::set<std::string> restored = RecalledFlights(fresh.client, first);
  CHECK(restored.contains(first));
  CHECK_FALSE(restored.contains(second));
}

}  // namespace
}  // namespace freelsd
