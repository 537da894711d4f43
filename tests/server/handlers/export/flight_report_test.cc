// The report of a flight over HTTP.
#include <filesystem>
#include <fstream>

#include <doctest/doctest.h>

#include "api/import/import.h"
#include "tests/server/meadow_map.h"
#include "tests/server/openapi_check.h"

namespace freelsd {
namespace {

// Flight "f" with a row, a map, an accepted site and frames; the map may have a picture.
void StoreFlight(Storage& storage, bool has_picture) {
  FlightRow flight;
  flight.id = "f";
  flight.name = "a <b>meadow</b>";
  flight.request_json =
      ParseFlightRequest(R"({"name":"meadow","aircraft":{"profile":"small"}})").canonical_json;
  flight.warnings_json = R"({"evaluation":["a warning"]})";
  storage.flights.Insert(flight);
  const PhotoLattice lattice{1.0, 512, 1};
  const auto photo = has_picture ? std::optional(lattice) : std::nullopt;
  const FlightMapRow map = StageMeadowMap(storage, Meadow(), "f", 1600000000000000, photo);
  if (has_picture) PutMeadowPicture(storage, map);
  storage.sites.PutEvaluation({{SiteOnMap(map)}, {}, {map.id}, {}}, {});
}

MeadowServer ServerWithFlight(bool has_picture, const std::function<void(Config&)>& change = {}) {
  return MeadowServer([=](Storage& storage) { StoreFlight(storage, has_picture); }, change);
}

std::string Report(const MeadowServer& meadow) {
  const auto answer = meadow.client->Get("/v1/flights/f?f=html");
  REQUIRE(answer);
  REQUIRE(answer->status == 200);
  CHECK(answer->get_header_value("Content-Type") == "text/html; charset=utf-8");
  CHECK(answer->get_header_value("Vary") == "Accept");
  CHECK(answer->get_header_value("Content-Security-Policy").find("default-src 'none'") == 0);
  return answer->body;
}

TEST_CASE("flight report: is answered without a picture, with its site and wind rose") {
  const MeadowServer meadow = ServerWithFlight(false);
  HoldAgainstContract(*meadow.client);
  const std::string page = Report(meadow);
  CHECK(page.find("image/jpeg") == std::string::npos);
  CHECK(page.find("a &lt;b&gt;meadow&lt;/b&gt;") != std::string::npos);
  CHECK(page.find("Site 1") != std::string::npos);
  CHECK(page.find("class=\"cell landable\" d=") != std::string::npos);
  // The site without a map, which is rejected.
  CHECK(page.find("<td>r2</td>") != std::string::npos);
  CHECK(page.find("a warning") != std::string::npos);
  CHECK(page.find("100 % of the map") != std::string::npos);
}

TEST_CASE("flight report: shows the picture of the ground where there is one") {
  const MeadowServer meadow = ServerWithFlight(true);
  HoldAgainstContract(*meadow.client);
  CHECK(Report(meadow).find("image/jpeg") != std::string::npos);
}

TEST_CASE("flight report: the same flight gives the same bytes, but for the time of writing") {
  const MeadowServer meadow = ServerWithFlight(false);
  const auto without_time = [&meadow] {
    const std::string page = Report(meadow);
    return page.substr(0, page.find("<footer>"));
  };
  CHECK(without_time() == without_time());
}

TEST_CASE("flight report: JSON is the default, Accept and ?f= choose") {
  const MeadowServer meadow = ServerWithFlight(false);
  HoldAgainstContract(*meadow.client);
  const auto type = [&meadow](const std::string& query, const std::string& accept) {
    const auto answer = meadow.client->Get("/v1/flights/f" + query, {{"Accept", accept}});
    REQUIRE(answer);
    CHECK(answer->status == 200);
    CHECK(answer->get_header_value("Vary") == "Accept");
    return answer->get_header_value("Content-Type");
  };
  CHECK(type("", "*/*") == "application/json");
  CHECK(type("", "application/json, text/html;q=0.5") == "application/json");
  CHECK(type("", "text/html,application/xhtml+xml,*/*;q=0.8") == "text/html; charset=utf-8");
  CHECK(type("?f=json", "text/html") == "application/json");
  CheckProblem(meadow.client->Get("/v1/flights/f?f=kml"), 400, "InvalidQuery");
}

TEST_CASE("flight report: no such flight is 404, and it is read like all else") {
  const MeadowServer meadow;
  CheckProblem(meadow.client->Get("/v1/flights/none?f=html"), 404, "NoSuchFlight");
  const MeadowServer guarded = ServerWithFlight(false, [](Config& config) {
    const std::filesystem::path file = config.data.parent_path() / "tokens.json";
    std::ofstream(file) << nlohmann::json{
        {{"sha256", Sha256Hex("reader")},
         {"scopes", {"read"}}}}.dump();
    std::filesystem::permissions(file, std::filesystem::perms(0600));
    config.token_file = file;
  });
  CheckProblem(guarded.client->Get("/v1/flights/f?f=html"), 401, "Unauthorized");
  const auto answer =
      guarded.client->Get("/v1/flights/f?f=html", {{"Authorization", "Bearer reader"}});
  REQUIRE(answer);
  CHECK(answer->status == 200);
}

TEST_CASE("flight report: a flight without map and sites is reported") {
  FreshServer fresh;
  HoldAgainstContract(fresh.client);
  const auto answer = fresh.client.Get("/v1/flights/" + NewFlight(fresh.client) + "?f=html");
  REQUIRE(answer);
  CHECK(answer->status == 200);
  CHECK(answer->body.find("The flight has no map") != std::string::npos);
}

}  // namespace
}  // namespace freelsd
