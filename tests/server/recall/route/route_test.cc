// The landing insurance of routes over HTTP: it is recall at each second, and its fixes do what
// they say.
#include <chrono>
#include <cmath>
#include <optional>

#include <doctest/doctest.h>

#include "tests/server/meadow.h"
#include "tests/server/recall/emergency_query.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

constexpr double kDegreesPerMetreNorth = 1.0 / 111200.0;

nlohmann::json PointAt(double east_m, double north_m, double altitude_m) {
  const GeoPoint place = LocalFrame({47.0, 8.0, 0.0}).GeoFromWorld({east_m, north_m, 0.0});
  return {{"latitude_deg", place.latitude_deg},
          {"longitude_deg", place.longitude_deg},
          {"altitude_m", altitude_m}};
}

// Past the meadow at 47 N 8 E, which lies at 400 m.
nlohmann::json Request(double altitude_m) {
  return {{"route",
           {PointAt(-900.0, -1200.0, altitude_m),
            PointAt(300.0, -150.0, altitude_m + 20.0),
            PointAt(500.0, 1900.0, altitude_m - 20.0)}},
          {"altitude_datum", "amsl"},
          {"airspeed_mps", 15.0},
          {"wind", {{"east_mps", 2.0}, {"north_mps", -1.0}}}};
}

httplib::Result Post(httplib::Client& client,
                     const nlohmann::json& request,
                     const std::string& query = "") {
  return client.Post("/v1/routes/check" + query, request.dump(), "application/json");
}

nlohmann::json Check(httplib::Client& client, const nlohmann::json& request) {
  const auto result = Post(client, request);
  REQUIRE(result);
  INFO(result->body);
  REQUIRE(result->status == 200);
  return nlohmann::json::parse(result->body);
}

nlohmann::json RecallAt(httplib::Client& client,
                        const nlohmann::json& sample,
                        const nlohmann::json& wind) {
  const nlohmann::json request{{"latitude_deg", sample["latitude_deg"]},
                               {"longitude_deg", sample["longitude_deg"]},
                               {"altitude_m", sample["altitude_m"]},
                               {"heading_deg", sample["heading_deg"]},
                               {"altitude_datum", "amsl"},
                               {"wind_east_mps", wind["east_mps"]},
                               {"wind_north_mps", wind["north_mps"]},
                               {"limit", 1}};
  const auto result = client.Post("/v1/emergency", request.dump(), "application/json");
  REQUIRE(result);
  REQUIRE(result->status == 200);
  return nlohmann::json::parse(result->body);
}

double GapSeconds(const nlohmann::json& answer) {
  double seconds = 0.0;
  for (const auto& gap : answer["gaps"]) {
    seconds += gap["to_s"].get<double>() - gap["from_s"].get<double>();
  }
  return seconds;
}

TEST_CASE("route check: each second is what recall answers there") {
  const MeadowServer meadow(StoreAmslMeadow);
  httplib::Client& client = *meadow.client;
  const nlohmann::json request = Request(500.0);
  const nlohmann::json answer = Check(client, request);
  size_t num_covered = 0;
  for (const auto& sample : answer["samples"]) {
    const nlohmann::json recall = RecallAt(client, sample, request["wind"]);
    const bool is_covered = !recall["sites"].empty();
    INFO(sample.dump());
    REQUIRE(sample["covered"] == is_covered);
    const nlohmann::json& site = is_covered ? recall["sites"][0] : recall["nearest_miss"];
    REQUIRE(sample["arrival_margin_m"] == site["arrival_margin_m"]);
    if (is_covered) {
      REQUIRE(sample["best_site"] == site["site_id"]);
      REQUIRE(sample["failure_probability"] == site["failure_probability"]);
    }
    num_covered += is_covered;
  }
  // The test is about both.
  CHECK(num_covered > 20);
  CHECK(num_covered + 20 < answer["samples"].size());
  CHECK(answer["covered_ratio"].get<double>() ==
        doctest::Approx(static_cast<double>(num_covered) /
                        static_cast<double>(answer["samples"].size())));
}

