// Tables whose numbers have no sign, and columns beside them that do, as exiftool writes them.
#include <doctest/doctest.h>

#include "api/import/poses/poses.h"
#include "tests/api/errors.h"

namespace freelsd {
namespace {

constexpr char kHeader[] =
    "SourceFile,GPSLatitudeRef,GPSLatitude,GPSLongitudeRef,GPSLongitude,GPSAltitudeRef,"
    "GPSAltitude\n";

GeoPoint Place(const std::string& cells) {
  return ParsePoses(kHeader + ("a.jpg," + cells + "\n")).poses.at(0).second.position.value();
}

std::string ErrorOfLine(const std::string& cells) {
  return ErrorOf([&cells] { Place(cells); });
}

TEST_CASE("poses: columns of hemispheres and of the altitude's sign are applied") {
  for (const char* const south_west : {"S,33.5,W,70.25,0,100",
                                       "s,33.5,w,70.25,,100",
                                       "South,33.5,West,70.25,Above Sea Level,100",
                                       "S,-33.5,W,-70.25,0,100",
                                       " S ,33.5, W ,70.25,2,100"}) {
    CAPTURE(std::string(south_west));
    const GeoPoint place = Place(south_west);
    CHECK(place.latitude_deg == -33.5);
    CHECK(place.longitude_deg == -70.25);
    CHECK(place.altitude_m == 100.0);
  }
  CHECK(Place("N,54.5,E,2.76,Below Sea Level,3").altitude_m == -3.0);
  CHECK(Place("N,54.5,E,2.76,1,3").altitude_m == -3.0);
  CHECK(Place("North,54.5,East,2.76,0,3").longitude_deg == 2.76);
}

TEST_CASE("poses: a hemisphere that is missing, unknown or contradicts its number is refused") {
  for (const char* const odd : {",33.5,W,70.25,0,100",
                                "S,33.5,,70.25,0,100",
                                "S,33.5,X,70.25,0,100",
                                "1,33.5,W,70.25,0,100",
                                "N,-33.5,W,70.25,0,100",
                                "S,33.5,W,70.25,unknown,100"}) {
    CAPTURE(std::string(odd));
    CHECK(ErrorOfLine(odd).starts_with("422 InvalidPoses /poses/2/gps"));
  }
  const auto with_header = [](const std::string& header, const std::string& cells) {
    return ParsePoses(header + "\n" + cells + "\n").poses.at(0).second.position->longitude_deg;
  };
  CHECK(with_header("image,lat,lat_ref,lon,lon_ref,alt", "a.jpg,54.5,N,2.76,W,345") == -2.76);
  CHECK(with_header("image,latitude,longitude,longitude_ref,altitude", "a.jpg,54.5,2.76,W,345") ==
        -2.76);
}

TEST_CASE("poses: columns N/S and E/W are hemispheres") {
  const PoseFile file = ParsePoses("image,lat,N/S,lon,E/W,alt\na.jpg,33.5,S,70.25,W,345\n");
  const GeoPoint place = file.poses.at(0).second.position.value();
  CHECK(place.latitude_deg == -33.5);
  CHECK(place.longitude_deg == -70.25);
}

TEST_CASE("poses: altitudes that are all 0 are placeholders") {
  const std::string table = "image,lat,lon,alt\na.jpg,47.5,8.5,0\nb.jpg,47.5,8.6,0.0\n";
  CHECK(ErrorOf([&] { ParsePoses(table); }) == "422 InvalidPoses /poses/1/altitude_m");
  FrameMeta tags;
  tags.position = GeoPoint{47.5, 8.5, 555.0};
  SideContext context;
  context.image_tags = {{"a.jpg", tags}, {"b.jpg", tags}};
  const PoseFile file = ParsePoses(table, context);
  REQUIRE(file.poses.size() == 2);
  CHECK(file.poses[0].second.position->altitude_m == 555.0);
  // One of them is a place at sea level.
  CHECK(ParsePoses("image,lat,lon,alt\na.jpg,47.5,8.5,0\nb.jpg,47.5,8.6,9\n").poses.size() == 2);
}

TEST_CASE("poses: the column of the images is known by its cells, whatever its name") {
  for (const char* const name : {"ID", "Point ID", "Nr"}) {
    CAPTURE(std::string(name));
    const PoseFile file = ParsePoses(
        std::string(name) + ",lat,lon,alt\nIMG_1.JPG,47.5,8.5,345\nIMG_2.JPG,47.5,8.6,345\n");
    REQUIRE(file.poses.size() == 2);
    CHECK(file.poses[0].first == "IMG_1.JPG");
  }
}

}  // namespace
}  // namespace freelsd
