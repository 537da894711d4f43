// Nothing in reach beside a field: what the datums of altitudes cost in emergency recall.
#include <cmath>
#include <cstdlib>

#include <doctest/doctest.h>

#include "engine/glide/glide.h"
#include "server/intake/arrival_clock.h"
#include "tests/api/import/images/tagged_image.h"
#include "tests/server/child.h"
#include "tests/server/meadow.h"
#include "tests/server/recall/emergency_query.h"
#include "tests/server/sample_flight.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

// EGM96 at 47 N 8 E, a node of its grid.
constexpr double kGeoidHeightM = 48.389;
constexpr double kMaxGeoidErrorM = 0.1;
constexpr char kCalm[] = "&wind_east_mps=0&wind_north_mps=0&heading_deg=0";

nlohmann::json BestOf(const nlohmann::json& answer) {
  if (!answer["sites"].empty()) return answer["sites"][0];
  REQUIRE(answer.contains("nearest_miss"));
  return answer["nearest_miss"];
}

double MarginOf(httplib::Client& client, const std::string& path) {
  return BestOf(GetJson(client, path))["arrival_margin_m"];
}

// A flight with this datum ("": not given) that found the meadow's site.
void StoreFlight(Storage& storage, const std::string& id, const std::string& datum) {
  FlightRow flight;
  flight.id = id;
  nlohmann::json request{{"name", "x"}, {"aircraft", {{"profile", "small"}}}};
  if (!datum.empty()) request["altitude_datum"] = datum;
  request["camera"] = {{"width_px", 320},
                       {"height_px", 240},
                       {"fx_px", 300.0},
                       {"fy_px", 300.0},
                       {"cx_px", 160.0},
                       {"cy_px", 120.0}};
  flight.request_json = ParseFlightRequest(request.dump()).canonical_json;
  storage.flights.Insert(flight);
}

SiteRow SiteOf(const std::string& flight_id, const std::string& datum) {
  SiteRow site = MeadowSite(datum);
  site.id = flight_id + "-r1";
  site.flight_id = flight_id;
  return site;
}

// The flight's datum when it is this one, or after half a minute: frames are settled one by one.
std::string AwaitDatum(httplib::Client& client,
                       const std::string& flight,
                       const std::string& expected) {
  std::string datum;
  for (int i = 0; i < 600 && datum != expected; ++i) {
    if (i > 0) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    datum = GetJson(client, "/v1/flights/" + flight)["altitude_datum"];
  }
  return datum;
}

std::string AtSomeHeight() { return R"({"height_above_ground_m": 70.0})"; }

TEST_CASE("nothing in reach beside a field: a flight of geotags comes down from 70 m above it") {
  const MeadowServer meadow([](Storage& storage) {
    StoreFlight(storage, "f", "");
    StoreAmslMeadow(storage);
  });
  httplib::Client& client = *meadow.client;
  // 150 m south of the touchdown, by photographs without any pose beside their tags.
  const std::string image = WithGeotag(NoiseImage(1), {46.99865, 8.0, 470.0, 0});
  REQUIRE(PutFrame(client, "f", "a", image, AtSomeHeight())->status == 201);
  CHECK(AwaitDatum(client, "f", "amsl") == "amsl");
  const nlohmann::json answer = GetJson(client,
                                        "/v1/emergency?latitude_deg=46.99865&longitude_deg=8"
                                        "&altitude_m=470&flight=f" +
                                            std::string(kCalm));
  INFO(answer.dump());
  REQUIRE(answer["sites"].size() == 1);
  CHECK(answer["sites"][0]["datum_penalty_m"] == 0.0);
  CHECK(answer["sites"][0]["terrain_datum_penalty_m"] == 0.0);
  CHECK(answer["taken_from_flight"]["altitude_datum"] == "amsl");
  CHECK(answer["warnings"].dump().find("datum") == std::string::npos);
}

TEST_CASE("nothing in reach beside a field: an unknown datum costs nothing within one flight") {
  const MeadowServer meadow([](Storage& storage) {
    StoreFlight(storage, "f", "");
    StoreFlight(storage, "g", "");
  });
  httplib::Client& client = *meadow.client;
  const std::string place = Query(600.0, kCalm);
  const nlohmann::json own = GetJson(client, place + "&flight=f");
  CHECK(BestOf(own)["datum_penalty_m"] == 0.0);
  CHECK(BestOf(own)["terrain_datum_penalty_m"] == 0.0);
  CHECK(own["warnings"].dump().find("datum") == std::string::npos);
  // Another flight's unknown datum may be the other one, as may that of no flight.
  for (const char* const other : {"&flight=g", "", "&altitude_datum=amsl"}) {
    const nlohmann::json answer = GetJson(client, place + other);
    CHECK(std::abs(BestOf(answer)["datum_penalty_m"].get<double>() - kGeoidHeightM) <
          kMaxGeoidErrorM);
    CHECK(answer["warnings"].dump().find("datum") != std::string::npos);
    CHECK(BestOf(own)["arrival_margin_m"].get<double>() -
              BestOf(answer)["arrival_margin_m"].get<double>() ==
          doctest::Approx(BestOf(answer)["datum_penalty_m"].get<double>()));
  }
}

