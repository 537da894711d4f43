// What must never be in a file that something flies to.
#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/api/export/sites/readers.h"
#include "tests/api/export/sites/sites.h"

namespace freelsd {
namespace {

const std::vector<std::string> kFlownFormats{"plan", "waypoints", "rally", "cup"};
const ExportOptions kWithHome{400.0};

KnownSite SiteOf(Verdict verdict, int region_id = 1, const std::string& datum = "amsl") {
  KnownSiteOptions options;
  options.verdict = verdict;
  options.region_id = region_id;
  options.altitude_datum = datum;
  return MakeSite(options);
}

std::string CodeOf(const std::string& format,
                   const std::vector<StoredSite>& sites,
                   const ExportOptions& options) {
  try {
    ExportSites(format, sites, options);
  } catch (const ApiError& error) {
    CHECK(error.http_status() == 409);
    return error.code();
  }
  return "";
}

TEST_CASE("export: a rejected site is in nothing that is flown to, though it has an approach") {
  const StoredSite rejected = SiteOf(Verdict::kRejected).stored;
  for (const std::string& format : kFlownFormats) {
    CHECK(CodeOf(format, {rejected}, kWithHome) == "SiteRejected");
    CHECK(CodeOf(format, {}, kWithHome) == "SiteRejected");
  }
}

TEST_CASE("export: of a flight the rejected ones are left out, wherever they rank") {
  const std::vector<StoredSite> sites{SiteOf(Verdict::kRejected, 7).stored,
                                      SiteOf(Verdict::kLandable, 8).stored,
                                      SiteOf(Verdict::kRejected, 9).stored};
  for (const std::string& format : kFlownFormats) {
    const std::string text = ExportSites(format, sites, kWithHome);
    CHECK(text == ExportSites(format, {sites[1]}, kWithHome));
    CHECK(text.find("r7") == std::string::npos);
  }
}

TEST_CASE("export: a verdict that nobody knows counts as rejected") {
  StoredSite site = SiteOf(Verdict::kLandable).stored;
  site.verdict = "probably";
  for (const std::string& format : kFlownFormats) {
    CHECK(CodeOf(format, {site}, kWithHome) == "SiteRejected");
  }
}

TEST_CASE("export: an unverified site is called so, a rejected one too where people look at it") {
  const StoredSite unverified = SiteOf(Verdict::kUnverified).stored;
  for (const char* const format : {"plan", "rally", "cup", "kml"}) {
    CHECK(ExportSites(format, {unverified}, kWithHome).find("f1-r1 UNVERIFIED") !=
          std::string::npos);
  }
  const StoredSite rejected = SiteOf(Verdict::kRejected).stored;
  CHECK(ExportSites("kml", {rejected}, {}).find("f1-r1 REJECTED") != std::string::npos);
  CHECK(ExportSites("csv", {rejected}, {}).find("rejected") != std::string::npos);
}

TEST_CASE("export: without a datum an autopilot's file needs home, then tells heights above it") {
  for (const char* const datum : {"unknown", "ellipsoid"}) {
    const KnownSite site = SiteOf(Verdict::kLandable, 1, datum);
    for (const char* const format : {"plan", "waypoints", "rally"}) {
      CHECK(CodeOf(format, {site.stored}, {}) == "AltitudeUnknown");
    }
    const std::string text = ExportSites("plan", {site.stored}, kWithHome);
    const nlohmann::json plan = nlohmann::json::parse(text);
    CHECK(plan["mission"]["items"][0]["altitudesAreRelative"] == true);
    CHECK(plan["mission"]["plannedHomePosition"][2].is_null());
    CHECK(ReadPlan(text).land.altitude_m ==
          doctest::Approx(site.touchdown.altitude_m - 400.0).epsilon(1e-4));
    const auto rows = SplitRows(ExportSites("waypoints", {site.stored}, kWithHome), '\t');
    CHECK(rows[4][2] == "3");
    CHECK(std::stod(rows[4][10]) ==
          doctest::Approx(site.touchdown.altitude_m - 400.0).epsilon(1e-4));
  }
  CHECK(CodeOf("rally", {SiteOf(Verdict::kLandable).stored}, {}) == "AltitudeUnknown");
}

TEST_CASE("export: without a datum elevations are left out or lie on the ground") {
  const StoredSite site = SiteOf(Verdict::kLandable, 1, "unknown").stored;
  const auto rows = SplitRows(ExportSites("cup", {site}, {}), ',');
  CHECK(rows[1][5].empty());
  CHECK(rows[1][10].find("datum unknown") != std::string::npos);
  const std::string kml = ExportSites("kml", {site}, {});
  CHECK(kml.find("absolute") == std::string::npos);
  CHECK(kml.find("clampToGround") != std::string::npos);
}

TEST_CASE("export: a name that a spreadsheet takes for a formula is text, numbers stay numbers") {
  StoredSite site = SiteOf(Verdict::kLandable).stored;
  site.rank = 1;
  for (const std::string name : {"=HYPERLINK(1)", "+1", "-1", "@x"}) {
    site.flight_name = name;
    CHECK(SplitRows(ExportSites("cup", {site}, {}), ',')[1][0] == "'" + name + " 1");
    site.summary = name;
    const std::string csv = ExportSites("csv", {site}, {});
    CHECK(csv.find(",\"'" + name + "\",") != std::string::npos);
  }
  site.touchdown = {-33.5, -70.25, -3.0};
  const auto rows = SplitRows(ExportSites("csv", {site}, {}), ',');
  CHECK(rows[1][1] == "-33.500000000");
  CHECK(rows[1][3] == "-3.000");
}

TEST_CASE("export: a site without approach has no autopilot's file") {
  StoredSite site = SiteOf(Verdict::kLandable).stored;
  site.final_places.reset();
  for (const char* const format : {"plan", "waypoints", "rally"}) {
    CHECK(CodeOf(format, {site}, kWithHome) == "NoApproach");
  }
  CHECK(SplitRows(ExportSites("cup", {site}, {}), ',')[1][7].empty());
  CHECK(ExportSites("csv", {site}, {}).find("f1-r1") != std::string::npos);
}

}  // namespace
}  // namespace freelsd
