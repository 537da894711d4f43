#include "api/export/report/report.h"

#include "api/export/layers/layers.h"
#include "api/export/report/figures.h"
#include "api/export/report/page.h"
#include "api/export/text.h"

namespace freelsd {
namespace {

std::string Warnings(const StoredSite& site) {
  std::string text;
  for (const std::string& warning : site.warnings) text += "<p>" + EscapeXml(warning) + "</p>\n";
  return text;
}

std::string ProfileSection(const StoredSite& site) {
  const std::string figure = ProfileFigure(site);
  return figure.empty() ? "" : "<h2>Profile of the final</h2>\n" + figure;
}

std::string Rejections(const StoredSite& site) {
  if (site.rejections.empty()) return "";
  std::string items;
  for (const StoredRejection& rejection : site.rejections) {
    items += "<li>" + EscapeXml(rejection.reason) + ": " + EscapeXml(rejection.detail) + "</li>\n";
  }
  return "<h2>Rejected touchdown points</h2>\n<ol>\n" + items + "</ol>\n";
}

std::string Layers(const StoredSite& site, const SiteMap& site_map, const LocalFrame& local_frame) {
  if (site_map.map.grid.num_rows == 0) return "";
  std::string figures;
  for (const std::string& layer : LayerNames()) {
    if (layer != "distance") figures += MapFigure(site, site_map, local_frame, layer);
  }
  return "<h2>Layers</h2>\n<div class=\"layers\">\n" + figures + "</div>\n";
}

}  // namespace

std::string SiteReport(const StoredSite& site,
                       const SiteMap& site_map,
                       const LocalFrame& local_frame) {
  return PageOf(site.Name(),
                "",
                "<h1>Landing site " + EscapeXml(site.Name()) + "</h1>\n" + VerdictBox(site) +
                    Warnings(site) + MapFigure(site, site_map, local_frame, "distance") +
                    ProfileSection(site) + "<h2>Numbers</h2>\n" + Table(SiteRows(site)) +
                    Rejections(site) + Layers(site, site_map, local_frame));
}

}  // namespace freelsd
