#include "api/import/poses/poses.h"
#include "tests/api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr double kMaxErrorDeg = 1e-8;

PoseFile ReadGeo(const std::string& text) { return PosesFromFiles({{"geo.txt", text}}, {}); }
std::string ErrorOfGeo(const std::string& text) { return ErrorOfFiles({{"geo.txt", text}}); }

void CheckGeo(const std::string& text, double latitude_deg, double longitude_deg) {
  const GeoPoint place = MetaOf(ReadGeo(text), "a.jpg").position.value();
  CHECK(std::abs(place.latitude_deg - latitude_deg) < kMaxErrorDeg);
  CHECK(std::abs(place.longitude_deg - longitude_deg) < kMaxErrorDeg);
  CHECK(place.altitude_m == 100.5);
}

TEST_CASE("geo.txt: x is the longitude and comes first, it is named as what it is") {
  const std::string text = "EPSG:4326\r\n# remark\r\n\r\na.jpg -91.5 46.25 100.5\r\n";
  CheckGeo(text, 46.25, -91.5);
  const PoseFile file = ReadGeo(text);
  REQUIRE(file.formats.size() == 1);
  CHECK(file.formats[0].name == "odm-geo");
  CHECK(file.warnings.empty());
}

TEST_CASE("geo.txt: UTM in all its spellings, north and south") {
  // On the central meridian: the arc to 45 deg is 4984944.378 m, times 0.9996.
  CheckGeo("EPSG:32632\na.jpg 500000 4982950.400217 100.5", 45.0, 9.0);
  CheckGeo("WGS84 UTM 32N\na.jpg 500000 4982950.400217 100.5", 45.0, 9.0);
  CheckGeo("+proj=utm +zone=32 +datum=WGS84 +units=m +no_defs\na.jpg 500000 4982950.400217 100.5",
           45.0,
           9.0);
  CheckGeo("EPSG:32732\na.jpg 500000 5017049.599783 100.5", -45.0, 9.0);
  CheckGeo("+proj=utm +zone=32 +south +ellps=WGS84\na.jpg 500000 5017049.599783 100.5", -45.0, 9.0);
}

TEST_CASE("geo.txt: yaw turns the image's top from north to east, pitch 0 looks down") {
  const PoseFile file = ReadGeo("EPSG:4326\na.jpg 8 47 500 90 0 0 0.5 1\nb.jpg 8 47 500 0 10 0\n");
  const FrameMeta& meta = MetaOf(file, "a.jpg");
  CheckAxis(meta, {0, -1, 0}, {0, 1, 0});
  CheckAxis(meta, {0, 0, 1}, {0, 0, 1});
  CHECK(meta.position_sd_m == 0.5);
  CHECK(meta.attitude_sd_deg == 5.0);
  // 10 deg up: it looks forward by sin(10 deg).
  CheckAxis(MetaOf(file, "b.jpg"), {0, 0, 1}, {0.1736481777, 0, 0.9848077530});
  CHECK(Warns(file, "yaw, pitch, roll"));
}

TEST_CASE("geo.txt: angles of zero are none, omega phi kappa are not taken for yaw pitch roll") {
  CHECK_FALSE(MetaOf(ReadGeo("EPSG:4326\na.jpg 8 47 500 0 0 0\n"), "a.jpg").ned_from_camera);
  const PoseFile file = ReadGeo("EPSG:4326\na.jpg 8 47 500 1 2 -120\nb.jpg 8 47 500 1 0 10\n");
  CHECK_FALSE(MetaOf(file, "b.jpg").ned_from_camera);
  CHECK(Warns(file, "CameraAnglesIgnored"));
}

