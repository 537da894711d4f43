#include <algorithm>

#include <doctest/doctest.h>

#include "api/export/report/report.h"
#include "tests/api/export/sites/sites.h"

namespace freelsd {
namespace {

const std::string kNasty = "<script>alert('1 & \"2\"')</script>";

StoredSite SiteWith(Verdict verdict, int region_id, int64_t rank) {
  KnownSiteOptions options;
  options.verdict = verdict;
  options.region_id = region_id;
  // Each at a place of its own.
  options.touchdown_in_world.x() = 40.0 * region_id;
  StoredSite site = MakeSite(options).stored;
  site.rank = rank;
  return site;
}

WindRose RoseWith(const std::vector<Verdict>& verdicts) {
  WindRose rose{4, {0.0, 5.0}, {}};
  for (const Verdict verdict : verdicts) {
    Plan plan;
    plan.verdict = verdict;
    rose.plans.push_back(plan);
  }
  return rose;
}

FlightReport Report() {
  FlightReport report;
  report.flight_id = "f1";
  report.name = kNasty;
  report.first_photographed_at = "2026-05-01T10:00:00Z";
  report.last_photographed_at = "2026-05-01T10:20:00Z";
  report.wind = WindEstimate{{-3.0, 0.0}, 0.4, 5, 0};
  report.altitude_datum = "amsl";
  report.local_frame = LocalFrame({47.4, 8.55, 450.0});
  report.num_photographs = 31;
  ReportedMap map;
  map.ground.box = {{-100.0, -200.0}, {300.0, 100.0}};
  map.ground.photo_jpeg = "photograph";
  map.ground.hazard_png = "hazard";
  map.coverage_png = map.coverage_legend_png = "coverage";
  map.cells = {1000, 800, 200};
  map.quality = {2.5, 0.6, 30, 28, 4000, kNasty};
  map.position_sd_m = 0.4;
  map.photo_pixel_size_m = 0.05;
  report.maps = {map};
  const WindRose rose = RoseWith({Verdict::kRejected,
                                  Verdict::kRejected,
                                  Verdict::kRejected,
                                  Verdict::kRejected,
                                  Verdict::kLandable,
                                  Verdict::kUnverified,
                                  Verdict::kRejected,
                                  Verdict::kLandable});
  report.sites = {{SiteWith(Verdict::kLandable, 4, 1), map.ground, rose},
                  {SiteWith(Verdict::kUnverified, 2, 2), std::nullopt, std::nullopt}};
  report.further_sites = {SiteWith(Verdict::kUnverified, 3, 3)};
  report.rejected_sites = {SiteWith(Verdict::kRejected, 5, 4)};
  report.superseded_sites = {
      {SiteWith(Verdict::kLandable, 6, 1), "f9-r1", "2026-06-01T00:00:00Z", kNasty}};
  report.photographs_left_out = {{kNasty, {"a", "b", "c", "d", "e", "f", "g", "<h>"}}};
  report.regions_left_out = {{"never seen as grass", {"r7"}}};
  report.warnings = {kNasty};
  report.software_version = "1.2.3";
  report.written_at = "2026-07-01T00:00:00Z";
  return report;
}

// Whether each element ends where XML wants it, and each attribute is quoted.
bool IsWellFormed(const std::string& page) {
  std::vector<std::string> open;
  for (size_t at = page.find('<'); at != std::string::npos; at = page.find('<', at + 1)) {
    const size_t end = page.find('>', at);
    if (end == std::string::npos) return false;
    const std::string tag = page.substr(at + 1, end - at - 1);
    if (tag.starts_with("!DOCTYPE")) continue;
    if (std::count(tag.begin(), tag.end(), '"') % 2 != 0) return false;
    if (tag.find('<') != std::string::npos) return false;
    const std::string name = tag.substr(0, tag.find_first_of(" \n/", 1));
    if (tag.ends_with("/")) continue;
    if (!tag.starts_with("/")) {
      open.push_back(name);
    } else if (open.empty() || open.back() != tag.substr(1)) {
      return false;
    } else {
      open.pop_back();
    }
  }
  return open.empty();
}

// Each text stands after the one before it.
void CheckOrder(const std::string& page, const std::vector<std::string>& texts) {
  size_t position = 0;
  for (const std::string& text : texts) {
    CAPTURE(text);
    const size_t found = page.find(text, position);
    REQUIRE(found != std::string::npos);
    position = found;
  }
}

TEST_CASE("flight report: is well-formed, escapes every name and loads nothing") {
  const std::string page = FlightReportPage(Report());
  CHECK(IsWellFormed(page));
  CHECK(page.find("&lt;script&gt;") != std::string::npos);
  for (const char* const word : {"<script", "<h>", "://", "<link", "@import", "src=\"http"}) {
    CAPTURE(word);
    CHECK(page.find(word) == std::string::npos);
  }
}

TEST_CASE("flight report: sections are in order, sites by rank") {
  const std::string page = FlightReportPage(Report());
  CheckOrder(page,
             {"<h1>",
              "Of 4 evaluated places, 1 landable, 2 unverified and 1 rejected. 1 site superseded",
              "2026-05-01 10:00 UTC to 2026-05-01 10:20 UTC",
              "from 90&#176; true at 3.0 m/s, varying by 0.4 m/s",
              "above mean sea level",
              "<h2>Map of the flight",
              "data:image/jpeg;base64,",
              "data:image/png;base64,",
              "unseen",
              "<h2>Landing sites",
              "<td>3</td><td>unverified</td>",
              "The first 2 of them follow in full",
              "<h3>Site 1",
              "verdict landable",
              "f1-r4",
              "<h3>Site 2",
              "verdict unverified",
              "f1-r2",
              "<h2>Quality",
              "28 of 30",
              "2.50 px",
              "0.60 px",
              "0.40 m",
              "400 x 300 m",
              "5.0 cm",
              "80 %",
              "25 %",
              "<h2>What was left out",
              "8 photographs",
              "and 2 more",
              "<td>r5</td>",
              "never seen as grass",
              "f9-r1",
              "1.2.3",
              "2026-07-01 00:00 UTC"});
}

TEST_CASE("flight report: the rose shows each wind's verdict, the calm once") {
  const std::string page = FlightReportPage(Report());
  const auto num_cells = [&page](const std::string& verdict) {
    const std::string cell = "class=\"cell " + verdict + "\" d=\"M";
    size_t count = 0;
    for (size_t at = page.find(cell); at != std::string::npos; at = page.find(cell, at + 1)) {
      ++count;
    }
    // One of them is the legend's.
    return count - 1;
  };
  CHECK(num_cells("landable") == 2);
  CHECK(num_cells("unverified") == 1);
  CHECK(num_cells("rejected") == 1);
  CHECK(page.find("<circle class=\"cell rejected\"") != std::string::npos);
  CHECK(page.find("Of 5 winds, 2 allow a landing, 1 an unverified one") != std::string::npos);
}

TEST_CASE("flight report: equal reports give equal bytes") {
  CHECK(FlightReportPage(Report()) == FlightReportPage(Report()));
}

TEST_CASE("flight report: without a picture the hazard is drawn alone, and that is said") {
  FlightReport report = Report();
  report.maps.front().ground.photo_jpeg.clear();
  report.maps.front().photo_pixel_size_m.reset();
  report.sites.resize(1);
  report.sites.front().ground.reset();
  const std::string page = FlightReportPage(report);
  CHECK(IsWellFormed(page));
  CHECK(page.find("image/jpeg") == std::string::npos);
  CHECK(page.find("The map has no photograph of the ground") != std::string::npos);
}

TEST_CASE("flight report: a flight of which nothing is known is reported too") {
  FlightReport report;
  report.flight_id = "f2";
  const std::string page = FlightReportPage(report);
  CHECK(IsWellFormed(page));
  CheckOrder(page,
             {"<h1>f2</h1>",
              "No place of this flight was evaluated",
              "<th scope=\"row\">Photographed</th><td>unknown",
              "<th scope=\"row\">Wind</th><td>unknown",
              "The flight has no map",
              "No place of this flight is accepted",
              "Nothing."});
}

TEST_CASE("flight report: each map of a long flight is drawn with the sites on it") {
  FlightReport report = Report();
  ReportedMap far = report.maps.front();
  far.ground.box = {{5000.0, 5000.0}, {5100.0, 5100.0}};
  report.maps.push_back(far);
  const std::string page = FlightReportPage(report);
  CheckOrder(page, {"Map 1 of 2", "class=\"mark landable\"", "Map 2 of 2"});
  const size_t second = page.find("<svg role=\"img\" aria-label=\"Map 2 of 2");
  REQUIRE(second != std::string::npos);
  CHECK(page.substr(second, page.find("</svg>", second) - second).find("class=\"mark") ==
        std::string::npos);
}

TEST_CASE("flight report: a landing's picture is a square around touchdown, final and roll") {
  const StoredSite site = SiteWith(Verdict::kLandable, 1, 1);
  const LocalFrame frame({47.4, 8.55, 450.0});
  const WorldBox box = LandingBoxOf(site, frame);
  const Eigen::Vector2d size = box.max_in_world - box.min_in_world;
  CHECK(size.x() == doctest::Approx(size.y()));
  for (const GeoPoint& place : {site.touchdown, site.final_places->start}) {
    const Eigen::Vector2d in_world = frame.WorldFromGeo(place).head<2>();
    CHECK((in_world.array() > box.min_in_world.array()).all());
    CHECK((in_world.array() < box.max_in_world.array()).all());
  }
}

}  // namespace
}  // namespace freelsd
