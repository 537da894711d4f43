// The map that the evaluation of a whole flight stores.
#include <algorithm>
#include <iterator>
#include <map>
#include <sstream>

#include <doctest/doctest.h>

#include "server/maps/maps.h"
#include "tests/server/sample_flight.h"
#include "tests/storage/place.h"

namespace freelsd {
namespace {

using TileBytes = std::map<TileKey, std::string>;

// All tiles of the flight's only map.
TileBytes TilesOf(const Storage& storage, const std::string& flight_id) {
  const std::vector<FlightMapRow> maps = storage.maps.ListOf(flight_id);
  REQUIRE(maps.size() == 1);
  const MapHead head = ParseMapHead(maps[0].head_json);
  TileBytes tiles;
  for (int level = 0; level < head.num_levels; ++level) {
    const auto [first, last] = TilesUnder(head.grid, level);
    for (int row = first.row; row <= last.row; ++row) {
      for (int col = first.col; col <= last.col; ++col) {
        const TileKey key{level, row, col};
        if (auto bytes = storage.maps.ReadTile(maps[0].id, key)) tiles[key] = *std::move(bytes);
      }
    }
  }
  return tiles;
}

std::string Evaluate(httplib::Client& client,
                     const nlohmann::json& aircraft,
                     int frames_per_batch) {
  std::string flight = NewSampleFlight(client, {}, aircraft);
  for (int begin = 0; begin < kNumSampleFrames; begin += frames_per_batch) {
    PostSampleFrames(client, flight, begin, std::min(kNumSampleFrames, begin + frames_per_batch));
  }
  REQUIRE(AwaitJob(client, Finish(client, flight))["state"] == "done");
  return flight;
}

TEST_CASE("flight map: frames one by one and all at once give the same tiles, for any aircraft") {
  const TemporaryFolder folder;
  Config config = TestConfig(folder.path());
  config.model = RealModel();
  std::string at_once, one_by_one, for_techpod;
  {
    const TestServer server(config);
    httplib::Client client = server.Client();
    at_once = Evaluate(client, {{"profile", "small"}}, kNumSampleFrames);
    one_by_one = Evaluate(client, {{"profile", "small"}}, 1);
    for_techpod = Evaluate(client, {{"profile", "techpod"}}, kNumSampleFrames);
  }
  const Storage storage(StorageAt(folder.path()));
  const TileBytes tiles = TilesOf(storage, at_once);
  CHECK(tiles.size() > 4);
  CHECK((TilesOf(storage, one_by_one) == tiles));
  CHECK((TilesOf(storage, for_techpod) == tiles));
}

TEST_CASE(
    "flight map: another aircraft on the map of a small plane lands where its own evaluation "
    "says") {
  FreshServer fresh([](Config& config) { config.model = RealModel(); });
  httplib::Client& client = fresh.client;
  const std::string small = Evaluate(client, {{"profile", "small"}}, kNumSampleFrames);
  const std::string other =
      Evaluate(client,
               {{"profile", "small"}, {"landing_airspeed_mps", 11.0}, {"max_bank_deg", 25.0}},
               kNumSampleFrames);
  size_t num_compared = 0;
  const nlohmann::json sites = GetJson(client, "/v1/flights/" + other + "/sites");
  for (const auto& site : sites["features"]) {
    const std::string id = site["properties"]["id"];
    const std::string twin = small + id.substr(other.size());
    CAPTURE(id);
    const auto planned =
        client.Get("/v1/sites/" + twin + "/approach?landing_airspeed_mps=11&max_bank_deg=25");
    const std::string verdict = site["properties"]["verdict"];
    // Sites from the map lie in squares (-e0n0). Which of them get one, and which rectangle of free
    // ground is searched there, depends on the aircraft's disc.
    const bool is_from_map = id.find("-e", other.size()) != std::string::npos;
    if (is_from_map && planned->status == 404) continue;
    if (planned->status == 409) {
      CHECK(verdict == "rejected");
      continue;
    }
    REQUIRE(planned->status == 200);
    const nlohmann::json answer = nlohmann::json::parse(planned->body);
    CHECK(answer["plan"]["verdict"] == verdict);
    for (const auto& feature : answer["features"]) {
      if (feature["properties"]["kind"] == "touchdown" && !is_from_map) {
        CHECK(feature["geometry"] == site["geometry"]);
        ++num_compared;
      }
    }
  }
  CHECK(num_compared > 0);
}

// The names of the events while a flight is evaluated, in order, up to the second map.
std::vector<std::string> EventsOfEvaluation(httplib::Client& listener, httplib::Client& client) {
  constexpr int kPatienceS = 30;
  listener.set_read_timeout(kPatienceS);
  std::string heard;
  std::vector<std::string> names;
  listener.Get("/v1/events", [&](const char* bytes, size_t size) {
    if (heard.empty()) Evaluate(client, {{"profile", "small"}}, kNumSampleFrames);
    heard.append(bytes, size);
    names.clear();
    std::istringstream lines(heard);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("event: ")) names.push_back(line.substr(7));
    }
    return std::count(names.begin(), names.end(), "map") < 2;
  });
  return names;
}

TEST_CASE("flight map: the first sites are in force before their map has its picture") {
  FreshServer fresh([](Config& config) { config.model = RealModel(); });
  httplib::Client listener = fresh.server.Client();
  const std::vector<std::string> events = EventsOfEvaluation(listener, fresh.client);
  REQUIRE(std::count(events.begin(), events.end(), "map") == 2);
  const auto first = std::find(events.begin(), events.end(), "map");
  const auto second = std::find(std::next(first), events.end(), "map");
  CHECK(std::find(events.begin(), first, "site") != first);
  // The picture is a stage of the job, told between the two.
  CHECK(std::find(first, second, "job") != second);
}

}  // namespace
}  // namespace freelsd
