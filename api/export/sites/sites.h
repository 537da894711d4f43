// Converts sites to file formats of other programs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/stored/stored.h"

namespace freelsd {

// The autopilot for which a QGroundControl plan (format "plan") is written.
enum class Firmware { kPx4, kArduPilot };

struct ExportOptions {
  // Altitude of the launch place, in the datum of the sites. If set, files for autopilots state
  // heights above this place.
  std::optional<double> home_altitude_m;
  Firmware firmware = Firmware::kPx4;
};
struct SiteFormat {
  const char* name;
  const char* media_type;
  const char* extension;
  // True if the file's content marks unverified sites. Otherwise the file's name must mark them.
  bool tells_verdicts = true;
};
// plan, waypoints, rally, kml, cup, csv.
std::vector<SiteFormat> SiteFormats();
// `sites` belong to one flight and are ordered best first. Navigation formats (plan, waypoints,
// rally, cup) omit rejected sites. Throws ApiError SiteRejected if no site remains, NoApproach if a
// site lacks the final approach that the format needs, AltitudeUnknown if home_altitude_m is
// needed but not set; std::invalid_argument for an unknown format.
std::string ExportSites(const std::string& format,
                        const std::vector<StoredSite>& sites,
                        const ExportOptions& options);

// What differs between plans for QGroundControl.
struct QgcPlan {
  bool is_above_home = false;
  // [latitude, longitude, altitude or null].
  nlohmann::json home;
  nlohmann::json items = nlohmann::json::array();
  nlohmann::json rally_points = nlohmann::json::array();
  // For people. The program ignores unknown keys.
  nlohmann::json remarks;
};
// A .plan, version 1, for a plane.
std::string QgcPlanFile(const QgcPlan& plan, Firmware firmware);

}  // namespace freelsd
