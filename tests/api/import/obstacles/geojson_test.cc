#include <cmath>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/import/obstacles/obstacles.h"
#include "tests/api/errors.h"

namespace freelsd {
namespace {

nlohmann::json Feature(const char* kind, const char* type, const std::string& coordinates) {
  return {{"type", "Feature"},
          {"geometry", {{"type", type}, {"coordinates", nlohmann::json::parse(coordinates)}}},
          {"properties", {{"kind", kind}}}};
}

nlohmann::json Wire() {
  nlohmann::json wire = Feature("wire", "LineString", "[[8.0, 47.0, 450.5], [8.01, 47.0, 460]]");
  wire["properties"]["altitude_datum"] = "amsl";
  wire["properties"]["position_sd_m"] = 2.0;
  wire["properties"]["name"] = "110 kV";
  return wire;
}

nlohmann::json Square(const char* kind) {
  return Feature(kind, "Polygon", "[[[8, 47], [8.01, 47], [8.01, 47.01], [8, 47.01], [8, 47]]]");
}

std::string FaultOf(const nlohmann::json& feature) {
  return ErrorOf([&] { ParseObstacle(feature, ""); });
}

// With one property or member set.
nlohmann::json With(nlohmann::json feature, const char* pointer, const nlohmann::json& value) {
  feature[nlohmann::json::json_pointer(pointer)] = value;
  return feature;
}

TEST_CASE("obstacle features: each kind is read, with its defaults") {
  const GivenObstacle wire = ParseObstacle(Wire(), "");
  CHECK(wire.kind == ObstacleKind::kWire);
  REQUIRE(wire.points.size() == 2);
  CHECK(wire.points[0].longitude_deg == 8.0);
  CHECK(wire.points[0].latitude_deg == 47.0);
  CHECK(wire.points[0].altitude_m == 450.5);
  CHECK(wire.altitude_datum == "amsl");
  CHECK(wire.position_sd_m == 2.0);
  CHECK_FALSE(wire.is_area);
  const GivenObstacle mast =
      ParseObstacle(With(Feature("mast", "Point", "[8, 47]"), "/properties/height_m", 80), "");
  CHECK(mast.height_m == 80.0);
  CHECK(std::isnan(mast.points.at(0).altitude_m));
  CHECK(mast.altitude_datum == "unknown");
  CHECK(mast.position_sd_m == 5.0);
  const GivenObstacle airspace =
      ParseObstacle(With(Square("no_fly"), "/properties/ceiling_m", 1500), "");
  CHECK(airspace.is_area);
  CHECK(airspace.points.size() == 4);
  CHECK_FALSE(airspace.floor_m);
  CHECK(airspace.ceiling_m == 1500.0);
  const GivenObstacle people =
      ParseObstacle(With(Square("people"), "/properties/expires_at", "2026-07-01T12:00:00.5Z"), "");
  CHECK(people.position_sd_m == 20.0);
  // It never expires early.
  CHECK(people.expires_at_us == 1782907201000000);
}

TEST_CASE("obstacle features: what is written reads back the same") {
  nlohmann::json people = With(Square("people"), "/properties/expires_at", "2026-07-01T12:00:00Z");
  people["id"] = "fair-1";
  for (const nlohmann::json& feature :
       {Wire(),
        people,
        With(Square("no_fly"), "/properties/floor_m", 300),
        With(Feature("mast", "Point", "[8, 47]"), "/properties/height_m", 80)}) {
    const nlohmann::json written = ObstacleFeature(ParseObstacle(feature, ""));
    CHECK(ObstacleFeature(ParseObstacle(written, "")) == written);
    CHECK(written["geometry"] == feature["geometry"]);
  }
}

TEST_CASE("obstacle features: each bad field is refused and named") {
  const nlohmann::json wire = Wire();
  const std::string invalid = "422 InvalidValue ";
  CHECK(FaultOf(nlohmann::json::array()) == invalid);
  CHECK(FaultOf(With(wire, "/type", "Wire")) == invalid + "/type");
  CHECK(FaultOf(With(wire, "/id", "a b")) == "422 InvalidId /id");
  CHECK(FaultOf(With(wire, "/colour", "red")) == "422 UnknownKey /colour");
  CHECK(FaultOf(With(wire, "/properties/heigth_m", 5)) == "422 UnknownKey /properties/heigth_m");
  CHECK(FaultOf(With(wire, "/properties/kind", "cable")) == invalid + "/properties/kind");
  CHECK(FaultOf(With(wire, "/properties/name", 5)) == invalid + "/properties/name");
  CHECK(FaultOf(With(wire, "/properties/name", std::string(300, 'x'))) ==
        invalid + "/properties/name");
  CHECK(FaultOf(With(wire, "/properties/altitude_datum", "msl")) ==
        invalid + "/properties/altitude_datum");
  CHECK(FaultOf(With(wire, "/properties/position_sd_m", -1)) ==
        invalid + "/properties/position_sd_m");
  CHECK(FaultOf(With(wire, "/properties/height_m", 0)) == invalid + "/properties/height_m");
  CHECK(FaultOf(With(wire, "/properties/height_m", "5 m")) == invalid + "/properties/height_m");
  CHECK(FaultOf(With(wire, "/properties/floor_m", 5)) == invalid + "/properties/floor_m");
  CHECK(FaultOf(With(wire, "/properties/expires_at", "soon")) ==
        invalid + "/properties/expires_at");
  CHECK(FaultOf(With(wire, "/geometry/type", "Point")) == invalid + "/geometry/type");
  CHECK(FaultOf(With(wire, "/geometry/coordinates", {})) != "nothing");
  CHECK(FaultOf(With(wire, "/geometry/coordinates/1/0", 181)) ==
        invalid + "/geometry/coordinates/1/0");
  CHECK(FaultOf(With(wire, "/geometry/coordinates/1/1", 91)) ==
        invalid + "/geometry/coordinates/1/1");
  CHECK(FaultOf(With(wire, "/geometry/coordinates/1/2", 30000)) ==
        invalid + "/geometry/coordinates/1/2");
  CHECK(FaultOf(With(wire, "/geometry/coordinates/1", {8.0})) ==
        invalid + "/geometry/coordinates/1");
  CHECK(FaultOf(Feature("wire", "LineString", "[[8, 47, 5], [8.01, 47]]")) ==
        invalid + "/geometry/coordinates");
  CHECK(FaultOf(Feature("wire", "LineString", "[[8, 47, 5], [9, 47, 5]]")) ==
        invalid + "/geometry/coordinates");
  CHECK(FaultOf(Feature("wire", "LineString", "[[179.99, 0, 5], [-179.99, 0, 5]]")) ==
        invalid + "/geometry/coordinates");
  CHECK(FaultOf(Feature("mast", "Point", "[8, 47]")) == invalid + "/geometry/coordinates");
  CHECK(
      FaultOf(Feature("no_fly", "Polygon", "[[[8, 47], [8.01, 47], [8.01, 47.01], [8, 47.01]]]")) ==
      invalid + "/geometry/coordinates/0");
  CHECK(FaultOf(Square("people")) == invalid + "/properties/expires_at");
  CHECK(FaultOf(With(
            With(Square("no_fly"), "/properties/floor_m", 500), "/properties/ceiling_m", 500)) ==
        invalid + "/properties/floor_m");
  nlohmann::json holes = Square("no_fly");
  holes["geometry"]["coordinates"].push_back(holes["geometry"]["coordinates"][0]);
  CHECK(FaultOf(holes) == invalid + "/geometry/coordinates");
}

TEST_CASE(
    "obstacle features: a ring that crosses itself is refused, one that touches itself is not") {
  const std::string crossed = "422 InvalidValue /geometry/coordinates";
  const auto people = [](const std::string& coordinates) {
    return With(Feature("people", "Polygon", coordinates),
                "/properties/expires_at",
                "2026-07-01T12:00:00Z");
  };
  const std::string bow_tie = "[[[8, 47], [8.01, 47.01], [8.01, 47], [8, 47.01], [8, 47]]]";
  CHECK(FaultOf(Feature("no_fly", "Polygon", bow_tie)) == crossed);
  CHECK(FaultOf(people(bow_tie)) == crossed);
  // Only one pair of sides crosses.
  CHECK(FaultOf(people("[[[8, 47], [8.02, 47], [8.02, 47.01], [8.01, 46.99], [8, 47]]]")) ==
        crossed);
  // A corner on another side, a side there and back, and a corner given twice.
  CHECK(
      FaultOf(people("[[[8, 47], [8.02, 47], [8.01, 47.01], [8.01, 47], [8, 47.01], [8, 47]]]")) ==
      "nothing");
  CHECK(FaultOf(people("[[[8, 47], [8.02, 47], [8.01, 47.01], [8.01, 47.02], [8.01, 47.01], "
                       "[8, 47.01], [8, 47]]]")) == "nothing");
  CHECK(FaultOf(people("[[[8, 47], [8.01, 47], [8.01, 47], [8, 47.01], [8, 47]]]")) == "nothing");
  // Not convex.
  CHECK(FaultOf(people("[[[8, 47], [8.02, 47], [8.01, 47.005], [8.02, 47.01], [8, 47]]]")) ==
        "nothing");
}

TEST_CASE("obstacle features: shapes without an extent are refused") {
  const std::string flat = "422 InvalidValue /geometry/coordinates";
  CHECK(FaultOf(Feature("no_fly", "Polygon", "[[[8, 47], [8.01, 47], [8, 47], [8, 47]]]")) == flat);
  CHECK(FaultOf(Feature("no_fly", "Polygon", "[[[8, 47], [8, 47], [8, 47], [8, 47]]]")) == flat);
  CHECK(FaultOf(Feature("no_fly", "Polygon", "[[[8, 47], [8.01, 47], [8.02, 47], [8, 47]]]")) ==
        flat);
  CHECK(FaultOf(Feature("wire", "LineString", "[[8, 47, 450], [8, 47, 450]]")) == flat);
  CHECK(FaultOf(Feature("wire", "LineString", "[[8, 47, 450], [8, 47, 460]]")) == flat);
}

TEST_CASE("obstacle features: control characters are refused in names and ids") {
  for (const std::string& text : {std::string("a\0b", 3), std::string("a\nb")}) {
    CHECK(FaultOf(With(Wire(), "/properties/name", text)) == "422 InvalidValue /properties/name");
    CHECK(FaultOf(With(Wire(), "/id", text)) == "422 InvalidId /id");
  }
  CHECK(FaultOf(With(Wire(), "/properties/name", "Möhlin–Basel")) == "nothing");
}

TEST_CASE("obstacle features: what is stored is read, also where a request would be refused") {
  const nlohmann::json stored = ObstacleFeature(ParseObstacle(Square("no_fly"), ""));
  nlohmann::json crossed = With(stored, "/properties/name", "a\nb");
  std::swap(crossed["geometry"]["coordinates"][0][1], crossed["geometry"]["coordinates"][0][2]);
  CHECK(FaultOf(crossed) != "nothing");
  CHECK(ObstacleFeature(ParseStoredObstacle(crossed)) == crossed);
}

TEST_CASE("obstacle features: a line of too many positions is refused with the limit") {
  nlohmann::json wire = Wire();
  nlohmann::json& line = wire["geometry"]["coordinates"];
  while (line.size() <= kLimits.obstacles.max_num_points) line.push_back(line.back());
  try {
    ParseObstacle(wire, "");
    FAIL("it was read");
  } catch (const ApiError& error) {
    CHECK(error.limit == kLimits.obstacles.max_num_points);
    CHECK(error.observed == kLimits.obstacles.max_num_points + 1);
  }
}

TEST_CASE("obstacle features: a fault of a collection names the feature") {
  nlohmann::json second = Wire();
  second["properties"]["kind"] = "cable";
  const nlohmann::json collection{{"type", "FeatureCollection"}, {"features", {Wire(), second}}};
  CHECK(ErrorOf([&] { ParseObstacles(collection.dump()); }) ==
        "422 InvalidValue /features/1/properties/kind");
  nlohmann::json one_place = Wire();
  one_place["geometry"]["coordinates"][1] = one_place["geometry"]["coordinates"][0];
  const nlohmann::json wires{{"type", "FeatureCollection"}, {"features", {Wire(), one_place}}};
  CHECK(ErrorOf([&] { ParseObstacles(wires.dump()); }) ==
        "422 InvalidValue /features/1/geometry/coordinates");
  CHECK(ErrorOf([&] { ParseObstacles(Wire().dump()); }) == "422 InvalidValue /type");
  CHECK(ErrorOf([&] { ParseObstacles("{"); }) == "400 InvalidJson");
}

TEST_CASE("OpenStreetMap: lines, towers and masts are wires and masts, with told heights") {
  const auto feature =
      [](const char* id, const nlohmann::json& tags, const nlohmann::json& geometry) {
        return nlohmann::json{
            {"type", "Feature"}, {"id", id}, {"properties", tags}, {"geometry", geometry}};
      };
  const nlohmann::json line{{"type", "LineString"}, {"coordinates", {{8.0, 47.0}, {8.01, 47.0}}}};
  const nlohmann::json point{{"type", "Point"}, {"coordinates", {8.005, 47.001}}};
  nlohmann::json collection{
      {"type", "FeatureCollection"},
      {"features",
       {feature("way/1", {{"power", "line"}, {"voltage", "380000;110000"}}, line),
        feature("way/2", {{"power", "minor_line"}, {"height", "49 ft"}}, line),
        feature("way/3", {{"power", "cable"}, {"location", "underground"}}, line),
        feature("node/4", {{"power", "tower"}, {"height", "45.5"}}, point),
        feature("node/5", {{"man_made", "mast"}, {"height", "high"}}, point),
        feature("way/6", {{"highway", "track"}}, line)}}};
  const ImportedObstacles imported = ParseObstacles(collection.dump());
  REQUIRE(imported.obstacles.size() == 5);
  const auto at = [&imported](size_t i) { return imported.obstacles[i]; };
  CHECK(at(0).id == "osm-way-1");
  CHECK(at(0).kind == ObstacleKind::kWire);
  CHECK(at(0).height_m == 80.0);
  CHECK(at(0).position_sd_m == 10.0);
  CHECK(*at(1).height_m == doctest::Approx(14.9352));
  CHECK(at(2).kind == ObstacleKind::kMast);
  CHECK(at(2).height_m == 45.5);
  CHECK(at(3).height_m == 150.0);
  CHECK(at(4).kind == ObstacleKind::kWiresKnown);
  CHECK(at(4).points.size() == 4);
  std::string warnings;
  for (const std::string& warning : imported.warnings) warnings += warning + "\n";
  CHECK(warnings.find("1 of power=line: 80 m above ground is assumed") != std::string::npos);
  CHECK(warnings.find("2 features are no wire or mast") != std::string::npos);
  CHECK(warnings.find("no bbox") != std::string::npos);
  collection["bbox"] = {7.5, 46.5, 8.5, 47.5};
  const GivenObstacle known = ParseObstacles(collection.dump()).obstacles.at(4);
  CHECK(known.points.front().longitude_deg == 7.5);
  CHECK(known.points.front().latitude_deg == 46.5);
  CHECK(ObstacleFeature(ParseStoredObstacle(ObstacleFeature(known))) == ObstacleFeature(known));
}

}  // namespace
}  // namespace freelsd
