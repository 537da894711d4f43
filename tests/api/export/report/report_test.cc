#include "api/export/report/report.h"

#include <doctest/doctest.h>

#include "tests/api/export/layers/hill_map.h"
#include "tests/api/export/sites/sites.h"

namespace freelsd {
namespace {

TEST_CASE("report: asks nothing of the network, states the verdict and draws map and profile") {
  const KnownSite site = MakeSite({.verdict = Verdict::kUnverified});
  const std::string page = SiteReport(site.stored, HillMap(), LocalFrame({47.4, 8.55, 450.0}));
  for (const char* const word : {"://", "<script", "<link", "@import", "url("}) {
    CHECK(page.find(word) == std::string::npos);
  }
  CHECK(page.find("data:image/png;base64,iVBOR") != std::string::npos);
  CHECK(page.find("verdict unverified") != std::string::npos);
  CHECK(page.find("Profile of the final") != std::string::npos);
  CHECK(page.find("class=\"unseen\"") != std::string::npos);
  const std::string rejected = SiteReport(
      MakeSite({.verdict = Verdict::kRejected}).stored, SiteMap(), LocalFrame({47.4, 8.55, 450.0}));
  CHECK(rejected.find("&lt;tree&gt; &amp;") != std::string::npos);
  CHECK(rejected.find("<tree>") == std::string::npos);
}

TEST_CASE("report: what is unknown is called unknown") {
  KnownSite site = MakeSite({});
  site.stored.wind.reset();
  site.stored.slope_deg.reset();
  site.stored.final_places.reset();
  const std::string page = SiteReport(site.stored, SiteMap(), LocalFrame({47.4, 8.55, 450.0}));
  CHECK(page.find("<th scope=\"row\">Wind</th><td>unknown</td>") != std::string::npos);
  CHECK(page.find("<th scope=\"row\">Slope</th><td>unknown</td>") != std::string::npos);
  CHECK(page.find("<th scope=\"row\">Approach</th><td>none</td>") != std::string::npos);
}

}  // namespace
}  // namespace freelsd
