// Where a flight's photographs were taken.
#include <doctest/doctest.h>

#include "tests/server/test_server.h"

namespace freelsd {
namespace {

// Of one track, [longitude, latitude, altitude].
nlohmann::json PositionsOf(const nlohmann::json& track) {
  REQUIRE(track["features"].size() == 1);
  CHECK(track["features"][0]["geometry"]["type"] == "LineString");
  return track["features"][0]["geometry"]["coordinates"];
}

void AwaitFinish(httplib::Client& client, const std::string& flight) {
  const auto job = client.Post("/v1/flights/" + flight + "/finish");
  REQUIRE(job->status == 202);
  REQUIRE(AwaitJob(client, nlohmann::json::parse(job->body)["id"])["state"] == "done");
}

TEST_CASE("track: photographs in the order of their time, whatever order they came in") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string path = "/v1/flights/" + flight + "/track";
  CHECK(GetJson(fresh.client, path)["features"].empty());
  for (const int number : {2, 0, 1}) {
    const auto result = PutFrame(
        fresh.client, flight, std::to_string(number), NoiseImage(number), SomeMeta(number));
    REQUIRE(result->status == 201);
  }
  AwaitFinish(fresh.client, flight);
  const nlohmann::json track = GetJson(fresh.client, path);
  const nlohmann::json positions = PositionsOf(track);
  REQUIRE(positions.size() == 3);
  for (int i = 0; i < 3; ++i) {
    const auto place = static_cast<size_t>(i);
    CHECK(positions[place][0] == 8.0);
    CHECK(positions[place][1].get<double>() == doctest::Approx(47.0 + i * 1e-5).epsilon(1e-10));
    CHECK(positions[place][2] == 500.0);
  }
  const nlohmann::json properties = track["features"][0]["properties"];
  CHECK(properties["flight_id"] == flight);
  CHECK(properties["num_positions"] == 3);
  CHECK(properties["altitude_datum"] == "unknown");
}

TEST_CASE("track: where a photograph has no time, the order is the one they came in") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  for (const int number : {2, 0, 1}) {
    nlohmann::json meta = nlohmann::json::parse(SomeMeta(number));
    if (number == 0) meta.erase("timestamp_us");
    const auto result =
        PutFrame(fresh.client, flight, std::to_string(number), NoiseImage(number), meta.dump());
    REQUIRE(result->status == 201);
  }
  AwaitFinish(fresh.client, flight);
  const nlohmann::json positions =
      PositionsOf(GetJson(fresh.client, "/v1/flights/" + flight + "/track"));
  REQUIRE(positions.size() == 3);
  CHECK(positions[0][1] > positions[2][1]);
  CHECK(positions[2][1] > positions[1][1]);
}

TEST_CASE("track: one position is no line") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  REQUIRE(PutFrame(fresh.client, flight, "one", NoiseImage(1), SomeMeta())->status == 201);
  AwaitFinish(fresh.client, flight);
  CHECK(GetJson(fresh.client, "/v1/flights/" + flight + "/track")["features"].empty());
}

TEST_CASE("track: without photographs it is telemetry's, thinned but from the first to the last") {
  constexpr int kNumLines = 4501;
  constexpr size_t kMaxNumPositions = 2000;
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  std::string lines;
  for (int i = 0; i < kNumLines; ++i) {
    nlohmann::json line = nlohmann::json::parse(SomeMeta(i));
    line.erase("height_above_ground_m");
    lines += line.dump() + "\n";
  }
  const auto sent = fresh.client.Post("/v1/flights/" + flight + "/telemetry", lines, "");
  REQUIRE(sent->status == 200);
  REQUIRE(nlohmann::json::parse(sent->body)["accepted"] == kNumLines);
  const nlohmann::json track = GetJson(fresh.client, "/v1/flights/" + flight + "/track");
  const nlohmann::json positions = PositionsOf(track);
  CHECK(positions.size() > kMaxNumPositions / 2);
  CHECK(positions.size() <= kMaxNumPositions);
  CHECK(track["features"][0]["properties"]["num_positions"] == positions.size());
  CHECK(positions.front()[1].get<double>() == doctest::Approx(47.0).epsilon(1e-10));
  CHECK(positions.back()[1].get<double>() ==
        doctest::Approx(47.0 + (kNumLines - 1) * 1e-5).epsilon(1e-10));
  for (size_t i = 1; i < positions.size(); ++i) CHECK(positions[i - 1][1] < positions[i][1]);
}

TEST_CASE("track: of a flight that is not there it is 404") {
  FreshServer fresh;
  CheckProblem(fresh.client.Get("/v1/flights/none/track"), 404, "NoSuchFlight");
}

}  // namespace
}  // namespace freelsd