TEST_CASE("nothing in reach beside a field: a rejected site's map on the way takes nothing off") {
  // Flat ground on the way, higher than the meadow: it decides the margin.
  const auto with_map_of = [](const std::string& datum) {
    return [datum](Storage& storage) {
      StoreAmslMeadow(storage);
      SiteMap hill = Meadow();
      hill.map.upper = cv::Mat1f(hill.map.upper.size(), 100.0f);
      SiteRow row = SiteOf("g", datum);
      row.recall.reset();
      row.map_datum = datum;
      PutOnMap(storage, row, hill);
    };
  };
  const std::string path = Query(700.0, kCalmNorth);
  const MeadowServer known(with_map_of("amsl"));
  const nlohmann::json site = BestOf(GetJson(*known.client, path));
  CHECK(site["datum_penalty_m"] == 0.0);
  CHECK(site["terrain_datum_penalty_m"] == 0.0);
  CHECK(site["terrain_margin_m"] == site["arrival_margin_m"]);
  // If a penalty is subtracted, the answer contains it and the reason.
  const MeadowServer unknown(with_map_of("unknown"));
  const nlohmann::json answer = GetJson(*unknown.client, path);
  const nlohmann::json doubtful = BestOf(answer);
  CHECK(doubtful["datum_penalty_m"] == 0.0);
  const double penalty_m = doubtful["terrain_datum_penalty_m"];
  CHECK(std::abs(penalty_m - kGeoidHeightM) < kMaxGeoidErrorM);
  CHECK(doubtful["terrain_margin_m"].get<double>() ==
        doctest::Approx(site["terrain_margin_m"].get<double>() - penalty_m));
  CHECK(answer["warnings"].dump().find("datum") != std::string::npos);
}

TEST_CASE("nothing in reach beside a field: between two known datums lies the geoid, no more") {
  for (const char* const stored : {"amsl", "ellipsoid"}) {
    const MeadowServer meadow(
        [stored](Storage& storage) { PutOnMap(storage, MeadowSite(stored), Meadow()); });
    const auto margin_of = [&](const std::string& datum) {
      return MarginOf(*meadow.client, Query(800.0, kCalm + ("&altitude_datum=" + datum)));
    };
    // An altitude above the ellipsoid is lower than the same number above the sea.
    CHECK(std::abs(margin_of("amsl") - margin_of("ellipsoid") - kGeoidHeightM) < kMaxGeoidErrorM);
    const nlohmann::json answer =
        GetJson(*meadow.client, Query(800.0, std::string(kCalm) + "&altitude_datum=ellipsoid"));
    const double penalty_m = BestOf(answer)["datum_penalty_m"];
    CHECK(std::abs(penalty_m - (std::string(stored) == "amsl" ? kGeoidHeightM : 0.0)) <
          kMaxGeoidErrorM);
    CHECK(answer["warnings"].dump().find("datum") == std::string::npos);
  }
  // What the altitude gains brings a site into reach, however far the search looks.
  const MeadowServer meadow(
      [](Storage& storage) { PutOnMap(storage, MeadowSite("ellipsoid"), Meadow()); });
  const nlohmann::json gained = GetJson(*meadow.client, Query(465.0, kCalmNorth));
  INFO(gained.dump());
  REQUIRE(gained["sites"].size() == 1);
  CHECK(gained["sites"][0]["datum_penalty_m"].get<double>() < 0.0);
}

TEST_CASE("nothing in reach beside a field: frames that contradict each other make it unknown") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const auto put = [&](const std::string& frame, const std::string& image) {
    CHECK(PutFrame(fresh.client, flight, frame, image, AtSomeHeight())->status == 201);
  };
  put("a", WithGeotag(NoiseImage(1), {}));
  CHECK(AwaitDatum(fresh.client, flight, "amsl") == "amsl");
  CHECK(GetJson(fresh.client, "/v1/flights/" + flight)["warnings"].dump().find("datum") ==
        std::string::npos);
  // The trap: RTK altitudes are ellipsoidal, and EXIF calls them sea level all the same.
  put("b", WithXmpTags(WithGeotag(NoiseImage(2), {}), "drone-dji:RtkFlag='50'"));
  CHECK(AwaitDatum(fresh.client, flight, "unknown") == "unknown");
  CHECK(GetJson(fresh.client, "/v1/flights/" + flight)["warnings"].dump().find("datum") !=
        std::string::npos);
}

