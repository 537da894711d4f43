#include <algorithm>

#include <doctest/doctest.h>

#include "api/import/date_time.h"
#include "api/import/gimbal.h"
#include "api/import/poses/poses.h"
#include "tests/api/errors.h"
#include "tests/api/flights.h"

namespace freelsd {
namespace {

constexpr double kMaxRotationErrorRad = 1e-9;
constexpr double kMaxWindErrorMps = 1e-9;
constexpr const char* kHeader = "image,latitude_deg,longitude_deg,altitude_m\n";

std::string ErrorOfPoses(const std::string& text) {
  return ErrorOf([&text] { ParsePoses(text); });
}

bool HasWarning(const PoseFile& file, const std::string& part) {
  return std::any_of(file.warnings.begin(), file.warnings.end(), [&part](const auto& warning) {
    return warning.find(part) != std::string::npos;
  });
}

double HeadingOfImageTop(const Eigen::Quaterniond& ned_from_camera) {
  const Eigen::Vector3d top = ned_from_camera * -Eigen::Vector3d::UnitY();
  return DegFromRad(std::atan2(top.y(), top.x()));
}

PoseFile Poses(const std::string& flight, const std::string& file) {
  const auto flights = FlightsFolder();
  return flights ? ParsePoses(ReadBytes(*flights / flight / file)) : PoseFile{};
}

TEST_CASE("poses: the contract's columns, in any order, with byte order mark and CRLF") {
  const PoseFile file = ParsePoses(
      "\xEF\xBB\xBFyaw_deg,roll_deg,pitch_deg,altitude_m,longitude_deg,latitude_deg,image,"
      "timestamp_us,wind_east_mps,wind_north_mps,height_above_ground_m\r\n"
      "90,0,0,500,8.5,47.5,my photo.jpg,1479832354498032,1,-2,80\r\n"
      ",,,500,8.5,47.5,b.jpg,,,,\r\n");
  CHECK(file.warnings.empty());
  REQUIRE(file.poses.size() == 2);
  CHECK(file.poses[0].first == "my_photo.jpg");
  const FrameMeta& meta = file.poses[0].second;
  CHECK(meta.position->latitude_deg == 47.5);
  CHECK(meta.timestamp_us == 1479832354498032);
  CHECK(meta.wind_in_world == Eigen::Vector2d(1, -2));
  CHECK(meta.height_above_ground_m == 80.0);
  const Eigen::Quaterniond expected(std::sqrt(0.5), 0, 0, std::sqrt(0.5));
  CHECK(AngleBetween(*meta.ned_from_body, expected) < kMaxRotationErrorRad);
  CHECK_FALSE(meta.attitude_sd_deg);
  const FrameMeta& sparse = file.poses[1].second;
  CHECK_FALSE(sparse.ned_from_body);
  CHECK_FALSE(sparse.timestamp_us);
  CHECK_FALSE(sparse.wind_in_world);
}

TEST_CASE("poses: a heading alone is level within eight degrees, and says so") {
  const PoseFile file = ParsePoses("image,lat,lon,alt,yaw_deg\na,47,8,500,-270\n");
  const FrameMeta& meta = file.poses[0].second;
  CHECK(AngleBetween(*meta.ned_from_body, NedFromBody({0, 0, kPi / 2})) < kMaxRotationErrorRad);
  CHECK(meta.attitude_sd_deg == 8.0);
  CHECK(HasWarning(file, "level"));
}

TEST_CASE("poses: what is wrong is refused at its line and column") {
  const std::string h = kHeader;
  CHECK(ErrorOfPoses(h + "a,47,8,500\n") == "nothing");
  CHECK(ErrorOfPoses(h + "b,,8,500\n") == "422 InvalidPoses /poses/2/latitude_deg");
  CHECK(ErrorOfPoses(h + ",47,8,500\n") == "422 InvalidPoses /poses/2/image");
  CHECK(ErrorOfPoses(h + "a,95,8,500\n") == "422 InvalidPoses /poses/2/latitude_deg");
  CHECK(ErrorOfPoses(h + "a,nan,8,500\n") == "422 InvalidPoses /poses/2/latitude_deg");
  CHECK(ErrorOfPoses(h + "a,47,1e999,500\n") == "422 InvalidPoses /poses/2/longitude_deg");
  CHECK(ErrorOfPoses(h + "a,47,8,inf\n") == "422 InvalidPoses /poses/2/altitude_m");
  CHECK(ErrorOfPoses(h + "a,47,8,5 s\n") == "422 InvalidPoses /poses/2/altitude_m");
  CHECK(ErrorOfPoses(h + "a,47,8\n") == "422 InvalidPoses /poses/2/altitude_m");
  CHECK(ErrorOfPoses(h + "a,47,8,5,6\n") == "422 InvalidPoses /poses/2");
  CHECK(ErrorOfPoses(h + "a,47,8,5\na,47,9,5\n") == "422 InvalidPoses /poses");
  CHECK(ErrorOfPoses(h + "a,1e1,8,5\n") == "nothing");
  CHECK(ErrorOfPoses("") == "422 InvalidPoses /poses");
  CHECK(ErrorOfPoses("image,lat,lon\na,1,2\n") == "422 InvalidPoses /poses/1/altitude_m");
  CHECK(ErrorOfPoses("image,lat,lon,lat,alt\n") == "422 InvalidPoses /poses/1/lat");
  // A place is enough: what is wrong beside it is left out.
  const PoseFile noon = ParsePoses("image,lat,lon,alt,utc\na,1,2,3,noon\n");
  CHECK_FALSE(noon.poses.at(0).second.timestamp_us);
  CHECK(HasWarning(noon, "line 2: \"utc\" must be YYYY"));
  const PoseFile below = ParsePoses("image,lat,lon,alt,height_above_ground_m\na,1,2,3,-4\n");
  CHECK_FALSE(below.poses.at(0).second.height_above_ground_m);
  CHECK(HasWarning(below, "line 2: \"height_above_ground_m\""));
}

TEST_CASE("poses: columns without a name are passed over, and told of where they hold values") {
  const std::string header = "image,lat,,lon,alt,, \n";
  const PoseFile empty = ParsePoses(header + "a.jpg,47,,8,500,,\nb.jpg,47,, 8,500\n");
  REQUIRE(empty.poses.size() == 2);
  CHECK(empty.poses[0].second.position->longitude_deg == 8.0);
  CHECK(empty.warnings.empty());
  const PoseFile noted = ParsePoses(header + "a.jpg,47,,8,500,,\nb.jpg,47,,8,500,,blurred\n");
  CHECK(noted.poses.size() == 2);
  CHECK(noted.warnings == std::vector<std::string>{"columns without a name hold values: ignored"});
  CHECK(ParsePoses(header + "a.jpg,47,,8,500,,\n,,,,,,\n , ,\n").poses.size() == 1);
  // More cells than columns stay a fault, and so does a name that comes twice.
  CHECK(ErrorOfPoses(header + "a.jpg,47,,8,500,,,\n") != "");
  CHECK(ErrorOfPoses("image,lat,lon,alt,note,note\na.jpg,47,8,500,,\n") != "");
}

TEST_CASE("poses: wind told by where it blows to") {
  const PoseFile file = ParsePoses(
      "image,lat,lon,alt,wind_to_deg,wind_speed_mps\n"
      "a,47,8,500,90,5\nb,47,8,500,180,3\nc,47,8,500,30,4\nd,47,8,500,,\n");
  CHECK(file.warnings.empty());
  const auto wind = [&file](size_t i) { return file.poses.at(i).second.wind_in_world; };
  // East, then north: 4 sin 30 = 2, 4 cos 30 = 3.4641.
  CHECK((*wind(0) - Eigen::Vector2d(5, 0)).norm() < kMaxWindErrorMps);
  CHECK((*wind(1) - Eigen::Vector2d(0, -3)).norm() < kMaxWindErrorMps);
  CHECK((*wind(2) - Eigen::Vector2d(2, 3.4641016151)).norm() < kMaxWindErrorMps);
  CHECK_FALSE(wind(3));
  const PoseFile both = ParsePoses(
      "image,lat,lon,alt,wind_from_deg,wind_to_deg,wind_speed_mps\n"
      "a,47,8,500,270,,5\nb,47,8,500,,90,5\n");
  CHECK(HasWarning(both, "wind comes from is used"));
  for (const auto& [id, meta] : both.poses) {
    CHECK((*meta.wind_in_world - Eigen::Vector2d(5, 0)).norm() < kMaxWindErrorMps);
  }
}

TEST_CASE("poses: half a wind is left out, and told at a column that is there") {
  const auto read = [](const std::string& rest) { return ParsePoses("image,lat,lon,alt," + rest); };
  CHECK(HasWarning(read("wind_to_deg\na,1,2,3,4\n"), "line 2: \"wind_to_deg\""));
  CHECK(HasWarning(read("wind_from_deg\na,1,2,3,4\n"), "line 2: \"wind_from_deg\""));
  CHECK(HasWarning(read("wind_speed\na,1,2,3,4\n"), "line 2: \"wind_speed\""));
  CHECK(HasWarning(read("wind_north_mps\na,1,2,3,4\n"), "line 2: \"wind_north_mps\""));
  // The empty cell, where it has a column.
  CHECK(HasWarning(read("wind_to_deg,wind_speed\na,1,2,3,4,\n"), "line 2: \"wind_speed\""));
  CHECK(HasWarning(read("wind_to_deg,wind_speed\na,1,2,3,,4\n"), "line 2: \"wind_to_deg\""));
  const PoseFile east = read("wind_east_mps,wind_north_mps\na,1,2,3,4,\n");
  CHECK(HasWarning(east, "line 2: \"wind_north_mps\""));
  CHECK_FALSE(east.poses.at(0).second.wind_in_world);
}

TEST_CASE("poses: Agisoft's reference, with remarks before its header and markers behind") {
  const PoseFile file = ParsePoses(
      "# Cameras (2)\r\n"
      "# CoordinateSystem: GEOGCS[\"WGS 84\",DATUM[\"World Geodetic System 1984\"]]\r\n"
      "#Label,X/Longitude,Y/Latitude,Z/Altitude,Yaw,Pitch,Roll\r\n"
      "a.jpg,8.5,47.25,500.5,90,0,0\r\n"
      "b.jpg,8.5,47.25,500.5,,,\r\n"
      "# Total Error,,,,,,\r\n"
      "# Markers (1)\r\n"
      "#Label,X/Longitude,Y/Latitude,Z/Altitude\r\n"
      "point 1,8.5,47.25,400\r\n");
  REQUIRE(file.poses.size() == 2);
  const FrameMeta& meta = file.poses[0].second;
  CHECK(file.poses[0].first == "a.jpg");
  CHECK(meta.position->latitude_deg == 47.25);
  CHECK(meta.position->longitude_deg == 8.5);
  CHECK(meta.position->altitude_m == 500.5);
  // The nose, forward, points east.
  CHECK((*meta.ned_from_body * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm() <
        kMaxRotationErrorRad);
  CHECK_FALSE(file.poses[1].second.ned_from_body);
  CHECK(HasWarning(file, "second table begins at line 8"));
  CHECK(HasWarning(file, "2 lines that begin with #"));
}

TEST_CASE("poses: lines are counted with the remarks, and separators told by the header") {
  const std::string h = "# taken in spring, windy\n#image;lat;lon;alt\n";
  CHECK(ParsePoses(h + "a;47;8;500\n").poses.size() == 1);
  CHECK(ErrorOfPoses(h + "b;47;x;500\n") == "422 InvalidPoses /poses/3/lon");
  CHECK(ErrorOfPoses("# x\nimage,lat,lon\n") == "422 InvalidPoses /poses/2/altitude_m");
  CHECK(ErrorOfPoses("# x\n#Label,X/Longitude\na,1\n") == "422 InvalidPoses /poses/2/latitude_deg");
  CHECK(ErrorOfPoses("# x\n# y") == "422 InvalidPoses /poses/1/image");
}

TEST_CASE("poses: quaternions in four columns, by their names") {
  // b: yaw 60, cos 30 and sin 30. c: yaw 90 and then roll 10, cos 45 cos 5 = 0.70441603.
  const PoseFile file = ParsePoses(
      "image,lat,lon,alt,qx,qy,qz,qw\n"
      "a,47,8,500,0,0,0,1\n"
      "b,47,8,500,0,0,0.5,0.8660254038\n"
      "c,47,8,500,0.0616284167,0.0616284167,0.7044160264,0.7044160264\n"
      "d,47,8,500,,,,\n");
  REQUIRE(file.poses.size() == 4);
  CHECK(file.warnings.size() == 1);
  CHECK(HasWarning(file, "north, east, down"));
  const auto attitude = [&file](size_t i) { return file.poses.at(i).second.ned_from_body; };
  CHECK(EulerFromNedFromBody(attitude(0).value()).yaw == doctest::Approx(0.0));
  CHECK(DegFromRad(EulerFromNedFromBody(attitude(1).value()).yaw) == doctest::Approx(60.0));
  CHECK((*attitude(1) * Eigen::Vector3d::UnitX() - Eigen::Vector3d(0.5, 0.8660254038, 0)).norm() <
        kMaxRotationErrorRad);
  // Flying east, the right wing points south and ten degrees down.
  CHECK((*attitude(2) * Eigen::Vector3d::UnitY() - Eigen::Vector3d(-0.9848077530, 0, 0.1736481777))
            .norm() < kMaxRotationErrorRad);
  CHECK_FALSE(attitude(3));
  CHECK_FALSE(file.poses[1].second.attitude_sd_deg);
  CHECK(ParsePoses("image,lat,lon,alt,Q_W,q_x,q_y,q_z\na,47,8,5,1,0,0,0\n")
            .poses[0]
            .second.ned_from_body);
}

TEST_CASE("poses: quaternions that are not whole, and beside angles") {
  const std::string h = "image,lat,lon,alt,qw,qx,qy,qz\n";
  CHECK(HasWarning(ParsePoses(h + "a,47,8,5,1,0,,0\n"), "line 2: \"qy\""));
  CHECK(HasWarning(ParsePoses(h + "a,47,8,5,0,0,0,0\n"), "line 2: \"qw\""));
  const PoseFile part = ParsePoses("image,lat,lon,alt,qw,qx\na,47,8,5,1,0\n");
  CHECK_FALSE(part.poses[0].second.ned_from_body);
  CHECK(HasWarning(part, "needs qw, qx, qy and qz"));
  const PoseFile both =
      ParsePoses("image,lat,lon,alt,roll,pitch,yaw,qw,qx,qy,qz\na,47,8,5,0,0,90,1,0,0,0\n");
  CHECK(HasWarning(both, "quaternion is ignored"));
  CHECK(DegFromRad(EulerFromNedFromBody(*both.poses[0].second.ned_from_body).yaw) ==
        doctest::Approx(90.0));
  // A heading alone says less.
  const PoseFile heading = ParsePoses("image,lat,lon,alt,yaw,qw,qx,qy,qz\na,47,8,5,90,1,0,0,0\n");
  CHECK(EulerFromNedFromBody(*heading.poses[0].second.ned_from_body).yaw == doctest::Approx(0.0));
  CHECK_FALSE(heading.poses[0].second.attitude_sd_deg);
}

TEST_CASE("poses: altitudes stay in the datum of the column, which is told") {
  const std::string line = "\na,47,8,547.25,500.5\n";
  const PoseFile amsl = ParsePoses("image,lat,lon,alt_hae_m,alt_amsl_m" + line);
  CHECK(amsl.poses[0].second.position->altitude_m == 500.5);
  CHECK(HasWarning(amsl, "\"alt_amsl_m\" is of the datum amsl"));
  CHECK(amsl.poses[0].second.altitude_datum == "amsl");
  CHECK(HasWarning(amsl, "not used: \"alt_hae_m\""));
  const PoseFile ellipsoid = ParsePoses("image,lat,lon,alt_hae_m,yaw_deg" + line);
  CHECK(ellipsoid.poses[0].second.position->altitude_m == 547.25);
  CHECK(HasWarning(ellipsoid, "\"alt_hae_m\" is of the datum ellipsoid"));
  CHECK(ellipsoid.poses[0].second.altitude_datum == "ellipsoid");
  CHECK(ParsePoses("image,lat,lon,alt\na,47,8,-12.5\n").poses[0].second.position->altitude_m ==
        -12.5);
  const PoseFile silent = ParsePoses("image,lat,lon,alt\na,47,8,5\n");
  CHECK_FALSE(HasWarning(silent, "datum"));
  CHECK_FALSE(silent.poses[0].second.altitude_datum);
}

TEST_CASE("poses: lines of JSON, with the image beside the meta") {
  const std::string good =
      R"({"image": "a.jpg", "position": {"latitude_deg": 47, "longitude_deg": 8, "altitude_m": 5}})";
  const PoseFile file = ParsePoses(good + "\r\n\n" + R"({"image": "b.jpg", "timestamp_us": 7})");
  REQUIRE(file.poses.size() == 2);
  CHECK(file.poses[0].second.position->altitude_m == 5.0);
  CHECK(file.poses[1].second.timestamp_us == 7);
  CHECK(ErrorOfPoses(good + "\n{\"image\": \"b\", \"pos\": 1}") == "422 UnknownKey /poses/2/pos");
  CHECK(ErrorOfPoses("{\"timestamp_us\": 1}") == "422 InvalidPoses /poses/1/image");
  CHECK(ErrorOfPoses(good + "\n{\"image\": \"b\", \"timestamp_us\": NaN}") ==
        "400 InvalidJson /poses/2");
  CHECK(ErrorOfPoses(R"({"image": "b", "attitude": {"quaternion_wxyz": [0, 0, 0, 0]}})") ==
        "422 InvalidValue /poses/1/attitude/quaternion_wxyz");
}

TEST_CASE("photographs without a usable date: pose columns tell local time and UTC apart") {
  const auto source_of = [](const std::string& column, const std::string& time) {
    const PoseFile file = ParsePoses("image,latitude_deg,longitude_deg,altitude_m," + column +
                                     "\na.jpg,47,8,500," + time + "\n");
    const FrameMeta& meta = file.poses.at(0).second;
    return meta.timestamp_us ? std::string(NameOf(meta.time_source)) : "none";
  };
  CHECK(source_of("utc", "2016:06:29 17:49:32") == "given");
  CHECK(source_of("timestamp_us", "1479832354498032") == "given");
  CHECK(source_of("local_time", "2016:06:29 17:49:32") == "camera_local");
  CHECK(source_of("datetime", "2016:06:29 17:49:32") == "camera_local");
  CHECK(source_of("local_time", "2016-06-29T17:49:32+02:00") == "given");
  CHECK(source_of("local_time", "0000:00:00 00:00:00") == "none");
}

TEST_CASE("poses: swindale as it stands") {
  const PoseFile file = Poses("swindale", "poses.csv");
  if (file.poses.empty()) return;
  CHECK(file.poses.size() == 54);
  CHECK(file.poses[0].first == "IMG_1417.JPG");
  const FrameMeta& meta = file.poses[0].second;
  CHECK(meta.position->latitude_deg == 54.5090622);
  CHECK(meta.position->longitude_deg == -2.7582823);
  CHECK(meta.position->altitude_m == 343.42);
  CHECK(meta.timestamp_us == TimestampFromText("2016:06:29 17:49:32"));
  CHECK_FALSE(meta.ned_from_body);
}

TEST_CASE("poses: garfield_park as it stands, attitude of the aircraft, quoted cells") {
  const PoseFile file = Poses("garfield_park", "poses_from_exif.csv");
  if (file.poses.empty()) return;
  CHECK(file.poses.size() == 28);
  const FrameMeta& meta = file.poses[1].second;
  CHECK(meta.position->altitude_m == 348.241);
  CHECK(meta.position_sd_m == 2.289);
  CHECK(meta.timestamp_us == TimestampFromText("2016:11:22 16:32:39.306746"));
  const EulerAngles attitude = EulerFromNedFromBody(meta.ned_from_body.value());
  CHECK(DegFromRad(attitude.yaw) == doctest::Approx(326.721 - 360.0));
  CHECK(DegFromRad(attitude.pitch) == doctest::Approx(2.28039));
  CHECK(DegFromRad(attitude.roll) == doctest::Approx(-2.08752));
  CHECK(HasWarning(file, "imu_linear_velocity_mps"));
}

TEST_CASE("poses: brighton_beach as it stands, the image's top wins over the gimbal's yaw") {
  const PoseFile file = Poses("brighton_beach", "poses_from_exif.csv");
  if (file.poses.empty()) return;
  CHECK(file.poses.size() == 18);
  const FrameMeta& first = file.poses[0].second;
  CHECK_FALSE(first.ned_from_body);
  CHECK(AngleBetween(*first.ned_from_camera,
                     NedFromGimbalCamera({0, RadFromDeg(-89.9), RadFromDeg(45)})) <
        kMaxRotationErrorRad);
  CHECK(first.position->altitude_m == 198.31);
  CHECK(first.height_above_ground_m == 39.8);
  // DJI_0024: gimbal yaw -140, turned by 180 deg after exposure, so its top points to 40.
  const FrameMeta& turned = file.poses[6].second;
  CHECK(file.poses[6].first == "DJI_0024.JPG");
  CHECK(HeadingOfImageTop(*turned.ned_from_camera) == doctest::Approx(40.0).epsilon(1e-6));
  const Eigen::Vector3d axis = *turned.ned_from_camera * Eigen::Vector3d::UnitZ();
  // The optical axis stays where the gimbal held it: 0.1 deg from straight down towards -140.
  CHECK(DegFromRad(std::atan2(axis.y(), axis.x())) == doctest::Approx(-140.0));
  CHECK(HasWarning(file, "take-off"));
}

TEST_CASE("poses: seneca_nir as it stands, the track is not taken for the heading") {
  const PoseFile file = Poses("seneca_nir", "poses_from_exif.csv");
  if (file.poses.empty()) return;
  CHECK(file.poses.size() == 26);
  CHECK(file.poses[0].second.position->altitude_m == 283.5939948);
  CHECK_FALSE(file.poses[0].second.ned_from_body);
  CHECK_FALSE(file.poses[0].second.ned_from_camera);
  CHECK(HasWarning(file, "track over ground"));
}

}  // namespace
}  // namespace freelsd
