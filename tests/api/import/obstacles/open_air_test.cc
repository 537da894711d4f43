#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include "api/import/obstacles/air_values.h"
#include "api/import/obstacles/obstacles.h"
#include "tests/api/errors.h"

namespace freelsd {
namespace {

constexpr double kMetresPerNauticalMile = 1852.0;

constexpr char kSquare[] =
    "* Airspaces of a test\r\n"
    "AC R\r\n"
    "AN LS-R 12/A\r\n"
    "AL GND\r\n"
    "AH 4500 FT MSL\r\n"
    "DP 47:00:00 N 008:00:00 E\r\n"
    "DP 47:00:00 N 008:06:00 E\r\n"
    "DP 47:06:00 N 008:06:00 E * the last\r\n";

std::string Circle(const std::string& more) {
  return "AC D\nAN CTR\nAL SFC\nAH FL 95\nV X=47:30.0 N 7:30.0 E\n" + more;
}

double DistanceM(const GeoPoint& center, const GeoPoint& place) {
  return LocalFrame(center).WorldFromGeo({place.latitude_deg, place.longitude_deg, 0.0}).norm();
}

std::string FaultOf(const std::string& text) {
  return ErrorOf([&] { ParseOpenAir(text); });
}

TEST_CASE("open air: a polygon is a no_fly with floor, ceiling and name") {
  REQUIRE(IsOpenAir(kSquare));
  const ImportedObstacles imported = ParseOpenAir(kSquare);
  REQUIRE(imported.obstacles.size() == 1);
  const GivenObstacle& airspace = imported.obstacles[0];
  CHECK(airspace.kind == ObstacleKind::kNoFly);
  CHECK(airspace.id == "airspace-LS-R_12_A");
  CHECK(airspace.name == "LS-R 12/A");
  CHECK(airspace.altitude_datum == "amsl");
  CHECK_FALSE(airspace.floor_m);
  CHECK(*airspace.ceiling_m == doctest::Approx(4500 * 0.3048));
  REQUIRE(airspace.points.size() == 3);
  CHECK(airspace.points[2].latitude_deg == doctest::Approx(47.1));
  CHECK(airspace.points[2].longitude_deg == doctest::Approx(8.1));
  CHECK(imported.warnings.empty());
}

TEST_CASE("open air: the polygon of a circle encloses it, by less than a share of a hundred") {
  const GivenObstacle circle = ParseOpenAir(Circle("DC 5\n")).obstacles.at(0);
  CHECK(*circle.ceiling_m == doctest::Approx(9500 * 0.3048));
  CHECK(circle.points.size() >= 72);
  for (size_t i = 0; i < circle.points.size(); ++i) {
    const GeoPoint center{47.5, 7.5, 0.0};
    const GeoPoint& next = circle.points[(i + 1) % circle.points.size()];
    const GeoPoint middle{0.5 * (circle.points[i].latitude_deg + next.latitude_deg),
                          0.5 * (circle.points[i].longitude_deg + next.longitude_deg),
                          0.0};
    CHECK(DistanceM(center, middle) > 0.9999 * 5 * kMetresPerNauticalMile);
    CHECK(DistanceM(center, circle.points[i]) < 1.01 * 5 * kMetresPerNauticalMile);
  }
}

TEST_CASE("open air: arcs turn as V D says, by angles and between places") {
  // A quarter to the east of north, and three quarters the other way round.
  const auto quarter = ParseOpenAir(Circle("DA 5,0,90\nDP 47:30:00 N 7:30:00 E\n")).obstacles[0];
  const auto rest =
      ParseOpenAir(Circle("V D=-\nDA 5,0,90\nDP 47:30:00 N 7:30:00 E\n")).obstacles[0];
  CHECK(quarter.points.size() == 20);
  CHECK(rest.points.size() == 56);
  for (const GeoPoint& point : quarter.points) CHECK(point.longitude_deg > 7.5 - 1e-6);
  const auto between = ParseOpenAir(
      Circle("V D=+\nDB 47:35:00 N 7:30:00 E, 47:30:00 N 7:37:24 E\nDP 47:30:00 N 7:30:00 E\n"));
  CHECK(between.obstacles[0].points.size() == 20);
}

TEST_CASE("open air: heights above ground count as the worst, with a warning") {
  const ImportedObstacles imported =
      ParseOpenAir("AC Q\nAN low\nAL 500 FT AGL\nAH 1000 M AGL\nV X=47:30 N 7:30 E\nDC 1\n");
  REQUIRE(imported.obstacles.size() == 1);
  CHECK_FALSE(imported.obstacles[0].floor_m);
  CHECK_FALSE(imported.obstacles[0].ceiling_m);
  CHECK(imported.warnings.size() == 2);
}

TEST_CASE("open air: two airspaces of one name have two ids") {
  const ImportedObstacles imported = ParseOpenAir(std::string(kSquare) + kSquare);
  REQUIRE(imported.obstacles.size() == 2);
  CHECK(imported.obstacles[1].id == "airspace-LS-R_12_A-2");
}

TEST_CASE("open air: a fault names its line") {
  const std::string invalid = "422 InvalidAirspace line ";
  CHECK(FaultOf("") == invalid + "1");
  CHECK(FaultOf("* nothing\n") == invalid + "1");
  CHECK(FaultOf("AN before\n") == invalid + "1");
  CHECK(FaultOf("AC D\nAL low\n") == invalid + "2");
  CHECK(FaultOf("AC D\nAH GND\nDP 47:00 N\n") == invalid + "3");
  CHECK(FaultOf("AC D\nDP 97:00 N 8:00 E\n") == invalid + "2");
  CHECK(FaultOf("AC D\nDC 5\n") == invalid + "2");
  CHECK(FaultOf(Circle("DC -5\n")) == invalid + "6");
  CHECK(FaultOf(Circle("DA 5,0\n")) == invalid + "6");
  CHECK(FaultOf(Circle("DA 5,0,1e9\n")) == invalid + "6");
  CHECK(FaultOf(Circle("DB 47:35 N 7:30 E\n")) == invalid + "6");
  CHECK(FaultOf(Circle("V D=left\n")) == invalid + "6");
  CHECK(FaultOf(Circle("DY 47:00 N 8:00 E\n")) == invalid + "6");
  // Of the whole airspace: where it begins.
  CHECK(FaultOf("AC D\nAH GND\nV X=47:30 N 7:30 E\nDC 5\n") == invalid + "1");
  CHECK(FaultOf("AC D\nAL GND\nV X=47:30 N 7:30 E\nDC 5\n") == invalid + "1");
  CHECK(FaultOf("AC D\nAL FL 100\nAH FL 50\nV X=47:30 N 7:30 E\nDC 5\n") == invalid + "1");
  CHECK(FaultOf("AC D\nAL GND\nAH FL 50\nDP 47:30 N 7:30 E\n") == invalid + "1");
  const std::string line = "DP 47:00 N 8:00 E\nDP 47:00 N 8:06 E\n";
  CHECK(FaultOf("AC D\nAL GND\nAH FL 50\n" + line + "DP 47:00 N 8:00 E\n") == invalid + "1");
  CHECK(FaultOf("AC D\nAL GND\nAH FL 50\n" + line + "DP 47:00 N 8:12 E\n") == invalid + "1");
  CHECK(FaultOf("AC D\nAN x\nAL GND\nAH FL 1000\n") == invalid + "4");
  CHECK(FaultOf("AC D\nAL FL 1000\n") == invalid + "2");
  CHECK(FaultOf(std::string("AC D\nAN a\0b\n", 12)) == invalid + "2");
  CHECK(FaultOf("<airspace/>\n") == invalid + "1");
}

TEST_CASE("open air: a border that crosses itself counts, with a warning") {
  const std::string head = "AC D\nAN zone\nAL GND\nAH FL 50\n";
  const ImportedObstacles imported =
      ParseOpenAir(head +
                   "DP 47:00 N 8:00 E\nDP 47:06 N 8:06 E\nDP 47:00 N 8:06 E\n"
                   "DP 47:06 N 8:00 E\n");
  CHECK(imported.obstacles.at(0).points.size() == 4);
  CHECK(imported.warnings == std::vector<std::string>{"airspace-zone: its border crosses itself"});
  CHECK(ParseOpenAir(Circle("DC 5\n")).warnings.empty());
}

TEST_CASE("open air: coordinates and altitudes as files write them") {
  CHECK(CoordinatesFromText("47:30:36S 007:31:12 w")->latitude_deg == doctest::Approx(-47.51));
  CHECK(CoordinatesFromText("47:30:36S 007:31:12 w")->longitude_deg == doctest::Approx(-7.52));
  CHECK(CoordinatesFromText("47:30.6 N, 7:31.2 E")->latitude_deg == doctest::Approx(47.51));
  CHECK(CoordinatesFromText("47.51N 7.52E")->longitude_deg == doctest::Approx(7.52));
  for (const char* const text : {"", "N E", "47:60 N 7 E", "47 N", "47 N 7 E x", "1:2:3:4 N 7 E"}) {
    CAPTURE(text);
    CHECK_FALSE(CoordinatesFromText(text));
  }
  CHECK(*AirAltitudeFromText("FL95")->altitude_m == doctest::Approx(2895.6));
  CHECK(*AirAltitudeFromText("1000 m MSL")->altitude_m == 1000.0);
  CHECK(*AirAltitudeFromText("1000ft")->altitude_m == doctest::Approx(304.8));
  CHECK(*AirAltitudeFromText("3000")->altitude_m == doctest::Approx(914.4));
  CHECK_FALSE(AirAltitudeFromText("UNLIMITED")->altitude_m);
  CHECK_FALSE(AirAltitudeFromText("0 AGL")->is_above_ground);
  CHECK(AirAltitudeFromText("1000 GND")->is_above_ground);
  CHECK_FALSE(AirAltitudeFromText("FL 999")->altitude_m);
  CHECK_FALSE(AirAltitudeFromText("99999 FT")->altitude_m);
  for (const char* const text : {"", "ask tower", "FL", "FL 1000", "1000 2000", "FT"}) {
    CAPTURE(text);
    CHECK_FALSE(AirAltitudeFromText(text));
  }
}

}  // namespace
}  // namespace freelsd
