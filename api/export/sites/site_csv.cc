// CSV (RFC 4180): one row per site, including rejected ones. Unknown values are empty.
#include <nlohmann/json.hpp>

#include "api/export/sites/site_export.h"

namespace freelsd {
namespace {

constexpr char kPlaceColumns[] =
    "id,latitude_deg,longitude_deg,altitude_m,altitude_datum,wind_east_mps,wind_north_mps,"
    "heading_deg,approach_distance_m,approach_height_m,approach_start_latitude_deg,"
    "approach_start_longitude_deg,loiter_center_latitude_deg,loiter_center_longitude_deg,"
    "loiter_radius_m,loiter_direction";
constexpr char kPropertyColumns[] =
    ",rank,verdict,reject_reason,score,grade,num_observations,num_grass_observations,area_m2,"
    "hazard_distance_m,slope_deg,roughness_m,unseen_ratio,updated_at,summary,"
    "last_seen_at,age_s,no_return_distance_m";
constexpr int kNumFinalColumns = 9;

std::string Cell(const std::optional<std::string>& text) {
  if (!text) return "";
  std::string quoted = "\"";
  for (const char c : CellText(*text)) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

// JSON writes the shortest text that parses to the same number.
template <class Number>
std::string NumberCell(const std::optional<Number>& number) {
  return number ? nlohmann::json(*number).dump() : "";
}

std::string FinalCells(const StoredSite& site) {
  if (!site.final_places) return std::string(kNumFinalColumns, ',');
  const FinalPlaces& places = *site.final_places;
  return "," + FixedText(places.heading_deg, 3) + "," + FixedText(places.distance_m, 3) + "," +
         FixedText(places.height_m, 3) + "," + FixedText(places.start.latitude_deg, 9) + "," +
         FixedText(places.start.longitude_deg, 9) + "," +
         FixedText(places.loiter_center.latitude_deg, 9) + "," +
         FixedText(places.loiter_center.longitude_deg, 9) + "," +
         FixedText(places.loiter_radius_m, 3) + (places.is_right_turn ? ",right" : ",left");
}

std::optional<double> NoReturnM(const StoredSite& site) {
  if (!site.go_around) return std::nullopt;
  return site.go_around->no_return_distance_m;
}

std::string PropertyCells(const StoredSite& site) {
  std::string cells;
  for (const std::string& cell : {NumberCell(site.rank),
                                  Cell(site.verdict),
                                  Cell(site.reject_reason),
                                  NumberCell(site.score),
                                  NumberCell(site.grade),
                                  NumberCell(site.num_observations),
                                  NumberCell(site.num_grass_observations),
                                  NumberCell(site.area_m2),
                                  NumberCell(site.hazard_distance_m),
                                  NumberCell(site.slope_deg),
                                  NumberCell(site.roughness_m),
                                  NumberCell(site.unseen_ratio),
                                  Cell(site.updated_at),
                                  Cell(site.summary),
                                  Cell(site.last_seen_at),
                                  NumberCell(site.age_s),
                                  NumberCell(NoReturnM(site))}) {
    cells += "," + cell;
  }
  return cells;
}

std::string CsvRow(const StoredSite& site) {
  const StoredWind wind = site.wind.value_or(StoredWind());
  return Cell(site.id) + "," + FixedText(site.touchdown.latitude_deg, 9) + "," +
         FixedText(site.touchdown.longitude_deg, 9) + "," +
         FixedText(site.touchdown.altitude_m, 3) + "," + site.altitude_datum + "," +
         NumberCell(wind.east_mps) + "," + NumberCell(wind.north_mps) + FinalCells(site) +
         PropertyCells(site) + "\r\n";
}

}  // namespace

std::string CsvFile(const std::vector<StoredSite>& sites, const ExportOptions&) {
  std::string text = std::string(kPlaceColumns) + kPropertyColumns + "\r\n";
  for (const StoredSite& site : sites) text += CsvRow(site);
  return text;
}

}  // namespace freelsd
