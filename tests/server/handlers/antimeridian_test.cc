// Every line and polygon of an answer across the antimeridian is cut there (RFC 7946, 3.1.9).
#include <cmath>

#include <doctest/doctest.h>

#include "tests/server/meadow_map.h"
#include "tests/server/openapi_check.h"

namespace freelsd {
namespace {

constexpr double kAntimeridianDeg = 180.0;

struct Shapes {
  int num_cut = 0;
  int num_jumps = 0;
  int num_outside = 0;
};

void LookAt(const nlohmann::json& coordinates, Shapes& shapes) {
  if (coordinates.empty()) return;
  if (coordinates[0].is_array()) {
    for (size_t i = 0; i < coordinates.size(); ++i) {
      LookAt(coordinates[i], shapes);
      if (i == 0 || !coordinates[i][0].is_number()) continue;
      const double leg_deg = coordinates[i][0].get<double>() - coordinates[i - 1][0].get<double>();
      shapes.num_jumps += std::abs(leg_deg) > 180.0;
    }
  } else {
    shapes.num_outside += std::abs(coordinates[0].get<double>()) > 180.0;
  }
}

// Of all geometries anywhere in the answer.
Shapes ShapesOf(const nlohmann::json& answer) {
  Shapes shapes;
  if (answer.is_object() && answer.contains("coordinates")) {
    shapes.num_cut = answer["type"] == "MultiLineString" || answer["type"] == "MultiPolygon";
    LookAt(answer["coordinates"], shapes);
  } else if (answer.is_structured()) {
    for (const nlohmann::json& each : answer) {
      const Shapes inside = ShapesOf(each);
      shapes.num_cut += inside.num_cut;
      shapes.num_jumps += inside.num_jumps;
      shapes.num_outside += inside.num_outside;
    }
  }
  return shapes;
}

void CheckCut(const nlohmann::json& answer) {
  const Shapes shapes = ShapesOf(answer);
  CHECK(shapes.num_cut > 0);
  CHECK(shapes.num_jumps == 0);
  CHECK(shapes.num_outside == 0);
}

// The meadow of flight "g", its middle on the antimeridian, with a region around it.
void StoreMeadowAcross(Storage& storage) {
  FlightRow flight;
  flight.id = "g";
  flight.request_json =
      ParseFlightRequest(R"({"name":"g","altitude_datum":"amsl","aircraft":{"profile":"small"}})")
          .canonical_json;
  storage.flights.Insert(flight);
  const FlightMapRow map =
      StageMeadowMap(storage, Meadow(), "g", 1600000000000000, std::nullopt, kAntimeridianDeg);
  SiteRow site = SiteOnMap(map, kAntimeridianDeg);
  site.id = std::string("g-r1");
  storage.sites.PutEvaluation({{site}, {}, {map.id}, {}}, {});
  nlohmann::json region{{"type", "Feature"}, {"properties", {{"id", 1}}}};
  const nlohmann::json ring{
      {179.999, 46.999}, {-179.999, 46.999}, {-179.999, 47.001}, {179.999, 46.999}};
  region["geometry"] = {{"type", "Polygon"}, {"coordinates", nlohmann::json::array({ring})}};
  storage.flights.ReplaceRegions("g", {{1, region.dump(), "{}"}});
}

std::string From(double longitude_deg, double heading_deg) {
  return "latitude_deg=47.0&longitude_deg=" + std::to_string(longitude_deg) +
         "&altitude_m=560&altitude_datum=amsl&wind_east_mps=0&wind_north_mps=0&heading_deg=" +
         std::to_string(heading_deg);
}

TEST_CASE("antimeridian: emergency, approach, landing and reach are cut there") {
  const MeadowServer meadow(StoreMeadowAcross);
  httplib::Client& client = *meadow.client;
  HoldAgainstContract(client);
  // One of the two has to cross it.
  nlohmann::json both = nlohmann::json::array();
  for (const auto& query : {From(179.993, 90.0), From(-179.993, 270.0)}) {
    const nlohmann::json answer = GetJson(client, "/v1/emergency?" + query);
    INFO(answer.dump());
    REQUIRE(answer["sites"].size() == 1);
    const nlohmann::json& site = answer["sites"][0];
    size_t num_places = site["path"]["coordinates"].size();
    if (site["path"]["type"] == "MultiLineString") {
      num_places = 0;
      for (const nlohmann::json& part : site["path"]["coordinates"]) num_places += part.size();
    }
    CHECK(site["times_s"].size() == num_places);
    for (size_t i = 1; i < num_places; ++i) CHECK(site["times_s"][i] >= site["times_s"][i - 1]);
    both.push_back(site);
    CheckCut(GetJson(client, "/v1/reach?" + query));
  }
  CheckCut(both);
  const std::string wind = "?wind_east_mps=2&wind_north_mps=0";
  CheckCut(GetJson(client, "/v1/sites/g-r1/approach" + wind));
  CheckCut(
      GetJson(client, "/v1/flights/g/landing" + wind + "&latitude_deg=47.0&longitude_deg=180.0"));
}

TEST_CASE("antimeridian: tracks, regions and checked routes are cut there") {
  const MeadowServer meadow(StoreMeadowAcross);
  httplib::Client& client = *meadow.client;
  HoldAgainstContract(client);
  std::string lines;
  nlohmann::json route = nlohmann::json::array();
  for (const double longitude_deg : {179.99, 179.995, -179.995, -179.99}) {
    const nlohmann::json position{
        {"latitude_deg", 47.0}, {"longitude_deg", longitude_deg}, {"altitude_m", 560.0}};
    const auto time_us = 1600000000000000 + static_cast<int64_t>(route.size()) * 10000000;
    lines += nlohmann::json{{"timestamp_us", time_us}, {"position", position}}.dump() + "\n";
    route.push_back(position);
  }
  const auto told = client.Post("/v1/flights/g/telemetry", lines, "application/x-ndjson");
  REQUIRE(told->status == 200);
  CheckCut(GetJson(client, "/v1/flights/g/track"));
  CheckCut(GetJson(client, "/v1/flights/g/regions"));
  const nlohmann::json request{
      {"route", route}, {"altitude_datum", "amsl"}, {"airspeed_mps", 15}, {"aircraft", "small"}};
  const auto checked =
      client.Post("/v1/routes/check?f=geojson", request.dump(), "application/json");
  INFO(checked->body);
  REQUIRE(checked->status == 200);
  CheckCut(nlohmann::json::parse(checked->body));
}

}  // namespace
}  // namespace freelsd
