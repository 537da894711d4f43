#include <set>

#include <doctest/doctest.h>

#include "tests/api/export/sites/sites.h"

namespace freelsd {
namespace {

TEST_CASE("formats: every listed one is written, any other is refused") {
  const KnownSite site = MakeSite({});
  std::set<std::string> extensions;
  for (const SiteFormat& format : SiteFormats()) {
    CHECK_FALSE(ExportSites(format.name, {site.stored}, {400.0}).empty());
    extensions.insert(format.extension);
  }
  CHECK(extensions.size() == 6);
  CHECK_THROWS_AS(ExportSites("gpx", {site.stored}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
