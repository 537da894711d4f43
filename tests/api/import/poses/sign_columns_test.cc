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

}  // namespace
}  // namespace freelsd
