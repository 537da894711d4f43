// Tables as other programs write them, made anew from the descriptions of their formats.
#include <iomanip>
#include <sstream>

#include "tests/api/import/poses/side_files.h"

namespace freelsd {
namespace {

// Three photographs near 47.351 N, 8.4558 E; the second lies 38 m north, and the third 77 m.
struct Photograph {
  const char* id;
  GeoPoint place;
};
constexpr Photograph kFlown[] = {{"DJI_0001.JPG", {47.35100092, 8.45579865, 555.869}},
                                 {"DJI_0002.JPG", {47.35134298, 8.45580562, 555.436}},
                                 {"DJI_0003.JPG", {47.35169163, 8.45579576, 556.556}}};
constexpr double kMaxErrorDeg = 2e-6;  // 20 cm
constexpr double kMaxErrorM = 0.2;

SideContext Tagged() {
  SideContext context;
  for (const Photograph& each : kFlown) {
    FrameMeta meta;
    meta.position = each.place;
    meta.altitude_datum = "amsl";
    context.image_tags.emplace_back(each.id, meta);
  }
  return context;
}

// Without positions of their own.
SideContext Untagged() {
  SideContext context;
  for (const Photograph& each : kFlown) context.image_tags.emplace_back(each.id, FrameMeta{});
  return context;
}

std::string Warnings(const PoseFile& file) {
  std::string all;
  for (const std::string& warning : file.warnings) all += warning + "\n";
  return all;
}

// "all" if the table gives the three places, else what is wrong.
std::string Read(const std::string& name, const std::string& text, const SideContext& context) {
  try {
    const PoseFile file = PosesFromFiles({{name, text}}, context);
    if (file.poses.size() != std::size(kFlown)) {
      return std::to_string(file.poses.size()) + " poses: " + Warnings(file);
    }
    for (const Photograph& flown : kFlown) {
      const GeoPoint place = MetaOf(file, flown.id).position.value();
      if (std::abs(place.latitude_deg - flown.place.latitude_deg) < kMaxErrorDeg &&
          std::abs(place.longitude_deg - flown.place.longitude_deg) < kMaxErrorDeg &&
          std::abs(place.altitude_m - flown.place.altitude_m) < kMaxErrorM) {
        continue;
      }
      std::ostringstream wrong;
      wrong << std::setprecision(10) << flown.id << " " << place.latitude_deg << " "
            << place.longitude_deg << " " << place.altitude_m;
      return wrong.str();
    }
    return "all";
  } catch (const ApiError& error) {
    return std::string("refused: ") + error.what();
  }
}

void CheckTable(const std::string& name, const std::string& text) {
  CAPTURE(name);
  CAPTURE(text);
  CHECK(Read(name, text, Tagged()) == "all");
}
// Also without the help of the photographs' own tags.
void CheckTableAlone(const std::string& name, const std::string& text) {
  CheckTable(name, text);
  CHECK(Read(name, text, Untagged()) == "all");
}

// UTF-16, as Windows writes it.
std::string Utf16(const std::string& text, bool is_little_endian, const std::string& mark) {
  std::string wide = mark;
  for (const char c : text) wide += is_little_endian ? std::string{c, '\0'} : std::string{'\0', c};
  return wide;
}

const std::string kPlain =
    "image,lat,lon,alt\nDJI_0001.JPG,47.35100092,8.45579865,555.869\n"
    "DJI_0002.JPG,47.35134298,8.45580562,555.436\nDJI_0003.JPG,47.35169163,8.45579576,556.556\n";

TEST_CASE("program tables: Pix4Dmapper") {
  CheckTableAlone("pix4d.csv",
                  "DJI_0001.JPG,47.35100092,8.45579865,555.869,5,10\n"
                  "DJI_0002.JPG,47.35134298,8.45580562,555.436,5,10\n"
                  "DJI_0003.JPG,47.35169163,8.45579576,556.556,5,10\n");
  CheckTableAlone("pix4d.csv",
                  "imagename,latitude [decimal degrees],longitude [decimal degrees],"
                  "altitude [meter],accuracy horizontal [meter],accuracy vertical [meter]\n"
                  "DJI_0001.JPG,47.35100092,8.45579865,555.869,5,10\n"
                  "DJI_0002.JPG,47.35134298,8.45580562,555.436,5,10\n"
                  "DJI_0003.JPG,47.35169163,8.45579576,556.556,5,10\n");
}

TEST_CASE("program tables: Pix4Dmatic") {
  CheckTableAlone("matic.csv",
                  "#imagename,coordinate1,coordinate2,z,yaw,pitch,roll\n"
                  "DJI_0001.JPG,47.35100092,8.45579865,555.869,15.8732,0,0\n"
                  "DJI_0002.JPG,47.35134298,8.45580562,555.436,13.6693,0,0\n"
                  "DJI_0003.JPG,47.35169163,8.45579576,556.556,13.1421,0,0\n");
}

TEST_CASE("program tables: RealityScan and RealityCapture, whose roll of 90 looks down") {
  const std::string text =
      "#name,x,y,alt,yaw,pitch,roll,f_35mm,px_norm,py_norm,k1\n"
      "DJI_0001.JPG,8.45579865,47.35100092,555.869,15.8732,0.1,89.9,22.0,0,0,0\n"
      "DJI_0002.JPG,8.45580562,47.35134298,555.436,13.6693,0.1,89.9,22.0,0,0,0\n"
      "DJI_0003.JPG,8.45579576,47.35169163,556.556,13.1421,0.1,89.9,22.0,0,0,0\n";
  CheckTableAlone("realityscan.csv", text);
  const PoseFile file = PosesFromFiles({{"realityscan.csv", text}}, Tagged());
  CHECK_FALSE(file.poses.at(0).second.ned_from_body);
  CHECK(Warns(file, "CameraAnglesIgnored"));
  CheckTableAlone("capture.csv",
                  "#name;x;y;alt;heading;pitch;roll\n"
                  "DJI_0001.JPG;8.45579865;47.35100092;555.869;0;0;0\n"
                  "DJI_0002.JPG;8.45580562;47.35134298;555.436;0;0;0\n"
                  "DJI_0003.JPG;8.45579576;47.35169163;556.556;0;0;0\n");
}

TEST_CASE("program tables: Mission Planner's location.txt") {
  const std::string text =
      "#name latitude/Y longitude/X height/Z yaw pitch roll SAlt\n"
      "DJI_0001.JPG 47.35100092 8.45579865 555.869 15.8732 0 0 98\n"
      "DJI_0002.JPG 47.35134298 8.45580562 555.436 13.6693 0 0 98\n"
      "DJI_0003.JPG 47.35169163 8.45579576 556.556 13.1421 0 0 98\n";
  CheckTableAlone("location.txt", text);
  const FrameMeta meta = MetaOf(PosesFromFiles({{"location.txt", text}}, Tagged()), "DJI_0001.JPG");
  CHECK(DegFromRad(EulerFromNedFromBody(meta.ned_from_body.value()).yaw) ==
        doctest::Approx(15.8732));
}

TEST_CASE("program tables: exiftool -csv, with and without -n") {
  const std::string text =
      "SourceFile,GPSLatitude,GPSLongitude,GPSAltitude\n"
      "./DJI_0001.JPG,\"47 deg 21' 3.6033\"\" N\",\"8 deg 27' 20.8751\"\" E\",555.869 m Above Sea "
      "Level\n"
      "./DJI_0002.JPG,\"47 deg 21' 4.8347\"\" N\",\"8 deg 27' 20.9002\"\" E\",555.436 m Above Sea "
      "Level\n"
      "./DJI_0003.JPG,\"47 deg 21' 6.0899\"\" N\",\"8 deg 27' 20.8647\"\" E\",556.556 m Above Sea "
      "Level\n";
  CheckTableAlone("exif.csv", text);
  CHECK(PosesFromFiles({{"exif.csv", text}}, Tagged()).poses.at(0).second.altitude_datum == "amsl");
  CheckTableAlone("position.csv",
                  "SourceFile,GPSAltitude,GPSPosition\n"
                  "./DJI_0001.JPG,555.869,\"47 deg 21' 3.6033\"\" N, 8 deg 27' 20.8751\"\" E\"\n"
                  "./DJI_0002.JPG,555.436,\"47 deg 21' 4.8347\"\" N, 8 deg 27' 20.9002\"\" E\"\n"
                  "./DJI_0003.JPG,556.556,\"47 deg 21' 6.0899\"\" N, 8 deg 27' 20.8647\"\" E\"\n");
  const PoseFile west = PosesFromFiles(
      {{"n.csv",
        "SourceFile,GPSLatitudeRef,GPSLatitude,GPSLongitudeRef,GPSLongitude,GPSAltitudeRef,"
        "GPSAltitude\n./DJI_0001.JPG,S,54.5,W,2.76,1,3.5\n./DJI_0002.JPG,South,54.5,West,2.76,"
        "Above Sea Level,3.5\n./DJI_0003.JPG,S,54.5,,2.76,0,3.5\n"}},
      {});
  REQUIRE(west.poses.size() == 2);
  CHECK(west.poses[0].second.position->latitude_deg == -54.5);
  CHECK(west.poses[0].second.position->longitude_deg == -2.76);
  CHECK(west.poses[0].second.position->altitude_m == -3.5);
  CHECK(west.poses[1].second.position->longitude_deg == -2.76);
  CHECK(west.poses[1].second.position->altitude_m == 3.5);
  CHECK(Warns(west, "line 4: \"gpslongituderef\" must be E or W"));
}

TEST_CASE("program tables: exiftool's names of DJI's gimbal") {
  const PoseFile file = PosesFromFiles(
      {{"dji.csv",
        "SourceFile,GPSLatitude,GPSLongitude,AbsoluteAltitude,RelativeAltitude,GimbalRollDegree,"
        "GimbalYawDegree,GimbalPitchDegree,FlightYawDegree\n"
        "./DJI_0001.JPG,47.351,8.4558,+555.87,+98.50,+0.00,+90.00,-90.00,+12.00\n"}},
      {});
  const FrameMeta& meta = MetaOf(file, "DJI_0001.JPG");
  CHECK(meta.position->altitude_m == 555.87);
  CHECK(meta.height_above_ground_m == 98.5);
  CheckAxis(meta, {0, 0, 1}, {0, 0, 1});
  CheckAxis(meta, {0, -1, 0}, {0, 1, 0});
}

TEST_CASE("program tables: Metashape and PhotoScan, in degrees and in UTM") {
  CheckTableAlone("metashape.txt",
                  "# Cameras (3)\n# CoordinateSystem: GEOGCS[\"WGS 84\",AUTHORITY[\"EPSG\","
                  "\"4326\"]]\n#Label,X/Longitude,Y/Latitude,Z/Altitude,Error_(m),X_error\n"
                  "DJI_0001.JPG,8.45579865,47.35100092,555.869,,\n"
                  "DJI_0002.JPG,8.45580562,47.35134298,555.436,,\n"
                  "DJI_0003.JPG,8.45579576,47.35169163,556.556,,\n");
  // WGS84, zone 32: easting = 500000 - 0.9996 * arc of the parallel, and so on (GeographicLib).
  const std::string utm =
      "#Label\tX/East\tY/North\tZ/Altitude\n"
      "DJI_0001.JPG\t458898.56\t5244314.340\t555.869\n"
      "DJI_0002.JPG\t458899.352\t5244352.351\t555.436\n"
      "DJI_0003.JPG\t458898.878\t5244391.102\t556.556\n";
  const std::string system =
      "# CoordinateSystem: PROJCS[\"WGS 84 / UTM zone 32N\",GEOGCS[\"WGS 84\""
      ",AUTHORITY[\"EPSG\",\"4326\"]],AUTHORITY[\"EPSG\",\"32632\"]]\n";
  CheckTableAlone("photoscan.txt", system + utm);
  CHECK(Read("photoscan.txt", utm, Tagged()).find("EPSG:32632") != std::string::npos);
}

TEST_CASE("program tables: DJI's MRK, by the numbers of the photographs") {
  const std::string text =
      "1\t541804.521334\t[2316]\t    -7,N\t    -3,E\t   196,V\t47.35100092,Lat\t8.45579865,Lon\t"
      "555.869,Ellh\t0.012, 0.011, 0.025\t50,Q\n"
      "2\t541807.521334\t[2316]\t    -7,N\t    -3,E\t   196,V\t47.35134298,Lat\t8.45580562,Lon\t"
      "555.436,Ellh\t0.012, 0.011, 0.025\t50,Q\n"
      "3\t541810.521334\t[2316]\t    -7,N\t    -3,E\t   196,V\t47.35169163,Lat\t8.45579576,Lon\t"
      "556.556,Ellh\t0.012, 0.011, 0.025\t50,Q\n";
  CheckTableAlone("100_0001_Timestamp.MRK", text);
  const FrameMeta meta = MetaOf(PosesFromFiles({{"a.MRK", text}}, Tagged()), "DJI_0001.JPG");
  CHECK(meta.altitude_datum == "ellipsoid");
  // Sunday, 26 May 2024, and 541804.521334 s, without 18 leap seconds.
  CHECK(meta.timestamp_us == 1717223386521334);
}

TEST_CASE("program tables: Litchi has no photographs, which is said") {
  CHECK(Read("litchi.csv",
             "latitude,longitude,altitude(feet),speed(mph),datetime(utc)\n47.351,8.4558,1821,12,"
             "2024-06-01 10:00:00\n",
             Tagged()) == "refused: the column image is needed");
  CheckTable("litchi.csv",
             "photo,latitude,longitude,altitude(feet),datetime(utc)\n"
             "DJI_0001.JPG,47.35100092,8.45579865,1823.717,2024-06-01 10:00:00\n"
             "DJI_0002.JPG,47.35134298,8.45580562,1822.297,2024-06-01 10:00:03\n"
             "DJI_0003.JPG,47.35169163,8.45579576,1825.971,2024-06-01 10:00:06\n");
}

TEST_CASE("program tables: senseFly, Trimble and others that write omega, phi, kappa by name") {
  const std::string text =
      "Image;Latitude;Longitude;Ellipsoidal height [m];Omega [deg];Phi [deg];Kappa [deg]\n"
      "DJI_0001.JPG;47.35100092;8.45579865;555.869;0;0;0\n"
      "DJI_0002.JPG;47.35134298;8.45580562;555.436;0;0;-90\n"
      "DJI_0003.JPG;47.35169163;8.45579576;556.556;0;10;0\n";
  CheckTableAlone("sensefly.csv", text);
  const PoseFile file = PosesFromFiles({{"sensefly.csv", text}}, Tagged());
  CHECK(file.poses[0].second.altitude_datum == "ellipsoid");
  // The picture's top: north, and with kappa -90 east.
  CheckAxis(MetaOf(file, "DJI_0001.JPG"), {0, -1, 0}, {1, 0, 0});
  CheckAxis(MetaOf(file, "DJI_0001.JPG"), {0, 0, 1}, {0, 0, 1});
  CheckAxis(MetaOf(file, "DJI_0002.JPG"), {0, -1, 0}, {0, 1, 0});
  // Phi turns about north: the picture's back leans to the east, the axis to the west.
  CheckAxis(MetaOf(file, "DJI_0003.JPG"), {0, 0, 1}, {0, -0.1736481777, 0.9848077530});
  CheckTableAlone("trimble.csv",
                  "EPSG:32632\nImage,Easting,Northing,Elevation,Omega,Phi,Kappa\n"
                  "DJI_0001.JPG,458898.56,5244314.340,555.869,0,0,0\n"
                  "DJI_0002.JPG,458899.352,5244352.351,555.436,0,0,0\n"
                  "DJI_0003.JPG,458898.878,5244391.102,556.556,0,0,0\n");
}

TEST_CASE("program tables: OpenDroneMap's geo.txt, with remarks and without heights") {
  CheckTableAlone("geo.txt",
                  "# PPK 2024-06-01\nEPSG:4326\nDJI_0001.JPG 8.45579865 47.35100092 555.869\n"
                  "DJI_0002.JPG 8.45580562 47.35134298 555.436\n"
                  "DJI_0003.JPG 8.45579576 47.35169163 556.556\n");
  const std::string flat =
      "EPSG:4326\nDJI_0001.JPG 8.45579865 47.35100092\nDJI_0002.JPG 8.45580562 47.35134298\n"
      "DJI_0003.JPG 8.45579576 47.35169163\n";
  CheckTable("geo.txt", flat);
  CHECK(PosesFromFiles({{"geo.txt", flat}}, Tagged()).poses[0].second.altitude_datum == "amsl");
  CHECK(Warns(PosesFromFiles({{"geo.txt", flat}}, Tagged()), "there is no altitude"));
  CHECK(Read("geo.txt", flat, Untagged()).find("altitude") != std::string::npos);
  // ETRS89, and a name with blanks.
  CheckTableAlone("geo.txt",
                  "EPSG:25832\nDJI_0001.JPG 458898.56 5244314.340 555.869\n"
                  "DJI_0002.JPG 458899.352 5244352.351 555.436\n"
                  "DJI_0003.JPG 458898.878 5244391.102 556.556\n");
}

TEST_CASE("program tables: UgCS, ContextCapture, Emlid") {
  CheckTableAlone("ugcs.csv",
                  "ImageName\tLatitude\tLongitude\tAltitude AMSL\n"
                  "DJI_0001.JPG\t47.35100092\t8.45579865\t555.869\n"
                  "DJI_0002.JPG\t47.35134298\t8.45580562\t555.436\n"
                  "DJI_0003.JPG\t47.35169163\t8.45579576\t556.556\n");
  CheckTableAlone("context.txt",
                  "Photo Name;Longitude;Latitude;Height;Yaw;Pitch;Roll\n"
                  "DJI_0001.JPG;8.45579865;47.35100092;555.869;10;-90;0\n"
                  "DJI_0002.JPG;8.45580562;47.35134298;555.436;10;-90;0\n"
                  "DJI_0003.JPG;8.45579576;47.35169163;556.556;10;-90;0\n");
  CheckTableAlone("emlid.csv",
                  "\"Photo name\",\"Longitude\",\"Latitude\",\"Ellipsoidal height\"\n"
                  "\"DJI_0001.JPG\",\"8.45579865\",\"47.35100092\",\"555.869\"\n"
                  "\"DJI_0002.JPG\",\"8.45580562\",\"47.35134298\",\"555.436\"\n"
                  "\"DJI_0003.JPG\",\"8.45579576\",\"47.35169163\",\"556.556\"\n");
}

// --- What people do to tables -------------------------------------------------------------------

TEST_CASE("tables of people: encodings, separators, decimal commas, blanks, quotes") {
  CheckTableAlone("a.csv", Utf16(kPlain, true, "\xFF\xFE"));
  CheckTableAlone("b.csv", Utf16(kPlain, false, "\xFE\xFF"));
  CheckTableAlone("c.csv", Utf16(kPlain, true, ""));
  CheckTableAlone("d.csv",
                  "image;lat;lon;alt\nDJI_0001.JPG;47,35100092;8,45579865;555,869\n"
                  "DJI_0002.JPG;47,35134298;8,45580562;555,436\n"
                  "DJI_0003.JPG;47,35169163;8,45579576;556,556\n" +
                      std::string());
  CheckTableAlone("e.csv",
                  "lat, lon, alt, image\n47.35100092, 8.45579865, 555.869, DJI_0001.JPG\n"
                  "47.35134298, 8.45580562, 555.436, DJI_0002.JPG\n"
                  "47.35169163, 8.45579576, 556.556, DJI_0003.JPG\n");
  CheckTableAlone("f.csv",
                  "sep=;\nimage;latitude;longitude;altitude\n"
                  "DJI_0001.JPG;47.35100092;8.45579865;555.869\n"
                  "DJI_0002.JPG;47.35134298;8.45580562;555.436\n"
                  "DJI_0003.JPG;47.35169163;8.45579576;556.556\n");
  std::string mac = kPlain;
  std::replace(mac.begin(), mac.end(), '\n', '\r');
  CheckTableAlone("g.csv", mac);
}

TEST_CASE("tables of people: units in headers and in cells") {
  CheckTableAlone("feet.csv",
                  "image,lat,lon,Altitude [ft]\nDJI_0001.JPG,47.35100092,8.45579865,1823.717\n"
                  "DJI_0002.JPG,47.35134298,8.45580562,1822.297\n"
                  "DJI_0003.JPG,47.35169163,8.45579576,\"1,825.971\"\n");
  CheckTableAlone("cells.csv",
                  "image,lat,lon,alt\nDJI_0001.JPG,47.35100092 N,8.45579865 E,555.869 m\n"
                  "DJI_0002.JPG,N47.35134298,E8.45580562,1822.297 ft\n"
                  "DJI_0003.JPG,47\xC2\xB0"
                  "21'6.0899\"N,8\xB0"
                  "27'20.8647\"E,556.556m\n");
  // Nobody knows what it is, so it is not used.
  CHECK(Warns(
      PosesFromFiles({{"yards.csv", "image,lat,lon,alt (yd)\nDJI_0001.JPG,47.351,8.4558,607\n"}},
                     Tagged()),
      "unknown unit"));
}

TEST_CASE("tables of people: a bad line is told, and the others are taken") {
  const auto read = [](const std::string& lines) {
    return PosesFromFiles({{"p.csv", "image,lat,lon,alt,agl_m\n" + lines}}, Tagged());
  };
  const PoseFile ground =
      read("DJI_0001.JPG,47.35100092,8.45579865,555.869,0\nDJI_0002.JPG,47.351,8.4558,555.4,98\n");
  REQUIRE(ground.poses.size() == 2);
  CHECK_FALSE(ground.poses[0].second.height_above_ground_m);
  CHECK(ground.poses[1].second.height_above_ground_m == 98.0);
  CHECK(Warns(ground, "p.csv line 2: \"agl_m\""));
  const PoseFile bad = read(
      "DJI_0001.JPG,47.351,8.4558,555,98\nDJI_0002.JPG,n/a,8.4558,555,98\n"
      "DJI_0003.JPG,47.351,8.4558,555,98,7\n");
  CHECK(bad.poses.size() == 1);
  CHECK(Warns(bad, "p.csv line 3: \"lat\" must be a latitude in degrees: the line is left out"));
  CHECK(Warns(bad, "p.csv line 4: more cells than the header"));
  const PoseFile twice = read(
      "DJI_0001.JPG,47.351,8.4558,555,98\nDJI_0001.JPG,47.351,8.4558,555,98\n"
      "DJI_0002.JPG,47.351,8.4558,555,98\nDJI_0002.JPG,47.352,8.4558,555,98\n");
  CHECK(twice.poses.size() == 1);
  CHECK(Warns(twice, "DJI_0001.JPG: the first is used"));
  CHECK(Warns(twice, "DJI_0002.JPG: none is used"));
  const PoseFile quote = read("\"DJI_0001.JPG,47.351,8.4558,555,98\nDJI_0002.JPG,47.3,8.4,5,98\n");
  CHECK(quote.poses.size() >= 1);
}

TEST_CASE("tables of people: x and y in either order, longitudes to 360, names with blanks") {
  CheckTable("xy.csv",
             "image,x,y,z\nDJI_0001.JPG,47.35100092,8.45579865,555.869\n"
             "DJI_0002.JPG,47.35134298,8.45580562,555.436\n"
             "DJI_0003.JPG,47.35169163,8.45579576,556.556\n");
  const PoseFile west =
      PosesFromFiles({{"w.csv", "image,lat,lon,alt\na.jpg,54.5,357.24,345\n"}}, {});
  CHECK(west.poses.at(0).second.position->longitude_deg == doctest::Approx(-2.76));
  const PoseFile blanks = PosesFromFiles(
      {{"geo.txt", "EPSG:4326\nmy photo 1.jpg 8.4558 47.351 555\nmy photo 2.jpg 8.4 47.3 555\n"}},
      {});
  REQUIRE(blanks.poses.size() == 2);
  CHECK(blanks.poses[0].first == "my_photo_1.jpg");
}

TEST_CASE("tables of people: angles nobody measured, and those of another convention") {
  const auto read = [](const std::string& angles) {
    std::string text = "image,lat,lon,alt,yaw,pitch,roll\n";
    for (const Photograph& each : kFlown)
      text += std::string(each.id) + ",47.3,8.4,555," + angles + "\n";
    return PosesFromFiles({{"p.csv", text}}, {});
  };
  CHECK_FALSE(read("0,0,0").poses.at(0).second.ned_from_body);
  CHECK(Warns(read("0,0,0"), "taken as not known"));
  const PoseFile gimbal = read("90,-90,0");
  CheckAxis(gimbal.poses.at(0).second, {0, 0, 1}, {0, 0, 1});
  CheckAxis(gimbal.poses.at(0).second, {0, -1, 0}, {0, 1, 0});
  CHECK(Warns(gimbal, "gimbal"));
  const PoseFile kappa = PosesFromFiles(
      {{"geo.txt",
        "EPSG:4326\na.jpg 8 47 500 1.5 -0.8 38 0.02 0.05\nb.jpg 8 47 500 1.5 -0.8 38 0.02 0.05\n"}},
      {});
  CHECK_FALSE(kappa.poses.at(0).second.ned_from_camera);
  CHECK(Warns(kappa, "CameraAnglesIgnored"));
}

}  // namespace
}  // namespace freelsd
