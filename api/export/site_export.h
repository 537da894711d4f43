// What every format of a site is made of: its places, read from what is stored, and how altitudes
// are told.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/export/export.h"

namespace freelsd {

// The straight final and the circle before it.
struct FinalPlaces {
  GeoPoint start;
  GeoPoint loiter_center;  // as high as the start
  double loiter_radius_m = 0.0;
  bool is_right_turn = false;
  // Direction of travel at the touchdown, from true north there, 0 to 360.
  double heading_deg = 0.0;
  // Level, where it is flown: up a mountain it is more than between the feet on the ellipsoid.
  double distance_m = 0.0;
  // Start above touchdown.
  double height_m = 0.0;
};

struct SitePlaces {
  std::string id;
  std::string verdict;
  std::string altitude_datum;
  nlohmann::json properties;
  GeoPoint touchdown;
  std::optional<FinalPlaces> final_places;
  // [longitude, latitude, altitude] as stored; empty where there is no approach.
  nlohmann::json loiter_line = nlohmann::json::array();
  nlohmann::json profile;

  bool IsRejected() const { return verdict != "landable" && verdict != "unverified"; }
  // The id, and what a pilot has to know of it: "f-r1 UNVERIFIED".
  std::string Name() const;
};

SitePlaces ReadSite(const StoredSite& site);
// For what an autopilot or gliding computer would fly to: rejected sites are left out.
// Throws ApiError SiteRejected where nothing stays, NoApproach where `needs_final` and one has
// none.
std::vector<SitePlaces> SafeSites(const std::vector<StoredSite>& sites, bool needs_final);

// How a file says altitudes: above mean sea level, or above home.
struct AltitudeFrame {
  bool is_above_home = false;
  double zero_m = 0.0;
  double Of(double altitude_m) const { return altitude_m - zero_m; }
};
// Above home where home is given, which needs no datum; else above mean sea level where that is the
// sites' datum. Throws ApiError AltitudeUnknown: a guess would be a flight into the ground.
AltitudeFrame FrameOf(const std::vector<SitePlaces>& sites, const ExportOptions& options);
// Only above home. Throws ApiError AltitudeUnknown without home.
AltitudeFrame FrameAboveHome(const ExportOptions& options);

// Rally points are circled this high above the touchdown, at a radius that only the autopilot
// knows: far above what the map holds for clear. ArduPilot comes home at 100 m too.
constexpr double kRallyHeightM = 100.0;

std::string FixedText(double number, int num_decimals);
// For XML and HTML, in text and attributes.
std::string EscapeXml(const std::string& text);

// One function per format; `sites` best first.
std::string PlanFile(const std::vector<StoredSite>& sites, const ExportOptions& options);
std::string WaypointFile(const std::vector<StoredSite>& sites, const ExportOptions& options);
std::string RallyFile(const std::vector<StoredSite>& sites, const ExportOptions& options);
std::string KmlFile(const std::vector<StoredSite>& sites, const ExportOptions& options);
std::string CupFile(const std::vector<StoredSite>& sites, const ExportOptions& options);
std::string CsvFile(const std::vector<StoredSite>& sites, const ExportOptions& options);

}  // namespace freelsd
