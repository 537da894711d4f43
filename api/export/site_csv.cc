// CSV (RFC 4180): a row per site, rejected ones too; what is unknown is empty.
#include "api/export/site_export.h"

namespace freelsd {
namespace {

// Properties of the site, by their names in GeoJSON.
constexpr const char* kProperties[] = {"rank",
                                       "verdict",
                                       "reject_reason",
                                       "score",
                                       "grade",
                                       "num_observations",
                                       "num_grass_observations",
                                       "area_m2",
                                       "hazard_distance_m",
                                       "slope_deg",
                                       "roughness_m",
                                       "unseen_ratio",
                                       "updated_at",
                                       "summary"};
constexpr char kPlaceColumns[] =
    "id,latitude_deg,longitude_deg,altitude_m,altitude_datum,wind_east_mps,wind_north_mps,"
    "heading_deg,approach_distance_m,approach_height_m,approach_start_latitude_deg,"
    "approach_start_longitude_deg,loiter_center_latitude_deg,loiter_center_longitude_deg,"
    "loiter_radius_m,loiter_direction";
constexpr int kNumFinalColumns = 9;

std::string Cell(const nlohmann::json& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  std::string quoted = "\"";
  for (const char c : value.get<std::string>()) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string FinalCells(const SitePlaces& site) {
  if (!site.final_places) return std::string(kNumFinalColumns, ',');
  const FinalPlaces& places = *site.final_places;
  return "," + FixedText(places.heading_deg, 3) + "," + FixedText(places.distance_m, 3) + "," +
         FixedText(places.height_m, 3) + "," + FixedText(places.start.latitude_deg, 9) + "," +
         FixedText(places.start.longitude_deg, 9) + "," +
         FixedText(places.loiter_center.latitude_deg, 9) + "," +
         FixedText(places.loiter_center.longitude_deg, 9) + "," +
         FixedText(places.loiter_radius_m, 3) + (places.is_right_turn ? ",right" : ",left");
}

std::string Row(const SitePlaces& site) {
  const nlohmann::json wind = site.properties.value("wind", nlohmann::json());
  std::string row = Cell(site.id) + "," + FixedText(site.touchdown.latitude_deg, 9) + "," +
                    FixedText(site.touchdown.longitude_deg, 9) + "," +
                    FixedText(site.touchdown.altitude_m, 3) + "," + site.altitude_datum;
  for (const char* const side : {"east_mps", "north_mps"}) {
    row += "," + (wind.is_object() ? Cell(wind.value(side, nlohmann::json())) : "");
  }
  row += FinalCells(site);
  for (const char* const name : kProperties) {
    row += "," + Cell(site.properties.value(name, nlohmann::json()));
  }
  return row + "\r\n";
}

}  // namespace

std::string CsvFile(const std::vector<StoredSite>& stored, const ExportOptions&) {
  std::string text = kPlaceColumns;
  for (const char* const name : kProperties) text += std::string(",") + name;
  text += "\r\n";
  for (const StoredSite& site : stored) text += Row(ReadSite(site));
  return text;
}

}  // namespace freelsd
