#include "api/import/poses/coordinate_system.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include <proj.h>

#include "api/import/number_text.h"
#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr size_t kMaxCodeDigits = 6;

std::string UtmCode(const std::string& zone_text, bool is_north) {
  const std::optional<double> zone = NumberFromText(zone_text);
  if (!zone || *zone < 1 || *zone > 60 || *zone != std::floor(*zone)) return "";
  return std::to_string((is_north ? 32600 : 32700) + static_cast<int>(*zone));
}

// Only the number reaches PROJ, whose own strings may name files. Empty for what is not known.
std::string CodeOf(const std::string& name) {
  const std::vector<std::string> words = WordsOf(name);
  const auto has = [&words](const char* word) {
    return std::find(words.begin(), words.end(), word) != words.end();
  };
  if (name.starts_with("epsg:")) {
    const std::string code = words[0].substr(5);
    const bool is_number = code.find_first_not_of("0123456789") == std::string::npos;
    return is_number && code.size() <= kMaxCodeDigits ? code : "";
  }
  if (words.size() == 3 && words[0] == "wgs84" && words[1] == "utm" && words[2].size() > 1) {
    const char pole = words[2].back();
    if (pole != 'n' && pole != 's') return "";
    return UtmCode(words[2].substr(0, words[2].size() - 1), pole == 'n');
  }
  if (!has("+datum=wgs84") && !has("+ellps=wgs84")) return "";
  if (has("+proj=longlat") || has("+proj=latlong")) return "4326";
  if (!has("+proj=utm")) return "";
  for (const std::string& word : words) {
    if (word.starts_with("+zone=")) return UtmCode(word.substr(6), !has("+south"));
  }
  return "";
}

}  // namespace

bool CoordinateSystem::SetArea(const std::string& name) {
  PJ* const system = proj_create(context_, name.c_str());
  if (system == nullptr) return false;
  const PJ_TYPE type = proj_get_type(system);
  const bool is_plane = type == PJ_TYPE_PROJECTED_CRS || type == PJ_TYPE_GEOGRAPHIC_2D_CRS ||
                        type == PJ_TYPE_GEOGRAPHIC_3D_CRS;
  const bool has_area =
      proj_get_area_of_use(
          context_, system, &west_deg_, &south_deg_, &east_deg_, &north_deg_, nullptr) != 0;
  proj_destroy(system);
  return is_plane && has_area;
}

CoordinateSystem::CoordinateSystem(const std::string& name) : code_(CodeOf(name)) {
  if (code_.empty()) {
    throw std::invalid_argument(
        "only EPSG:code, WGS84 UTM zzN and the PROJ forms of WGS84 are supported");
  }
  if (code_ == "4326" || code_ == "4979") return;
  context_ = proj_context_create();
  proj_log_level(context_, PJ_LOG_NONE);
  // Poses do not wait for grids from elsewhere.
  proj_context_set_enable_network(context_, 0);
  const std::string system = "EPSG:" + code_;
  if (SetArea(system)) {
    PJ* const as_defined = proj_create_crs_to_crs(context_, system.c_str(), "EPSG:4326", nullptr);
    // East and longitude come first.
    wgs84_from_system_ =
        as_defined == nullptr ? nullptr : proj_normalize_for_visualization(context_, as_defined);
    proj_destroy(as_defined);
  }
  if (wgs84_from_system_ != nullptr) return;
  proj_context_destroy(context_);
  throw std::invalid_argument(system + " is no known system of eastings and northings");
}

CoordinateSystem::~CoordinateSystem() {
  proj_destroy(wgs84_from_system_);
  if (context_ != nullptr) proj_context_destroy(context_);
}

GeoPoint CoordinateSystem::PlaceOf(double x, double y) const {
  PJ_COORD place = proj_coord(x, y, 0.0, 0.0);
  if (wgs84_from_system_ != nullptr) {
    place = proj_trans(wgs84_from_system_, PJ_FWD, place);
    const PJ_COORD back = proj_trans(wgs84_from_system_, PJ_INV, place);
    constexpr double kMaxError = 1.0;
    // Zones are used beyond their borders.
    constexpr double kMarginDeg = 6.0;
    const double width_deg = east_deg_ - west_deg_ + (east_deg_ < west_deg_ ? 360.0 : 0.0);
    const double middle_deg = west_deg_ + 0.5 * width_deg;
    const bool is_in_area =
        place.xy.y > south_deg_ - kMarginDeg && place.xy.y < north_deg_ + kMarginDeg &&
        std::abs(std::remainder(place.xy.x - middle_deg, 360.0)) < 0.5 * width_deg + kMarginDeg;
    if (!is_in_area || !(std::hypot(back.xy.x - x, back.xy.y - y) < kMaxError)) {
      throw std::invalid_argument("easting and northing are not in EPSG:" + code_);
    }
  }
  if (!(std::abs(place.xy.x) <= 180.0 && std::abs(place.xy.y) <= 90.0)) {
    throw std::invalid_argument(
        "is not on the earth: x is the longitude and comes first, y the latitude");
  }
  return {place.xy.y, place.xy.x, 0.0};
}

}  // namespace freelsd
