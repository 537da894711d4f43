// Rally points in the format of ArduPilot's tools: place, altitude and break altitude above home in
// metres, landing direction in degrees, flags.
#include "api/export/sites/site_export.h"

namespace freelsd {

std::string RallyFile(const std::vector<StoredSite>& sites, const ExportOptions& options) {
  const std::vector<StoredSite> safe = SafeSites(sites, true);
  const AltitudeFrame frame = FrameAboveHome(options);
  std::string text = "# altitudes in metres above home, which is at " +
                     FixedText(*options.home_altitude_m, 3) + " m in the datum \"" +
                     safe.front().altitude_datum + "\"\n";
  for (const StoredSite& site : safe) {
    const double ground_m = frame.Of(site.touchdown.altitude_m);
    text += "# " + OneLine(site.Name()) + ", site " + site.id + ". " + PhotographedSentence(site) +
            "\nRALLY " + FixedText(site.touchdown.latitude_deg, 9) + "\t" +
            FixedText(site.touchdown.longitude_deg, 9) + "\t" +
            FixedText(ground_m + kRallyHeightM, 3) + "\t" +
            FixedText(frame.Of(site.final_places->start.altitude_m), 3) + "\t" +
            FixedText(site.final_places->heading_deg, 3) + "\t0\n";
  }
  return text;
}

}  // namespace freelsd
