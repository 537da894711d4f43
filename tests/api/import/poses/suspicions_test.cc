// What can be read and is wrong all the same is warned of by name; what is right is not.
#include <cmath>

#include "tests/api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr int kNumImages = 8;
constexpr char kHeader[] = "image,lat,lon,alt,timestamp_us\n";
constexpr double kStepDeg = 0.0003;  // 33 m

std::string IdOf(int i) { return "i" + std::to_string(i); }

GeoPoint PlaceOf(int i) { return {47.0 + kStepDeg * i, 8.0 + 0.0001 * (i % 3), 500.0}; }

std::string Line(int image, int pose, bool is_swapped = false) {
  const GeoPoint place = PlaceOf(pose);
  const std::string latitude = std::to_string(place.latitude_deg);
  const std::string longitude = std::to_string(place.longitude_deg);
  return IdOf(image) + "," +
         (is_swapped ? longitude + "," + latitude : latitude + "," + longitude) + ",500," +
         std::to_string(1000000 * (pose + 10)) + "\n";
}

std::string Poses(int shift, bool is_swapped = false) {
  std::string text = kHeader;
  for (int i = 0; i < kNumImages; ++i) text += Line(i, i + shift, is_swapped);
  return text;
}

enum class Tag { kPlace, kTime };
SideContext Tagged(Tag tag) {
  SideContext context;
  for (int i = 0; i < kNumImages; ++i) {
    FrameMeta meta;
    if (tag == Tag::kPlace) meta.position = PlaceOf(i);
    if (tag == Tag::kTime) meta.timestamp_us = 1000000 * (i + 10);
    context.image_tags.emplace_back(IdOf(i), meta);
  }
  return context;
}

bool IsWarned(const std::string& text, const SideContext& context, const std::string& name) {
  return Warns(PosesFromFiles({{"poses.csv", text}}, context), name);
}

TEST_CASE("suspicions: latitude for longitude, by geotags or by the flight's origin") {
  SideContext origin;
  origin.origin = GeoPoint{47.0, 8.0, 400.0};
  for (const SideContext& context : {Tagged(Tag::kPlace), origin}) {
    CHECK(IsWarned(Poses(0, true), context, "SwappedLatitudeLongitude"));
    CHECK_FALSE(IsWarned(Poses(0), context, "SwappedLatitudeLongitude"));
  }
  // Most of the poses are of images that are not here.
  SideContext some = Tagged(Tag::kPlace);
  some.image_tags.resize(kNumImages / 4);
  CHECK(IsWarned(Poses(0, true), some, "SwappedLatitudeLongitude"));
  CHECK_FALSE(IsWarned(Poses(0), some, "SwappedLatitudeLongitude"));
}

// Two lines north and two back south, 100 m aside, in steps of 33 m and more than the wind's 20 deg
// of crab; "latitude, longitude" where they are not swapped.
std::string Lines(bool is_swapped, double turned_deg, bool is_backwards = false) {
  std::string text = "image,lat,lon,alt,yaw_deg,pitch_deg,roll_deg\n";
  for (int i = 0; i < 4 * kNumImages; ++i) {
    const int line = i / kNumImages, step = i % kNumImages;
    const bool is_north = line % 2 == 0;
    const double latitude_deg = 47.0 + kStepDeg * (is_north ? step : kNumImages - 1 - step);
    const double longitude_deg = 8.0 + 0.0013 * line;
    const double yaw_deg = (is_north != is_backwards ? 0.0 : 180.0) + 20.0 + turned_deg;
    const std::string latitude = std::to_string(latitude_deg);
    const std::string longitude = std::to_string(longitude_deg);
    text += IdOf(i) + "," + (is_swapped ? longitude + "," + latitude : latitude + "," + longitude) +
            ",500," + std::to_string(yaw_deg) + ",0,0\n";
  }
  return text;
}

TEST_CASE("suspicions: latitude for longitude, by where a plane's nose points") {
  const std::string name = "SwappedLatitudeLongitude";
  CHECK(IsWarned(Lines(true, 0.0), {}, name));
  CHECK_FALSE(IsWarned(Lines(false, 0.0), {}, name));
  // Backwards it fits neither way, nor does a craft that looks aside at random.
  CHECK_FALSE(IsWarned(Lines(false, 0.0, true), {}, name));
  CHECK_FALSE(IsWarned(Lines(true, 180.0), {}, name));
  CHECK_FALSE(IsWarned(Poses(0, true), {}, name));
  // Where an origin agrees with the places, they are not doubted.
  SideContext origin;
  origin.origin = GeoPoint{8.0, 47.0, 400.0};
  CHECK_FALSE(IsWarned(Lines(true, 0.0), origin, name));
}

