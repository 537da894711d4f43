#include <algorithm>

#include "api/export/sites/site_export.h"

namespace freelsd {
namespace {

struct Writer {
  SiteFormat format;
  std::string (*write)(const std::vector<StoredSite>&, const ExportOptions&);
};

constexpr Writer kWriters[] = {
    {{"plan", "application/vnd.qgroundcontrol.plan+json", "plan"}, PlanFile},
    {{"waypoints", "text/vnd.qgroundcontrol.waypoints", "waypoints", false}, WaypointFile},
    {{"rally", "text/vnd.ardupilot.rally", "rally"}, RallyFile},
    {{"kml", "application/vnd.google-earth.kml+xml", "kml"}, KmlFile},
    {{"cup", "application/vnd.seeyou.cup", "cup"}, CupFile},
    {{"csv", "text/csv", "csv"}, CsvFile},
};

}  // namespace

std::vector<SiteFormat> SiteFormats() {
  std::vector<SiteFormat> formats;
  for (const Writer& writer : kWriters) formats.push_back(writer.format);
  return formats;
}

std::string ExportSites(const std::string& format,
                        const std::vector<StoredSite>& sites,
                        const ExportOptions& options) {
  for (const Writer& writer : kWriters) {
    if (format == writer.format.name) return writer.write(sites, options);
  }
  throw std::invalid_argument("format = " + format + ": no such format");
}

}  // namespace freelsd
