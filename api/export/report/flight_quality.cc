#include <algorithm>
#include <cmath>

#include "api/export/report/figures.h"
#include "api/export/report/flight_parts.h"
#include "api/export/report/page.h"
#include "api/export/text.h"

namespace freelsd {
namespace {

// Ids that are written out for one reason.
constexpr size_t kMaxNumIds = 6;

std::string Deviation(double deviation, const char* unit) {
  return std::isfinite(deviation) ? FixedText(deviation, 2) + unit : "unknown";
}

std::string Percent(int64_t part, int64_t whole) {
  if (whole == 0) return "unknown";
  // Rounded down: a map with a hole is never seen to 100 %.
  return std::to_string(100 * part / whole) + " %";
}

std::string Hectares(int64_t num_cells, double cell_size_m) {
  constexpr double kSquareMetres = 10000.0;
  return FixedText(static_cast<double>(num_cells) * cell_size_m * cell_size_m / kSquareMetres, 2) +
         " ha";
}

std::string AdjustmentRows(const BlockQuality& quality) {
  if (quality.num_views == 0) return Row("Adjustment of the photographs", "unknown");
  const std::string note = quality.note.empty() ? "" : Row("Remark", EscapeXml(quality.note));
  return Row("Photographs connected",
             std::to_string(quality.num_connected_views) + " of " +
                 std::to_string(quality.num_views)) +
         Row("Reprojection error, before adjustment", FixedText(quality.rms_before_px, 2) + " px") +
         Row("Reprojection error, after adjustment", FixedText(quality.rms_after_px, 2) + " px") +
         Row("Landmarks", std::to_string(quality.num_landmarks)) + note;
}

std::string GroundRows(const ReportedMap& map) {
  const Eigen::Vector2d size = map.ground.box.max_in_world - map.ground.box.min_in_world;
  const CellCounts& cells = map.cells;
  return Row("Standard deviation of the position", Deviation(map.position_sd_m, " m")) +
         Row("Standard deviation of the tilt", Deviation(map.tilt_sd_deg, "&#176;")) +
         Row("Size of the map, east by north",
             FixedText(size.x(), 0) + " x " + FixedText(size.y(), 0) + " m") +
         Row("Cells of the map", FixedText(map.cell_size_m, 2) + " m") +
         Row("Ground sampling of the picture",
             map.photo_pixel_size_m ? FixedText(100.0 * *map.photo_pixel_size_m, 1) + " cm"
                                    : "no picture") +
         Row("Seen ground",
             Hectares(cells.num_seen, map.cell_size_m) + ", " +
                 Percent(cells.num_seen, cells.num_cells) + " of the map's rectangle") +
         Row("Ground free of hazard",
             Hectares(cells.num_free, map.cell_size_m) + ", " +
                 Percent(cells.num_free, cells.num_seen) + " of the seen ground");
}

std::string MapQuality(const ReportedMap& map, size_t number, size_t num_maps) {
  const std::string title =
      num_maps > 1 ? "<h3>Map " + std::to_string(number) + "</h3>\n" : std::string();
  return "<article class=\"quality\">\n" + title + "<div class=\"pair\">\n" +
         Table(AdjustmentRows(map.quality) + GroundRows(map)) + CoverageFigure(map) +
         "</div>\n</article>\n";
}

std::string Items(const std::vector<std::string>& items) {
  std::string text;
  for (const std::string& item : items) text += "<li>" + item + "</li>\n";
  return "<ul>\n" + text + "</ul>\n";
}

std::string Ids(const std::vector<std::string>& ids) {
  std::string text;
  const size_t num_written = std::min(ids.size(), kMaxNumIds);
  for (size_t i = 0; i < num_written; ++i) text += (i == 0 ? "" : ", ") + EscapeXml(ids[i]);
  const size_t num_more = ids.size() - num_written;
  return num_more == 0 ? text : text + " and " + std::to_string(num_more) + " more";
}

std::string Groups(const std::string& title,
                   const std::string& one,
                   const std::vector<LeftOutGroup>& groups) {
  if (groups.empty()) return "";
  std::vector<std::string> items;
  items.reserve(groups.size());
  for (const LeftOutGroup& group : groups) {
    items.push_back("<b>" + CountText(static_cast<int64_t>(group.ids.size()), one) +
                    "</b>: " + EscapeXml(group.reason) + " (" + Ids(group.ids) + ")");
  }
  return "<h3>" + title + "</h3>\n" + Items(items);
}

// Within the flight: "r7" of "f-12-r7".
std::string ShortId(const std::string& site_id, const std::string& flight_id) {
  const bool is_of_flight = site_id.starts_with(flight_id + "-");
  return EscapeXml(is_of_flight ? site_id.substr(flight_id.size() + 1) : site_id);
}

std::string RejectedSites(const FlightReport& report) {
  if (report.rejected_sites.empty()) return "";
  std::vector<std::vector<std::string>> rows;
  for (const StoredSite& site : report.rejected_sites) {
    rows.push_back({ShortId(site.id, report.flight_id),
                    PlaceText(site.touchdown),
                    EscapeXml(site.summary.value_or(site.reject_reason.value_or("unknown")))});
  }
  return "<h3>Regions rejected</h3>\n" + ColumnTable({"region", "least bad place", "why"}, rows);
}

std::string SupersededSites(const FlightReport& report) {
  if (report.superseded_sites.empty()) return "";
  std::vector<std::vector<std::string>> rows;
  for (const ReportedSupersededSite& each : report.superseded_sites) {
    rows.push_back({ShortId(each.site.id, report.flight_id),
                    EscapeXml(each.superseded_by),
                    TimeText(each.superseded_at),
                    EscapeXml(each.detail)});
  }
  return "<h3>Sites superseded by later flights</h3>\n" +
         ColumnTable({"site", "superseded by", "photographed", "why"}, rows);
}

}  // namespace

std::string CountText(int64_t count, const std::string& one) {
  return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
}

std::string QualitySection(const FlightReport& report) {
  std::string text = "<section>\n<h2>Quality of the map</h2>\n";
  if (report.maps.empty()) text += "<p>The flight has no map.</p>\n";
  for (size_t i = 0; i < report.maps.size(); ++i) {
    text += MapQuality(report.maps[i], i + 1, report.maps.size());
  }
  if (!report.warnings.empty()) {
    std::vector<std::string> warnings;
    for (const std::string& warning : report.warnings) warnings.push_back(EscapeXml(warning));
    text += "<h3>Warnings of the flight</h3>\n" + Items(warnings);
  }
  return text + "</section>\n";
}

std::string LeftOutSection(const FlightReport& report) {
  const std::string content =
      Groups("Photographs", "photograph", report.photographs_left_out) + RejectedSites(report) +
      Groups("Regions not examined", "region", report.regions_left_out) + SupersededSites(report);
  return "<section>\n<h2>What was left out, and why</h2>\n" +
         (content.empty() ? "<p>Nothing.</p>\n" : content) + "</section>\n";
}

}  // namespace freelsd
