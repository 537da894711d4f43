#include <algorithm>
#include <cmath>

#include "api/export/report/page.h"
#include "api/export/text.h"

namespace freelsd {
namespace {

std::string Value(const std::optional<double>& number, int num_decimals, const char* unit) {
  return number ? FixedText(*number, num_decimals) + unit : "unknown";
}

std::string Count(const std::optional<int64_t>& number) {
  return number ? std::to_string(*number) : "unknown";
}

// Rounded down: no hazard is nearer than told.
std::string HazardText(const StoredSite& site) {
  if (!site.hazard_distance_m) return "unknown";
  return FixedText(std::floor(10.0 * *site.hazard_distance_m) / 10.0, 1) + " m";
}

// As in the summary: the least share that is not zero is told as 1 %.
std::string UnseenText(const StoredSite& site) {
  if (!site.unseen_ratio) return "unknown";
  const long percent = std::lround(100.0 * *site.unseen_ratio);
  return std::to_string(*site.unseen_ratio > 0.0 ? std::max(1L, percent) : 0L) + " %";
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
  return EscapeXml(*site.last_seen_at) + (site.age_s ? ", " + AgeText(*site.age_s) + " ago" : "");
}

std::string SurfaceRows(const StoredSite& site) {
  return Row("Score", Value(site.score, 2, "")) +
         Row("Usable strip, along the final", StripText(site)) +
         Row("Touchdown to nearest hazard", HazardText(site)) +
         Row("Slope", Value(site.slope_deg, 1, "&#176;")) +
         Row("Roughness", Value(site.roughness_m, 2, " m")) +
         Row("Grade (share of views seen as grass)", Value(site.grade, 2, "")) +
         Row("Observations", Count(site.num_observations)) +
         Row("Share of the circle along which some ground is not measured", UnseenText(site)) +
         Row("Ground photographed", PhotographedText(site)) +
         Row("Evaluated", EscapeXml(site.updated_at.value_or("unknown")));
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

std::string TimeText(const std::string& rfc3339) {
  constexpr size_t kDate = 10, kMinutes = 16;
  const bool is_utc = rfc3339.size() > kMinutes && rfc3339[kDate] == 'T' && rfc3339.back() == 'Z';
  if (!is_utc) return EscapeXml(rfc3339);
  const std::string clock = rfc3339.substr(kDate + 1, kMinutes - kDate - 1);
  return EscapeXml(rfc3339.substr(0, kDate) + " " + clock + " UTC");
}

std::string StripText(const StoredSite& site) {
  if (!site.usable_length_m || !site.usable_width_m) return "unknown";
  return FixedText(std::floor(*site.usable_length_m), 0) + " x " +
         FixedText(std::floor(*site.usable_width_m), 0) + " m";
}

std::string DatumSentence(const std::string& datum) {
  if (datum == "amsl") return "above mean sea level";
  if (datum == "unknown") return "datum unknown";
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
