#include "api/export/sites/site_export.h"

namespace freelsd {

std::vector<StoredSite> SafeSites(const std::vector<StoredSite>& sites, bool needs_final) {
  std::vector<StoredSite> safe;
  for (const StoredSite& site : sites) {
    if (site.IsRejected()) continue;
    if (needs_final && !site.final_places) {
      throw ApiError("NoApproach", "site " + site.id + " has no approach");
    }
    safe.push_back(site);
  }
  if (!safe.empty()) return safe;
  std::string detail = "this format omits rejected sites: none remains";
  if (sites.size() == 1) {
    detail = "this format omits rejected sites: " + sites.front().summary.value_or("rejected");
  }
  throw ApiError("SiteRejected", detail);
}

std::string PhotographedSentence(const StoredSite& site) {
  if (!site.last_seen_at || !site.age_s) return "Ground photographed at an unknown time.";
  return "Ground photographed " + *site.last_seen_at + ", " + AgeText(*site.age_s) +
         " before this file.";
}

AltitudeFrame FrameAboveHome(const ExportOptions& options) {
  if (options.home_altitude_m) return {true, *options.home_altitude_m};
  throw ApiError(
      "AltitudeUnknown",
      "this file states altitudes above home: give home_altitude_m, in the flight's datum",
      {{"home_altitude_m", "is missing"}});
}

AltitudeFrame FrameOf(const std::vector<StoredSite>& sites, const ExportOptions& options) {
  if (options.home_altitude_m) return {true, *options.home_altitude_m};
  for (const StoredSite& site : sites) {
    if (site.altitude_datum == "amsl") continue;
    throw ApiError("AltitudeUnknown",
                   "the datum of the flight's altitudes is " + site.altitude_datum +
                       ", not amsl: give home_altitude_m, in the flight's datum, for altitudes "
                       "above home",
                   {{"home_altitude_m", "is missing"}});
  }
  return {false, 0.0};
}

}  // namespace freelsd
