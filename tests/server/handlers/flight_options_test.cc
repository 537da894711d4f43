// The options of a flight: taken, told again, and refused by name.
#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/stored/stored.h"
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
  const nlohmann::json flight = Posted(
      fresh.client, R"({"name":"x","options":{"preset":"paper","terrain":{"cell_size_m":2}}})");
  const nlohmann::json given{{"preset", "paper"}, {"terrain", {{"cell_size_m", 2.0}}}};
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

TEST_CASE("flight options: a field of the engine that is no option any more is told as such") {
  FreshServer fresh;
  const std::string request = R"({"name":"x","options":{"wind":{"radius_m":200}}})";
  const auto result = fresh.client.Post("/v1/flights", request, "application/json");
  CheckProblem(result, 422, "RetiredOption");
  const nlohmann::json problem = nlohmann::json::parse(result->body);
  CHECK(problem.at("detail") == "wind.radius_m: is no longer an option of a request");
  CHECK(problem.at("errors").at(0).at("pointer") == "/options/wind/radius_m");
}

TEST_CASE("flight options: memory is kept unless an option can change a verdict, and says why") {
  FreshServer fresh;
  const auto memory_of = [&](const std::string& more) {
    const nlohmann::json flight = Posted(fresh.client, R"({"name":"x")" + more + "}");
    CAPTURE(flight.dump());
    const nlohmann::json again =
        GetJson(fresh.client, "/v1/flights/" + flight.at("id").get<std::string>());
    CHECK(again.at("memory") == flight.at("memory"));
    CHECK(again.at("memory_reason") == flight.at("memory_reason"));
    return flight.at("memory").get<std::string>() + ": " +
           flight.at("memory_reason").get<std::string>();
  };
  CHECK(memory_of("") == "keep: it is the default");
  CHECK(memory_of(R"(,"aircraft":{"profile":"small","min_area_m2":400})") ==
        "keep: it is the default");
  CHECK(memory_of(R"(,"options":{"backend":{"backend_period_frames":7}})") ==
        "keep: it is the default");
  CHECK(memory_of(R"(,"options":{"preset":"paper"})") == "none: preset paper is an experiment");
  CHECK(memory_of(R"(,"options":{"terrain":{"cell_size_m":2}})") ==
        "none: terrain.cell_size_m differs from its default and can change a verdict");
  CHECK(memory_of(R"(,"options":{"preset":"paper"},"memory":"keep")") ==
        "keep: the request says so");
  CHECK(memory_of(R"(,"memory":"none")") == "none: the request says so");
  const nlohmann::json problem = Posted(fresh.client, R"({"name":"x","memory":"some"})");
  CHECK(problem.at("status") == 422);
  CHECK(problem.at("errors").at(0).at("pointer") == "/memory");
  CHECK(Posted(fresh.client, R"({"name":"x","memory_reason":"y"})").at("status") == 422);
}

TEST_CASE("flight options: the service says which options can change a verdict") {
  FreshServer fresh;
  const nlohmann::json options = GetJson(fresh.client, "/v1/info").at("options");
  CHECK(options.at("preset").at("changes_verdicts") == true);
  CHECK(options.at("terrain").at("cell_size_m").at("changes_verdicts") == true);
  CHECK(options.at("adjustment").at("num_threads").at("changes_verdicts") == false);
  CHECK(options.at("backend").at("backend_period_frames").at("changes_verdicts") == false);
}

}  // namespace
}  // namespace freelsd