TEST_CASE("nothing in reach beside a field: all maps of a flight are stored with its datum") {
  const TemporaryFolder folder;
  {
    Config config = TestConfig(folder.path());
    config.model = RealModel();
    const TestServer server(config);
    httplib::Client client = server.Client();
    const std::string flight = PostSampleFlightWithNamedDatum(client);
    REQUIRE(AwaitJob(client, Finish(client, flight))["state"] == "done");
    CHECK(GetJson(client, "/v1/flights/" + flight)["altitude_datum"] == "amsl");
    const nlohmann::json sites = GetJson(client, "/v1/flights/" + flight + "/sites")["features"];
    REQUIRE_FALSE(sites.empty());
    for (const nlohmann::json& site : sites) CHECK(site["properties"]["altitude_datum"] == "amsl");
  }
  const Storage storage(StorageAt(folder.path()));
  const SharedRows<MapRow> maps = storage.sites.ListMaps({-180.0, -90.0, 180.0, 90.0});
  REQUIRE_FALSE(maps.empty());
  for (const auto& map : maps) CHECK(map->altitude_datum == "amsl");
  size_t num_rejected = 0;
  for (const SiteRow& site : storage.sites.List(std::nullopt, std::nullopt)) {
    num_rejected += site.feature_json.find("\"verdict\":\"rejected\"") != std::string::npos;
    CHECK(ParseReplan(site.replan_json).flight.altitude_datum == "amsl");
  }
  CHECK(num_rejected > 0);
}

TEST_CASE("altitude datum: what the client says of the flight overrides tags, with a warning") {
  const MeadowServer meadow([](Storage& storage) { StoreFlight(storage, "f", "ellipsoid"); });
  httplib::Client& client = *meadow.client;
  REQUIRE(PutFrame(client, "f", "a", WithGeotag(NoiseImage(1), {}), AtSomeHeight())->status == 201);
  std::string warnings;
  for (int i = 0; i < 600 && warnings.find("state amsl") == std::string::npos; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    warnings = GetJson(client, "/v1/flights/f")["warnings"].dump();
  }
  CHECK(warnings.find("state amsl") != std::string::npos);
  CHECK(GetJson(client, "/v1/flights/f")["altitude_datum"] == "ellipsoid");
}

TEST_CASE("altitude datum: meta and telemetry may tell it") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string place =
      R"("position":{"latitude_deg":47,"longitude_deg":8,"altitude_m":500},"altitude_datum":)";
  const auto meta = [&](const std::string& datum) {
    return R"({"height_above_ground_m":70,)" + place + "\"" + datum + "\"}";
  };
  CHECK(PutFrame(fresh.client, flight, "a", NoiseImage(1), meta("ellipsoid"))->status == 201);
  CHECK(AwaitDatum(fresh.client, flight, "ellipsoid") == "ellipsoid");
  CheckProblem(
      PutFrame(fresh.client, flight, "b", NoiseImage(2), meta("msl")), 422, "InvalidValue");
  CheckProblem(PutFrame(fresh.client, flight, "b", NoiseImage(2), R"({"altitude_datum":"amsl"})"),
               422,
               "InvalidValue");
  const std::string other = NewFlight(fresh.client);
  const auto sent = fresh.client.Post("/v1/flights/" + other + "/telemetry",
                                      R"({"timestamp_us":1700000000000000,)" + place + "\"amsl\"}",
                                      "application/x-ndjson");
  CHECK(nlohmann::json::parse(sent->body)["accepted"] == 1);
  const std::string timed = R"({"timestamp_us":1700000000000000,"height_above_ground_m":70})";
  CHECK(PutFrame(fresh.client, other, "a", NoiseImage(1), timed)->status == 201);
  CHECK(AwaitDatum(fresh.client, other, "amsl") == "amsl");
}

