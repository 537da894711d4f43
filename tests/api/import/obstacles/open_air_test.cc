#include <algorithm>
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include "api/import/number_text.h"
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

TEST_CASE("open air: heights above ground stay heights above ground") {
  const ImportedObstacles imported =
      ParseOpenAir("AC Q\nAN low\nAL 500 FT AGL\nAH 1000 M AGL\nV X=47:30 N 7:30 E\nDC 1\n");
  REQUIRE(imported.obstacles.size() == 1);
  CHECK_FALSE(imported.obstacles[0].floor_m);
  CHECK_FALSE(imported.obstacles[0].ceiling_m);
  CHECK(imported.obstacles[0].floor_above_ground_m == doctest::Approx(152.4));
  CHECK(imported.obstacles[0].ceiling_above_ground_m == 1000.0);
  CHECK(imported.warnings.empty());
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
  for (const char* const text : {"", "N E", "47:61 N 7 E", "47 N", "47 N 7 E x", "1:2:3:4 N 7 E"}) {
    CAPTURE(text);
    CHECK_FALSE(CoordinatesFromText(text));
  }
  using Kind = AirAltitude::Kind;
  CHECK(AirAltitudeFromText("FL95")->altitude_m == doctest::Approx(2895.6));
  CHECK(AirAltitudeFromText("1000 m MSL")->altitude_m == 1000.0);
  CHECK(AirAltitudeFromText("1000ft")->altitude_m == doctest::Approx(304.8));
  CHECK(AirAltitudeFromText("3000")->altitude_m == doctest::Approx(914.4));
  CHECK(AirAltitudeFromText("UNLIMITED")->kind == Kind::kUnlimited);
  CHECK(AirAltitudeFromText("0 AGL")->kind == Kind::kGround);
  CHECK(AirAltitudeFromText("1000 GND")->kind == Kind::kAboveGround);
  CHECK(AirAltitudeFromText("FL 999")->kind == Kind::kUnlimited);
  CHECK(AirAltitudeFromText("99999 FT")->kind == Kind::kUnlimited);
  for (const char* const text : {"", "ask tower", "FL", "FL 1000", "1000 2000", "FT"}) {
    CAPTURE(text);
    CHECK_FALSE(AirAltitudeFromText(text));
  }
}

constexpr char kBox[] =
    "DP 47:30:00 N 008:20:00 E\nDP 47:30:00 N 008:40:00 E\nDP 47:20:00 N 008:40:00 E\n"
    "DP 47:20:00 N 008:20:00 E\n";

// The names of what is imported, and all warnings; or the fault.
std::string NamesOf(const std::string& text) {
  try {
    const ImportedObstacles imported = ParseOpenAir(text);
    std::string names;
    for (const GivenObstacle& each : imported.obstacles) names += each.name + ".";
    for (const std::string& warning : imported.warnings) names += " " + warning + ".";
    return names;
  } catch (const ApiError& error) {
    return error.what();
  }
}

TEST_CASE("open air: one bad airspace is left out and named, the others stand") {
  const std::string good = std::string("AC D\nAN GOOD\nAL GND\nAH 4500 ft MSL\n") + kBox;
  const auto beside = [&good](const std::string& bad) { return NamesOf(bad + good); };
  CHECK(beside(std::string("AC D\nAN BAD\nAL GND\n") + kBox) ==
        "GOOD. BAD is left out: line 1: AH (the ceiling) is missing.");
  for (const char* const heights : {"AL FL65\nAH FL65\n",
                                    "AL UNL\nAH FL65\n",
                                    "AL GND\nAH GND\n",
                                    "AL 2000 ft AGL\nAH 1000 ft AGL\n",
                                    "AL ask\nAH FL65\n"}) {
    CAPTURE(heights);
    CHECK(beside(std::string("AC W\nAN BOX\n") + heights + kBox)
              .starts_with("GOOD. BOX is left out: line "));
  }
  CHECK(beside("AC W\nAN WAY\nAL GND\nAH FL65\nDY 47:30:00 N 008:20:00 E\n")
            .starts_with("GOOD. WAY is left out: line 5"));
  CHECK(beside(std::string("AC W\nAN TYPO\nAL GND\nAH FL65\nDP 47:3x N 8:20 E\n") + kBox)
            .starts_with("GOOD. TYPO is left out: line 5"));
  CHECK(beside("garbage before\n") == "GOOD. line 1: the record garbage is not read.");
}