TEST_CASE("route check: with several winds the worst one counts") {
  const MeadowServer meadow(StoreAmslMeadow);
  httplib::Client& client = *meadow.client;
  nlohmann::json request = Request(520.0);
  request.erase("wind");
  request["winds"] = {{{"east_mps", 4.0}, {"north_mps", 0.0}, {"weight", 3.0}},
                      {{"east_mps", -4.0}, {"north_mps", 0.0}}};
  const nlohmann::json answer = Check(client, request);
  size_t num_in_one = 0;
  for (size_t i = 0; i < answer["samples"].size(); i += 7) {
    const auto& sample = answer["samples"][i];
    double weight = 0.0;
    std::optional<double> least_m;
    for (const auto& wind : request["winds"]) {
      const nlohmann::json recall = RecallAt(client, sample, wind);
      const bool is_covered = !recall["sites"].empty();
      if (is_covered) weight += wind.value("weight", 1.0) / 4.0;
      const double margin_m =
          (is_covered ? recall["sites"][0] : recall["nearest_miss"])["arrival_margin_m"];
      least_m = std::min(least_m.value_or(margin_m), margin_m);
    }
    CHECK(sample["covered_weight"] == weight);
    CHECK(sample["covered"] == (weight == 1.0));
    CHECK(sample["arrival_margin_m"] == *least_m);
    num_in_one += weight > 0.0 && weight < 1.0;
  }
  CHECK(num_in_one > 0);
}

constexpr double kMaxHighRatio = 0.05;

TEST_CASE("route check: gaps, the point of no return and their reasons") {
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json answer = Check(*meadow.client, Request(500.0));
  REQUIRE(answer["gaps"].size() >= 2);
  const nlohmann::json& first = answer["gaps"].front();
  const nlohmann::json& last = answer["gaps"].back();
  // Over the meadow there are moments at which no way loses just the height that is too much.
  double high_s = 0.0;
  for (size_t i = 1; i + 1 < answer["gaps"].size(); ++i) {
    const nlohmann::json& gap = answer["gaps"][i];
    CHECK(gap["reason"] == "too_high");
    CHECK(gap["nearest_miss"]["missing_m"] == 0.0);
    high_s += gap["to_s"].get<double>() - gap["from_s"].get<double>();
  }
  CHECK(high_s <= kMaxHighRatio * answer["time_s"].get<double>());
  CHECK(first["from_s"] == 0.0);
  CHECK(first["reason"] == "too_low");
  CHECK(first["nearest_miss"]["site_id"] == "f-r1");
  CHECK(first["nearest_miss"]["missing_m"].get<double>() > 0.0);
  CHECK(last["to_s"] == answer["time_s"]);
  CHECK(answer["point_of_no_return"]["time_s"].get<double>() == last["from_s"].get<double>() - 1.0);
  CHECK(answer["point_of_no_return"]["best_site"] == "f-r1");
  const MeadowServer empty([](Storage& storage) {
    SiteRow rejected = MeadowSite("amsl");
    rejected.recall.reset();
    PutOnMap(storage, rejected, Meadow());
  });
  const nlohmann::json nothing = Check(*empty.client, Request(500.0));
  REQUIRE(nothing["gaps"].size() == 1);
  CHECK(nothing["gaps"][0]["reason"] == "no_site");
  CHECK(nothing["covered_ratio"] == 0.0);
  CHECK_FALSE(nothing.contains("point_of_no_return"));
  CHECK(nothing["fixes"].empty());
}

TEST_CASE("route check: terrain on the way is its own reason") {
  const MeadowServer walled([](Storage& storage) {
    StoreAmslMeadow(storage);
    SiteMap wall = Meadow();
    // 250 m south of the meadow's middle, 300 m high.
    wall.map.upper(cv::Rect(0, 545, 600, 5)) = 300.0f;
    SiteRow row = MeadowSite("amsl");
    row.id = std::string("f-r9");
    row.recall.reset();
    PutOnMap(storage, row, wall);
  });
  nlohmann::json request = Request(560.0);
  request["route"] = {PointAt(0.0, -500.0, 560.0), PointAt(0.0, -300.0, 560.0)};
  const nlohmann::json answer = Check(*walled.client, request);
  REQUIRE(answer["gaps"].size() == 1);
  CHECK(answer["gaps"][0]["reason"] == "terrain");
}

TEST_CASE("route check: each fix leaves the gaps that it says") {
  const MeadowServer meadow(StoreAmslMeadow);
  httplib::Client& client = *meadow.client;
  nlohmann::json request = Request(500.0);
  // Past the meadow, at such a distance that a climb or an offset closes the middle's gap.
  request["route"] = {
      PointAt(-150.0, -600.0, 540.0), PointAt(0.0, 100.0, 440.0), PointAt(150.0, 600.0, 540.0)};
  const nlohmann::json answer = Check(client, request);
  const double before_s = GapSeconds(answer);
  REQUIRE(before_s > 0.0);
  REQUIRE_FALSE(answer["fixes"].empty());
  size_t num_routes = 0;
  for (const auto& fix : answer["fixes"]) {
    INFO(fix["sentence"]);
    CHECK(fix["gaps_left_s"].get<double>() < before_s);
    if (!fix.contains("route")) continue;
    ++num_routes;
    nlohmann::json changed = request;
    changed["route"] = fix["route"];
    const nlohmann::json checked = Check(client, changed);
    CHECK(GapSeconds(checked) == fix["gaps_left_s"].get<double>());
  }
  CHECK(num_routes > 0);
}

