// The report is one printable page without scripts and without other files.
#include "api/export/report/report.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "api/export/layers/layers.h"
#include "api/export/report/figures.h"
#include "api/export/text.h"

namespace freelsd {
namespace {

constexpr char kStyle[] =
    "body{font:16px/1.4 sans-serif;max-width:60em;margin:1em auto;padding:0 1em;color:#111;"
    "background:#fff}h1{font-size:1.5em}.verdict{padding:.6em 1em;border:3px "
    "solid;font-weight:bold}"
    ".landable{border-color:#0072b2}.unverified{border-color:#e69f00}.rejected{border-color:#"
    "d55e00}"
    "table{border-collapse:collapse}th,td{text-align:left;padding:.2em .8em .2em "
    "0;border-bottom:1px "
    "solid #ccc}figure{margin:.5em 0;break-inside:avoid}.layers{display:grid;gap:1em;"
    "grid-template-columns:repeat(auto-fit,minmax(16em,1fr))}svg{width:100%;max-height:40em;"
    "background:#f4f4f4}figcaption img{display:block}image{image-rendering:pixelated}"
    "polyline,path{fill:none;vector-effect:non-scaling-stroke}.casing{stroke:#fff;stroke-width:5}"
    ".circle,.final{stroke:#000;stroke-width:2.5}.circle{stroke-dasharray:8 5}"
    ".final{stroke-dasharray:1 0}.terrain{stroke:#8c510a;stroke-width:2.5}"
    ".touchdown{fill:#000;stroke:#fff;stroke-width:2;vector-effect:non-scaling-stroke}"
    ".axis,.scale{stroke:#000;stroke-width:2}.unseen{fill:#ccc}";

std::string Row(const std::string& label, const std::string& value) {
  return "<tr><th scope=\"row\">" + label + "</th><td>" + value + "</td></tr>\n";
}

// JSON writes the shortest text that parses to the same number.
template <class Number>
std::string Value(const std::optional<Number>& number, const std::string& unit) {
  return number ? nlohmann::json(*number).dump() + unit : "unknown";
}

std::string NoReturnRow(const StoredSite& site) {
  if (site.IsRejected()) return "";
  if (!site.go_around) return Row("Point of no return", "no climb is known to clear");
  const long percent = std::lround(std::ceil(100.0 * site.go_around->unseen_ratio));
  return Row("Point of no return, with power",
             FixedText(std::ceil(site.go_around->no_return_distance_m), 0) +
                 " m before touchdown; " + std::to_string(percent) +
                 " % of the ground below the go-around is unseen");
}

std::string FinalRows(const StoredSite& site) {
  if (!site.final_places) return Row("Approach", "none");
  const FinalPlaces& places = *site.final_places;
  return NoReturnRow(site) +
         Row("Heading of the final", FixedText(places.heading_deg, 1) + "&#176; true") +
         Row("Length of the final", FixedText(places.distance_m, 1) + " m") +
         Row("Height of its start", FixedText(places.height_m, 1) + " m above touchdown") +
         Row("Loiter circle",
             FixedText(places.loiter_radius_m, 1) + " m radius, " +
                 (places.is_right_turn ? "right" : "left") + " turn");
}

std::string WindRow(const StoredSite& site) {
  if (!site.wind) return Row("Wind", "unknown");
  return Row("Wind, where the air moves towards",
             Value(site.wind->east_mps, "") + " m/s east, " + Value(site.wind->north_mps, "") +
                 " m/s north");
}

std::string DatumSentence(const std::string& datum) {
  if (datum == "amsl") return "above mean sea level";
  return "datum \"" + EscapeXml(datum) + "\", not known to be above mean sea level";
}

std::string StripRow(const StoredSite& site) {
  if (!site.usable_length_m || !site.usable_width_m) return Row("Usable strip", "unknown");
  return Row("Usable strip, along the final",
             FixedText(std::floor(*site.usable_length_m), 0) + " x " +
                 FixedText(std::floor(*site.usable_width_m), 0) + " m");
}

std::string ObstacleRow(const StoredClearance& approach) {
  if (!approach.obstacle_clearance_m || !approach.obstacle_distance_m) return "";
  return Row("Tightest obstacle",
             FixedText(*approach.obstacle_clearance_m, 1) + " m below the path, " +
                 FixedText(*approach.obstacle_distance_m, 0) + " m from touchdown");
}

// Each unit starts with its space. Numbers without unit have only the space.
std::string SurfaceRows(const StoredSite& site) {
  return Row("Score", Value(site.score, " ")) + StripRow(site) +
         Row("Touchdown to nearest hazard", Value(site.hazard_distance_m, " m")) +
         Row("Slope", Value(site.slope_deg, " &#176;")) +
         Row("Roughness", Value(site.roughness_m, " m")) +
         Row("Grade (share of views seen as grass)", Value(site.grade, " ")) +
         Row("Observations", Value(site.num_observations, " ")) +
         Row("Unseen share of the circle", Value(site.unseen_ratio, " ")) +
         Row("Ground photographed",
             site.last_seen_at && site.age_s
                 ? EscapeXml(*site.last_seen_at) + ", " + AgeText(*site.age_s) + " ago "
                 : "unknown") +
         Row("Evaluated", site.updated_at ? EscapeXml(*site.updated_at) + " " : "unknown");
}

std::string Numbers(const StoredSite& site) {
  std::string rows = Row("Site", EscapeXml(site.id)) +
                     Row("Touchdown",
                         FixedText(site.touchdown.latitude_deg, 7) + ", " +
                             FixedText(site.touchdown.longitude_deg, 7)) +
                     Row("Altitude",
                         FixedText(site.touchdown.altitude_m, 1) + " m (" +
                             DatumSentence(site.altitude_datum) + ")") +
                     FinalRows(site) + WindRow(site);
  if (site.final_places && site.approach) {
    rows += ObstacleRow(*site.approach);
  }
  rows += SurfaceRows(site);
  return "<h2>Numbers</h2>\n<table>\n" + rows + "</table>\n";
}

std::string Rejections(const StoredSite& site) {
  if (site.rejections.empty()) return "";
  std::string items;
  for (const StoredRejection& rejection : site.rejections) {
    items += "<li>" + EscapeXml(rejection.reason) + ": " + EscapeXml(rejection.detail) + "</li>\n";
  }
  return "<h2>Rejected touchdown points</h2>\n<ol>\n" + items + "</ol>\n";
}

std::string VerdictBox(const StoredSite& site) {
  const std::string verdict = site.IsRejected() ? "rejected" : site.verdict;
  std::string text = "<p class=\"verdict " + verdict + "\">" + verdict + ". " +
                     EscapeXml(site.summary.value_or("")) + "</p>\n";
  for (const std::string& warning : site.warnings) text += "<p>" + EscapeXml(warning) + "</p>\n";
  return text;
}

}  // namespace

std::string SiteReport(const StoredSite& site,
                       const SiteMap& site_map,
                       const LocalFrame& local_frame) {
  std::string layers;
  for (const std::string& layer : LayerNames()) {
    const bool has_map = site_map.map.grid.num_rows > 0;
    if (layer != "distance" && has_map) layers += MapFigure(site, site_map, local_frame, layer);
  }
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><title>" +
         EscapeXml(site.Name()) +
         "</title><meta name=\"viewport\" content=\"width=device-width\"/><style>" + kStyle +
         "</style></head><body>\n<h1>Landing site " + EscapeXml(site.Name()) + "</h1>\n" +
         VerdictBox(site) + MapFigure(site, site_map, local_frame, "distance") +
         ProfileFigure(site) + Numbers(site) + Rejections(site) +
         (layers.empty() ? "" : "<h2>Layers</h2>\n<div class=\"layers\">\n" + layers + "</div>\n") +
         "</body></html>\n";
}

}  // namespace freelsd