TEST_CASE("emergency: datum, wind, aircraft and track are the flight's where they are not given") {
  const MeadowServer meadow([](Storage& storage) {
    StoreFlight(storage, "g", "amsl");
    StoreAmslMeadow(storage);
  });
  httplib::Client& client = *meadow.client;
  const int64_t begin_us = ArrivalNowUs() - 2000000;
  std::string lines;
  for (int i = 0; i < 3; ++i) {
    // To the north at 11 m/s, the nose to the east.
    lines += nlohmann::json{{"timestamp_us", begin_us + int64_t{1000000} * i},
                            {"position",
                             {{"latitude_deg", 46.9953 + 0.0001 * i},
                              {"longitude_deg", 8.0},
                              {"altitude_m", 600.0}}},
                            {"attitude", {{"roll_deg", 0}, {"pitch_deg", 0}, {"yaw_deg", 90}}},
                            {"wind", {{"east_mps", 2.0}, {"north_mps", 0.0}}}}
                 .dump() +
             "\n";
  }
  REQUIRE(client.Post("/v1/flights/g/telemetry", lines, "application/x-ndjson")->status == 200);
  const nlohmann::json answer = GetJson(client, Query(600.0, "&flight=g"));
  const nlohmann::json& taken = answer["taken_from_flight"];
  INFO(answer.dump());
  CHECK(taken["flight_id"] == "g");
  CHECK(taken["altitude_datum"] == "amsl");
  CHECK(taken["wind"]["east_mps"] == 2.0);
  CHECK(taken["aircraft"]["profile"] == "small");
  CHECK(taken["timestamp_us"] == begin_us + 2000000);
  CHECK(std::abs(std::remainder(taken["heading_deg"].get<double>(), 360.0)) < 0.1);
  CHECK(answer["warnings"].dump().find("the wind is") == std::string::npos);
  CHECK(answer["warnings"].dump().find("heading is given") == std::string::npos);
  CHECK(BestOf(answer)["arrival_margin_m"] ==
        MarginOf(client,
                 Query(600.0,
                       "&altitude_datum=amsl&wind_east_mps=2&wind_north_mps=0&aircraft=small"
                       "&wind_sd_mps=" +
                           taken["wind"]["sd_now_mps"].dump() +
                           "&heading_deg=" + taken["heading_deg"].dump())));
  // What is given is not replaced, and far away the track is no one's.
  const nlohmann::json given = GetJson(client, Query(600.0, std::string(kCalmNorth) + "&flight=g"));
  CHECK_FALSE(given["taken_from_flight"].contains("wind"));
  CHECK_FALSE(given["taken_from_flight"].contains("heading_deg"));
  const nlohmann::json far =
      GetJson(client, "/v1/emergency?latitude_deg=46.99&longitude_deg=8&altitude_m=600&flight=g");
  CHECK_FALSE(far["taken_from_flight"].contains("heading_deg"));
  const nlohmann::json body{
      {"latitude_deg", 46.9955}, {"longitude_deg", 8.0}, {"altitude_m", 600.0}, {"flight", "g"}};
  const auto posted = client.Post("/v1/emergency", body.dump(), "application/json");
  nlohmann::json by_body = nlohmann::json::parse(posted->body)["taken_from_flight"];
  for (const char* const name : {"age_s", "sd_now_mps"})
    by_body["wind"][name] = taken["wind"][name];
  CHECK(by_body == taken);
}

TEST_CASE("emergency: an unknown flight is 404, on both listeners") {
  const MeadowServer meadow(StoreAmslMeadow, [](Config& config) {
    config.emergency = Address{"127.0.0.1", 0};
  });
  CheckProblem(meadow.client->Get(Query(600.0, "&flight=none")), 404, "NoSuchFlight");
  httplib::Client emergency = meadow.server->EmergencyClient();
  CheckProblem(emergency.Get(Query(600.0, "&flight=none")), 404, "NoSuchFlight");
  CheckProblem(
      meadow.client->Post("/v1/emergency",
                          R"({"latitude_deg":47,"longitude_deg":8,"altitude_m":500,"flight":7})",
                          "application/json"),
      422,
      "InvalidValue");
}

TEST_CASE("emergency: without the geoid's grid its greatest height is taken, with a warning") {
  const TemporaryFolder folder;
  {
    Storage storage(StorageAt(folder.path() / "data"));
    StoreAmslMeadow(storage);
  }
  setenv("PROJ_DATA", "/nonexistent", 1);
  Child child({folder.path()});
  httplib::Client client = ClientOf(child.AwaitPort());
  unsetenv("PROJ_DATA");
  const nlohmann::json answer =
      GetJson(client, Query(900.0, std::string(kCalm) + "&altitude_datum=ellipsoid"));
  CHECK(BestOf(answer)["datum_penalty_m"] == GlideOptions{}.datum_penalty_m);
  CHECK(answer["warnings"].dump().find("egm96_15.gtx") != std::string::npos);
  CHECK(BestOf(GetJson(client, Query(900.0, kCalmNorth)))["datum_penalty_m"] == 0.0);
  CHECK(child.Stop(SIGTERM) == 0);
}

}  // namespace
}  // namespace freelsd
