// Private to sites/. Shared by the formats: the sites that a file may contain, and the reference
// of its altitudes.
#pragma once

#include <string>
#include <vector>

#include "api/export/sites/sites.h"
#include "api/export/text.h"

namespace freelsd {

// Sites for autopilots and gliding computers: all except the rejected ones.
// Throws ApiError SiteRejected if no site remains, NoApproach if `needs_final` is set and one of
// the sites has no final.
std::vector<StoredSite> SafeSites(const std::vector<StoredSite>& sites, bool needs_final);

// "Ground photographed 2026-05-01T10:00:00Z, 12 days before this file."
std::string PhotographedSentence(const StoredSite& site);

// Reference of a file's altitudes: mean sea level, or home.
struct AltitudeFrame {
  bool is_above_home = false;
  double zero_m = 0.0;
  double Of(double altitude_m) const { return altitude_m - zero_m; }
};
// Selects the reference: home if home is given, because this needs no datum; else mean sea level if
// that is the sites' datum. Otherwise throws ApiError AltitudeUnknown, because a wrong altitude may
// cause a crash.
AltitudeFrame FrameOf(const std::vector<StoredSite>& sites, const ExportOptions& options);
// Selects home. Throws ApiError AltitudeUnknown if home is not given.
AltitudeFrame FrameAboveHome(const ExportOptions& options);

// Height of the circle at a rally point, above the touchdown. The radius of this circle is set in
// the autopilot. freelsd therefore cannot check the circle's clearance. 100 m is also ArduPilot's
// default for return.
constexpr double kRallyHeightM = 100.0;

// One function per format. `sites` are sorted best first.
std::string PlanFile(const std::vector<StoredSite>& sites, const ExportOptions& options);
std::string WaypointFile(const std::vector<StoredSite>& sites, const ExportOptions& options);
std::string RallyFile(const std::vector<StoredSite>& sites, const ExportOptions& options);
std::string KmlFile(const std::vector<StoredSite>& sites, const ExportOptions& options);
std::string CupFile(const std::vector<StoredSite>& sites, const ExportOptions& options);
std::string CsvFile(const std::vector<StoredSite>& sites, const ExportOptions& options);

}  // namespace freelsd