TEST_CASE("route check: a strip where a look is proposed closes what is said") {
  const MeadowServer meadow(StoreAmslMeadow);
  nlohmann::json request = Request(500.0);
  request["route"] = {PointAt(0.0, 0.0, 520.0), PointAt(0.0, 3000.0, 520.0)};
  const nlohmann::json answer = Check(*meadow.client, request);
  nlohmann::json look;
  for (const auto& fix : answer["fixes"]) {
    if (fix["kind"] == "look") look = fix;
  }
  INFO(answer["fixes"].dump());
  REQUIRE_FALSE(look.is_null());
  const double north_m =
      (look["place"]["latitude_deg"].get<double>() - 47.0) / kDegreesPerMetreNorth;
  CHECK(north_m > 500.0);
  CHECK(look["place"]["altitude_m"].get<double>() == doctest::Approx(400.0).epsilon(0.01));
  const MeadowServer with_strip([&](Storage& storage) {
    StoreAmslMeadow(storage);
    SiteRow strip = MeadowSite("amsl", north_m);
    strip.id = "g-r1";
    strip.flight_id = "g";
    PutOnMap(storage, strip, Meadow());
  });
  CHECK(GapSeconds(Check(*with_strip.client, request)) <= look["gaps_left_s"].get<double>());
}

TEST_CASE("route check: a plan of QGroundControl is the same route") {
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json request = Request(500.0);
  nlohmann::json items = nlohmann::json::array();
  for (const auto& point : request["route"]) {
    items.push_back({{"type", "SimpleItem"},
                     {"command", 16},
                     {"frame", 3},
                     {"params",
                      {0,
                       0,
                       0,
                       nullptr,
                       point["latitude_deg"],
                       point["longitude_deg"],
                       point["altitude_m"].get<double>() - 400.0}}});
  }
  const nlohmann::json plan{
      {"fileType", "Plan"},
      {"version", 1},
      {"mission",
       {{"cruiseSpeed", 15}, {"plannedHomePosition", {47.0, 8.0, 400.0}}, {"items", items}}}};
  const auto result = Post(*meadow.client, plan, "?wind_east_mps=2&wind_north_mps=-1");
  REQUIRE(result->status == 200);
  CHECK(nlohmann::json::parse(result->body) == Check(*meadow.client, request));
}

TEST_CASE("route check: what is not said is taken from the flight that is named") {
  const MeadowServer meadow(StoreAmslMeadow);
  httplib::Client& client = *meadow.client;
  const auto flight =
      client.Post("/v1/flights",
                  R"({"name":"x","altitude_datum":"amsl","aircraft":{"profile":"small"}})",
                  "application/json");
  REQUIRE(flight->status == 201);
  nlohmann::json named = Request(500.0);
  const nlohmann::json said = Check(client, named);
  named.erase("altitude_datum");
  const nlohmann::json unsaid = Check(client, named);
  CHECK(unsaid["warnings"].size() == said["warnings"].size() + 1);
  named["flight"] = nlohmann::json::parse(flight->body)["id"];
  const nlohmann::json taken = Check(client, named);
  CHECK(taken["warnings"] == said["warnings"]);
  CHECK(taken["covered_ratio"] == said["covered_ratio"]);
  named["flight"] = "f-none";
  CheckProblem(Post(client, named), 404, "NoSuchFlight");
  named["flight"] = 7;
  const auto refused = Post(client, named);
  CheckProblem(refused, 422, "InvalidValue");
  CHECK(refused->body.find("/flight") != std::string::npos);
}

