#include "api/export/report/report.h"
#include "tests/api/export/sites/agreement.h"

namespace freelsd {
namespace {

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
    REQUIRE(read.size() == 4);
    CheckPlace(PlaceOf(read.at(id)["geometry"]["coordinates"]), sites[i].touchdown);
    const nlohmann::json& line = read.at(id + " approach")["geometry"]["coordinates"];
    CheckPlace(PlaceOf(line.at(0)), sites[i].start);
    CheckPlace(PlaceOf(line.at(1)), sites[i].touchdown);
    const nlohmann::json& climb = read.at(id + " go-around")["geometry"]["coordinates"];
    const GeoPoint begin = PlaceOf(climb.at(0));
    CHECK(std::abs(MetresBetween(begin, sites[i].touchdown) - 40.0) < kMaxPlaceErrorM);
    CHECK(std::abs(MetresBetween(begin, PlaceOf(climb.at(1))) - 200.0) < 4.0 * kMaxPlaceErrorM);
    for (const nlohmann::json& position : read.at(id + " loiter")["geometry"]["coordinates"]) {
      const double radius_m = MetresInSpace(PlaceOf(position), sites[i].loiter_center);
      CHECK(std::abs(radius_m - sites[i].loiter_radius_m) < kMaxPlaceErrorM);
    }
  }
}

TEST_CASE("kml keeps to its schema, the report is well-formed, whatever the sentences hold") {
  if (!IsInstalled("xmllint")) {
    MESSAGE("skipped: xmllint (libxml2-utils) is not installed");
    return;
  }
  const std::string by_schema = "xmllint --noout --schema " FREELSD_TEST_SOURCE_DIR
                                "/tests/api/export/sites/kml22_of_ours.xsd ";
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

}  // namespace
}  // namespace freelsd
