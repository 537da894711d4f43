// One site in every format is one place, one heading, one circle; read back by other readers.
#include <cmath>
#include <map>
#include <sstream>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/api/export/hill_map.h"
#include "tests/api/export/readers.h"
#include "tests/api/export/sites.h"

namespace freelsd {
namespace {

constexpr double kMaxPlaceErrorM = 0.05;
constexpr double kMaxAltitudeErrorM = 0.05;
constexpr double kMaxHeadingErrorDeg = 0.1;
constexpr double kMaxGlideSlopeErrorDeg = 0.05;
// QGroundControl measures on a sphere: 0.6 % off at the equator, northwards.
constexpr double kMaxSphereErrorRatio = 0.006;
// Half a thousandth of a minute, both ways.
constexpr double kMaxCupErrorM = 1.32;
constexpr int kNumSites = 200;

double Number(const std::string& text) { return std::stod(text); }

// The places' altitudes are compared, too.
void CheckPlace(const GeoPoint& place, const GeoPoint& truth) {
  CHECK(MetresBetween(place, truth) < kMaxPlaceErrorM);
  CHECK(std::abs(place.altitude_m - truth.altitude_m) < kMaxAltitudeErrorM);
}

std::string Export(const std::string& format, const KnownSite& site) {
  return ExportSites(format, {site.stored}, {});
}

// All sites, with ids of their own.
std::vector<KnownSite> ManySites() {
  std::vector<KnownSite> sites;
  for (int i = 0; i < kNumSites; ++i) {
    KnownSiteOptions options = SomewhereOnEarth(i);
    options.region_id = i;
    sites.push_back(MakeSite(options));
  }
  return sites;
}

std::vector<StoredSite> StoredOf(const std::vector<KnownSite>& sites) {
  std::vector<StoredSite> stored;
  for (const KnownSite& site : sites) stored.push_back(site.stored);
  return stored;
}

// Geometry by GDAL as GeoJSON, by the feature's name (or id).
std::map<std::string, nlohmann::json> ReadByGdal(const std::string& path,
                                                 const std::string& options,
                                                 const std::string& key) {
  const auto output = OutputOf("ogr2ogr -f GeoJSONSeq /vsistdout/ -lco COORDINATE_PRECISION=10 " +
                               options + " " + path);
  REQUIRE(output.has_value());
  std::map<std::string, nlohmann::json> features;
  std::istringstream lines(*output);
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json feature = nlohmann::json::parse(line);
    // GDAL takes a property "id" that equals the feature's own id for the latter.
    const nlohmann::json& name =
        feature["properties"].contains(key) ? feature["properties"] : feature;
    features[name.at(key)] = feature;
  }
  return features;
}

GeoPoint PlaceOf(const nlohmann::json& position) {
  return {position.at(1), position.at(0), position.at(2)};
}

TEST_CASE("plan: QGroundControl finds our touchdown, heading, distance and glide slope") {
  double worst_heading_deg = 0.0, worst_distance_ratio = 0.0, worst_radius_ratio = 0.0;
  for (const KnownSite& site : ManySites()) {
    const LandingPattern pattern = ReadPlan(Export("plan", site));
    CheckPlace(pattern.land, site.touchdown);
    CHECK(MetresBetween(pattern.loiter_center, site.loiter_center) < kMaxPlaceErrorM);
    CHECK(pattern.is_clockwise == site.is_right_turn);
    const double heading_error_deg = DegreesBetween(pattern.heading_deg, site.heading_deg);
    CHECK(heading_error_deg < kMaxHeadingErrorDeg);
    const double height_m = site.start.altitude_m - site.touchdown.altitude_m;
    const double slope_deg = DegFromRad(std::atan2(height_m, site.distance_m));
    CHECK(std::abs(pattern.glide_slope_deg - slope_deg) < kMaxGlideSlopeErrorDeg);
    worst_heading_deg = std::max(worst_heading_deg, heading_error_deg);
    worst_distance_ratio =
        std::max(worst_distance_ratio, std::abs(pattern.distance_m / site.distance_m - 1.0));
    worst_radius_ratio = std::max(worst_radius_ratio,
                                  std::abs(pattern.loiter_radius_m / site.loiter_radius_m - 1.0));
  }
  CHECK(worst_distance_ratio < kMaxSphereErrorRatio * 2.0);
  CHECK(worst_radius_ratio < kMaxSphereErrorRatio * 2.0);
  MESSAGE("plan: heading within " << worst_heading_deg << " deg, distance within "
                                  << 100.0 * worst_distance_ratio << " %, radius within "
                                  << 100.0 * worst_radius_ratio << " %");
}

TEST_CASE("plan: in the middle latitudes of the paper's flights the distance is within 0.5 m") {
  constexpr double kMaxDistanceErrorM = 0.5;
  for (int i = 0; i < 36; ++i) {
    KnownSiteOptions options;
    options.heading = RadFromDeg(10.0 * i);
    options.direction = i % 2 == 0 ? LoiterDirection::kLeft : LoiterDirection::kRight;
    const KnownSite site = MakeSite(options);
    const LandingPattern pattern = ReadPlan(Export("plan", site));
    CHECK(std::abs(pattern.distance_m - site.distance_m) < kMaxDistanceErrorM);
    CHECK(DegreesBetween(pattern.heading_deg, site.heading_deg) < kMaxHeadingErrorDeg);
  }
}

TEST_CASE("waypoints: land start, circle on the right side, landing, in the right order") {
  for (const KnownSite& site : ManySites()) {
    const std::string text = Export("waypoints", site);
    const auto rows = SplitRows(text, '\t');
    REQUIRE(rows.size() == 5);
    REQUIRE(rows[0][0] == "QGC WPL 110");
    const std::vector<std::string> commands{"16", "189", "31", "21"};
    for (size_t i = 0; i < commands.size(); ++i) {
      REQUIRE(rows[i + 1].size() == 12);
      CHECK(rows[i + 1][0] == std::to_string(i));
      CHECK(rows[i + 1][2] == "0");  // above mean sea level, as the site
      CHECK(rows[i + 1][3] == commands[i]);
    }
    const auto place = [&rows](size_t row) -> GeoPoint {
      return {Number(rows[row][8]), Number(rows[row][9]), Number(rows[row][10])};
    };
    CheckPlace(place(4), site.touchdown);
    CHECK(MetresBetween(place(3), site.loiter_center) < kMaxPlaceErrorM);
    CHECK(std::abs(place(3).altitude_m - site.start.altitude_m) < kMaxAltitudeErrorM);
    const double radius_m = Number(rows[3][5]) * (site.is_right_turn ? 1.0 : -1.0);
    CHECK(std::abs(radius_m - site.loiter_radius_m) < kMaxPlaceErrorM);
  }
}

TEST_CASE("rally: ArduPilot's land direction is the heading, altitudes are above home") {
  for (const KnownSite& site : ManySites()) {
    const double home_m = site.touchdown.altitude_m - 30.0;
    const auto lines = SplitRows(ExportSites("rally", {site.stored}, {home_m}), '\n');
    REQUIRE(lines.size() == 3);
    const auto cells = SplitRows(lines[2][0].substr(6), '\t')[0];
    REQUIRE(cells.size() == 6);
    CHECK(MetresBetween({Number(cells[0]), Number(cells[1]), 0.0}, site.touchdown) <
          kMaxPlaceErrorM);
    CHECK(Number(cells[2]) == doctest::Approx(130.0).epsilon(1e-4));
    CHECK(std::abs(Number(cells[3]) - (site.start.altitude_m - home_m)) < kMaxAltitudeErrorM);
    CHECK(DegreesBetween(Number(cells[4]), site.heading_deg) < kMaxHeadingErrorDeg);
  }
}

TEST_CASE("rally: the plan has the same points above home, and none without home") {
  const KnownSite site = MakeSite({});
  CHECK(nlohmann::json::parse(Export("plan", site))["rallyPoints"]["points"].empty());
  const nlohmann::json plan = nlohmann::json::parse(ExportSites("plan", {site.stored}, {400.0}));
  const nlohmann::json& point = plan["rallyPoints"]["points"].at(0);
  CHECK(MetresBetween({point[0], point[1], 0.0}, site.touchdown) < kMaxPlaceErrorM);
  CHECK(point[2].get<double>() == doctest::Approx(site.touchdown.altitude_m - 300.0));
}

TEST_CASE("cup: a landable within its thousandths of minutes, with direction and style") {
  for (const KnownSite& site : ManySites()) {
    const auto rows = SplitRows(Export("cup", site), ',');
    REQUIRE(rows.size() == 2);
    const std::vector<std::string>& cells = rows[1];
    REQUIRE(cells.size() == 11);
    REQUIRE(cells[3].size() == 9);
    REQUIRE(cells[4].size() == 10);
    const double latitude = (Number(cells[3].substr(0, 2)) + Number(cells[3].substr(2, 6)) / 60) *
                            (cells[3][8] == 'S' ? -1 : 1);
    const double longitude = (Number(cells[4].substr(0, 3)) + Number(cells[4].substr(3, 6)) / 60) *
                             (cells[4][9] == 'W' ? -1 : 1);
    CHECK(MetresBetween({latitude, longitude, 0.0}, site.touchdown) < kMaxCupErrorM);
    CHECK(std::abs(Number(cells[5]) - site.touchdown.altitude_m) <= 0.051);
    CHECK(cells[6] == "3");
    CHECK(DegreesBetween(Number(cells[7]), site.heading_deg) <= 0.51);
    CHECK(Number(cells[7]) >= 1.0);
  }
}

TEST_CASE("cup: each site of a region has a code of its own") {
  KnownSite site = MakeSite({.region_id = 7});
  CHECK(SplitRows(Export("cup", site), ',')[1][1] == "R7");
  nlohmann::json feature = nlohmann::json::parse(site.stored.feature_json);
  feature["properties"]["id"] = "f1-r7-f2";
  site.stored.feature_json = feature.dump();
  CHECK(SplitRows(Export("cup", site), ',')[1][1] == "R7F2");
}

TEST_CASE("cup: minutes never reach 60") {
  KnownSiteOptions options;
  options.origin = {46.9999999, 7.9999999, 450.0};
  options.touchdown_in_world = {0.0, 0.0, 0.0};
  const auto rows = SplitRows(Export("cup", MakeSite(options)), ',');
  CHECK(rows[1][3] == "4700.000N");
  CHECK(rows[1][4] == "00800.000E");
}

TEST_CASE("kml: GDAL reads touchdown, final and circle where they are") {
  if (!IsInstalled("ogr2ogr")) {
    MESSAGE("skipped: ogr2ogr (gdal-bin) is not installed");
    return;
  }
  const std::vector<KnownSite> sites = ManySites();
  // One after the other: to GDAL every folder is a layer.
  for (int i = 0; i < kNumSites; i += 20) {
    const TemporaryFile single("site.kml", ExportSites("kml", {sites[i].stored}, {}));
    const auto read = ReadByGdal(single.path(), "", "Name");
    const std::string id = "f1-r" + std::to_string(i);
    REQUIRE(read.size() == 3);
    CheckPlace(PlaceOf(read.at(id)["geometry"]["coordinates"]), sites[i].touchdown);
    const nlohmann::json& line = read.at(id + " approach")["geometry"]["coordinates"];
    CheckPlace(PlaceOf(line.at(0)), sites[i].start);
    CheckPlace(PlaceOf(line.at(1)), sites[i].touchdown);
    for (const nlohmann::json& position : read.at(id + " loiter")["geometry"]["coordinates"]) {
      const double radius_m = MetresInSpace(PlaceOf(position), sites[i].loiter_center);
      CHECK(std::abs(radius_m - sites[i].loiter_radius_m) < kMaxPlaceErrorM);
    }
  }
}

TEST_CASE("csv and geojson: GDAL reads the same touchdown and heading") {
  if (!IsInstalled("ogr2ogr")) {
    MESSAGE("skipped: ogr2ogr (gdal-bin) is not installed");
    return;
  }
  const std::vector<KnownSite> sites = ManySites();
  const TemporaryFile csv("sites.csv", ExportSites("csv", StoredOf(sites), {}));
  const auto rows = ReadByGdal(csv.path(),
                               "-oo X_POSSIBLE_NAMES=longitude_deg -oo "
                               "Y_POSSIBLE_NAMES=latitude_deg -oo Z_POSSIBLE_NAMES=altitude_m",
                               "id");
  nlohmann::json collection{{"type", "FeatureCollection"}, {"features", nlohmann::json::array()}};
  for (const KnownSite& site : sites) {
    collection["features"].push_back(nlohmann::json::parse(site.stored.feature_json));
  }
  const TemporaryFile geojson("sites.geojson", collection.dump());
  const auto features = ReadByGdal(geojson.path(), "", "id");
  REQUIRE(rows.size() == kNumSites);
  REQUIRE(features.size() == kNumSites);
  for (int i = 0; i < kNumSites; ++i) {
    const std::string id = "f1-r" + std::to_string(i);
    CheckPlace(PlaceOf(rows.at(id)["geometry"]["coordinates"]), sites[i].touchdown);
    CheckPlace(PlaceOf(features.at(id)["geometry"]["coordinates"]), sites[i].touchdown);
    const std::string heading = rows.at(id)["properties"]["heading_deg"];
    CHECK(DegreesBetween(Number(heading), sites[i].heading_deg) < kMaxHeadingErrorDeg);
    const nlohmann::json feature = nlohmann::json::parse(sites[i].stored.feature_json);
    const double told_deg = feature["properties"]["approach"]["heading_deg"];
    CHECK(DegreesBetween(told_deg, sites[i].heading_deg) < kMaxHeadingErrorDeg);
  }
}

TEST_CASE("kml keeps to its schema, the report is well-formed, whatever the sentences hold") {
  if (!IsInstalled("xmllint")) {
    MESSAGE("skipped: xmllint (libxml2-utils) is not installed");
    return;
  }
  const std::string by_schema =
      "xmllint --noout --schema " FREELSD_TEST_SOURCE_DIR "/tests/api/export/kml22_of_ours.xsd ";
  for (const Verdict verdict : {Verdict::kLandable, Verdict::kUnverified, Verdict::kRejected}) {
    KnownSiteOptions options;
    options.verdict = verdict;
    const KnownSite site = MakeSite(options);
    const TemporaryFile kml("site.kml", Export("kml", site));
    CHECK(OutputOf(by_schema + kml.path()).has_value());
    const TemporaryFile report("site.html",
                               SiteReport(site.stored, SiteMap(), LocalFrame(options.origin)));
    CHECK(OutputOf("xmllint --noout " + report.path()).has_value());
  }
}

// Corners as GDAL sees them, in the order of upper left, lower left, upper right, lower right.
std::vector<Eigen::Vector2d> CornersByGdal(const std::string& path) {
  const auto output = OutputOf("gdalinfo -json " + path);
  REQUIRE(output.has_value());
  const nlohmann::json corners = nlohmann::json::parse(*output)["cornerCoordinates"];
  std::vector<Eigen::Vector2d> places;
  for (const char* const name : {"upperLeft", "lowerLeft", "upperRight", "lowerRight"}) {
    places.emplace_back(corners[name][0], corners[name][1]);
  }
  return places;
}

TEST_CASE("world file: GDAL puts picture and GeoTIFF at the same place") {
  if (!IsInstalled("gdalinfo")) {
    MESSAGE("skipped: gdalinfo (gdal-bin) is not installed");
    return;
  }
  for (const GeoPoint& origin : {GeoPoint{47.4, 8.55, 450.0}, GeoPoint{-33.9, -70.7, 500.0}}) {
    const LocalFrame frame(origin);
    const SiteMap site_map = HillMap();
    const TemporaryFile png("layer.png", LayerPng(site_map, "slope"));
    const TemporaryFile world("layer.pgw", LayerWorldFile(site_map, frame));
    const TemporaryFile tif("layer.tif", LayerGeoTiff(site_map, "slope", frame));
    const auto from_png = CornersByGdal(png.path()), from_tif = CornersByGdal(tif.path());
    for (size_t i = 0; i < from_png.size(); ++i) {
      CHECK((from_png[i] - from_tif[i]).norm() < kMaxPlaceErrorM);
    }
  }
}

}  // namespace
}  // namespace freelsd
