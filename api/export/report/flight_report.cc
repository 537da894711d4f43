#include <algorithm>
#include <cmath>

#include "api/export/report/figures.h"
#include "api/export/report/flight_parts.h"
#include "api/export/report/page.h"
#include "api/export/report/report.h"
#include "api/export/text.h"

namespace freelsd {
namespace {

// For a screen, and for A4 and Letter: the paper's size is the printer's.
constexpr char kFlightStyle[] =
    "body{font:15px/1.45 'Helvetica Neue',Helvetica,Arial,sans-serif;max-width:58em;"
    "font-variant-numeric:tabular-nums}h1{font-size:1.9em;margin:.4em 0 .2em}"
    "h2{font-size:1.3em;border-top:2px solid #111;padding-top:.4em;margin:2em 0 .6em}"
    "h3{font-size:1.1em;margin:1.4em 0 .4em}h4{font-size:1em;margin:1em 0 .2em}"
    "p{margin:.5em 0}.result{font-size:1.15em}th{font-weight:normal;color:#444}"
    "td{font-variant-numeric:tabular-nums}thead th{font-weight:bold;color:#111}"
    ".wide{width:100%;font-size:.9em}.verdict{margin:.4em 0;padding:.5em .8em}"
    ".verdict.unverified{border-style:dashed}.verdict.rejected{border-style:double}"
    ".warning{font-size:.9em;color:#444;margin:.2em 0}"
    "figcaption{font-size:.85em;color:#333}svg{background:none}"
    ".flight-map{display:grid;grid-template-columns:1fr 13em;gap:1.2em;align-items:start}"
    ".flight-map>div>svg{max-height:none;background:#f4f4f4;display:block}"
    ".legend{list-style:none;margin:.5em 0;padding:0}.legend li{display:flex;gap:.6em;"
    "align-items:center;margin:.25em 0}.legend svg{flex:none;width:28px;height:18px}"
    ".beyond{fill:#f4f4f4;stroke:#999}.hatch{stroke:#6e6e6e;stroke-width:2}"
    ".hatch.hazard{stroke:#6e2300}"
    ".mark circle{stroke:#000;stroke-width:1.5;vector-effect:non-scaling-stroke}"
    ".mark text{font-weight:bold}.mark.landable circle{fill:#000;stroke:#fff}"
    ".mark.landable text{fill:#fff}.mark.unverified circle{fill:#fff}"
    ".pair{display:grid;grid-template-columns:1fr 1fr;gap:1.5em;align-items:start}"
    ".pair svg{background:#f4f4f4}.rose>svg{background:none}"
    ".rose .legend{display:flex;gap:1.5em}.cell{stroke:#444;stroke-width:.7}"
    ".cell.landable{fill:#0072b2}.cell.unverified{fill:url(#unverified)}"
    ".cell.rejected{fill:url(#rejected)}.patterns{position:absolute}"
    ".cross{stroke:#000;stroke-width:1.5}"
    ".profile svg{max-height:20em;background:#f4f4f4}.columns{columns:2;column-gap:2em}"
    ".columns table{width:100%}.columns tr{break-inside:avoid}footer{margin-top:2.5em;"
    "border-top:1px solid #999;font-size:.85em;color:#444}"
    "@media(max-width:45em){.flight-map,.pair{grid-template-columns:1fr}.columns{columns:1}}"
    "@page{margin:14mm 14mm 16mm;@bottom-right{content:counter(page) ' / ' counter(pages);"
    "font:8pt sans-serif;color:#444}}@media "
    "print{body{font-size:9.5pt;max-width:none;margin:0;padding:0;"
    "print-color-adjust:exact;-webkit-print-color-adjust:exact}"
    "h1{margin-top:0}h2{margin-top:1.3em}h2,h3,h4,thead{break-after:avoid}"
    "figure,tr,li,p,article,.overview{break-inside:avoid}"
    ".flight-map{grid-template-columns:1fr 11em;break-inside:avoid}"
    ".flight-map>div>svg{max-height:102mm}.sites>.site{break-before:page;margin:0}"
    ".site h3{margin-top:0}"
    ".cut-out svg{width:68mm;height:68mm}.rose>svg{max-height:66mm}"
    ".coverage svg{max-height:80mm}"
    ".profile svg{max-height:44mm}.columns{font-size:.86em;line-height:1.3}"
    "h4,.pair figure,.profile{margin:.2em 0}th,td{padding-top:.1em;padding-bottom:.1em}}";

std::string PhotographedText(const FlightReport& report) {
  if (!report.first_photographed_at || !report.last_photographed_at) return "unknown";
  const std::string first = TimeText(*report.first_photographed_at);
  const std::string last = TimeText(*report.last_photographed_at);
  return first == last ? first : first + " to " + last;
}

std::string AircraftText(const Aircraft& aircraft) {
  return EscapeXml(aircraft.profile) + ": " + FixedText(aircraft.landing_airspeed_mps, 1) +
         " m/s on final, path of " + FixedText(aircraft.flight_path_angle_deg, 1) +
         "&#176;, at most " + FixedText(aircraft.max_bank_deg, 0) + "&#176; of bank, " +
         FixedText(aircraft.ground_roll_m, 0) + " m of ground roll, slope to " +
         FixedText(aircraft.max_slope_deg, 1) + "&#176;, roughness to " +
         FixedText(aircraft.max_roughness_m, 2) + " m";
}

std::string FlightWindText(const std::optional<WindEstimate>& wind) {
  if (!wind) return "unknown";
  const std::string spread =
      wind->spread_mps > 0.0 ? ", varying by " + FixedText(wind->spread_mps, 1) + " m/s" : "";
  return WindText(wind->wind_in_world.x(), wind->wind_in_world.y()) + spread;
}

std::string HeadRows(const FlightReport& report) {
  return Row("Flight", EscapeXml(report.flight_id)) +
         Row("Photographed", PhotographedText(report)) +
         Row("Photographs", std::to_string(report.num_photographs)) +
         Row("Aircraft", AircraftText(report.aircraft)) + Row("Wind", FlightWindText(report.wind)) +
         Row("Altitudes", DatumSentence(report.altitude_datum));
}

// The result in a sentence.
std::string ResultOf(const FlightReport& report) {
  int64_t num_landable = 0, num_unverified = 0;
  const auto count = [&](const StoredSite& site) {
    (site.verdict == "landable" ? num_landable : num_unverified) += 1;
  };
  for (const ReportedSite& site : report.sites) count(site.site);
  for (const StoredSite& site : report.further_sites) count(site);
  const auto num_rejected = static_cast<int64_t>(report.rejected_sites.size());
  const int64_t num_all = num_landable + num_unverified + num_rejected;
  if (num_all == 0) return "No place of this flight was evaluated.";
  std::string text = "Of " + CountText(num_all, "evaluated place") + ", " +
                     std::to_string(num_landable) + " landable, " + std::to_string(num_unverified) +
                     " unverified and " + std::to_string(num_rejected) + " rejected.";
  if (!report.superseded_sites.empty()) {
    text += " " + CountText(static_cast<int64_t>(report.superseded_sites.size()), "site") +
            " superseded by later flights.";
  }
  return text;
}

std::string MapsSection(const FlightReport& report) {
  std::string text = "<section>\n<h2>Map of the flight</h2>\n";
  if (report.maps.empty()) return text + "<p>The flight has no map.</p>\n</section>\n";
  for (size_t i = 0; i < report.maps.size(); ++i) {
    const std::string number = report.maps.size() > 1 ? " " + std::to_string(i + 1) + " of " +
                                                            std::to_string(report.maps.size())
                                                      : "";
    const std::string what =
        report.maps[i].ground.photo_jpeg.empty() ? "Hazard" : "Photograph from above, with hazard";
    text += FlightMapFigure(report, report.maps[i], "Map" + number + ". " + what);
  }
  return text + "</section>\n";
}

}  // namespace

std::string FlightReportPage(const FlightReport& report) {
  const std::string name = report.name.empty() ? report.flight_id : report.name;
  const bool has_rose = std::any_of(report.sites.begin(),
                                    report.sites.end(),
                                    [](const ReportedSite& site) { return site.rose.has_value(); });
  return PageOf("Report of " + name,
                kFlightStyle,
                (has_rose ? RosePatterns() : "") + "<h1>" + EscapeXml(name) +
                    "</h1>\n<p class=\"result\">" + ResultOf(report) + "</p>\n" +
                    Table(HeadRows(report)) + MapsSection(report) + SitesSection(report) +
                    QualitySection(report) + LeftOutSection(report) + "<footer><p>freelsd " +
                    EscapeXml(report.software_version) + ", written at " +
                    TimeText(report.written_at) +
                    ". Wires, thin poles and what moved later are not on the maps. An aircraft "
                    "must not rely on this report alone.</p></footer>\n");
}

}  // namespace freelsd
