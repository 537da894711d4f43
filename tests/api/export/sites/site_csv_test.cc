#include "tests/api/export/sites/agreement.h"

namespace freelsd {
namespace {

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
    collection["features"].push_back(nlohmann::json::parse(site.feature_json));
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
    const nlohmann::json feature = nlohmann::json::parse(sites[i].feature_json);
    const double told_deg = feature["properties"]["approach"]["heading_deg"];
    CHECK(DegreesBetween(told_deg, sites[i].heading_deg) < kMaxHeadingErrorDeg);
  }
}

}  // namespace
}  // namespace freelsd
