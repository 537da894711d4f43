#include <cmath>

#include <nlohmann/json.hpp>

#include "api/export/report/page.h"
#include "api/export/text.h"

namespace freelsd {
namespace {

// JSON writes the shortest text that parses to the same number.
template <class Number>
std::string Value(const std::optional<Number>& number, const std::string& unit) {
  return number ? nlohmann::json(*number).dump() + unit : "unknown";
}

std::string NoReturnRow(const StoredSite& site) {
  if (site.IsRejected()) return "";
  if (!site.go_around) return Row("Point of no return", "no climb is known to clear");
  const long percent = std::lround(std::ceil(100.0 * site.go_around->unseen_ratio));
  return Row("Point of no return, with power",
             FixedText(std::ceil(site.go_around->no_return_distance_m), 0) +
                 " m before touchdown; " + std::to_string(percent) +
                 " % of the ground below the go-around is unseen");
}

std::string FinalRows(const StoredSite& site) {
  if (!site.final_places) return Row("Approach", "none");
  const FinalPlaces& places = *site.final_places;
  return NoReturnRow(site) +
         Row("Heading of the final", FixedText(places.heading_deg, 1) + "&#176; true") +
         Row("Length of the final", FixedText(places.distance_m, 1) + " m") +
         Row("Height of its start", FixedText(places.height_m, 1) + " m above touchdown") +
         Row("Loiter circle",
             FixedText(places.loiter_radius_m, 1) + " m radius, " +
                 (places.is_right_turn ? "right" : "left") + " turn");
}

std::string WindRow(const StoredSite& site) {
  if (!site.wind || !site.wind->east_mps || !site.wind->north_mps) return Row("Wind", "unknown");
  return Row("Wind", WindText(*site.wind->east_mps, *site.wind->north_mps));
}

std::string ObstacleRow(const StoredSite& site) {
  if (!site.final_places || !site.approach) return "";
  const StoredClearance& approach = *site.approach;
  if (!approach.obstacle_clearance_m || !approach.obstacle_distance_m) return "";
  return Row("Tightest obstacle",
             FixedText(*approach.obstacle_clearance_m, 1) + " m below the path, " +
                 FixedText(*approach.obstacle_distance_m, 0) + " m from touchdown");
}

std::string PhotographedText(const StoredSite& site) {
  if (!site.last_seen_at) return "unknown";
  return EscapeXml(*site.last_seen_at) + (site.age_s ? ", " + AgeText(*site.age_s) + " ago " : "");
}

// Each unit starts with its space. Numbers without unit have only the space.
std::string SurfaceRows(const StoredSite& site) {
  return Row("Score", Value(site.score, " ")) +
         Row("Usable strip, along the final", StripText(site)) +
         Row("Touchdown to nearest hazard", Value(site.hazard_distance_m, " m")) +
         Row("Slope", Value(site.slope_deg, " &#176;")) +
         Row("Roughness", Value(site.roughness_m, " m")) +
         Row("Grade (share of views seen as grass)", Value(site.grade, " ")) +
         Row("Observations", Value(site.num_observations, " ")) +
         Row("Unseen share of the circle", Value(site.unseen_ratio, " ")) +
         Row("Ground photographed", PhotographedText(site)) +
         Row("Evaluated", site.updated_at ? EscapeXml(*site.updated_at) + " " : "unknown");
}

}  // namespace

std::string PlaceText(const GeoPoint& place) {
  return FixedText(place.latitude_deg, 7) + ", " + FixedText(place.longitude_deg, 7);
}

std::string WindText(double east_mps, double north_mps) {
  const double speed_mps = std::hypot(east_mps, north_mps);
  // A weaker wind has no direction worth telling.
  constexpr double kCalmMps = 0.05;
  if (speed_mps < kCalmMps) return "calm";
  const double from_deg = DegFromRad(std::atan2(-east_mps, -north_mps));
  const long whole_deg = std::lround(from_deg + 360.0) % 360;
  return "from " + std::to_string(whole_deg) + "&#176; true at " + FixedText(speed_mps, 1) + " m/s";
}

std::string StripText(const StoredSite& site) {
  if (!site.usable_length_m || !site.usable_width_m) return "unknown";
  return FixedText(std::floor(*site.usable_length_m), 0) + " x " +
         FixedText(std::floor(*site.usable_width_m), 0) + " m";
}

std::string DatumSentence(const std::string& datum) {
  if (datum == "amsl") return "above mean sea level";
  return "datum \"" + EscapeXml(datum) + "\", not known to be above mean sea level";
}

std::string SiteRows(const StoredSite& site) {
  return Row("Site", EscapeXml(site.id)) + Row("Touchdown", PlaceText(site.touchdown)) +
         Row("Altitude",
             FixedText(site.touchdown.altitude_m, 1) + " m (" + DatumSentence(site.altitude_datum) +
                 ")") +
         FinalRows(site) + WindRow(site) + ObstacleRow(site) + SurfaceRows(site);
}

}  // namespace freelsd