TEST_CASE("suspicions: a latitude that can only be a longitude is told as such") {
  const auto detail = [](const std::string& line) {
    try {
      ParsePoses("image,lat,lon,alt\n" + line + "\n");
    } catch (const ApiError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string hint = "may be swapped";
  CHECK(detail("a,151.2,-33.9,5").find(hint) != std::string::npos);
  CHECK(detail("a,-120,45,5").find("a latitude") != std::string::npos);
  CHECK(detail("a,-33.9,151.2,5").empty());
  CHECK(detail("a,151.2,120,5").find(hint) == std::string::npos);
  CHECK(detail("a,500,45,5").find(hint) == std::string::npos);
  CHECK_FALSE(detail("a,500,45,5").empty());
}

TEST_CASE("suspicions: poses that are far from where the photographs say") {
  SideContext elsewhere = Tagged(Tag::kPlace);
  for (auto& [id, meta] : elsewhere.image_tags) meta.position->longitude_deg += 0.1;
  CHECK(IsWarned(Poses(0), elsewhere, "GeotagsDisagree"));
  CHECK_FALSE(IsWarned(Poses(0), Tagged(Tag::kPlace), "GeotagsDisagree"));
  CHECK_FALSE(IsWarned(Poses(0), {}, "GeotagsDisagree"));
}

TEST_CASE("suspicions: poses one image early or late, by geotags or by times") {
  for (const Tag tag : {Tag::kPlace, Tag::kTime}) {
    CHECK(IsWarned(Poses(1), Tagged(tag), "ShiftedPoses"));
    CHECK(IsWarned(Poses(-1), Tagged(tag), "ShiftedPoses"));
    CHECK_FALSE(IsWarned(Poses(0), Tagged(tag), "ShiftedPoses"));
  }
}

// Level, on the four headings of a lawn mower's pattern.
std::string Quaternions(bool is_w_last) {
  std::string text;
  for (int i = 0; i < kNumImages; ++i) {
    const double half_yaw = 0.25 * kPi * i;
    const std::string w = std::to_string(std::cos(half_yaw)),
                      z = std::to_string(std::sin(half_yaw));
    text += R"({"image": ")" + IdOf(i) + R"(", "attitude": {"quaternion_wxyz": [)" +
            (is_w_last ? "0,0," + z + "," + w : w + ",0,0," + z) + "]}}\n";
  }
  return text;
}

TEST_CASE("suspicions: attitudes that are level only with w last") {
  CHECK(IsWarned(Quaternions(true), {}, "QuaternionOrder"));
  CHECK_FALSE(IsWarned(Quaternions(false), {}, "QuaternionOrder"));
}

TEST_CASE("csv: wind told by where it comes from blows the other way") {
  const PoseFile file = ParsePoses(
      "#Label;Y/Latitude;X/Longitude;Z/Altitude;wind_from_deg;wind_speed_mps\n"
      "a;47;8;500;270;5\nb;47;8;500;0;3\nc;47;8;500;;\n");
  // From the west it blows east; from the north, south.
  CHECK((*MetaOf(file, "a").wind_in_world - Eigen::Vector2d(5, 0)).norm() < 1e-12);
  CHECK((*MetaOf(file, "b").wind_in_world - Eigen::Vector2d(0, -3)).norm() < 1e-12);
  CHECK_FALSE(MetaOf(file, "c").wind_in_world);
  CHECK(MetaOf(file, "a").position->latitude_deg == 47.0);
  CHECK(file.warnings.empty());
  CHECK(
      Warns(ParsePoses("image,lat,lon,alt,wind_dir_deg,wind_speed\na,1,2,3,4,5\n"), "comes from"));
  CHECK(Warns(ParsePoses("image,lat,lon,alt,wind_from_deg,wind_speed\na,1,2,3,4,\n"),
              "line 2: \"wind_speed\""));
}

TEST_CASE("csv: every line that cannot be used is told of at once") {
  try {
    ParsePoses("image,lat,lon,alt\na,95,8,5\n\nc,47,x,5\n");
    FAIL("was taken");
  } catch (const ApiError& error) {
    REQUIRE(error.errors().size() == 2);
    CHECK(error.errors()[1].pointer == "/poses/4/lon");
  }
}

}  // namespace
}  // namespace freelsd