TEST_CASE("open air: records of times, frequencies and later versions are passed over") {
  const auto with = [](const std::string& record) {
    return NamesOf("AC D\nAN CTR\n" + record + "\nAL GND\nAH 4500 ft MSL\n" + kBox);
  };
  for (const char* const record : {"AR 123.450", "AW MON.08:00L-23:59L", "AY TMA", "AF 118.1"}) {
    CHECK(with(record) == "CTR.");
  }
  CHECK(with("ZZ 1") == "CTR. line 3: the record ZZ is not read.");
}

TEST_CASE("open air: seconds of 60, letters before, tabs, UTF-16") {
  for (const char* const first : {"DP 47:29:60 N 008:20:00 E\n",
                                  "DP N47:29:30 E008:20:00\n",
                                  "DP\t47:29:30N\t008:20:00E\n",
                                  "DP 47 29 30 N 008 20 00 E\n"}) {
    CAPTURE(first);
    CHECK(NamesOf(std::string("AC D\nAN CTR\nAL GND\nAH 4500 ft MSL\n") + first +
                  "DP 47:30:00 N 008:40:00 E\nDP 47:20:00 N 008:40:00 E\n") == "CTR.");
  }
  std::string wide = "\xFF\xFE";
  for (const char c : std::string(kSquare)) wide += {c, '\0'};
  CHECK(IsOpenAir(wide));
  CHECK(NamesOf(wide) == "LS-R 12/A.");
}

TEST_CASE("open air: commands in small letters, lines that end with CR alone") {
  std::string small = "ac d\nan CTR\nal gnd\nah 4500 ft msl\nv d=+\n" + InLowerCase(kBox);
  CHECK(IsOpenAir(small));
  CHECK(NamesOf(small) == "CTR.");
  std::replace(small.begin(), small.end(), '\n', '\r');
  CHECK(IsOpenAir(small));
  CHECK(NamesOf(small) == "CTR.");
}

TEST_CASE("open air: lines of terrain are no border of the airspace before") {
  for (const char* const record : {"TO RIVER\n", "TC LAKE\nSP 0,1,0,0,255\n"}) {
    const ImportedObstacles imported = ParseOpenAir(kSquare + std::string(record) + kBox);
    REQUIRE(imported.obstacles.size() == 1);
    CHECK(imported.obstacles[0].points.size() == 3);
    CHECK(imported.warnings.empty());
  }
}

TEST_CASE("open air: an airspace across the antimeridian becomes two") {
  const ImportedObstacles imported =
      ParseOpenAir("AC C\nAN FJ\nAL GND\nAH FL95\nV X=17:00:00 S 179:55:00 E\nDC 30\n");
  REQUIRE(imported.obstacles.size() == 2);
  CHECK(imported.obstacles[0].id == "airspace-FJ");
  CHECK(imported.obstacles[1].id == "airspace-FJ-2");
  for (size_t i = 0; i < 2; ++i) {
    for (const GeoPoint& point : imported.obstacles[i].points) {
      CHECK((i == 0 ? 1.0 : -1.0) * point.longitude_deg > 179.3);
    }
  }
  CHECK(ParseOpenAir("AC C\nAN W\nAL GND\nAH FL95\nDP 10:00 S 179:00 W\nDP 10:00 S 179:00 E\n"
                     "DP 11:00 S 179:30 W\n")
            .obstacles.size() == 2);
}

}  // namespace
}  // namespace freelsd
