// Flights over HTTP: their names, and what it costs if they leave something unknown.
#include <cmath>

#include <doctest/doctest.h>

#include "server/recall/geoid/geoid.h"
#include "tests/server/openapi_check.h"
#include "tests/server/test_server.h"

namespace freelsd {
namespace {

std::string PathOf(const std::string& flight) { return "/v1/flights/" + flight; }

httplib::Result Rename(httplib::Client& client,
                       const std::string& flight,
                       const nlohmann::json& request) {
  return client.Patch(PathOf(flight), request.dump(), "application/json");
}

std::string NewFlightWith(httplib::Client& client, nlohmann::json request) {
  request["name"] = "x";
  const auto made = client.Post("/v1/flights", request.dump(), "application/json");
  REQUIRE(made->status == 201);
  return nlohmann::json::parse(made->body)["id"];
}

// At Swindale, where the geoid is 53 m above the ellipsoid.
nlohmann::json MetaAtSwindale() {
  return {{"position", {{"latitude_deg", 54.51}, {"longitude_deg", -2.76}, {"altitude_m", 500.0}}},
          {"attitude", {{"roll_deg", 0.0}, {"pitch_deg", 0.0}, {"yaw_deg", 0.0}}}};
}

std::string WarningsOf(httplib::Client& client, const std::string& flight) {
  return GetJson(client, PathOf(flight))["warnings"].dump();
}

bool Has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

constexpr char kCamera[] = R"({"camera":{"width_px":320,"height_px":240,"fx_px":200,"fy_px":200,)"
                           R"("cx_px":160,"cy_px":120}})";

TEST_CASE("flights: one is renamed, and nothing else of it can be changed") {
  FreshServer fresh;
  httplib::Client& client = fresh.client;
  HoldAgainstContract(client);
  const std::string flight = NewFlight(client);
  const auto renamed = Rename(client, flight, {{"name", "Möhlin"}});
  CHECK(renamed->status == 200);
  CHECK(nlohmann::json::parse(renamed->body)["name"] == "Möhlin");
  CHECK(GetJson(client, PathOf(flight))["name"] == "Möhlin");
  CheckProblem(
      Rename(client, flight, {{"name", "a"}, {"altitude_datum", "amsl"}}), 422, "InvalidValue");
  CheckProblem(Rename(client, flight, nlohmann::json::object()), 422, "InvalidValue");
  CheckProblem(Rename(client, "f-none", {{"name", "a"}}), 404, "NoSuchFlight");
  CHECK(GetJson(client, PathOf(flight))["name"] == "Möhlin");
}

TEST_CASE("flights: a name that is read in another order than it is written is refused") {
  FreshServer fresh;
  httplib::Client& client = fresh.client;
  const std::string flight = NewFlight(client);
  for (const char* const name : {"safe\xE2\x80\xAE"
                                 "dliw",
                                 "a\xE2\x81\xA6"
                                 "b",
                                 "a\xC2\x85"
                                 "b"}) {
    CheckProblem(Rename(client, flight, {{"name", name}}), 422, "InvalidValue");
    const nlohmann::json request{{"name", name}};
    CheckProblem(
        client.Post("/v1/flights", request.dump(), "application/json"), 422, "InvalidValue");
  }
}

TEST_CASE("flights: an unknown datum and wind say what they cost there") {
  FreshServer fresh;
  httplib::Client& client = fresh.client;
  const std::string flight = NewFlightWith(client, nlohmann::json::parse(kCamera));
  CHECK_FALSE(Has(WarningsOf(client, flight), "is unknown"));
  REQUIRE(PutFrame(client, flight, "a", NoiseImage(1), MetaAtSwindale().dump())->status == 201);
  REQUIRE(std::lround(Egm96().HeightAt(54.51, -2.76).value_or(0.0)) == 53);
  const std::string warnings = WarningsOf(client, flight);
  CAPTURE(warnings);
  CHECK(Has(warnings,
            "the datum of the altitudes is unknown: every recall of these sites takes 53 m off"));
  // Of a techpod, 1000 m / 12 * (13 / (13 - 5.5) - 1).
  CHECK(Has(warnings, "the wind is unknown: "));
  CHECK(Has(warnings, "takes 61 m more off the height for each kilometre"));
}

TEST_CASE("flights: what they tell costs nothing") {
  FreshServer fresh;
  httplib::Client& client = fresh.client;
  nlohmann::json request = nlohmann::json::parse(kCamera);
  request["altitude_datum"] = "amsl";
  const std::string flight = NewFlightWith(client, request);
  nlohmann::json meta = MetaAtSwindale();
  meta["wind"] = {{"east_mps", 1.0}, {"north_mps", 2.0}};
  REQUIRE(PutFrame(client, flight, "a", NoiseImage(1), meta.dump())->status == 201);
  CHECK_FALSE(Has(WarningsOf(client, flight), "is unknown"));
}

}  // namespace
}  // namespace freelsd
