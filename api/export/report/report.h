// Reports for people, each of one page that loads no other file: of a site, and of a whole flight.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/export/map/map.h"
#include "api/stored/stored.h"

namespace freelsd {

// Self-contained HTML that loads no other file: verdict, map with layers, profile, numbers.
// `site_map` may be empty.
std::string SiteReport(const StoredSite& site,
                       const SiteMap& site_map,
                       const LocalFrame& local_frame);

// --- The report of a flight ---

// Ground from straight above. The pictures fill the box.
struct GroundPicture {
  WorldBox box;
  // JPEG; empty if no photograph shows the ground.
  std::string photo_jpeg;
  // PNG of HazardBoxPng; empty if only the photograph is to be shown.
  std::string hazard_png;
};

// Cells of a map.
struct CellCounts {
  int64_t num_cells = 0;
  // Those whose hazard is known, and those of them that are free.
  int64_t num_seen = 0;
  int64_t num_free = 0;
};

// One of the flight's maps.
struct ReportedMap {
  GroundPicture ground;
  // PNG with its legend; empty if it was not computed.
  std::string coverage_png;
  std::string coverage_legend_png;
  CellCounts cells;
  BlockQuality quality;
  double cell_size_m = 1.0;
  double position_sd_m = 0.0;
  double tilt_sd_deg = 0.0;
  // Of the picture; nothing without one.
  std::optional<double> photo_pixel_size_m;
};

// A square around touchdown, final and ground roll of a site, with a margin: what its picture is
// to show.
WorldBox LandingBoxOf(const StoredSite& site, const LocalFrame& local_frame);

// An accepted site in full.
struct ReportedSite {
  StoredSite site;
  // Around the landing; nothing if no map of the flight shows it.
  std::optional<GroundPicture> ground;
  // Nothing if the site cannot be planned anew.
  std::optional<WindRose> rose;
};

struct ReportedSupersededSite {
  StoredSite site;
  // Id of the site or flight that supersedes it; when (RFC 3339), and the sentence that says why.
  std::string superseded_by;
  std::string superseded_at;
  std::string detail;
};

// Photographs or regions that were left out for the same reason.
struct LeftOutGroup {
  std::string reason;
  std::vector<std::string> ids;
};

struct FlightReport {
  std::string flight_id;
  std::string name;
  // When the first and the last photograph were taken (RFC 3339). Nothing if unknown.
  std::optional<std::string> first_photographed_at;
  std::optional<std::string> last_photographed_at;
  Aircraft aircraft;
  std::optional<WindEstimate> wind;
  std::string altitude_datum = "unknown";
  // Of all maps and sites. Its origin is arbitrary if the flight has neither.
  LocalFrame local_frame{GeoPoint{}};
  int64_t num_photographs = 0;
  // Newest first.
  std::vector<ReportedMap> maps;
  // Accepted sites, best first, with their ranks; the others follow in further_sites.
  std::vector<ReportedSite> sites;
  std::vector<StoredSite> further_sites;
  std::vector<StoredSite> rejected_sites;
  std::vector<ReportedSupersededSite> superseded_sites;
  std::vector<LeftOutGroup> photographs_left_out;
  std::vector<LeftOutGroup> regions_left_out;
  std::vector<std::string> warnings;
  std::string software_version;
  // RFC 3339.
  std::string written_at;
};
// Equal reports give equal bytes.
std::string FlightReportPage(const FlightReport& report);

}  // namespace freelsd