TEST_CASE("route check: a flight's wind comes with its deviation, as in recall") {
  const MeadowServer meadow(StoreAmslMeadow);
  httplib::Client& client = *meadow.client;
  const auto flight =
      client.Post("/v1/flights",
                  R"({"name":"x","altitude_datum":"amsl","aircraft":{"profile":"small"}})",
                  "application/json");
  REQUIRE(flight->status == 201);
  const std::string id = nlohmann::json::parse(flight->body)["id"];
  const int64_t now_us = std::chrono::duration_cast<std::chrono::microseconds>(
                             std::chrono::system_clock::now().time_since_epoch())
                             .count();
  const nlohmann::json line{
      {"timestamp_us", now_us},
      {"position", PointAt(0.0, 0.0, 500.0)},
      {"wind", {{"east_mps", 2.0}, {"north_mps", -1.0}, {"sd_mps", 1.5}, {"source", "drift"}}}};
  const auto stored =
      client.Post("/v1/flights/" + id + "/telemetry", line.dump() + "\n", "application/x-ndjson");
  REQUIRE(stored->status == 200);
  nlohmann::json named = Request(460.0);
  const nlohmann::json exact = Check(client, named);
  named.erase("wind");
  named["flight"] = id;
  const nlohmann::json taken = Check(client, named);
  int num_lower = 0;
  REQUIRE(taken["samples"].size() == exact["samples"].size());
  for (size_t i = 0; i < taken["samples"].size(); i += 10) {
    const nlohmann::json& sample = taken["samples"][i];
    const nlohmann::json request{{"latitude_deg", sample["latitude_deg"]},
                                 {"longitude_deg", sample["longitude_deg"]},
                                 {"altitude_m", sample["altitude_m"]},
                                 {"heading_deg", sample["heading_deg"]},
                                 {"flight", id},
                                 {"limit", 1}};
    const auto result = client.Post("/v1/emergency", request.dump(), "application/json");
    REQUIRE(result->status == 200);
    const nlohmann::json recall = nlohmann::json::parse(result->body);
    const bool is_covered = sample["covered"];
    CHECK(is_covered == !recall["sites"].empty());
    if (is_covered) {
      // The wind is a little older by now.
      constexpr double kMaxAgedM = 1.0;
      const double margin_m = sample["arrival_margin_m"];
      const double recalled_m = recall["sites"][0]["arrival_margin_m"];
      CHECK(std::abs(margin_m - recalled_m) < kMaxAgedM);
    }
    const nlohmann::json& exactly = exact["samples"][i];
    num_lower += exactly["covered"] &&
                 (!is_covered || sample["arrival_margin_m"] < exactly["arrival_margin_m"]);
  }
  CHECK(num_lower > 0);
}

TEST_CASE("route check: GeoJSON colours the whole line") {
  const MeadowServer meadow(StoreAmslMeadow);
  const auto result = Post(*meadow.client, Request(500.0), "?f=geojson");
  REQUIRE(result->status == 200);
  CHECK(result->get_header_value("Content-Type") == "application/geo+json");
  const nlohmann::json answer = nlohmann::json::parse(result->body);
  std::vector<nlohmann::json> lines;
  for (const auto& feature : answer["features"]) {
    const std::string kind = feature["properties"]["kind"];
    if (kind == "covered" || kind == "gap") lines.push_back(feature);
  }
  REQUIRE(lines.size() >= 3);
  for (size_t i = 0; i + 1 < lines.size(); ++i) {
    CHECK(lines[i]["geometry"]["coordinates"].back() ==
          lines[i + 1]["geometry"]["coordinates"].front());
    CHECK(lines[i]["properties"]["stroke"] != lines[i + 1]["properties"]["stroke"]);
  }
}

TEST_CASE("route check: bad requests are refused by name") {
  const MeadowServer meadow(StoreAmslMeadow);
  httplib::Client& client = *meadow.client;
  nlohmann::json storm = Request(500.0);
  storm["wind"] = {{"east_mps", -40.0}, {"north_mps", 0.0}};
  const auto refused = Post(client, storm);
  CheckProblem(refused, 422, "InvalidValue");
  CHECK(refused->body.find("/route/1") != std::string::npos);
  nlohmann::json endless = Request(500.0);
  endless["route"] = {PointAt(0.0, 0.0, 500.0), PointAt(0.0, 200000.0, 500.0)};
  CheckProblem(Post(client, endless), 422, "InvalidValue");
  CheckProblem(Post(client, Request(500.0), "?f=kml"), 400, "InvalidQuery");
  CheckProblem(Post(client, Request(500.0), "?wind_east_mps=1"), 400, "InvalidQuery");
  CheckProblem(client.Post("/v1/routes/check", "{", "application/json"), 400, "InvalidJson");
  CheckProblem(client.Post("/v1/routes/check", "[]", "application/json"), 422, "InvalidValue");
}

}  // namespace
}  // namespace freelsd
