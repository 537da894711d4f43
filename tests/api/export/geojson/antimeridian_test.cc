// GeoJSON across the antimeridian, as RFC 7946 wants it.
#include <cmath>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/export/geojson/geojson.h"
#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

Json Line(const Json& positions) { return {{"type", "LineString"}, {"coordinates", positions}}; }

Json Area(const Json& rings) { return {{"type", "Polygon"}, {"coordinates", rings}}; }

// The longest leg along a parallel, degrees.
double LongestLegDeg(const Json& coordinates) {
  double longest_deg = 0.0;
  for (size_t i = 0; i < coordinates.size(); ++i) {
    if (coordinates[i][0].is_array()) {
      longest_deg = std::max(longest_deg, LongestLegDeg(coordinates[i]));
    } else if (i > 0) {
      const double leg_deg = coordinates[i][0].get<double>() - coordinates[i - 1][0].get<double>();
      longest_deg = std::max(longest_deg, std::abs(leg_deg));
    }
  }
  return longest_deg;
}

// Of all rings of all polygons, square degrees; holes count negative if they turn right.
double SignedAreaOf(const Json& geometry) {
  double area = 0.0;
  const Json polygons = geometry["type"] == "Polygon" ? Json::array({geometry["coordinates"]})
                                                      : geometry["coordinates"];
  for (const Json& rings : polygons) {
    for (size_t i = 0; i < rings.size(); ++i) {
      Polygon ring;
      for (const Json& place : rings[i]) ring.emplace_back(place[0], place[1]);
      REQUIRE(rings[i].front() == rings[i].back());
      const double signed_area = SignedArea(ring);
      CHECK((signed_area > 0.0) == (i == 0));
      area += signed_area;
    }
  }
  return area;
}

TEST_CASE("antimeridian: a line across is cut there, with the height and time of the cut") {
  const Json cut = CutAtAntimeridian(Line({{179.5, 10.0, 100.0, 0.0}, {-179.5, 12.0, 300.0, 8.0}}));
  CHECK(cut["type"] == "MultiLineString");
  CHECK(cut["coordinates"] == Json({{{179.5, 10.0, 100.0, 0.0}, {180.0, 11.0, 200.0, 4.0}},
                                    {{-180.0, 11.0, 200.0, 4.0}, {-179.5, 12.0, 300.0, 8.0}}}));
}

TEST_CASE("antimeridian: a line there and back has three parts") {
  const Json cut = CutAtAntimeridian(Line({{-179.0, 1.0}, {179.0, 2.0}, {-179.0, 3.0}}));
  REQUIRE(cut["coordinates"].size() == 3);
  CHECK(LongestLegDeg(cut["coordinates"]) <= 2.0);
}

TEST_CASE("antimeridian: what does not cross it stays as it is") {
  for (const Json& geometry : {Line({{8.0, 47.0, 400.0}, {8.1, 47.0, 410.0}}),
                               Line({{179.0, 0.0}, {180.0, 0.0}}),
                               Area({{{8, 47}, {8.1, 47}, {8.1, 47.1}, {8, 47}}}),
                               Json{{"type", "Point"}, {"coordinates", {180.0, 1.0}}},
                               Json(nullptr)}) {
    CHECK(CutAtAntimeridian(geometry) == geometry);
  }
}

TEST_CASE("antimeridian: a line that only touches it is one line") {
  const Json touching = CutAtAntimeridian(Line({{180.0, 0.0}, {-179.9, 0.1}, {-179.8, 0.2}}));
  CHECK(touching["type"] == "LineString");
  CHECK(touching["coordinates"][0] == Json({-180.0, 0.0}));
}

TEST_CASE("antimeridian: longitudes that go on beyond 180 degrees begin anew") {
  const Json beyond = CutAtAntimeridian(Line({{180.25, 0.0}, {180.5, 1.0}}));
  CHECK(beyond == Line({{-179.75, 0.0}, {-179.5, 1.0}}));
  CHECK(CutAtAntimeridian(Line({{179.5, 0.0}, {180.5, 1.0}}))["coordinates"] ==
        Json({{{179.5, 0.0}, {180.0, 0.5}}, {{-180.0, 0.5}, {-179.5, 1.0}}}));
}

TEST_CASE("antimeridian: a polygon across is two, with the same area and the same turn") {
  // From the west, and from the east.
  for (const Json& ring : {Json{{179, 0}, {-178, 0}, {-178, 2}, {179, 2}, {179, 0}},
                           Json{{-178, 0}, {-178, 2}, {179, 2}, {179, 0}, {-178, 0}}}) {
    const Json cut = CutAtAntimeridian(Area(Json::array({ring})));
    CHECK(cut["type"] == "MultiPolygon");
    REQUIRE(cut["coordinates"].size() == 2);
    CHECK(LongestLegDeg(cut["coordinates"]) <= 2.0);
    CHECK(SignedAreaOf(cut) == doctest::Approx(6.0));
  }
}

TEST_CASE("antimeridian: holes stay in their part, and one on the cut opens both parts") {
  const Json outer{{178, 0}, {-178, 0}, {-178, 4}, {178, 4}, {178, 0}};
  const Json west{{178.5, 1}, {178.5, 2}, {179.5, 2}, {179.5, 1}, {178.5, 1}};
  const Json on_cut{{179.5, 2.5}, {179.5, 3.5}, {-179.5, 3.5}, {-179.5, 2.5}, {179.5, 2.5}};
  const Json cut = CutAtAntimeridian(Area({outer, west, on_cut}));
  REQUIRE(cut["coordinates"].size() == 2);
  CHECK(cut["coordinates"][0].size() == 2);
  CHECK(cut["coordinates"][1].size() == 1);
  CHECK(LongestLegDeg(cut["coordinates"]) <= 4.0);
  CHECK(SignedAreaOf(cut) == doctest::Approx(16.0 - 1.0 - 1.0));
}

TEST_CASE("antimeridian: a comb whose teeth reach over it falls into as many parts") {
  const Json comb = Json::array({Json{{179, 0},
                                      {-179, 0},
                                      {-179, 1},
                                      {179.5, 1},
                                      {179.5, 2},
                                      {-179, 2},
                                      {-179, 3},
                                      {179, 3},
                                      {179, 0}}});
  const Json cut = CutAtAntimeridian(Area(comb));
  CHECK(cut["coordinates"].size() == 3);
  CHECK(SignedAreaOf(cut) == doctest::Approx(6.0 - 1.5));
}

TEST_CASE("antimeridian: a collection is cut feature by feature") {
  const Json feature{{"type", "Feature"},
                     {"properties", {{"kind", "reach"}}},
                     {"geometry", Line({{179.5, 0.0}, {-179.5, 0.0}})}};
  const Json cut = CutAtAntimeridian(
      {{"type", "FeatureCollection"}, {"features", Json::array({feature})}, {"next", "x"}});
  CHECK(cut["features"][0]["geometry"]["type"] == "MultiLineString");
  CHECK(cut["features"][0]["properties"]["kind"] == "reach");
  CHECK(cut["next"] == "x");
}

TEST_CASE("antimeridian: a ring around a pole stays as it is") {
  const Json ring{{-120, 80}, {0, 80}, {120, 80}, {-120, 80}};
  const Json polar = Area(Json::array({ring}));
  CHECK(CutAtAntimeridian(polar) == polar);
}

}  // namespace
}  // namespace freelsd
