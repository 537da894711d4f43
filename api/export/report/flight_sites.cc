#include <algorithm>

#include "api/export/report/figures.h"
#include "api/export/report/flight_parts.h"
#include "api/export/report/page.h"
#include "api/export/text.h"

namespace freelsd {
namespace {

// Sentences that hold for every site are told once, before the first one.
std::vector<std::string> CommonWarnings(const std::vector<ReportedSite>& sites) {
  std::vector<std::string> common;
  if (sites.size() < 2) return common;
  for (const std::string& warning : sites.front().site.warnings) {
    const bool is_common =
        std::all_of(sites.begin(), sites.end(), [&warning](const ReportedSite& site) {
          const std::vector<std::string>& warnings = site.site.warnings;
          return std::find(warnings.begin(), warnings.end(), warning) != warnings.end();
        });
    if (is_common) common.push_back(warning);
  }
  return common;
}

std::string Paragraphs(const std::vector<std::string>& sentences,
                       const std::vector<std::string>& without) {
  std::string text;
  for (const std::string& sentence : sentences) {
    if (std::find(without.begin(), without.end(), sentence) != without.end()) continue;
    text += "<p class=\"warning\">" + EscapeXml(sentence) + "</p>\n";
  }
  return text;
}

std::string ForEverySite(const std::vector<std::string>& warnings) {
  std::string text;
  for (const std::string& warning : warnings) {
    text += (text.empty() ? "For every site: " : "; ") + EscapeXml(warning);
  }
  return text.empty() ? "" : "<p class=\"warning\">" + text + ".</p>\n";
}

std::string RankText(const StoredSite& site) { return std::to_string(site.rank.value_or(0)); }

std::string SiteArticle(const ReportedSite& reported,
                        const std::vector<std::string>& common_warnings,
                        const LocalFrame& local_frame) {
  const StoredSite& site = reported.site;
  const std::string profile = ProfileFigure(site);
  const std::string rose =
      reported.rose ? RoseFigure(*reported.rose)
                    : "<p>The winds were not examined: the site has no map to plan on.</p>\n";
  return "<article class=\"site\">\n<h3>Site " + RankText(site) + "</h3>\n" + VerdictBox(site) +
         Paragraphs(site.warnings, common_warnings) + "<div class=\"pair\">\n" +
         CutOutFigure(reported, local_frame) + rose + "</div>\n" +
         (profile.empty() ? "" : "<h4>Profile of the final</h4>\n" + profile) +
         "<div class=\"columns\">\n" + Table(SiteRows(site)) + "</div>\n</article>\n";
}

std::string HeadingText(const StoredSite& site) {
  if (!site.final_places) return "none";
  return FixedText(site.final_places->heading_deg, 0) + "&#176;";
}

std::string NumberText(const std::optional<double>& number, int num_decimals, const char* unit) {
  return number ? FixedText(*number, num_decimals) + unit : "unknown";
}

std::vector<std::string> OverviewRow(const StoredSite& site) {
  return {RankText(site),
          VerdictOf(site),
          PlaceText(site.touchdown),
          HeadingText(site),
          StripText(site),
          NumberText(site.hazard_distance_m, 0, " m"),
          NumberText(site.score, 2, "")};
}

std::string Overview(const FlightReport& report) {
  std::vector<std::vector<std::string>> rows;
  for (const ReportedSite& site : report.sites) rows.push_back(OverviewRow(site.site));
  for (const StoredSite& site : report.further_sites) rows.push_back(OverviewRow(site));
  const std::string more = report.further_sites.empty()
                               ? ""
                               : "<p>The first " + std::to_string(report.sites.size()) +
                                     " of them follow in full.</p>\n";
  return ColumnTable({"site",
                      "verdict",
                      "touchdown",
                      "heading, true",
                      "usable strip",
                      "to hazard",
                      "score"},
                     rows) +
         more;
}

}  // namespace

std::string SitesSection(const FlightReport& report) {
  const std::string head = "<section class=\"sites\">\n<h2>Landing sites, best first</h2>\n";
  if (report.sites.empty()) {
    return head + "<p>No place of this flight is accepted as a landing site.</p>\n</section>\n";
  }
  const std::vector<std::string> common = CommonWarnings(report.sites);
  std::string text =
      head + "<div class=\"overview\">\n" + Overview(report) + ForEverySite(common) + "</div>\n";
  for (const ReportedSite& site : report.sites) {
    text += SiteArticle(site, common, report.local_frame);
  }
  return text + "</section>\n";
}

}  // namespace freelsd