TEST_CASE("geo.txt: kappa of a flight in one direction is not read as roll") {
  const auto attitude = [](const std::string& angles) {
    const PoseFile file = ReadGeo("EPSG:4326\na.jpg 8 47 500 " + angles + "\nb.jpg 8 47 500 " +
                                  angles + "\nc.jpg 8 47 500 " + angles + "\n");
    CHECK(Warns(file, "angles"));
    return file.poses[0].second.ned_from_camera.has_value();
  };
  for (const char* const opk : {"0.5 -1.2 38", "2 3 -44", "-0.3 0.1 16", "1 1 10", "0 0 38"}) {
    CAPTURE(std::string(opk));
    CHECK_FALSE(attitude(opk));
  }
  for (const char* const ypr : {"38 -1.2 0.5", "-170 3 2", "90 10 -12"}) {
    CAPTURE(std::string(ypr));
    CHECK(attitude(ypr));
  }
}

TEST_CASE("gcp_list.txt: ground control points are no poses, and are told of by name") {
  const SideFile geo{"geo.txt", "EPSG:4326\na.jpg 8 47 500\n"};
  const std::string utm = "WGS84 UTM 32N\n500000 4982950.4 100.5 1044.5 517.25 a.jpg gcp1\n";
  const std::string degrees =
      "\xEF\xBB\xBF"
      "EPSG:4326\n8 47 400 10 20 a.jpg\n";
  for (const std::string& text : {utm, degrees}) {
    for (const char* const name : {"flight/gcp_list.txt", "points.txt"}) {
      const PoseFile file = PosesFromFiles({{name, text}, geo}, {});
      CHECK(file.poses.size() == 1);
      CHECK(file.formats[0].name == "odm-gcp");
      CHECK(file.formats[1].name == "odm-geo");
      CHECK(Warns(file, std::string(name) + ": ground control points are not used"));
    }
  }
  // Of an image whose name is a number.
  CHECK(ReadGeo("EPSG:4326\n0017 8 47 500 90 0 0\n").poses.size() == 1);
}

TEST_CASE("side files: a text that is nothing known is told from one that may be poses") {
  CHECK(IsAnyText({"notes.txt", "# A flight\n\nwindy, cold\n"}));
  CHECK(IsAnyText({"README.TXT", ""}));
  CHECK_FALSE(IsAnyText({"poses.txt", "# x\nimage,lat\n"}));
  CHECK_FALSE(IsAnyText({"poses.csv", "windy, cold\n"}));
  CHECK_FALSE(IsAnyText({"geo.txt", "EPSG:4326\n"}));
  CHECK_FALSE(IsAnyText({"cameras.txt", "# Camera list\n"}));
  CHECK(ErrorOfFiles({{"notes.txt", "windy, cold\n"}}) == "422 InvalidPoses /poses/1/image");
}

TEST_CASE("geo.txt: what cannot be used is refused at its line") {
  CHECK(ErrorOfGeo("EPSG:2056\na.jpg 8 47 5") == "422 InvalidPoses /poses/2/x");
  CHECK(ErrorOfGeo("EPSG:4978\na.jpg 8 47 5") == "422 InvalidPoses /poses");
  CHECK(ErrorOfGeo("WGS84 UTM 61N\na.jpg 8 47 5") == "422 InvalidPoses /poses");
  CHECK(ErrorOfGeo("EPSG:4326\na.jpg 8 47") == "422 InvalidPoses /poses/2/altitude_m");
  CHECK(ErrorOfGeo("EPSG:4326\n\na.jpg 8 nan 5") == "422 InvalidPoses /poses/3/y");
  CHECK(ErrorOfGeo("EPSG:4326\na.jpg 97 98 5") == "422 InvalidPoses /poses/2/x");
  CHECK(ErrorOfGeo("EPSG:32632\na.jpg 8e9 47 5") == "422 InvalidPoses /poses/2/x");
  // Only the other way round it is on the earth.
  const PoseFile swapped = ReadGeo("EPSG:4326\na.jpg 47 91 5");
  CHECK(MetaOf(swapped, "a.jpg").position->longitude_deg == 91.0);
  CHECK(Warns(swapped, "value 3 is read as the longitude"));
}

}  // namespace
}  // namespace freelsd
