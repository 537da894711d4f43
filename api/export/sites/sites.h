// Sites -> file formats of other programs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/stored/stored.h"

namespace freelsd {

// The autopilot that a plan names.
enum class Firmware { kPx4, kArduPilot };

struct ExportOptions {
  // Altitude of the launch place, in the sites' datum. If set, autopilots get heights above it.
  std::optional<double> home_altitude_m;
  Firmware firmware = Firmware::kPx4;
};
struct SiteFormat {
  const char* name;
  const char* media_type;
  const char* extension;
  // True if the file itself marks unverified sites. Otherwise the file's name marks them.
  bool tells_verdicts = true;
};
// plan, waypoints, rally, kml, cup, csv.
std::vector<SiteFormat> SiteFormats();
// `sites` are of one flight, best first. Formats to navigate by (plan, waypoints, rally, cup) never
// contain a rejected site and mark unverified ones by name. Throws ApiError SiteRejected if no site
// remains, NoApproach if a needed final is missing, AltitudeUnknown if the altitude reference is
// unknown; std::invalid_argument for an unknown format.
std::string ExportSites(const std::string& format,
                        const std::vector<StoredSite>& sites,
                        const ExportOptions& options);

}  // namespace freelsd
