// Lists of alternates: fair between flights, and never out of date after the stored sites changed.
#include "server/recall/alternates.h"

#include <atomic>
#include <chrono>
#include <thread>

#include <doctest/doctest.h>

#include "tests/server/meadow.h"

namespace freelsd {
namespace {

std::string NewAmslFlight(httplib::Client& client) {
  const auto made =
      client.Post("/v1/flights",
                  R"({"name":"x","altitude_datum":"amsl","aircraft":{"profile":"small"}})",
                  "application/json");
  return nlohmann::json::parse(made->body)["id"];
}

std::string LineAt(int64_t timestamp_us, double altitude_m) {
  return nlohmann::json{
      {"timestamp_us", timestamp_us},
      {"position", {{"latitude_deg", 46.9955}, {"longitude_deg", 8.0}, {"altitude_m", altitude_m}}},
      {"wind", {{"east_mps", 0.0}, {"north_mps", 0.0}}}}
      .dump();
}

nlohmann::json PostLine(httplib::Client& client,
                        const std::string& flight,
                        const std::string& line) {
  const auto answer =
      client.Post("/v1/flights/" + flight + "/telemetry", line + "\n", "application/x-ndjson");
  REQUIRE(answer);
  REQUIRE(answer->status == 200);
  return nlohmann::json::parse(answer->body);
}

// True if the list of alternates satisfies the condition within the time.
template <class Condition>
bool Becomes(httplib::Client& client,
             const std::string& flight,
             std::chrono::milliseconds within,
             const Condition& condition) {
  const auto deadline = std::chrono::steady_clock::now() + within;
  while (std::chrono::steady_clock::now() < deadline) {
    if (condition(GetJson(client, "/v1/flights/" + flight + "/alternates"))) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

TEST_CASE("alternates: a flight that is never silent does not starve the others") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  MapCache maps(1 << 20, 1 << 20);
  EventLog events;
  // Its id comes first.
  for (const char* const id : {"a", "b", "c"}) {
    FlightRow flight;
    flight.id = id;
    flight.request_json = R"({"name":"x"})";
    storage.flights.Insert(flight);
  }
  Alternates alternates(storage, maps, events);
  alternates.Start();
  std::atomic<bool> is_done{false};
  std::thread chatterer([&] {
    while (!is_done) {
      alternates.Wake("a");
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  alternates.Wake("b");
  alternates.Wake("c");
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  CHECK(alternates.Find("a"));
  CHECK(alternates.Find("b"));
  CHECK(alternates.Find("c"));
  is_done = true;
  chatterer.join();
  alternates.Stop();
}

TEST_CASE("alternates: a deleted site leaves the list at once, also if the aircraft is silent") {
  const MeadowServer meadow(
      [](Storage& storage) { storage.sites.Put(MeadowSite("amsl"), SerializeSiteMap(Meadow())); });
  httplib::Client& client = *meadow.client;
  const std::string flight = NewAmslFlight(client);
  PostLine(client, flight, LineAt(1, 900.0));
  REQUIRE(Becomes(client, flight, std::chrono::seconds(10), [](const nlohmann::json& answer) {
    return answer["sites"].size() == 1;
  }));
  REQUIRE(client.Delete("/v1/sites/f-r1")->status == 204);
  CHECK(Becomes(client, flight, std::chrono::seconds(2), [](const nlohmann::json& answer) {
    return answer["sites"].empty();
  }));
}

TEST_CASE("alternates: a sample far ahead of the server's clock is refused, the past is not") {
  const MeadowServer meadow(
      [](Storage& storage) { storage.sites.Put(MeadowSite("amsl"), SerializeSiteMap(Meadow())); });
  httplib::Client& client = *meadow.client;
  const std::string flight = NewAmslFlight(client);
  constexpr int64_t kYear2255Us = 9000000000000000;
  const nlohmann::json ahead = PostLine(client, flight, LineAt(kYear2255Us, 500.0));
  CHECK(ahead["accepted"] == 0);
  CHECK(ahead["rejected"][0]["detail"].get<std::string>().find("ahead of the server's clock") !=
        std::string::npos);
  CHECK(PostLine(client, flight, LineAt(1700000000000000, 900.0))["accepted"] == 1);
  CHECK(Becomes(client, flight, std::chrono::seconds(10), [](const nlohmann::json& answer) {
    return answer.contains("pose") && answer["pose"]["altitude_m"] == 900.0;
  }));
}

}  // namespace
}  // namespace freelsd
