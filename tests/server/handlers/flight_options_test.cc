// The options of a flight: taken, told again, and refused by name.
#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/server/test_server.h"

namespace freelsd {
namespace {

nlohmann::json Posted(httplib::Client& client, const std::string& request) {
  const auto result = client.Post("/v1/flights", request, "application/json");
  REQUIRE(result);
  return nlohmann::json::parse(result->body);
}

TEST_CASE("flight options: the preset is told by the flight, with what was given beside it") {
  FreshServer fresh;
  const nlohmann::json flight =
      Posted(fresh.client, R"({"name":"x","options":{"preset":"paper","wind":{"radius_m":200}}})");
  const nlohmann::json given{{"preset", "paper"}, {"wind", {{"radius_m", 200.0}}}};
  CHECK(flight.at("options") == given);
  const auto stored = fresh.client.Get("/v1/flights/" + flight.at("id").get<std::string>());
  REQUIRE(stored);
  CHECK(nlohmann::json::parse(stored->body).at("options") == given);
  const auto list = fresh.client.Get("/v1/flights");
  REQUIRE(list);
  CHECK_FALSE(nlohmann::json::parse(list->body).at("flights").at(0).contains("options"));
  CHECK(Posted(fresh.client, R"({"name":"y"})").at("options").empty());
}

TEST_CASE("flight options: an unknown preset is a problem of its field") {
  FreshServer fresh;
  const nlohmann::json problem =
      Posted(fresh.client, R"({"name":"x","options":{"preset":"ours"}})");
  CHECK(problem.at("status") == 422);
  CHECK(problem.dump().find("/options/preset") != std::string::npos);
}

}  // namespace
}  // namespace freelsd
