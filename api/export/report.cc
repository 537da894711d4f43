// One page for people: no script, no other file, printable.
#include "api/export/report.h"

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

struct Field {
  const char* name;
  const char* label;
  const char* unit;
};

// Numbers of the site, by their names in GeoJSON.
constexpr Field kFields[] = {
    {"score", "Score", ""},
    {"area_m2", "Area of the field", "m&#178;"},
    {"hazard_distance_m", "Free around the touchdown", "m"},
    {"slope_deg", "Slope", "&#176;"},
    {"roughness_m", "Roughness", "m"},
    {"grade", "Grade (share of views seen as grass)", ""},
    {"num_observations", "Times seen", ""},
    {"unseen_ratio", "Unseen share of the circle", ""},
    {"updated_at", "Updated", ""},
};

std::string Row(const std::string& label, const std::string& value) {
  return "<tr><th scope=\"row\">" + label + "</th><td>" + value + "</td></tr>\n";
}

std::string Value(const nlohmann::json& value) {
  if (value.is_null()) return "unknown";
  return EscapeXml(value.is_string() ? value.get<std::string>() : value.dump());
}

std::string FinalRows(const SitePlaces& site) {
  if (!site.final_places) return Row("Approach", "none");
  const FinalPlaces& places = *site.final_places;
  return Row("Heading of the final", FixedText(places.heading_deg, 1) + "&#176; true") +
         Row("Length of the final", FixedText(places.distance_m, 1) + " m") +
         Row("Height at its start", FixedText(places.height_m, 1) + " m above touchdown") +
         Row("Circle before it",
             FixedText(places.loiter_radius_m, 1) + " m radius, " +
                 (places.is_right_turn ? "right" : "left") + " turn");
}

std::string WindRow(const SitePlaces& site) {
  const nlohmann::json wind = site.properties.value("wind", nlohmann::json());
  if (!wind.is_object()) return Row("Wind", "unknown");
  return Row("Wind, where the air moves to",
             Value(wind.value("east_mps", nlohmann::json())) + " m/s east, " +
                 Value(wind.value("north_mps", nlohmann::json())) + " m/s north");
}

std::string DatumSentence(const std::string& datum) {
  if (datum == "amsl") return "above mean sea level";
  return "datum \"" + EscapeXml(datum) + "\", not known to be above mean sea level";
}

std::string Numbers(const SitePlaces& site) {
  std::string rows = Row("Touchdown",
                         FixedText(site.touchdown.latitude_deg, 7) + ", " +
                             FixedText(site.touchdown.longitude_deg, 7)) +
                     Row("Altitude",
                         FixedText(site.touchdown.altitude_m, 1) + " m (" +
                             DatumSentence(site.altitude_datum) + ")") +
                     FinalRows(site) + WindRow(site);
  if (site.final_places && site.properties.value("approach", nlohmann::json()).is_object()) {
    const nlohmann::json clearance =
        site.properties["approach"].value("min_clearance_m", nlohmann::json());
    rows += Row("Least clearance", Value(clearance) + (clearance.is_null() ? "" : " m"));
  }
  for (const Field& field : kFields) {
    const nlohmann::json value = site.properties.value(field.name, nlohmann::json());
    rows += Row(field.label, Value(value) + (value.is_null() ? "" : " " + std::string(field.unit)));
  }
  return "<h2>Numbers</h2>\n<table>\n" + rows + "</table>\n";
}

std::string Rejections(const SitePlaces& site) {
  const nlohmann::json rejections = site.properties.value("rejections", nlohmann::json::array());
  if (rejections.empty()) return "";
  std::string items;
  for (const nlohmann::json& rejection : rejections) {
    items += "<li>" + EscapeXml(rejection.value("reason", "")) + ": " +
             EscapeXml(rejection.value("detail", "")) + "</li>\n";
  }
  return "<h2>Other touchdowns, and why not</h2>\n<ol>\n" + items + "</ol>\n";
}

std::string VerdictBox(const SitePlaces& site) {
  const std::string verdict = site.IsRejected() ? "rejected" : site.verdict;
  std::string text = "<p class=\"verdict " + verdict + "\">" + verdict + ". " +
                     EscapeXml(site.properties.value("summary", "")) + "</p>\n";
  const nlohmann::json warnings = site.properties.value("warnings", nlohmann::json::array());
  for (const nlohmann::json& warning : warnings) {
    if (warning.is_string()) text += "<p>" + EscapeXml(warning.get<std::string>()) + "</p>\n";
  }
  return text;
}

}  // namespace

std::string SiteReport(const StoredSite& stored,
                       const SiteMap& site_map,
                       const LocalFrame& local_frame) {
  const SitePlaces site = ReadSite(stored);
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
